"""The rows of a chosen subset: every question for them is a single query of SQLite.

Geometrically pruned words have no class; they are found only if the selection names their status.
"""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, FromClause, func, select

from orbitdb.arrays import Integers
from orbitdb.columns import kind_of
from orbitdb.criteria import unknown_column
from orbitdb.errors import DeletedError
from orbitdb.orbits.status import Status
from orbitdb.selection import Selection
from orbitdb.store import tables as t
from orbitdb.store import views
from orbitdb.store.conditions import conditions_of, is_of_classes, may_choose_pruned, parse_order
from orbitdb.store.lookup import area_slopes_of, coordinates_of
from orbitdb.store.sqlite import cursor_of, driver_of, never
from orbitdb.store.where import CancelledError, Patience, watched
from orbitdb.symbols.symmetry import (
    ELEMENT_OF,
    REVERSE,
    SIZES,
    STABILISER_OF,
    class_of,
    images_of,
)
from orbitdb.symbols.words import least_rotation

WORDS = "words"
COORDINATES, AREA_SLOPE, REVERSED = "coordinates", "area_slope", "reverse"
_COMPUTED = (COORDINATES, AREA_SLOPE, REVERSED)
ROW_COLUMNS = (*views.VIEWED, WORDS, *_COMPUTED)
"""The columns that can be read: those of the view, the number of chosen words, and computed ones."""

ROWS = 1 << 9
"""Number of rows that are fetched at once; with 4096, reading every row takes a third longer."""

ROW_KEY = np.dtype([("id", "i8"), ("element", "u1")])
"""What names a row: the id of its class or pruned word, and the element that leads to the word."""

_KEYS = ("id", "p", "representative", "code", "element")
"""The columns that decide the order of rows with equal sort keys, and from which others are computed."""

_NEVER_NULL = ("p", "code", "status")
"""Columns that every row has; SQLite compares texts faster where NULL has no place of its own."""

_SHARED = views.CLASS_COLUMNS.keys() - {"p", "a", "status"}
"""The columns that the words of a class share, and that pruned words do not have."""

_MOST = 2**63 - 1
"""SQLite's largest integer."""


@dataclass(frozen=True)
class Words:
    """A chosen subset of the words stored at one value of a, in an order.

    Attributes
    ----------
    selection : Selection
    order : str
        Columns to sort by, separated by commas; ``desc`` after a name, or ``-`` before it, reverses the
        order. Ties are broken by period, representative and element, in ascending order.
    by_class : bool
        Whether a class has one row, for the least of its chosen words.
    """

    selection: Selection
    order: str = "p"
    by_class: bool = False

    def rows(
        self, connection: sa.Connection, names: Sequence[str], ids: Integers | None = None
    ) -> FromClause:
        """Return the rows, in no order, with the named columns, the sort keys and `_KEYS`.

        With `ids`, return only those of these classes and pruned words.
        """
        listed = dict.fromkeys([*names, *parse_order(self.order), *_KEYS])
        whole, queries = is_of_classes(self.selection) and self.by_class, []  # the former checks expressions
        for view in _views(connection, self.selection, whole):
            own = _values(view, self.by_class)
            query = select(*(own[name].label(name) for name in listed))
            query = query.where(*conditions_of(self.selection, view))
            query = query if ids is None else query.where(t.in_list(own["id"], ids.tolist()))
            queries.append(query.group_by(own["id"]) if self.by_class and not whole else query)
        return (queries[0] if len(queries) == 1 else sa.union_all(*queries)).subquery("words")

    def sorting(self, connection: sa.Connection, rows: FromClause) -> list[ColumnElement[Any]]:
        """Return the sort keys of the rows; the natural order is that of the ids, which the views have."""
        keys = parse_order(self.order)
        natural: list[ColumnElement[Any]] = [rows.c.id, rows.c.element]
        if _is_mixed(connection, self.selection):
            least = func.coalesce(rows.c.representative, rows.c.code)
            natural = [rows.c.p, rows.c.id < 0, least, rows.c.element]
        elif [*keys.items()][-1:] == [("p", False)]:
            keys = dict([*keys.items()][:-1])  # because ids increase with the period
        return [*(_sorted_by(rows.c[name], falls) for name, falls in keys.items()), *natural]


def _sorted_by(column: ColumnElement[Any], falls: bool) -> ColumnElement[Any]:
    """Return a sort key that puts missing values last."""
    if falls:
        return column.desc()  # NULL is SQLite's least value
    return column.asc() if column.name in _NEVER_NULL else column.asc().nulls_last()


def _views(connection: sa.Connection, selection: Selection, whole: bool) -> Iterator[FromClause]:
    """Yield what to query: whole classes or stored words, and pruned words; each is called ``catalogue``."""
    only_pruned = selection.statuses == (Status.GEOMETRIC,)
    if not only_pruned:
        yield views.classes.alias("catalogue") if whole else views.catalogue
    if only_pruned or _has_pruned(connection, selection):
        yield views.pruned_at(selection.a)


def _has_pruned(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether there may be pruned words; a second view takes SQLite longer, even an empty one."""
    stored = select(select(t.pruned.c.id).exists())
    return may_choose_pruned(selection) and bool(connection.scalar(stored))


def _values(view: FromClause, by_class: bool) -> Mapping[str, ColumnElement[Any]]:
    """Return the columns of the rows of a view.

    Where rows are grouped by class, SQLite takes the other columns from the row with the least code.
    """
    none: Mapping[str, ColumnElement[Any]] = {name: sa.null() for name in views.WORD_COLUMNS}
    own = {**none, **view.c}
    if "id" in own:  # pruned words
        return {**own, WORDS: sa.literal(1)}
    own["id"] = own["cycle"]
    if view is not views.catalogue:
        return {**own, "code": own["representative"], "element": sa.literal(0), WORDS: own["class_size"]}
    if by_class:
        return {**own, "code": func.min(own["code"]), WORDS: func.count()}
    return {**own, WORDS: sa.literal(1)}


def _is_mixed(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether there may be words, pruned or long, whose ids do not increase with the period."""
    long = select(select(t.cycle.c.id).where(t.cycle.c.id >= t.LONG).exists())
    return _has_pruned(connection, selection) or bool(connection.scalar(long))


def _answering(
    connection: sa.Connection, selection: Selection, patience: Patience | None = None
) -> AbstractContextManager[None]:
    """Return a context in which to query a subset; it confines the expression of the subset, if any."""
    driver = driver_of(connection)
    if selection.where is not None:
        return watched(driver, patience or Patience(cancelled=driver.cancelled), selection.where)
    if driver.cancelled is never:
        return nullcontext()
    return watched(driver, Patience(math.inf, driver.cancelled))


# counts


def count(connection: sa.Connection, selection: Selection, by_class: bool = False) -> int:
    """Return the number of chosen words, or of classes with chosen words."""
    with _answering(connection, selection):
        whole = is_of_classes(selection)
        rows = Words(selection, by_class=by_class or whole).rows(connection, (WORDS,))
        number = func.sum(rows.c.words) if whole and not by_class else func.count()
        return connection.scalar(select(number).select_from(rows)) or 0


def counts_by(connection: sa.Connection, selection: Selection, names: Sequence[str]) -> list[tuple[Any, ...]]:
    """Return the numbers of chosen words and classes with each combination of values of some columns.

    Each row has the values, ascending, the number of words, and that of classes.
    """
    with _answering(connection, selection):
        whole = views.WORD_COLUMNS.keys().isdisjoint(names)
        rows = Words(selection, by_class=whole).rows(connection, (*names, WORDS))
        values = [rows.c[name] for name in names]
        numbers = func.sum(rows.c.words), func.count(sa.distinct(rows.c.id))
        found = connection.execute(select(*values, *numbers).group_by(*values).order_by(*values))
        return [tuple(row) for row in found]


# rows


def rows_of(
    connection: sa.Connection, words: Words, names: Sequence[str], first: int = 0, last: int | None = None
) -> Iterator[tuple[Any, ...]]:
    """Yield rows first .. last - 1 of a subset as plain values; missing values are None.

    Raises
    ------
    SelectionError
        If a column is not one of `ROW_COLUMNS`.
    AlteredError
        If a row cannot be read because it was altered.
    """
    for name in names:
        if name not in ROW_COLUMNS:
            raise unknown_column(name, ROW_COLUMNS)
    for block in _blocks(connection, words, names, first, last):
        if driver_of(connection).cancelled():
            raise CancelledError
        yield from zip(*block, strict=True)


def rows_at(
    connection: sa.Connection, words: Words, names: Sequence[str], keys: NDArray[np.void]
) -> list[tuple[Any, ...]]:
    """Return the rows with some keys, a part of `row_keys_of`; raise `DeletedError` if one is gone."""
    found: dict[tuple[int, int], tuple[Any, ...]] = {}
    listed = (*names, "id", "element")
    for block in _blocks(connection, words, listed, ids=np.unique(keys["id"])):
        found |= {(number, element or 0): tuple(row) for *row, number, element in zip(*block, strict=True)}
    try:
        return [found[key] for key in keys.tolist()]
    except KeyError:
        raise DeletedError("some of the rows") from None


def row_key_of(connection: sa.Connection, words: Words, word: str) -> tuple[int, int] | None:
    """Return the key of the row of a word, given as its least rotation, or None if it has no row."""
    own = (t.pruned.c.p == len(word), t.pruned.c.word == word)
    pruned = connection.scalar(select(t.pruned.c.id).where(*own))
    least = class_of(word).representative
    number = t.class_ids(connection, [least])[least] if pruned is None else pruned
    for block in _blocks(connection, words, ("code", "element"), ids=np.array([number])):
        for code, element in zip(*block, strict=True):
            if words.by_class or code == word:
                return number, element or 0
    return None


def _blocks(
    connection: sa.Connection,
    words: Words,
    names: Sequence[str],
    first: int = 0,
    last: int | None = None,
    ids: Integers | None = None,
) -> Iterator[list[Sequence[Any]]]:
    """Yield the named columns of rows first .. last - 1, among those with some ids, in blocks of rows."""
    computed = [name for name in names if name in _COMPUTED]
    listed = dict.fromkeys([*(name for name in names if name not in computed), *(_KEYS if computed else ())])
    rows, driver = words.rows(connection, [*listed], ids), driver_of(connection)
    query = select(*(rows.c[name] for name in listed)).order_by(*words.sorting(connection, rows))
    most = _MOST if last is None else max(0, last - first)
    query = query.limit(min(most, _MOST)).offset(min(first, _MOST))
    patience = Patience(cancelled=driver.cancelled)
    with _answering(connection, words.selection, patience):
        cursor = cursor_of(connection, query)
        driver.statements.add(cursor)
    while True:
        driver_of(connection)  # raises `ClosedError` after the snapshot
        with _answering(connection, words.selection, patience):
            block = cursor.fetchmany(ROWS)
        if not block:
            return
        with t.readable(f"a row of {words.selection.describe()}"):
            read = dict(zip(listed, zip(*block, strict=True), strict=True))
            columns = [_column(connection, words.selection.a, name, read) for name in names]
        fetched = time.monotonic()
        yield columns
        patience.deadline += time.monotonic() - fetched


def _column(
    connection: sa.Connection, a: float, name: str, read: Mapping[str, Sequence[Any]]
) -> Sequence[Any]:
    """Return a column of some rows as plain values, given those that were read."""
    if name == COORDINATES:
        ends = np.cumsum(read["p"])[:-1]
        parts = np.split(coordinates_of(connection, a, read), ends)
        return [None if np.isnan(part[0]) else part.tolist() for part in parts]
    if name == AREA_SLOPE:
        return [None if slope != slope else slope for slope in area_slopes_of(connection, a, read)]
    if name == REVERSED:
        return [least_rotation(images_of(code)[REVERSE]) for code in read["code"]]
    if kind_of(name) == "integers":
        none: list[int] | None = [] if name == "rules" else None
        return [[int(part) for part in text.split(",")] if text else none for text in read[name]]
    return read[name]


# arrays


def arrays_of(
    connection: sa.Connection,
    words: Words,
    names: Sequence[str],
    last: int | None = None,
    ids: Integers | None = None,
) -> dict[str, NDArray[Any]]:
    """Return columns of the rows as arrays; missing numbers are NaN, missing integers 0, missing texts ''.

    What words share is read once a class, because fetching it for each word takes twice as long.
    """
    shared = [] if words.by_class else [name for name in names if name in _SHARED]
    own = [*dict.fromkeys(["id", *(name for name in names if name not in shared)])]
    parts: list[list[NDArray[Any]]] = [[_as_array(name, ())] for name in own]
    for block in _blocks(connection, words, own, last=last, ids=ids):
        with t.readable(f"a row of {words.selection.describe()}"):
            for name, part, values in zip(own, parts, block, strict=True):
                part.append(_as_array(name, values))
    found = {name: np.concatenate(part) for name, part in zip(own, parts, strict=True)}
    if shared:
        numbers, owner = np.unique(found["id"], return_inverse=True)
        every = Words(Selection(words.selection.a), by_class=True)
        classes = arrays_of(connection, every, shared, ids=numbers)
        in_order = np.argsort(classes["id"])
        pruned = [None] * (len(numbers) - len(in_order))  # their ids are negative
        for name in shared:
            found[name] = np.concatenate([_as_array(name, pruned), classes[name][in_order]])[owner]
    return found


def _as_array(name: str, values: Sequence[Any]) -> NDArray[Any]:
    """Return the values of a column as an array."""
    kind = "integer" if name == "id" else kind_of(name)
    if kind == "number":
        return np.array(values, np.float64)
    if kind == "integer":
        return np.array([value or 0 for value in values], np.int64)
    return np.array([value or "" for value in values], np.dtypes.StringDType())


def row_keys_of(connection: sa.Connection, words: Words) -> NDArray[np.void]:
    """Return the keys of all rows in order, shape (N,), with the fields of `ROW_KEY`.

    Where whole classes are chosen and sorted, SQLite sorts the classes, which are an eighth of the words.
    """
    apart = views.WORD_COLUMNS.keys() & parse_order(words.order).keys()
    if words.by_class or apart or not is_of_classes(words.selection):
        found = arrays_of(connection, words, ("element",))
        ids, elements = found["id"], found["element"]
    else:
        found = arrays_of(connection, replace(words, by_class=True), ("symmetry",))
        with t.readable(f"a row of {words.selection.describe()}"):
            masks = np.array([_STABILISERS[label] for label in found["symmetry"].tolist()], np.intp)
        sizes = SIZES[masks]
        ids, owners = np.repeat(found["id"], sizes), np.repeat(np.arange(len(sizes)), sizes)
        nth = np.arange(len(ids)) - (np.cumsum(sizes) - sizes)[owners]
        elements = ELEMENT_OF[masks[owners], nth]
    keys = np.empty(len(ids), ROW_KEY)
    keys["id"], keys["element"] = ids, elements
    return keys


_STABILISERS = STABILISER_OF | {"": (1 << 8) - 1}
"""The stabiliser with each symmetry label; a pruned word has none, and counts as one without other images."""
