"""The rows of a chosen subset, many at a time; shared values of a class are read once."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.column_files import ColumnBlock, Values
from orbitdb.columns import kind_of
from orbitdb.store.asking.conditions import rules_of
from orbitdb.store.file.schema import OF_WORD, SHARED
from orbitdb.store.file.tables import classes
from orbitdb.store.reading.chosen import Chosen, listed, orders_of
from orbitdb.store.reading.fitting import stabiliser_of
from orbitdb.store.reading.question import as_array, pruned_rows
from orbitdb.store.reading.soundness import coordinates_of, need_words, unsound
from orbitdb.symbols.members import ELEMENT_OF
from orbitdb.symbols.symmetry import image_coordinates
from orbitdb.symbols.words import MAX_KEYED

COORDINATES = "coordinates"
COLUMNS = (*SHARED, *OF_WORD, COORDINATES)
"""Readable columns of a word: those of the view ``catalogue``, and its coordinates."""

ROWS, _LONG_ROWS = 1 << 13, 16
"""Rows of a block, and fewer if words of up to a million symbols are among them."""


def blocks_of(
    connection: sa.Connection, chosen: Chosen, names: Sequence[str], first: int = 0, last: int | None = None
) -> Iterator[ColumnBlock]:
    """Yield rows first .. last - 1 of a subset by columns, some of `COLUMNS`."""
    last = len(chosen) if last is None else min(last, len(chosen))
    for start in range(first, last, ROWS):
        words = chosen.words(start, min(start + ROWS, last))
        step = ROWS if orders_of(words.ids).max(initial=0) <= MAX_KEYED else _LONG_ROWS
        for begin in range(0, len(words.ids), step):
            here = slice(begin, begin + step)
            ids, inverse = np.unique(words.ids[here], return_inverse=True)
            shared = _classes(connection, chosen.selection.a, ids, names)
            yield ColumnBlock(_Block(shared, inverse, words.places[here]).columns(names))


def _classes(connection: sa.Connection, a: float, ids: NDArray[np.int64], wanted: Sequence[str]) -> list[Any]:
    """Return columns of classes or pruned words, in the order of their ids, that the wanted ones need."""
    shared = [name for name in wanted if name in SHARED or name in (COORDINATES, "rules")]
    names = tuple(dict.fromkeys(["p", "representative", "words", "symmetry", *shared]))
    rows: list[tuple[Any, ...]] = []
    pruned = ids[ids < 0]
    if len(pruned):
        known = pruned_rows(a).c
        query = sa.select(known.id, *(known[name] for name in names)).where(known.id.in_(listed(pruned)))
        rows += sorted(connection.execute(query).cursor.fetchall())
    if len(pruned) < len(ids):
        of_view = [classes.c[name] if name in classes.c else sa.null() for name in names]
        query = sa.select(classes.c.cycle, *of_view)
        query = query.where(classes.c.a == a, classes.c.cycle.in_(listed(ids[len(pruned) :])))
        rows += sorted(connection.execute(query).cursor.fetchall(), key=lambda row: row[0])
    numbers, *columns = zip(*rows, strict=True) if rows else [()] * (1 + len(names))
    if list(numbers) != ids.tolist():
        raise unsound("classes without a row among", f"{ids[0]} to {ids[-1]}")
    return list(zip(names, columns, strict=True))


class _Block:
    """Words of one block, and the stored values of their classes."""

    def __init__(self, shared: list[Any], inverse: NDArray[np.intp], places: NDArray[np.uint8]) -> None:
        self.shared = dict(shared)
        self.rows, self.places = inverse.tolist(), places.tolist()
        self.inverse = inverse
        orders, texts = self.shared["p"], self.shared["words"]
        need_words(texts, [p * (len(text) // p) if p else -1 for p, text in zip(orders, texts, strict=True)])
        for least, text in zip(self.shared["representative"], texts, strict=True):
            if least is not None and least != text[: len(least)]:
                raise unsound("a least word that begins no class:", least)
        self.words = [
            texts[row][orders[row] * place : orders[row] * (place + 1)]
            for row, place in zip(self.rows, self.places, strict=True)
        ]
        if not all(self.words):
            raise unsound("a class without some of its words:", self.shared["representative"][0])

    def columns(self, names: Sequence[str]) -> list[Values]:
        """Return some columns."""
        made: dict[str, Callable[[], Values]] = {
            "code": lambda: self.words,
            "word": lambda: self.words,
            "element": self._elements,
            "rules": self._rules,
            COORDINATES: self._coordinates,
        }
        return [made[name]() if name in made else self._column(name) for name in names]

    def _column(self, name: str) -> Values:
        values = self.shared.get(name)
        if values is None:
            return [None] * len(self.rows)
        if kind_of(name) != "number":
            return [values[row] for row in self.rows]
        try:
            return as_array(name, values)[self.inverse]
        except (TypeError, ValueError) as error:
            raise unsound("a value of a class in the column", name) from error

    def _rules(self) -> list[list[int]]:
        known = [rules_of(text) for text in self.shared["rules"]]
        return [known[row] for row in self.rows]

    def _elements(self) -> list[int | None]:
        known = [
            None if label is None else ELEMENT_OF[stabiliser_of(label)].tolist()
            for label in self.shared["symmetry"]
        ]
        pairs = zip(self.rows, self.places, strict=True)
        return [None if (own := known[row]) is None else own[place] for row, place in pairs]

    def _coordinates(self) -> list[NDArray[np.float64] | None]:
        """Return the coordinates of the words: those of the representative, mirrored, reversed and turned."""
        blobs, least = self.shared[COORDINATES], self.shared["representative"]
        found: list[NDArray[np.float64] | None] = [None] * len(self.rows)
        groups: dict[tuple[int, int], list[int]] = {}
        for row, (own, element) in enumerate(zip(self.rows, self._elements(), strict=True)):
            if blobs[own] is not None and element is not None:
                groups.setdefault((len(self.words[row]), element), []).append(row)
        for (p, element), members in groups.items():
            owners = [self.rows[row] for row in members]
            places = coordinates_of([blobs[own] for own in owners], p)
            texts = [least[own] for own in owners]
            need_words(texts, [p] * len(texts))
            try:
                images = image_coordinates([self.words[row] for row in members], texts, element, places)
            except ValueError as error:
                raise unsound("a word that is no image of", texts[0]) from error
            for row, image in zip(members, images, strict=True):
                found[row] = image
        return found
