"""All rows of a large subset as blocks of columns: what the words of a class share is read once, into arrays.

Those of one period are kept meanwhile, some 250 bytes a class with its coordinates.
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.column_blocks import Column, ColumnBlock, Lists
from orbitdb.columns import kind_of
from orbitdb.store.asking.conditions import answering, conditions_of, containing
from orbitdb.store.asking.confinement import Patience
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.engines import little_kept
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.first_rows import keys_before_words
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import coordinates_of, need_elements, need_words, unsound
from orbitdb.store.reading.spread import periods_by_class, places_of
from orbitdb.symbols.symmetry import ELEMENTS, image_places
from orbitdb.symbols.words import from_strings

_NAMES = ("code", "word")
_OF_WORDS = (*_NAMES, "rules", "element")
_COORDINATES = "coordinates"
_BLOCK = 20_000

_TYPES = {"number": np.float64, "integer": np.int64}


def spread_columns(
    reader: Reader, selection: Selection, columns: Sequence[str], order: str
) -> Iterator[ColumnBlock] | None:
    """Return the rows of a whole subset by columns; None if it is small, or takes single words of classes.

    Parameters
    ----------
    reader : Reader
    selection : Selection
    columns : sequence of str
        Of the view ``catalogue``, and ``coordinates``.
    order : str
        Only that of the table will do.
    """
    if keys_before_words(order) or not {*_OF_WORDS, *class_view().c.keys()}.issuperset(columns):
        return None
    periods = periods_by_class(reader, selection)
    if periods is None:
        return None
    return (block for p in periods for block in _blocks_of_period(reader, selection, columns, p))


@dataclass(frozen=True, eq=False)
class _Classes:
    """The chosen classes of a period.

    Attributes
    ----------
    numbers : ndarray of int64, shape (C,)
        Rising.
    values : dict of str to ndarray, shape (C,) each
        Their columns; of texts the ASCII bytes.
    least : ndarray of uint8, shape (C, p)
        Their least words.
    rows : ndarray of intp, shape (C,)
        Where the coordinates of each are; -1 where there are none.
    coordinates : ndarray, shape (K, p)
    """

    numbers: NDArray[np.int64]
    values: dict[str, NDArray[Any]]
    least: NDArray[np.uint8]
    rows: NDArray[np.intp]
    coordinates: NDArray[np.float64]

    def images(
        self, places: NDArray[np.intp], words: NDArray[np.uint8], elements: NDArray[np.integer]
    ) -> Lists:
        """Return the coordinates of words of some classes, which elements lead to."""
        rows, p = self.rows[places], words.shape[1]
        present = rows >= 0
        found = np.empty(words.shape)
        for g in ELEMENTS:
            here = np.flatnonzero(present & (elements == g))
            if len(here):
                own = self.coordinates[rows[here]]
                try:
                    found[here] = image_places(words[here], self.least[places[here]], g, own)
                except ValueError as error:
                    raise unsound("a symmetry element that leads to another word:", g) from error
        return Lists(found[present].ravel(), np.where(present, p, 0).astype(np.int64), present)


def _blocks_of_period(
    reader: Reader, selection: Selection, columns: Sequence[str], p: int
) -> Iterator[ColumnBlock]:
    with reader.reading() as connection, little_kept(connection):
        classes = _read_classes(connection, replace(selection, contains=None), columns, p)
        if classes is None:
            return
        known = sequence.c
        query = sa.select(known.word, known.cycle, known.element).where(known.p == p)
        if selection.contains is not None:
            query = query.where(containing(known.word, selection.contains))
        with closing(connection.execute(query.order_by(known.word)).cursor) as cursor:
            while block := cursor.fetchmany(_BLOCK):
                found = _block(classes, columns, p, block)
                if len(found):
                    yield found


def _block(classes: _Classes, columns: Sequence[str], p: int, block: Sequence[Any]) -> ColumnBlock:
    """Return the columns of those of some words whose class is chosen."""
    words, cycles, elements = zip(*block, strict=True)
    need_words(words, [p] * len(words))
    need_elements(set(elements))
    wanted = np.array([number or 0 for number in cycles], np.int64)
    chosen, places = places_of(wanted, classes.numbers)
    symbols = from_strings(words)[chosen]
    images = np.array([element or 0 for element in elements], np.int64)[chosen]

    def column(name: str) -> Column:
        if name in _NAMES:
            return (symbols + np.uint8(ord("0"))).view(f"S{p}")[:, 0]
        if name == "rules":
            nothing = np.zeros(len(chosen), np.int64)
            return Lists(np.zeros(0, np.int64), nothing, np.ones(len(chosen), np.bool_))
        if name == "element":
            return images
        if name == _COORDINATES:
            return classes.images(places, symbols, images)
        return classes.values[name][places]

    return ColumnBlock([column(name) for name in columns])


def _read_classes(
    connection: sa.Connection, selection: Selection, columns: Sequence[str], p: int
) -> _Classes | None:
    """Read what is asked for of the chosen classes of one period; None if there are none."""
    known = class_view().c
    wanted = [name for name in dict.fromkeys(("cycle", "representative", *columns)) if name not in _OF_WORDS]
    query = sa.select(*(known[name] for name in wanted))
    query = query.where(*conditions_of(selection, known), known.p == p).order_by(known.class_order)
    parts: list[dict[str, NDArray[Any]]] = []
    places: list[NDArray[np.float64]] = [np.zeros((0, p))]
    with answering(connection, selection, Patience()):
        cursor = connection.execute(query).cursor
        while block := cursor.fetchmany(_BLOCK):
            found = dict(zip(wanted, zip(*block, strict=True), strict=True))
            need_words(found["representative"], [p] * len(block))
            blobs = found.pop(_COORDINATES, (None,) * len(block))
            places.append(coordinates_of([blob for blob in blobs if blob is not None], p))
            parts.append({name: _array(name, values) for name, values in found.items()})
            parts[-1][_COORDINATES] = np.array([blob is not None for blob in blobs], np.bool_)
    if not parts:
        return None
    values = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    present = values.pop(_COORDINATES)
    rows = np.where(present, np.cumsum(present) - 1, -1)
    least = values["representative"].view(np.uint8).reshape(-1, p) - np.uint8(ord("0"))
    return _Classes(values["cycle"], values, least, rows, np.concatenate(places))


def _array(name: str, values: Sequence[Any]) -> NDArray[Any]:
    """Return the values of a column, as `orbitdb.column_blocks.Column` has them."""
    try:
        return np.array(values, _TYPES.get(kind_of(name), np.bytes_))
    except (TypeError, ValueError, OverflowError) as error:
        raise unsound("a value of a class in the column", name) from error
