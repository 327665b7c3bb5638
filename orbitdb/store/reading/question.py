"""Find a chosen subset: the only way from a selection to classes and their words.

* Conditions shared by all words of a class use the view `class`, and choose all its words.
* Patterns in the text of words are decided on the packed words, which are the ids of the classes.
* Other conditions on single words use the view `catalogue`, grouped by class.

Geometrically pruned words have no class. They count only if the selection names their status.
"""

import sqlite3
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import Any, cast

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.columns import kind_of
from orbitdb.orbits.status import Status
from orbitdb.store.asking.conditions import Divided, answering, conditions_of, divide, parse_order
from orbitdb.store.asking.confinement import never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import LONG
from orbitdb.store.file.tables import catalogue, classes, cycle, pruned
from orbitdb.store.reading.chosen import Chosen, Masks
from orbitdb.store.reading.fitting import fitting, stabilisers_of_classes
from orbitdb.store.reading.order import in_order_of_words, order_of_classes
from orbitdb.symbols.members import places_of_elements
from orbitdb.symbols.symmetry import ELEMENTS

_OF_WORDS = ("code", "word", "element")
"""Columns in which the words of a class differ."""

_CODED: sa.ColumnClause[int] = sa.literal_column(
    "(cycle << 2) + (class_size > 1) + (class_size > 2) + (class_size > 4)"
)
"""The id and the size of a class in one integer, because a second column would take half as long again.

A shift stays an integer even for an altered, very large id; a product would not."""

BLOCK = 1 << 14

_FEW = 1 << 16
"""Above this many rows, SQLite sorts everything faster than it keeps the first N."""

Values = dict[str, NDArray[Any]]


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
        Columns separated by commas, falling with ``desc`` after or ``-`` before a name. Among equal rows, the
        lower period, representative and element come first.
    columns : sequence of str, optional
        Further columns of the view ``class`` to read.
    most : int, optional
        Number of first rows needed; later ones may come in any order.
    counted : bool, optional
        Whether to find all rows nonetheless, because their number is needed.
    cancelled : callable, optional
        Called now and then; True raises `CancelledError`.
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
        query = query.limit(most)  # every class has at least one row
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
    return replace(found, rows=in_order_of_words(connection, found, keys, most)) if by_words else found


def _places(
    connection: sa.Connection, ids: NDArray[np.int64], sizes: NDArray[np.uint8], elements: Masks
) -> Masks:
    """Turn marks by symmetry element into marks by place in the class."""
    return places_of_elements(elements, stabilisers_of_classes(connection, ids, sizes == len(ELEMENTS)))


def _query(
    connection: sa.Connection, divided: Divided, keys: dict[str, bool], columns: Sequence[str]
) -> sa.Select[Any]:
    """Return the query for classes in their order: coded id, mask by elements if needed, and columns."""
    named = tuple(dict.fromkeys(["p", *columns, *keys]))
    sources = list(_sources(divided, named))
    rows = (sa.union_all(*sources) if len(sources) > 1 else sources[0]).subquery().c
    outputs = [rows.coded, *([rows.mask] if divided.of_words else []), *(rows[name] for name in columns)]
    mixed = Status.GEOMETRIC in divided.conditions.statuses or _has_long(connection)
    return sa.select(*outputs).order_by(*order_of_classes(rows, keys, mixed))


def _sources(divided: Divided, columns: Sequence[str]) -> Iterator[sa.Select[Any]]:
    """Yield the queries for the chosen classes, and for pruned words if the selection names them."""
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
    """Return a column of a view, or NULL for one that only pruned words have."""
    return known[name] if name in known else sa.null()


def pruned_rows(a: float) -> sa.Subquery:
    """Return the geometrically pruned words with the columns of both views, at one a."""
    own = {
        "a": sa.cast(a, sa.REAL),
        "p": pruned.c.p,
        "code": pruned.c.word,
        "word": pruned.c.word,
        "words": pruned.c.word,
        "status": sa.literal(Status.GEOMETRIC.value),
        "rules": pruned.c.rules,
    }
    names = {**dict(catalogue.c), **dict(classes.c)}
    listed = [own.get(name, sa.null()).label(name) for name in names]
    return sa.select(pruned.c.id, *listed).subquery(catalogue.name)


def _has_long(connection: sa.Connection) -> bool:
    return connection.scalar(sa.select(sa.exists().where(cycle.c.id >= LONG))) or False


def _arrays(connection: sa.Connection, query: sa.Select[Any], columns: Sequence[str]) -> list[NDArray[Any]]:
    """Return the columns of a query as arrays."""
    count = len(query.selected_columns) - len(columns)
    parts: list[list[NDArray[Any]]] = []
    cursor = cast(sqlite3.Cursor, connection.execute(query).cursor)
    while rows_of_block := cursor.fetchmany(BLOCK):  # keeps few objects in memory
        each = zip(*rows_of_block, strict=True)
        numbers = [np.array(values, np.int64) for _, values in zip(range(count), each, strict=False)]
        parts.append(numbers + [as_array(name, values) for name, values in zip(columns, each, strict=True)])
    if not parts:
        return [np.zeros(0, np.int64)] * count + [as_array(name, ()) for name in columns]
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def as_array(name: str, values: Sequence[Any]) -> NDArray[Any]:
    """Return values of a column: numbers with NaN for NULL, all others as objects."""
    return np.array(values, np.float64 if kind_of(name) == "number" else object)
