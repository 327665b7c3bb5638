"""Find the classes and words of a chosen subset; every query for a selection comes through here.

Conditions with the same value for all words of a class are one query of the view `class`. Conditions on
single words, and orders of them, are one query of the view `catalogue`.

Geometrically pruned words have no class; they are found only if the selection names their status.
"""

import math
import re
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import Any, cast

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Integers, Masks
from orbitdb.orbits.status import Status
from orbitdb.store.connection import driver
from orbitdb.store.lives import NEAR, Standings
from orbitdb.store.rows import COUNTS, Chosen, as_array, orders_of
from orbitdb.store.schema import BORN, DIED, LONG, id_of_class
from orbitdb.store.selection import Selection, SelectionError, unknown_column
from orbitdb.store.tables import ENDS, catalogue, change, classes, cycle, pruned, pruned_rows
from orbitdb.store.where import Patience, expression, never, of_classes, watched
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import ODD, STABILISER_OF, class_of, members, places_of_elements
from orbitdb.symbols.words import MAX_KEYED

_OF_WORDS = ("code", "element", "area")
"""Columns whose values differ between the words of a class."""

_OF_CLASS = {"code": "representative", "word": "representative"}
"""Their counterparts for a class."""

_CODED: sa.ColumnClause[int] = sa.literal_column(
    "(cycle << 2) + (class_size > 1) + (class_size > 2) + (class_size > 4)"
)
"""Id and size of a class in a single integer, because a second column would take half as long again."""

_SYMMETRY: sa.ColumnClause[str] = sa.literal_column("iif(class_size < 8, symmetry, '1')")

BLOCK = 1 << 14

_FEW = 1 << 16
"""Above this many rows, SQLite sorts everything faster than it keeps the first N."""

_LARGEST = 2**63 - 1
"""SQLite's largest integer."""


def choose(
    connection: sa.Connection,
    selection: Selection,
    order: str = "p",
    columns: Sequence[str] = (),
    most: int | None = None,
    counted: bool = False,
    cancelled: Callable[[], bool] = never,
    by_class: bool = False,
) -> Chosen:
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
    cancelled : callable, optional
        Called now and then; if it returns True, `CancelledError` is raised.
    by_class : bool, optional
        Whether a class with chosen words has one row, for its representative.
    """
    keys = parse_order(order)
    if by_class:
        keys = {_OF_CLASS.get(name, name): falls for name, falls in keys.items() if name != "element"}
    by_words = not by_class and any(name in keys for name in _OF_WORDS)
    of_words = not is_of_classes(selection) or by_words
    query = _classes(connection, selection, of_words, {} if by_words else keys, columns)
    sorted_far = order != "p" and (most or 0) > _FEW
    if most is not None and not (counted or by_words or sorted_far):
        query = query.limit(min(most, _LARGEST))  # every class has at least one row
    with _answering(connection, selection, cancelled):
        coded, *more = _arrays(connection, query, (*(["symmetry"] if of_words else []), *columns))
    sizes = np.uint8(1) << (coded & 3).astype(np.uint8)
    masks = ((np.uint16(1) << sizes) - 1).astype(np.uint8)
    ids = np.right_shift(coded, 2, out=coded)
    elements = more.pop(0).astype(np.uint8) if of_words else masks
    if of_words:
        stabilisers = np.array(
            [STABILISER_OF.get(symmetry, 1) for symmetry in more.pop(0).tolist()], np.uint8
        )
        masks &= places_of_elements(elements, stabilisers)
    if by_class:
        masks = np.ones_like(masks)
    chosen = Chosen(selection, ids, masks, None, dict(zip(columns, more, strict=True)))
    if not by_words:
        return chosen
    query = _words(connection, selection, keys).limit(_LARGEST if most is None else min(most, _LARGEST))
    with _answering(connection, selection, cancelled):
        numbers, own = _arrays(connection, query)
    return replace(chosen, rows=_rows(chosen, elements, numbers, own))


def _rows(chosen: Chosen, elements: Masks, numbers: Integers, own: Integers) -> NDArray[np.uint32]:
    """Return the row numbers of words, given by the ids of their classes and their own elements.

    `elements` has the elements of all chosen words of each class. The words of a class are in their order.
    """
    by_id = np.argsort(chosen.ids)
    at = by_id[np.searchsorted(chosen.ids, numbers, sorter=by_id)]
    before = elements[at] & ((1 << own) - 1).astype(np.uint8)
    return (chosen.ends[at] - chosen.counts[at] + COUNTS[before]).astype(np.uint32)


def _answering(
    connection: sa.Connection, selection: Selection, cancelled: Callable[[], bool]
) -> AbstractContextManager[None]:
    """Return a context in which to query a subset; it confines the expression of the subset, if any."""
    if selection.where is not None:
        return watched(driver(connection), Patience(cancelled=cancelled), selection.where)
    return nullcontext() if cancelled is never else watched(driver(connection), Patience(math.inf, cancelled))


def _classes(
    connection: sa.Connection,
    selection: Selection,
    of_words: bool,
    keys: Mapping[str, bool],
    columns: Sequence[str],
) -> sa.Select[Any]:
    """Return the query for the classes in order: coded ids, then `columns`.

    If the subset is `of_words`, the elements of the chosen words and the symmetry follow the coded ids.
    """
    named = tuple(dict.fromkeys(["p", *columns, *keys]))
    view = (catalogue if of_words else classes.alias(catalogue.name)).c
    least = view.representative.label("least")
    query = sa.select(_CODED.label("coded"), least, *(_of_class(view, name).label(name) for name in named))
    rows = pruned_rows(selection.a).c
    lone = sa.select((rows.id * 4).label("coded"), rows.code.label("least"), *(rows[name] for name in named))
    if of_words:
        mask: sa.ColumnElement[Any] = sa.func.sum(sa.literal_column("1 << element")).label("mask")
        query = query.add_columns(mask, _SYMMETRY.label("own")).group_by(view.cycle)
        lone = lone.add_columns(sa.literal(1).label("mask"), sa.null().label("own"))
    source = _of_statuses(selection, query.where(*conditions_of(selection, view)), lone, rows)
    outputs = [source.coded, *([source.mask, source.own] if of_words else []), *(source[n] for n in columns)]
    return sa.select(*outputs).order_by(*_order_of_classes(source, keys, _is_mixed(connection, selection)))


def _words(connection: sa.Connection, selection: Selection, keys: Mapping[str, bool]) -> sa.Select[Any]:
    """Return the query for the words in order: the ids of their classes, and their own elements."""
    view, rows = catalogue.c, pruned_rows(selection.a).c
    names = tuple(dict.fromkeys(["p", "element", *keys]))
    query = sa.select(
        (view.cycle * 4).label("coded"), view.representative.label("least"), *(view[name] for name in names)
    )
    lone = sa.select((rows.id * 4).label("coded"), rows.code.label("least"), *(rows[name] for name in names))
    source = _of_statuses(selection, query.where(*conditions_of(selection)), lone, rows)
    order = _order_of_classes(source, keys, _is_mixed(connection, selection))
    return sa.select(source.coded // 4, sa.func.coalesce(source.element, 0)).order_by(*order, source.element)


def _of_statuses(
    selection: Selection,
    stored: sa.Select[Any],
    lone: sa.Select[Any],
    rows: "sa.sql.base.ReadOnlyColumnCollection[str, Any]",
) -> "sa.sql.base.ReadOnlyColumnCollection[str, Any]":
    """Return the columns of the query for stored classes, for pruned words, or for both, by status."""
    lone = lone.where(*conditions_of(selection, rows))
    if selection.statuses == (Status.GEOMETRIC,):
        return lone.subquery().c
    return (sa.union_all(stored, lone) if Status.GEOMETRIC in selection.statuses else stored).subquery().c


def _is_mixed(connection: sa.Connection, selection: Selection) -> bool:
    """Tell whether there may be words, pruned or long, whose ids do not increase with the period."""
    long = sa.select(sa.exists().where(cycle.c.id >= LONG))
    return Status.GEOMETRIC in selection.statuses or connection.scalar(long) or False


def _order_of_classes(
    rows: "sa.sql.base.ReadOnlyColumnCollection[str, Any]", keys: Mapping[str, bool], mixed: bool
) -> list[sa.ColumnElement[Any]]:
    """Return the sort keys of classes in SQL; there are none for the natural order, which the views have.

    The rows have ``p``, ``least`` (the representative), ``coded`` (`_CODED`) and the columns in `keys`, each
    with whether its order is descending.
    """
    natural: list[sa.ColumnElement[Any]] = [rows.coded]
    if mixed:
        number = sa.func.abs(rows.coded)
        natural = [rows.p, rows.coded < 0, sa.case((number >= 4 * LONG, rows.least)), number]
        keys = keys or {"p": False}
    elif [*keys.items()][-1:] == [("p", False)]:
        keys = dict([*keys.items()][:-1])  # because ids increase with the period
    # NULL is SQLite's least value, so it comes last in descending orders anyway
    sorting = [rows[name].desc() if falls else rows[name].asc().nulls_last() for name, falls in keys.items()]
    return [*sorting, *natural] if keys else []


def _column(view: sa.ColumnCollection[str, Any], name: str) -> sa.ColumnElement[Any]:
    """Return a column of a view, or NULL if the view does not have it."""
    return view[name] if name in view else sa.null()


def _of_class(view: sa.ColumnCollection[str, Any], name: str) -> sa.ColumnElement[Any]:
    """Return a column of a class from either view; the area is that of the representative."""
    if name == "area" and "element" in view:
        return sa.case((view.element.in_(ODD), 0.0 - view.area), else_=view.area)
    return _column(view, name)


def _arrays(
    connection: sa.Connection, query: sa.Select[Any], columns: Sequence[str] = ()
) -> list[NDArray[Any]]:
    count = len(query.selected_columns) - len(columns)
    parts: list[list[NDArray[Any]]] = []
    cursor = cast(sqlite3.Cursor, connection.execute(query).cursor)
    while rows_of_block := cursor.fetchmany(BLOCK):  # so that few objects are in memory at a time
        remaining = zip(*rows_of_block, strict=True)
        numbers = [np.array(values, np.int64) for _, values in zip(range(count), remaining, strict=False)]
        parts.append(
            numbers + [as_array(name, values) for name, values in zip(columns, remaining, strict=True)]
        )
    if not parts:
        return [np.zeros(0, np.int64)] * count + [as_array(name, ()) for name in columns]
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


# where a word is among the rows


def position_of(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    """Return the row number of a code in the subset, or None if it is not there."""
    if rules_of(word):
        lone = connection.scalar(sa.select(pruned.c.id).where(pruned.c.p == len(word), pruned.c.word == word))
        return None if lone is None else chosen.position(lone, 0)
    representative = class_of(word).representative
    place = [*members(representative)].index(word)
    return chosen.position(id_of_class(driver(connection), representative), place)


def periods_of(connection: sa.Connection, ids: Integers) -> Integers:
    """Return the periods of classes and pruned words, shape (C,)."""
    periods = orders_of(ids)
    if (long := np.flatnonzero(periods > MAX_KEYED)).size:
        stored = sa.select(cycle.c.id, cycle.c.p).where(cycle.c.id >= LONG)
        lone = sa.select(pruned.c.id, pruned.c.p).where(pruned.c.id <= -LONG)
        of_long = {row.id: row.p for row in connection.execute(stored.union_all(lone))}
        periods[long] = [of_long[number] for number in ids[long].tolist()]
    return periods


def periods_without(connection: sa.Connection, ids: Integers, standings: Standings) -> list[int]:
    """Return the distinct periods of the classes for which no births are stored."""
    return np.unique(periods_of(connection, ids[standings.places == len(standings.cycles)])).tolist()


def first_of_period(connection: sa.Connection, chosen: Chosen, p: int) -> int | None:
    """Return the number of the first row with a given period, or None."""
    of_period = periods_of(connection, chosen.ids) == p
    return chosen.first(np.where(of_period, 0xFF, 0).astype(np.uint8))


def first_beginning(
    connection: sa.Connection, chosen: Chosen, code: str, cancelled: Callable[[], bool] = never
) -> int | None:
    """Return the number of the first row whose code begins with the given symbols, or None."""
    where, begins = chosen.selection.where, f"code GLOB '{code}*'"
    both = f"(\n{where}\n) AND {begins}" if where else begins
    part = choose(connection, replace(chosen.selection, where=both), cancelled=cancelled)
    masks, by_id = np.zeros_like(chosen.masks), np.argsort(chosen.ids)
    masks[by_id[np.searchsorted(chosen.ids, part.ids, sorter=by_id)]] = part.masks
    return chosen.first(masks)


# conditions and orders as SQL


COLUMNS = tuple(catalogue.c.keys())
"""The columns of the view ``catalogue``."""

_ORDER = re.compile(r"(-?)(\w+)(?:\s+(asc|desc))?", re.IGNORECASE)


def conditions_of(
    selection: Selection, view: sa.ColumnCollection[str, Any] = catalogue.c
) -> list[sa.ColumnElement[bool] | sa.TextClause]:
    """Return a selection, with an expression that is checked, as conditions on a view with these columns."""
    conditions: list[sa.ColumnElement[bool] | sa.TextClause] = [view.a == selection.a]
    if selection.periods:
        conditions.append(sa.or_(*(view.p.between(low, high) for low, high in selection.periods)))
    if selection.statuses:
        conditions.append(view.status.in_([status.value for status in selection.statuses]))
    if selection.time_reversal:
        conditions.append(view.time_reversal == selection.time_reversal)
    if selection.symmetry:
        conditions.append(view.symmetry == selection.symmetry)
    conditions += [alive_at(view.cycle, a) for a in selection.exists]
    has_life = sa.exists().where(change.c.cycle == view.cycle, change.c.number == 1)
    conditions += [sa.and_(has_life, sa.not_(alive_at(view.cycle, a))) for a in selection.not_at]
    for name, (low, high) in selection.ranges.items():
        conditions += [] if low is None else [view[name] >= low]
        conditions += [] if high is None else [view[name] <= high]
    if selection.contains is not None:
        conditions.append(sa.func.instr(view.code.concat(view.code), selection.contains) > 0)
    if selection.where is not None:
        conditions.append(expression(selection.where, selection.parameters))
    return conditions


def is_of_classes(selection: Selection) -> bool:
    """Tell whether each class is chosen with all its words or not at all.

    Raises `SelectionError` if the expression of the selection is invalid.
    """
    by_class = selection.where is None or of_classes(selection.where, selection.parameters)
    return by_class and selection.contains is None


def alive_at(number: sa.ColumnElement[int], a: float) -> sa.ColumnElement[bool]:
    """Return the condition that a class, given by its id, is an orbit at a given a, from births and deaths.

    A class does not count as an orbit if a is within the error of a birth or death, where the orbit may run
    exactly through a joint.
    """
    reach = NEAR * change.c.error
    begun = sa.and_(change.c.kind == BORN, change.c.a + reach < a)
    ended = sa.and_(change.c.kind == DIED, change.c.a - reach <= a)
    lives = sa.func.coalesce(sa.func.sum(sa.case((begun, 1), (ended, -1), else_=0)), 0)
    return sa.select(lives).where(change.c.cycle == number).scalar_subquery() > 0


def asks_of_lives(selection: Selection, names: Sequence[str] = (), order: str = "p") -> bool:
    """Tell whether a subset, its columns or its order depends on births and deaths."""
    named = set(selection.ranges) | set(names) | set(parse_order(order))
    if selection.where is not None:
        named |= set(re.findall(r"\w+", selection.where.lower()))
    return bool(selection.exists or selection.not_at or named & set(ENDS))


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
        if key[2] not in COLUMNS:
            raise unknown_column(key[2], COLUMNS)
        keys.setdefault(key[2], falling)
    return keys
