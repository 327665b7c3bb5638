"""The rows of a chosen subset, and how they are read.

A subset consists of two arrays: its symmetry classes in the wanted order, and for each class a bit mask of
its chosen words. The number of set bits is the size of the subset, and a page is a slice of their cumulative
count. Averages weight a class by its number of bits. A third array is needed only to sort single words.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, Connection, func, null, select

from orbitdb.arrays import Floats, Indices, Integers, Masks, Values
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import kind_of
from orbitdb.errors import AlteredError, DeletedError
from orbitdb.magnetic.action import area_slopes
from orbitdb.store import views
from orbitdb.store.connection import cursor_of, driver_of
from orbitdb.store.selection import Selection, unknown_column
from orbitdb.store.tables import LONG
from orbitdb.store.where import CancelledError
from orbitdb.symbols.symmetry import (
    BITS_OF,
    ELEMENT_OF,
    STABILISER_OF,
    act_on_areas,
    image_coordinates,
    packed_members,
)
from orbitdb.symbols.words import BITS, MAX_KEYED, from_strings, pack, packed

COUNTS = BITS_OF.sum(axis=1, dtype=np.uint8)
"""Number of set bits for each value of a byte."""

_NTH = np.argsort(1 - BITS_OF, axis=1, kind="stable").astype(np.uint8)
"""Positions of the set bits for each value of a byte, beginning with the lowest."""


class WordIndices(NamedTuple):
    """Words, each given by the id of its class and its position in the class, from 0.

    Geometrically pruned words have negative ids and position 0.
    """

    ids: Integers
    places: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class SelectedWords:
    """A chosen subset of the words stored at one value of a.

    Attributes
    ----------
    selection : Selection
        What was chosen.
    ids : ndarray of int64, shape (C,)
        Ids of the classes with chosen words, in the order of the rows; a pruned word has a negative id.
    masks : ndarray of uint8, shape (C,)
        Masks of the chosen words: bit n is set if word n of the class is chosen.
    rows : ndarray of uint32, shape (N,), or None
        The numbers of the words in the order of the rows; None if they follow the order of the classes.
    values : mapping of str to ndarray, shape (C,)
        The columns of the classes that were asked for.
    """

    selection: Selection
    ids: Integers
    masks: Masks
    rows: NDArray[np.uint32] | None = None
    values: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __len__(self) -> int:
        return int(self.ends[-1]) if len(self.ends) else 0

    @property
    def counts(self) -> NDArray[np.uint8]:
        """Number of chosen words of each class, shape (C,)."""
        return COUNTS[self.masks]

    @cached_property
    def ends(self) -> Integers:
        """Number of chosen words up to and including each class, shape (C,)."""
        return np.cumsum(self.counts, dtype=np.int64)

    def words(self, first: int = 0, last: int | None = None) -> WordIndices:
        """Return the words in rows first .. last - 1."""
        numbers = self._numbers(first, last)
        classes = np.searchsorted(self.ends, numbers, side="right")
        masks = self.masks[classes]
        before = numbers - (self.ends[classes] - COUNTS[masks])
        return WordIndices(self.ids[classes], _NTH[masks, before])

    def classes(self, first: int = 0, last: int | None = None) -> Indices:
        """Return the index in `ids` of the class of each of the rows first .. last - 1."""
        return np.searchsorted(self.ends, self._numbers(first, last), side="right")

    def _numbers(self, first: int, last: int | None) -> Integers:
        last = len(self) if last is None else min(last, len(self))
        if self.rows is None:
            return np.arange(first, max(first, last))
        return self.rows[first:last].astype(np.int64)

    def position(self, number: int, place: int) -> int | None:
        """Return the row number of a word, given by class id and position in the class, or None."""
        return self.first(np.where(self.ids == number, 1 << place, 0).astype(np.uint8))

    def first(self, masks: Masks) -> int | None:
        """Return the number of the first row whose word is in the given masks, shape (C,), or None."""
        inside = BITS_OF[self.masks & masks][BITS_OF[self.masks] > 0]
        numbers = np.flatnonzero(inside if self.rows is None else inside[self.rows])
        return int(numbers[0]) if len(numbers) else None


def as_array(name: str, values: Sequence[Any]) -> NDArray[Any]:
    """Return the values of a column as an array: of numbers, with NaN for NULL, or of objects."""
    return np.array(values, np.float64 if kind_of(name) == "number" else object)


def in_list(column: ColumnElement[int], ids: Integers) -> ColumnElement[bool]:
    """Return the condition that a column is one of many ids, which are passed as a single value."""
    listed = func.json_each(json.dumps(ids.tolist())).table_valued("value")
    return column.in_(select(listed.c.value))


def periods_of(ids: Integers) -> Integers:
    """Return the periods of classes and pruned words, given their ids.

    The period is `MAX_KEYED` + 1 for all words too long for a key.
    """
    keys = np.abs(ids)
    ends = np.int64(1) << BITS * np.arange(1, MAX_KEYED + 1, dtype=np.int64)
    periods = np.searchsorted(ends, keys, side="right")
    periods[keys >= LONG] = MAX_KEYED + 1
    return periods


# orders of words


ROTATION_COLUMNS = ("code", "element", "area")
"""Columns whose values differ between the words of a class, and by which words can be sorted."""


def stabilisers_of(symmetries: Values) -> Masks:
    """Return the stabilisers with the given labels; that of a pruned word, without a label, is the least."""
    return np.array([STABILISER_OF.get(label, 1) for label in symmetries], np.uint8)


def sorted_words(
    connection: Connection,
    chosen: SelectedWords,
    keys: Mapping[str, bool],
    values: Mapping[str, NDArray[Any]],
) -> NDArray[np.uint32]:
    """Return the numbers of the words of a subset in another order; ties stay in the order of classes.

    Parameters
    ----------
    connection, chosen
    keys : mapping of str to bool
        The columns to sort by, with whether the order is descending. Missing values come last.
    values : mapping of str to ndarray, shape (C,)
        For each class these columns, as far as they have them, and ``symmetry``.
    """
    owners, places = chosen.classes(), chosen.words().places
    stabilisers = stabilisers_of(values["symmetry"])
    elements = ELEMENT_OF[stabilisers[owners], places]
    sorting: list[NDArray[Any]] = []
    for name, falls in keys.items():
        columns: Sequence[NDArray[Any]]
        if name == "code":
            columns = _codes(connection, chosen, stabilisers, owners)
        elif name == "element":
            columns = [np.where(chosen.ids[owners] < 0, np.nan, elements)]
        elif name == "area":
            columns = [act_on_areas(elements, values[name][owners])]
        else:
            ranks = values[name] if kind_of(name) == "number" else _ranks(values[name].tolist())
            columns = [ranks[owners]]
        sorting += [-column if falls else column for column in columns]
    return np.lexsort(sorting[::-1]).astype(np.uint32)


def _ranks(values: Sequence[Any]) -> Floats:
    """Return numbers that sort like the values; NaN for missing ones."""
    ranks = {value: rank for rank, value in enumerate(sorted(set(values) - {None}), 1)}
    return np.array([ranks.get(value, np.nan) for value in values], np.float64)


def _codes(
    connection: Connection, chosen: SelectedWords, stabilisers: Masks, owners: Indices
) -> list[Integers]:
    """Return two integers for each row that sort like the codes: the first `MAX_KEYED` symbols, the rest."""
    begin, rest = np.zeros((2, len(chosen)), np.int64)
    periods = periods_of(chosen.ids)
    for p in np.unique(periods).tolist():
        group = periods == p
        rows = np.flatnonzero(group[owners])
        if p <= MAX_KEYED:
            packed_least = packed(np.abs(chosen.ids[group]), p)
            codes = [*packed_members(packed_least, p, chosen.masks[group], stabilisers[group])]
            begin[rows] = _aligned(np.concatenate(codes), p)
        else:
            part = SelectedWords(chosen.selection, chosen.ids[group], chosen.masks[group])
            texts = [code for (block,) in blocks_of(connection, part, ("code",)) for code in block]
            begin[rows] = _aligned(pack(from_strings([text[:MAX_KEYED] for text in texts])), MAX_KEYED)
            rest[rows] = _ranks([text[MAX_KEYED:] for text in texts])
    return [begin, rest]


def _aligned(codes: Integers, p: int) -> Integers:
    """Return packed words of period p as integers that sort like texts, so that a beginning comes first."""
    ones = sum(1 << BITS * place for place in range(p))  # every symbol counts more than none
    return (codes + np.int64(ones)) << np.int64(BITS * (MAX_KEYED - p))


# reading


COORDINATES = "coordinates"
AREA_SLOPE = "area_slope"
COLUMNS = (*views.CLASS_COLUMNS, *views.WORD_COLUMNS, COORDINATES, AREA_SLOPE)
"""The columns that can be read: those of the view ``catalogue``, the coordinates, and computed ones."""

ROWS, _LONG_ROWS = 1 << 13, 16
"""Numbers of rows per block; the second is for words too long for a key, of up to a million symbols."""


class _MissingError(LookupError):
    """Some of the wanted rows are not stored."""


def blocks_of(
    connection: Connection,
    chosen: SelectedWords,
    names: Sequence[str],
    first: int = 0,
    last: int | None = None,
) -> Iterator[list[Values]]:
    """Yield the named columns for rows first .. last - 1 of a subset, in blocks of rows.

    Raises
    ------
    SelectionError
        If a column is not one of `COLUMNS`.
    StoreError
        If a row cannot be read because it was altered.
    """
    for name in names:
        if name not in COLUMNS:
            raise unknown_column(name, COLUMNS)
    last = len(chosen) if last is None else min(last, len(chosen))
    for start in range(first, last, ROWS):
        words = chosen.words(start, min(start + ROWS, last))
        step = ROWS if periods_of(words.ids).max(initial=0) <= MAX_KEYED else _LONG_ROWS
        for begin in range(0, len(words.ids), step):
            part = slice(begin, begin + step)
            ids, inverse = np.unique(words.ids[part], return_inverse=True)
            try:
                shared = _classes(connection, chosen.selection.a, ids, names)
                if AREA_SLOPE in names:
                    shared[AREA_SLOPE] = _area_slopes(chosen.selection.a, shared)
                block = _Block(shared, inverse, words.places[part])
                columns = [block.column(name) for name in names]
            except _MissingError as error:
                raise DeletedError(f"some of the classes with ids from {ids[0]} to {ids[-1]}") from error
            except (LookupError, TypeError, ValueError) as error:
                raise AlteredError(f"a row of the classes with ids from {ids[0]} to {ids[-1]}") from error
            yield columns


def rows_of(
    connection: Connection,
    chosen: SelectedWords,
    names: Sequence[str],
    first: int = 0,
    last: int | None = None,
) -> Iterator[tuple[Any, ...]]:
    """Yield rows first .. last - 1 of a subset as plain values; missing values are None."""
    for columns in blocks_of(connection, chosen, names, first, last):
        if driver_of(connection).cancelled():
            raise CancelledError
        yield from zip(*map(plain, columns), strict=True)


def plain(column: Values) -> Sequence[Any]:
    """Return a column as plain values; missing values are None."""
    if isinstance(column, np.ndarray):
        return [None if value != value else value for value in column.tolist()]
    return [value.tolist() if isinstance(value, np.ndarray) else value for value in column]


def _classes(connection: Connection, a: float, ids: Integers, wanted: Sequence[str]) -> dict[str, Any]:
    """Return the columns that are needed, with classes in the order of ids."""
    needed = [COORDINATES if name == AREA_SLOPE else name for name in wanted]
    shared = [
        name for name in needed if name in views.CLASS_COLUMNS or name in (COORDINATES, "rules", "area")
    ]
    names = tuple(dict.fromkeys(["p", "representative", "words", "symmetry", *shared]))
    pruned = views.pruned_at(a)
    rows: list[tuple[Any, ...]] = []
    for view, number, part in (
        (pruned, pruned.c.id, ids[ids < 0]),
        (views.classes, views.classes.c.cycle, ids[ids >= 0]),
    ):
        if len(part):
            listed = [(view.c[name] if name in view.c else null()).label(name) for name in names]
            query = select(number.label("number"), *listed).where(view.c.a == a, in_list(number, part))
            rows += sorted(cursor_of(connection, query).fetchall(), key=itemgetter(0))
    numbers, *columns = zip(*rows, strict=True) if rows else [()] * (1 + len(names))
    if list(numbers) != ids.tolist():
        raise _MissingError
    return dict(zip(names, columns, strict=True))


def _area_slopes(a: float, shared: dict[str, Any]) -> list[float | None]:
    """Return the derivatives of the areas of classes in the curvature; None for classes without an orbit."""
    slopes: list[float | None] = [None] * len(shared["p"])
    groups: dict[int, list[int]] = {}
    for row, (p, blob) in enumerate(zip(shared["p"], shared[COORDINATES], strict=True)):
        if blob is not None:
            groups.setdefault(p, []).append(row)
    for p, rows in groups.items():
        words = from_strings([shared["representative"][row] for row in rows])
        places = np.frombuffer(b"".join(shared[COORDINATES][row] for row in rows), dtype="<f8")
        for row, slope in zip(rows, area_slopes(Stadium(a), words, places.reshape(-1, p)), strict=True):
            slopes[row] = float(slope)
    return slopes


class _Block:
    """N words of a block: the columns of their classes, and for each word its class and its place there."""

    def __init__(self, shared: dict[str, Any], owners: Indices, places: NDArray[np.uint8]) -> None:
        self.shared, self.owners, self.rows = shared, owners, owners.tolist()
        self.places = places
        spans = [(shared["words"][row], shared["p"][row]) for row in self.rows]
        numbered = zip(spans, places.tolist(), strict=True)
        self.words = [words[p * place : p * (place + 1)] for (words, p), place in numbered]

    @cached_property
    def elements(self) -> Masks:
        """The elements that lead to the words; 0 for pruned words."""
        if unknown := set(self.shared["symmetry"]) - STABILISER_OF.keys() - {None}:
            raise LookupError(f"symmetries {unknown}")
        return ELEMENT_OF[stabilisers_of(self.shared["symmetry"])[self.owners], self.places]

    def column(self, name: str) -> Values:
        """Return a column of the words."""
        if name == "code":
            return self.words
        if name == COORDINATES:
            return self._coordinates()
        if name == "element":
            labels = self.shared["symmetry"]
            own = zip(self.rows, self.elements.tolist(), strict=True)
            return [None if labels[row] is None else element for row, element in own]
        values = self.shared[name]
        if kind_of(name) == "number":
            numbers = as_array(name, values)[self.owners]
            return act_on_areas(self.elements, numbers) if name == "area" else numbers
        if name == "rules":
            values = [[int(rule) for rule in text.split(",")] if text else [] for text in values]
        return [values[row] for row in self.rows]

    def _coordinates(self) -> list[Floats | None]:
        """Return the coordinates of the words, from those of the representatives and the symmetries."""
        blobs, least = self.shared[COORDINATES], self.shared["representative"]
        coordinates: list[Floats | None] = [None] * len(self.rows)
        groups: dict[tuple[int, int], list[int]] = {}
        for row, (own, element) in enumerate(zip(self.rows, self.elements.tolist(), strict=True)):
            if blobs[own] is not None:
                groups.setdefault((len(self.words[row]), element), []).append(row)
        for (p, element), members in groups.items():
            owners = [self.rows[row] for row in members]
            places = np.frombuffer(b"".join(blobs[own] for own in owners), dtype="<f8").reshape(-1, p)
            texts = [least[own] for own in owners]
            images = image_coordinates([self.words[row] for row in members], texts, element, places)
            for row, image in zip(members, images, strict=True):
                coordinates[row] = image
        return coordinates
