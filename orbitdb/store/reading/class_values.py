"""What is asked of symmetry classes, as arrays in the order of an `Index`: which are chosen, and values.

SQLite answers for a piece of the classes at a time and leaves the interpreter free meanwhile. Which of them
are chosen comes as one text, a character a class.
"""

import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.columns import kind_of
from orbitdb.orbits.orbit import NUMBERS, Status
from orbitdb.store.asking.conditions import answering, conditions_of
from orbitdb.store.asking.confinement import Patience, authorize_checked, never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import ENDS, change, cycle, orbit, stadium
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.reading.class_first import orders_with_pruned
from orbitdb.store.reading.class_index import STATUSES, Index
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.symmetry import ELEMENTS, label
from orbitdb.symbols.words import BITS, MAX_KEYED

Values = NDArray[np.float64]
Chosen = NDArray[np.bool_]

_PIECE = 1 << 15
"""Classes that are asked for at a time."""

_GROUPS = [
    m
    for m in range(1, 256)
    if all(m >> (g ^ h) & 1 for g in ELEMENTS for h in ELEMENTS if m >> g & m >> h & 1)
]
TEXTS = {
    "symmetry": sorted({label(mask) for mask in _GROUPS}),
    "time_reversal": ["pair", "self"],
    "solver": ["newton", "relaxation"],
}
"""Columns that hold one of a few texts, and these in their order."""

_OF_ORBITS = {*NUMBERS, "lambda_d", "lambda_c"} - {"margin"}
"""Columns without a value where there is no orbit."""

_WITH_NUMBERS = [STATUSES.index(status) for status in (Status.ORBIT, Status.BOUNDARY)]
_GEOMETRIC = STATUSES.index(Status.GEOMETRIC)


class CancelledError(Exception):
    """Nobody waits for the result any more."""


def chosen_classes(
    reader: Reader, index: Index, selection: Selection, cancelled: Callable[[], bool] = never
) -> Chosen:
    """Return which classes of the index a subset takes, which takes all words of a class or none.

    Raises
    ------
    SelectionError
        If ``where`` is refused.
    CancelledError
        If it is told to stop.
    """
    chosen = np.ones(len(index.numbers), dtype=np.bool_)
    if selection.periods:
        chosen = index.by_period(selection.includes) > 0
    if selection.statuses:
        chosen &= np.isin(index.statuses, [STATUSES.index(status) for status in selection.statuses])
    if replace(selection, periods=(), statuses=()) == Selection(selection.a):
        return chosen
    patience = Patience(cancelled=cancelled)
    with reader.reading() as connection:
        answers = _answers(connection, index, selection, patience)
        for first, marks in answers:
            if cancelled():
                raise CancelledError
            chosen[first : first + len(marks)] &= marks
        orders = list(orders_with_pruned(connection, selection))
    pruned = index.statuses == _GEOMETRIC
    chosen[pruned] = np.isin(index.by_period(float)[pruned], orders)
    return chosen


def _answers(
    connection: sa.Connection, index: Index, selection: Selection, patience: Patience
) -> Iterator[tuple[int, Chosen]]:
    """Yield which classes fulfil the conditions of a selection, a piece at a time."""
    for first, rows, count in _pieces(connection, index):
        mark = sa.case((sa.and_(*conditions_of(selection, rows)), "1"), else_="0").label("mark")
        listed = sa.select(mark).order_by(rows.cycle).subquery()
        query = sa.select(sa.func.group_concat(listed.c.mark, ""))
        with answering(connection, selection, patience, authorize_joined):
            marks = connection.scalar(query) or ""
        if len(marks) != count:
            raise unsound("classes without what became of them at a =", index.a)
        yield first, np.frombuffer(marks.encode(), dtype=np.uint8) == ord("1")


def authorize_joined(
    action: int, first: str | None, second: str | None, base: str | None, view: str | None
) -> int:
    """Allow, too, that the answers are joined: a checked expression cannot do it itself."""
    if action == sqlite3.SQLITE_FUNCTION and second == "group_concat":
        return sqlite3.SQLITE_OK
    return authorize_checked(action, first, second, base, view)


def _pieces(connection: sa.Connection, index: Index) -> Iterator[tuple[int, Any, int]]:
    """Yield the classes that have orbits, or might, in pieces: where each begins, its rows, and their number."""
    here = connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == index.a))
    for part, start in zip(index.parts, index.class_starts.tolist(), strict=False):
        numbers = part.numbers[part.statuses != _GEOMETRIC]
        for begin in range(0, len(numbers), _PIECE):
            piece = numbers[begin : begin + _PIECE]
            rows = _class_rows(index.a, here, part.words.p, int(piece[0]), int(piece[-1]))
            yield start + begin, rows.c, len(piece)


def _class_rows(a: float, here: int | None, p: int, low: int, high: int) -> sa.Subquery:
    """Return the rows of `class_view` with numbers between two, which SQLite finds in their order.

    What is known of all of them is written out, and the class is looked up only where it is asked for.
    """
    end = {name: _end(name, number) for number, name in enumerate(ENDS, 1)}
    size = sa.cast(p, sa.Integer) if p else cycle.c.p  # cast, as of a column: texts are compared as numbers
    return (
        sa.select(
            sa.cast(a, sa.REAL).label("a"),
            orbit.c.cycle,
            size.label("p"),
            cycle.c.word.label("representative"),
            *(cycle.c[name] for name in ("class_size", "walls", "time_reversal", "symmetry")),
            orbit.c.status,
            *(orbit.c[name] for name in (*NUMBERS, "iterations", "solver")),
            (orbit.c.lyapunov / size).label("lambda_d"),
            (orbit.c.lyapunov / orbit.c.length).label("lambda_c"),
            *(column.label(name) for name, column in end.items()),
        )
        .select_from(orbit.outerjoin(cycle, cycle.c.id == orbit.c.cycle))
        .where(orbit.c.stadium == here, orbit.c.cycle.between(low, high))
        .subquery(view.name)
    )


def _end(name: str, number: int) -> sa.ScalarSelect[float]:
    """Return the first birth or death of a class, as `class_view` has it."""
    found = sa.select(sa.func.nullif(change.c.a, 0.0)).where(change.c.cycle == orbit.c.cycle)
    return found.where(change.c.number == number).correlate(orbit).scalar_subquery()


def class_values(
    reader: Reader, index: Index, column: str, cancelled: Callable[[], bool] = never
) -> Values | None:
    """Return a number a class that sorts as a column of it does, NaN for none; None if there are no such numbers.

    Raises
    ------
    CancelledError
        If it is told to stop.
    """
    if column == "p":
        return index.by_period(float)
    if column == "status":
        return np.argsort(np.argsort([status.value for status in STATUSES])).astype(float)[index.statuses]
    if column in ("representative", "cycle"):
        return _ranks_of_words(index, column)
    if column not in class_view().c or (kind_of(column) == "text" and column not in TEXTS):
        return None
    found = np.full(len(index.numbers), np.nan)
    with reader.reading() as connection:
        for first, rows, count in _pieces(connection, index):
            if cancelled():
                raise CancelledError
            statuses = index.statuses[first : first + count]
            found[first : first + count] = _values(connection, rows, column, statuses)
    return found


def _ranks_of_words(index: Index, column: str) -> Values | None:
    """Return numbers that sort as the least words or the numbers of the classes do; pruned words have none."""
    if index.long_words:
        return None
    numbers = index.numbers
    if column == "representative":
        period = index.by_period(float).astype(np.int64)
        numbers = (numbers - (np.int64(1) << BITS * period)) << BITS * (MAX_KEYED - period)
    ranks = np.empty(len(numbers))
    ranks[np.argsort(numbers)] = np.arange(len(numbers))
    ranks[index.statuses == _GEOMETRIC] = np.nan
    return ranks


def _values(connection: sa.Connection, rows: Any, column: str, statuses: NDArray[np.uint8]) -> Values:
    """Return the values of a piece of the classes."""
    value, there = rows[column], np.ones(len(statuses), dtype=np.bool_)
    query = sa.select().order_by(rows.cycle)
    if column in TEXTS:
        places = {text: float(place) for place, text in enumerate(TEXTS[column])}
        value = sa.case(places, value=value, else_=None)
    elif column in _OF_ORBITS:
        query = query.where(rows.status.in_([STATUSES[place].value for place in _WITH_NUMBERS]))
        there = np.isin(statuses, _WITH_NUMBERS)
    query = query.add_columns(sa.func.coalesce(value, sa.literal_column("9e999")))
    cursor = connection.execute(query).cursor
    numbers = np.fromiter(chain.from_iterable(iter(cursor.fetchone, None)), dtype=np.float64)
    if len(numbers) != there.sum():
        raise unsound("classes without what became of them, sorted by", column)
    numbers[numbers == np.inf] = np.nan
    found = np.full(len(statuses), np.nan)
    found[there] = numbers
    return found
