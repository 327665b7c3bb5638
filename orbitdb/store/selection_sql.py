"""Find the classes and words of a chosen subset; every query for a selection comes through here.

Conditions with the same value for all words of a class are one query of the view `class`. Conditions on
single words are one query of the view `catalogue`. Orders of single words are sorted in memory, because
SQLite takes ten times as long to sort that many rows.

Geometrically pruned words have no class; they are found only if the selection names their status.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray
from sqlalchemy import Boolean, ColumnElement, FromClause, Integer, Select, func, select, type_coerce
from sqlalchemy.sql.base import ReadOnlyColumnCollection

from orbitdb.columns import IN_CATALOGUE, WRITTEN
from orbitdb.orbits.status import Status
from orbitdb.store import tables as t
from orbitdb.store import views
from orbitdb.store.connection import cursor_of, driver_of, never
from orbitdb.store.lives import NEAR
from orbitdb.store.rows import ROTATION_COLUMNS, SelectedWords, as_array, sorted_words, stabilisers_of
from orbitdb.store.selection import Selection, SelectionError, unknown_column
from orbitdb.store.where import Patience, check, expression, watched
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import ODD, class_of, images_of_pattern, members, places_of_elements

COLUMNS = tuple(column.name for column in IN_CATALOGUE)
"""The columns of the view ``catalogue``."""

BLOCK = 1 << 14

_FEW = 1 << 16
"""Above this many rows, SQLite sorts everything faster than it keeps the first N."""

_LARGEST = 2**63 - 1
"""SQLite's largest integer."""


def select_words(
    connection: sa.Connection,
    selection: Selection,
    order: str = "p",
    columns: Sequence[str] = (),
    most: int | None = None,
    counted: bool = False,
    by_class: bool = False,
    more: "Conditions | None" = None,
) -> SelectedWords:
    """Find a chosen subset in the catalogue.

    Parameters
    ----------
    connection, selection
    order : str, optional
        Columns to sort by, separated by commas; ``desc`` after a name, or ``-`` before it, reverses the
        order. Ties are broken by period, representative and element, in ascending order.
    columns : sequence of str, optional
        Further columns of the view ``class`` to read.
    most : int, optional
        Number of rows that are needed, from the first on; later rows may be in any order, or missing.
    counted : bool, optional
        Whether the total number of rows is needed even so.
    by_class : bool, optional
        Whether a class with chosen words has one row, for its representative.
    more : callable, optional
        Returns further conditions on the words of the view that it gets.
    """
    keys = parse_order(order)
    if by_class:
        renamed = {"representative" if name == "code" else name: falls for name, falls in keys.items()}
        keys = {name: falls for name, falls in renamed.items() if name != "element"}
    by_words = not by_class and any(name in keys for name in ROTATION_COLUMNS)
    of_words = more is not None or not is_of_classes(selection)
    names = [*columns, *(["symmetry", *(name for name in keys if name not in columns)] if by_words else [])]
    query = _classes(connection, selection, of_words, {} if by_words else keys, names, more)
    sorted_far = order != "p" and (most or 0) > _FEW
    if most is not None and not (counted or by_words or sorted_far):
        query = query.limit(min(most, _LARGEST))  # every class has at least one row
    own = ["mask", "symmetry"] if of_words else []
    with _answering(connection, selection):
        coded, *others = _arrays(connection, query, ("coded", *own, *names))
    sizes = np.uint8(1) << (coded & 3).astype(np.uint8)
    masks = ((np.uint16(1) << sizes) - 1).astype(np.uint8)
    ids = np.right_shift(coded, 2, out=coded)
    if of_words:
        elements, symmetries = others.pop(0).astype(np.uint8), others.pop(0)
        masks &= places_of_elements(elements, stabilisers_of(symmetries))
    if by_class:
        masks = np.ones_like(masks)
    read = dict(zip(names, others, strict=True))
    chosen = SelectedWords(selection, ids, masks, None, {name: read[name] for name in columns})
    return replace(chosen, rows=sorted_words(connection, chosen, keys, read)) if by_words else chosen


Conditions = Callable[[FromClause], list[ColumnElement[bool]]]


def _answering(connection: sa.Connection, selection: Selection) -> AbstractContextManager[None]:
    """Return a context in which to query a subset; it confines the expression of the subset, if any."""
    driver = driver_of(connection)
    if selection.where is not None:
        return watched(driver, Patience(cancelled=driver.cancelled), selection.where)
    return (
        nullcontext() if driver.cancelled is never else watched(driver, Patience(math.inf, driver.cancelled))
    )


def _classes(
    connection: sa.Connection,
    selection: Selection,
    of_words: bool,
    keys: Mapping[str, bool],
    columns: Sequence[str],
    more: Conditions | None,
) -> Select[Any]:
    """Return the query for the classes in order: their coded ids, then `columns`.

    If the subset is `of_words`, the elements of the chosen words and the symmetry follow the coded ids.
    """
    names = list(dict.fromkeys(["p", *columns, *keys]))
    sources: list[Select[Any]] = []
    if selection.statuses != (Status.GEOMETRIC,):
        sources.append(_stored(selection, of_words, names, more))
    if Status.GEOMETRIC in selection.statuses:
        sources.append(_pruned(selection, of_words, names, more))
    rows = (sources[0] if len(sources) == 1 else sa.union_all(*sources)).subquery()
    outputs = ["coded", *(["mask", "own"] if of_words else []), *columns]
    order = _order_of_classes(rows, keys, _is_mixed(connection, selection))
    return select(*(rows.c[name] for name in outputs)).order_by(*order)


def _stored(
    selection: Selection, of_words: bool, names: Sequence[str], more: Conditions | None
) -> Select[Any]:
    """Select the classes with chosen words."""
    view = views.catalogue if of_words else views.classes.alias("catalogue")
    size = view.c.class_size
    # id and size of a class in a single integer, because a second column would take half as long again
    coded = view.c.cycle.bitwise_lshift(2) + sum(type_coerce(size > least, Integer) for least in (1, 2, 4))
    listed = [coded.label("coded"), view.c.cycle.label("id"), view.c.representative.label("least")]
    listed += [_of_class(view, name, of_words).label(name) for name in names]
    found = conditions_of(selection, view) + (more(view) if more else [])
    if not of_words:
        return select(*listed).where(*found)
    if selection.contains and len(selection.contains) <= _LONGEST_PATTERN:
        found.append(view.c.cycle.in_(select(t.cycle.c.id).where(_needed_symbols(selection.contains))))
    listed.append(func.sum(sa.literal(1).bitwise_lshift(view.c.element)).label("mask"))
    listed.append(func.iif(size < 8, view.c.symmetry, "1").label("own"))
    return select(*listed).where(*found).group_by(view.c.cycle)


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


def _pruned(
    selection: Selection, of_words: bool, names: Sequence[str], more: Conditions | None
) -> Select[Any]:
    """Select the chosen geometrically pruned words, each as a class of its own."""
    view = views.pruned_at(selection.a)
    listed = [(view.c.id * 4).label("coded"), view.c.id, view.c.code.label("least")]
    listed += [view.c[name].label(name) for name in names]
    listed += [sa.literal(1).label("mask"), sa.null().label("own")] if of_words else []
    return select(*listed).where(*conditions_of(selection, view), *(more(view) if more else []))


def _is_mixed(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether there may be words, pruned or long, whose ids do not increase with the period."""
    long = select(select(t.cycle.c.id).where(t.cycle.c.id >= t.LONG).exists())
    return Status.GEOMETRIC in selection.statuses or bool(connection.scalar(long))


def _order_of_classes(rows: FromClause, keys: Mapping[str, bool], mixed: bool) -> list[ColumnElement[Any]]:
    """Return the sort keys of classes; the natural order is that of the ids, which the views have.

    The rows have ``p``, ``least`` (the representative), ``coded``, ``id`` and the columns in `keys`, each
    with whether its order is descending.
    """
    natural: list[ColumnElement[Any]] = [rows.c.id]
    if mixed:
        long = func.iif(func.abs(rows.c.id) >= t.LONG, rows.c.least, None)
        natural = [rows.c.p, rows.c.id < 0, long, func.abs(rows.c.id)]
    elif [*keys.items()][-1:] == [("p", False)]:
        keys = dict([*keys.items()][:-1])  # because ids increase with the period
    # NULL is SQLite's least value, so it comes last in descending orders anyway
    sorting = [
        rows.c[name].desc() if falls else rows.c[name].asc().nulls_last() for name, falls in keys.items()
    ]
    return [*sorting, *natural]


def _of_class(view: FromClause, name: str, of_words: bool) -> ColumnElement[Any]:
    """Return a column of a class from either view; the area is that of the representative."""
    if name == "area" and of_words:
        return func.iif(view.c.element.in_(ODD), 0.0 - view.c.area, view.c.area)
    known = name in views.CLASS_COLUMNS or (name in views.STORED_COLUMNS and not of_words)
    return view.c[name] if known else sa.null()


def _arrays(connection: sa.Connection, query: Select[Any], names: Sequence[str]) -> list[NDArray[Any]]:
    parts = [[_as_column(name, ()) for name in names]]
    cursor = cursor_of(connection, query)
    while rows_of_block := cursor.fetchmany(BLOCK):  # so that few objects are in memory at a time
        columns = zip(names, zip(*rows_of_block, strict=True), strict=True)
        parts.append([_as_column(name, column) for name, column in columns])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def _as_column(name: str, values: Sequence[Any]) -> NDArray[Any]:
    if name in ("coded", "mask"):
        return np.array(values, np.int64)
    return as_array(name, values)


# where a word is among the rows


def position_of(connection: sa.Connection, chosen: SelectedWords, word: str) -> int | None:
    """Return the row number of a code in the subset, or None if it is not there."""
    if rules_of(word):
        stored = select(t.pruned.c.id).where(t.pruned.c.p == len(word), t.pruned.c.word == word)
        lone = connection.scalar(stored)
        return None if lone is None else chosen.position(lone, 0)
    representative = class_of(word).representative
    place = [*members(representative)].index(word)
    return chosen.position(t.class_id(connection, representative), place)


def first_of_period(connection: sa.Connection, chosen: SelectedWords, p: int) -> int | None:
    """Return the number of the first row of a period, or None."""
    return _first(connection, chosen, lambda view: [view.c.p == p])


def first_that_begins(connection: sa.Connection, chosen: SelectedWords, symbols: str) -> int | None:
    """Return the number of the first row whose code begins with the given symbols, or None."""
    return _first(connection, chosen, lambda view: [view.c.code.startswith(symbols)])


def _first(connection: sa.Connection, chosen: SelectedWords, more: Conditions) -> int | None:
    part = select_words(connection, chosen.selection, more=more)
    masks, by_id = np.zeros_like(chosen.masks), np.argsort(chosen.ids)
    masks[by_id[np.searchsorted(chosen.ids, part.ids, sorter=by_id)]] = part.masks
    return chosen.first(masks)


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
    keys: dict[str, bool] = {}
    for part in order.split(","):
        key = _ORDER.fullmatch(part.strip())
        if key is None:
            raise SelectionError(f"order {order!r}: write columns such as 'length' or 'p,lambda_c desc'")
        falling = bool(key[1]) != ((key[3] or "").lower() == "desc")
        if key[2] in set(WRITTEN) - set(COLUMNS):
            raise SelectionError(
                f"order {order!r}: column {key[2]} is computed afterwards, for the chosen rows"
            )
        if key[2] not in COLUMNS:
            raise unknown_column(key[2], COLUMNS)
        keys.setdefault(key[2], falling)
    return keys
