"""The rows of a chosen subset: every question for one is a single query of SQLite.

Geometrically pruned words have no class; they are found only if the selection names their status.
"""

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray
from sqlalchemy import Boolean, ColumnElement, FromClause, func, select, type_coerce
from sqlalchemy.sql.base import ReadOnlyColumnCollection

from orbitdb.arrays import Integers, Values
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import IN_CATALOGUE, WRITTEN, kind_of
from orbitdb.errors import AlteredError, check_text
from orbitdb.magnetic.action import area_slopes
from orbitdb.orbits.status import Status
from orbitdb.store import tables as t
from orbitdb.store import views
from orbitdb.store.connection import cursor_of, driver_of, never
from orbitdb.store.lives import NEAR
from orbitdb.store.selection import Selection, SelectionError, unknown_column
from orbitdb.store.where import CancelledError, Patience, check, expression, watched
from orbitdb.symbols.symmetry import image_coordinates, images_of_pattern
from orbitdb.symbols.words import from_strings

VIEWED = tuple(column.name for column in IN_CATALOGUE)
"""The columns of the view ``catalogue``."""

COORDINATES = "coordinates"
AREA_SLOPE = "area_slope"
COLUMNS = (*views.CLASS_COLUMNS, *views.WORD_COLUMNS, COORDINATES, AREA_SLOPE)
"""The columns that can be read: those of the view ``catalogue``, the coordinates, and computed ones."""

ROTATION_COLUMNS = ("code", "element", "area")
"""Columns whose values differ between the words of a class."""

ROWS = 1 << 12

_KEYS = ("p", "cycle", "representative", "code", "element")
"""The columns that decide the order of rows with equal sort keys, and from which others are computed."""


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
        Whether a class with chosen words has one row, for its representative.
    """

    selection: Selection
    order: str = "p"
    by_class: bool = False

    def rows(self, names: Sequence[str]) -> FromClause:
        """Return the rows, in no order, with the named columns, the sort keys and `_KEYS`."""
        listed = dict.fromkeys([*names, *parse_order(self.order), *_KEYS])
        sources = []
        for view in _views(self.selection, self.by_class):
            values = (_value(view, name, self.by_class).label(name) for name in listed)
            sources.append(select(*values).where(*self._found(view)))
        return (sources[0] if len(sources) == 1 else sa.union_all(*sources)).subquery("words")

    def _found(self, view: FromClause) -> list[ColumnElement[bool]]:
        if not self.by_class or view.c is views.catalogue.c or is_of_classes(self.selection):
            return conditions_of(self.selection, view)
        own = views.catalogue
        chosen = select(own.c.cycle).where(*conditions_of(self.selection, own))
        return [view.c.a == self.selection.a, view.c.cycle.in_(chosen)]

    def sorting(self, connection: sa.Connection, rows: FromClause) -> list[ColumnElement[Any]]:
        """Return the sort keys of the rows; the natural order is that of the ids, which the views have."""
        keys = parse_order(self.order)
        natural: list[ColumnElement[Any]] = [rows.c.cycle, rows.c.element]
        if _is_mixed(connection, self.selection):
            least = func.coalesce(rows.c.representative, rows.c.code)
            natural = [rows.c.p, rows.c.cycle.is_(None), least, rows.c.element]
        elif [*keys.items()][-1:] == [("p", False)]:
            keys = dict([*keys.items()][:-1])  # because ids increase with the period
        # NULL is SQLite's least value, so it comes last in descending orders anyway
        sorting = [
            rows.c[name].desc() if falls else rows.c[name].asc().nulls_last() for name, falls in keys.items()
        ]
        return [*sorting, *natural]


def _views(selection: Selection, by_class: bool) -> Iterator[FromClause]:
    """Yield what to query: stored words or classes, and pruned words."""
    if selection.statuses != (Status.GEOMETRIC,):
        yield views.classes.alias("catalogue") if by_class else views.catalogue
    if Status.GEOMETRIC in selection.statuses:
        yield views.pruned_at(selection.a)


def _value(view: FromClause, name: str, by_class: bool) -> ColumnElement[Any]:
    """Return a column of the rows; a class has the values of its representative."""
    if by_class and "id" not in view.c:
        name = "representative" if name == "code" else name
        if name == "element":
            return sa.literal(0)
    return view.c[name] if name in view.c else sa.null()


def _is_mixed(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether there may be words, pruned or long, whose ids do not increase with the period."""
    long = select(select(t.cycle.c.id).where(t.cycle.c.id >= t.LONG).exists())
    return Status.GEOMETRIC in selection.statuses or bool(connection.scalar(long))


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


# counts and classes


def count(connection: sa.Connection, selection: Selection, by_class: bool = False) -> int:
    """Return the number of chosen words, or of classes with chosen words."""
    with _answering(connection, selection):
        if by_class or not is_of_classes(selection):
            rows = Words(selection, by_class=by_class).rows(("p",))
            return connection.scalar(select(func.count()).select_from(rows)) or 0
        totals = (
            select(func.sum(func.coalesce(view.c.class_size, 1))).where(*conditions_of(selection, view))
            for view in _views(selection, True)
        )
        return sum(connection.scalar(total) or 0 for total in totals)


def classes_of(
    connection: sa.Connection, selection: Selection, columns: Sequence[str] = ()
) -> tuple[Integers, Integers, dict[str, NDArray[Any]]]:
    """Return the ids of the classes with chosen words, their numbers of chosen words, and some columns."""
    whole, sources = is_of_classes(selection), []
    for view in _views(selection, whole):
        pruned = "id" in view.c
        number = sa.literal(1) if pruned else view.c.class_size if whole else func.count()
        first = [(view.c.id if pruned else view.c.cycle).label("cycle"), number.label("words")]
        query = select(*first, *(_value(view, name, True).label(name) for name in columns))
        query = query.where(*conditions_of(selection, view))
        sources.append(query if whole or pruned else query.group_by(view.c.cycle))
    whole_query: sa.Select[Any] | sa.CompoundSelect[Any] = (
        sources[0] if len(sources) == 1 else sa.union_all(*sources)
    )
    with _answering(connection, selection):
        cursor = cursor_of(connection, whole_query.order_by(sa.text("1")))
        parts = [[np.zeros((2, 0), np.int64), *(as_array(name, ()) for name in columns)]]
        while block := cursor.fetchmany(ROWS):
            ids, words, *others = zip(*block, strict=True)
            parts.append([np.array([ids, words], np.int64), *map(as_array, columns, others)])
    (ids, words), *values = (np.concatenate(part, axis=-1) for part in zip(*parts, strict=True))
    return ids, words, dict(zip(columns, values, strict=True))


def as_array(name: str, values: Sequence[Any]) -> NDArray[Any]:
    """Return the values of a column as an array: of numbers, with NaN for NULL, or of objects."""
    return np.array(values, np.float64 if kind_of(name) == "number" else object)


# rows


def blocks_of(
    connection: sa.Connection, words: Words, names: Sequence[str], first: int = 0, last: int | None = None
) -> Iterator[list[Values]]:
    """Yield the named columns for rows first .. last - 1 of a subset, in blocks of rows.

    Raises
    ------
    SelectionError
        If a column is not one of `COLUMNS`.
    AlteredError
        If a row cannot be read because it was altered.
    """
    for name in names:
        if name not in COLUMNS:
            raise unknown_column(name, COLUMNS)
    stored = [name for name in names if name not in (COORDINATES, AREA_SLOPE)]
    listed = [*dict.fromkeys([*stored, *(_KEYS if len(stored) < len(names) else ())])] or ["p"]
    rows, driver = words.rows(listed), driver_of(connection)
    query = select(*(rows.c[name] for name in listed)).order_by(*words.sorting(connection, rows))
    query = query.limit(min(_MOST, max(0, (_MOST if last is None else last) - first))).offset(
        min(first, _MOST)
    )
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
        try:
            read = dict(zip(listed, zip(*block, strict=True), strict=True))
            yield [_column(connection, words, name, read) for name in names]
        except (LookupError, TypeError, ValueError) as error:
            raise AlteredError(f"a row of {words.selection.describe()}") from error


_MOST = 2**63 - 1
"""SQLite's largest integer."""


def rows_of(
    connection: sa.Connection, words: Words, names: Sequence[str], first: int = 0, last: int | None = None
) -> Iterator[tuple[Any, ...]]:
    """Yield rows first .. last - 1 of a subset as plain values; missing values are None."""
    for columns in blocks_of(connection, words, names, first, last):
        if driver_of(connection).cancelled():
            raise CancelledError
        yield from zip(*map(plain, columns), strict=True)


def plain(column: Values) -> Sequence[Any]:
    """Return a column as plain values; missing values are None."""
    if isinstance(column, np.ndarray):
        return [None if value != value else value for value in column.tolist()]
    return [value.tolist() if isinstance(value, np.ndarray) else value for value in column]


def _column(connection: sa.Connection, words: Words, name: str, read: Mapping[str, Sequence[Any]]) -> Values:
    """Return a column of some rows, given those that were read."""
    if name in (COORDINATES, AREA_SLOPE):
        return _computed(connection, words.selection.a, name, read)
    if name == "rules":
        return [[int(rule) for rule in text.split(",")] if text else [] for text in read[name]]
    return as_array(name, read[name]) if kind_of(name) == "number" else read[name]


def _computed(connection: sa.Connection, a: float, name: str, read: Mapping[str, Sequence[Any]]) -> list[Any]:
    """Return the coordinates of some words, or the derivatives of their areas in the curvature."""
    own, found = t.orbit.c, list[Any]([None] * len(read["p"]))
    ids = np.array([cycle for cycle in {*read["cycle"]} if cycle is not None], np.int64)
    query = select(own.cycle, own.coordinates).where(t.at_a(t.orbit, a), in_list(own.cycle, ids))
    blobs = dict(cursor_of(connection, query).fetchall())
    groups: dict[tuple[int, int], list[int]] = {}
    for row, (p, element, cycle) in enumerate(zip(read["p"], read["element"], read["cycle"], strict=True)):
        if blobs.get(cycle) is not None:
            groups.setdefault((p, element if name == COORDINATES else 0), []).append(row)
    for (p, element), rows in groups.items():
        places = np.frombuffer(b"".join(blobs[read["cycle"][row]] for row in rows), dtype="<f8").reshape(
            -1, p
        )
        least = [read["representative"][row] for row in rows]
        values: Sequence[Any] = (
            area_slopes(Stadium(a), from_strings(least), places).tolist()
            if name == AREA_SLOPE
            else [*image_coordinates([read["code"][row] for row in rows], least, element, places)]
        )
        for row, value in zip(rows, values, strict=True):
            found[row] = value
    return found


def in_list(column: ColumnElement[int], ids: Integers) -> ColumnElement[bool]:
    """Return the condition that a column is one of many ids, which are passed as a single value."""
    listed = func.json_each(json.dumps(ids.tolist())).table_valued("value")
    return column.in_(select(listed.c.value))


# where a word is among the rows


def position_of(connection: sa.Connection, words: Words, word: str) -> int | None:
    """Return the row number of a code in the subset, or None if it is not there."""
    rows = words.rows(())
    number = func.row_number().over(order_by=words.sorting(connection, rows)).label("number")
    numbered = select(number, rows).subquery()
    with _answering(connection, words.selection):
        place = connection.scalar(select(numbered.c.number).where(numbered.c.code == word))
    return None if place is None else int(place) - 1


# conditions and orders as SQL


_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def conditions_of(selection: Selection, view: FromClause) -> list[ColumnElement[bool]]:
    """Return a selection as conditions on a view with the name ``catalogue``.

    The expression of the selection must have been checked (`is_of_classes`).
    """
    own = view.c
    found = [own.a == selection.a, t.in_spans(own.p, selection.periods)]
    if selection.statuses:
        found.append(own.status.in_([status.value for status in selection.statuses]))
    if selection.time_reversal:
        found.append(own.time_reversal == selection.time_reversal)
    if selection.symmetry:
        found.append(own.symmetry == selection.symmetry)
    found += [_lives_at(view, a) > 0 for a in selection.exists]
    found += [_lives_at(view, a) <= 0 for a in selection.not_at]
    for name, (low, high) in selection.ranges.items():
        found += [] if low is None else [own[name] >= low]
        found += [] if high is None else [own[name] <= high]
    if selection.contains is not None:
        found.append(_has(own, selection.contains))
        if len(selection.contains) <= _LONGEST_PATTERN and "id" not in own:
            found.append(own.cycle.in_(select(t.cycle.c.id).where(_needed_symbols(selection.contains))))
    found += [sa.not_(_has(own, pattern)) for pattern in selection.without]
    if selection.where is not None:
        found.append(type_coerce(expression(selection.where, selection.parameters), Boolean))
    return found


def _has(own: ReadOnlyColumnCollection[str, Any], pattern: str) -> ColumnElement[bool]:
    """Return the condition that a cyclic word contains a pattern.

    SQLite's own function is faster, but sees all positions only if the pattern is short enough.
    """
    inside = func.instr(own.code.concat(own.code), pattern) > 0
    found = func.iif(own.p >= len(pattern) - 1, inside, func.contains(own.code, pattern))
    return type_coerce(found, Boolean)


def _lives_at(view: FromClause, a: float) -> ColumnElement[Any]:
    """Return the births minus the deaths of a class up to an a, or NULL if no births are stored.

    A class does not count as an orbit if a is within the error of a birth or death, where the orbit may run
    exactly through a joint.
    """
    own = t.change.c
    counted = sa.case(
        (sa.and_(own.kind == t.BORN, own.a + NEAR * own.error < a), 1),
        (sa.and_(own.kind == t.DIED, own.a - NEAR * own.error <= a), -1),
        else_=0,
    )
    return select(func.sum(counted)).where(own.cycle == view.c.cycle).scalar_subquery()


def is_of_classes(selection: Selection) -> bool:
    """Tell whether each class is chosen with all its words or not at all.

    Raises `SelectionError` if the expression of the selection is invalid.
    """
    by_class = selection.where is None or check(selection.where, selection.parameters).of_classes
    return by_class and selection.contains is None and not selection.without


def asks_of_lives(selection: Selection, names: Sequence[str] = (), order: str = "p") -> bool:
    """Tell whether a subset, its columns or its order depends on births and deaths."""
    named: set[str | None] = {*selection.ranges, *names, *parse_order(order)}
    if selection.where is not None:
        named |= check(selection.where, selection.parameters).columns
    return bool(selection.exists or selection.not_at or named & {"born", "dies"})


def parse_order(order: str) -> dict[str, bool]:
    """Return the columns to sort by, each mapped to whether its order is descending.

    Raises `SelectionError` if the text cannot be read or names an unknown column.
    """
    check_text("order", order, "length desc")
    keys: dict[str, bool] = {}
    for part in order.split(","):
        key = _ORDER.fullmatch(part.strip())
        if key is None:
            raise SelectionError(f"order {order!r}: write columns such as 'length' or 'p,lambda_c desc'")
        falling = bool(key[1]) != ((key[3] or "").lower() == "desc")
        if key[2] in set(WRITTEN) - set(VIEWED):
            raise SelectionError(
                f"order {order!r}: column {key[2]} is computed afterwards, for the chosen rows"
            )
        if key[2] not in VIEWED:
            raise unknown_column(key[2], VIEWED)
        keys.setdefault(key[2], falling)
    return keys


_LONGEST_PATTERN = 40
"""Number of symbols of a pattern beyond which the texts of its images would take too long to compare."""


def _needed_symbols(pattern: str) -> ColumnElement[bool]:
    """Return a condition that the table `cycle` fulfils for each class with words that contain a pattern.

    SQLite then need not look at most words, eight to a class, which is what takes long.
    """
    own = t.cycle.c
    twice = own.word.concat(own.word)
    images = (func.instr(twice, image) > 0 for image in sorted(images_of_pattern(pattern)))
    return sa.or_(own.p < len(pattern) - 1, *images)
