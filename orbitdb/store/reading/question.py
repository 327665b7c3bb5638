"""Find the classes and words of a chosen subset; every query for a selection comes through here.

* Conditions with the same value for all words of a class become a query of the view `class`.
* Patterns in the text of words are matched against the packed words, which the ids of the classes contain.
* Other conditions on single words become a query of the view `catalogue`, grouped by class.

Geometrically pruned words have no class; they are found only if the selection names their status.
"""

import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import Any, cast

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Integers, Masks
from orbitdb.orbits.status import Status
from orbitdb.store.asking.conditions import Divided, answering, conditions_of, divide, parse_order
from orbitdb.store.asking.limits import never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.ids import LONG
from orbitdb.store.file.tables import catalogue, classes, cycle, pruned_rows
from orbitdb.store.reading.matching import fitting, stabilisers_of_classes
from orbitdb.store.reading.order_of_words import in_order_of_words
from orbitdb.store.reading.rows import Chosen, as_array
from orbitdb.symbols.symmetry import ELEMENTS, places_of_elements

_OF_WORDS = ("code", "word", "element")
"""Columns whose values differ between the words of a class."""

_CODED: sa.ColumnClause[int] = sa.literal_column(
    "(cycle << 2) + (class_size > 1) + (class_size > 2) + (class_size > 4)"
)
"""Id and size of a class in a single integer, because a second column would take half as long again.

The id is shifted, because a product with a very large id, in an altered file, would not be an integer."""

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
    """
    keys, divided = parse_order(order), divide(selection)
    by_class = dict(takewhile(lambda key: key[0] not in _OF_WORDS, keys.items()))
    by_words = len(by_class) < len(keys)
    if by_words:
        columns = tuple(dict.fromkeys([*columns, *(name for name in keys if name not in _OF_WORDS)]))
        by_class = {}
    query = _query(connection, divided, by_class, columns)
    sorted_far = order != "p" and (most or 0) > _FEW
    if most is not None and not (counted or by_words or divided.patterns or sorted_far):
        query = query.limit(min(most, _LARGEST))  # every class has at least one row
    with answering(connection, divided.conditions, cancelled):
        coded, *more = _arrays(connection, query, columns)
    sizes = np.uint8(1) << (coded & 3).astype(np.uint8)
    masks = ((np.uint16(1) << sizes) - 1).astype(np.uint8)
    ids = np.right_shift(coded, 2, out=coded)
    if divided.of_words:
        masks &= _places(connection, ids, sizes, more.pop(0).astype(np.uint8))
    if divided.patterns:
        elements = fitting(connection, ids, divided.patterns, cancelled)
        masks &= _places(connection, ids, sizes, elements)
    kept = slice(None) if masks.all() else masks > 0
    values = {name: column[kept] for name, column in zip(columns, more, strict=True)}
    found = Chosen(selection, ids[kept], masks[kept], None, values)
    return replace(found, rows=in_order_of_words(connection, found, keys)) if by_words else found


def _places(connection: sa.Connection, ids: Integers, sizes: NDArray[np.uint8], elements: Masks) -> Masks:
    """Turn masks of symmetry elements into masks of positions in the class."""
    return places_of_elements(elements, stabilisers_of_classes(connection, ids, sizes == len(ELEMENTS)))


def _query(
    connection: sa.Connection, divided: Divided, keys: dict[str, bool], columns: Sequence[str]
) -> sa.Select[Any]:
    """Return the query for the classes in order: coded ids, masks of elements if needed, and columns."""
    named = tuple(dict.fromkeys(["p", *columns, *keys]))
    sources = list(_sources(divided, named))
    rows = (sa.union_all(*sources) if len(sources) > 1 else sources[0]).subquery().c
    outputs = [rows.coded, *([rows.mask] if divided.of_words else []), *(rows[name] for name in columns)]
    mixed = Status.GEOMETRIC in divided.conditions.statuses or _has_long(connection)
    return sa.select(*outputs).order_by(*_order_of_classes(rows, keys, mixed))


def _order_of_classes(
    rows: "sa.sql.base.ReadOnlyColumnCollection[str, Any]", keys: Mapping[str, bool], mixed: bool
) -> list[sa.ColumnElement[Any]]:
    """Return the sort keys of classes in SQL; there are none for the natural order, which the views have.

    The rows have ``p``, ``least`` (the representative), ``coded`` (`_CODED`) and the columns in `keys`, each
    with whether its order is descending. `mixed` tells whether there may be words, pruned or too long for a
    key, whose ids do not increase with the period.
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


def _sources(divided: Divided, columns: Sequence[str]) -> Iterator[sa.Select[Any]]:
    """Yield the query for classes and, if the selection names their status, the query for pruned words."""
    chosen = divided.conditions
    if chosen.statuses != (Status.GEOMETRIC,):
        known = (catalogue if divided.of_words else classes.alias(catalogue.name)).c
        mask: list[Any] = []
        if divided.of_words:
            mask = [sa.func.sum(sa.literal_column("1 << element")).label("mask")]
        named = [known.representative.label("least"), *(_column(known, name).label(name) for name in columns)]
        query = sa.select(_CODED.label("coded"), *mask, *named)
        query = query.where(*conditions_of(chosen, known))
        yield query.group_by(known.cycle) if divided.of_words else query
    if Status.GEOMETRIC in chosen.statuses:
        rows = pruned_rows(chosen.a).c
        mask = [sa.literal(1).label("mask")] if divided.of_words else []
        named = [rows.code.label("least"), *(rows[name].label(name) for name in columns)]
        query = sa.select((rows.id * 4).label("coded"), *mask, *named)
        yield query.where(*conditions_of(chosen, rows))


def _column(known: sa.ColumnCollection[str, Any], name: str) -> sa.ColumnElement[Any]:
    """Return a column of a view, or NULL if the view does not have it."""
    return known[name] if name in known else sa.null()


def _has_long(connection: sa.Connection) -> bool:
    return connection.scalar(sa.select(sa.exists().where(cycle.c.id >= LONG))) or False


def _arrays(connection: sa.Connection, query: sa.Select[Any], columns: Sequence[str]) -> list[NDArray[Any]]:
    count = len(query.selected_columns) - len(columns)
    parts: list[list[NDArray[Any]]] = []
    cursor = cast(sqlite3.Cursor, connection.execute(query).cursor)
    while rows_of_block := cursor.fetchmany(BLOCK):  # so that few objects are in memory at a time
        each = zip(*rows_of_block, strict=True)
        numbers = [np.array(values, np.int64) for _, values in zip(range(count), each, strict=False)]
        parts.append(numbers + [as_array(name, values) for name, values in zip(columns, each, strict=True)])
    if not parts:
        return [np.zeros(0, np.int64)] * count + [as_array(name, ()) for name in columns]
    return [np.concatenate(column) for column in zip(*parts, strict=True)]
