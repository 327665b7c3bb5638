"""What is asked of symmetry classes, as arrays in the order of an `Index`: which are chosen, and values.

SQLite answers for a piece of the classes at a time and leaves the interpreter free meanwhile. Which of them
are chosen comes as one text, a character a class.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.columns import kind_of
from orbitdb.orbits.orbit import NUMBERS, Status
from orbitdb.store.asking.conditions import Columns, answering, conditions_of
from orbitdb.store.asking.confinement import Patience, authorize_joined, never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.engines import little_kept
from orbitdb.store.file.schema import ENDS, change, cycle, orbit, stadium
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.reading.class_first import orders_with_pruned
from orbitdb.store.reading.class_index import STATUSES, Index
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.joined_texts import joined_numbers
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.symmetry import GROUPS, label
from orbitdb.symbols.words import BITS, MAX_KEYED

Values = NDArray[np.float64]
Chosen = NDArray[np.bool_]

_PIECE = 1 << 14
"""Classes that are asked for at a time."""

_PERIOD, _LOW, _HIGH = "piece p", "piece low", "piece high"
"""Values of a query, by names that no free expression can write."""

_OF_CLASSES = {"class_size", "walls", "symmetry", "time_reversal"}
"""Columns that are the same at every a."""

_CLASSES = (
    sa.select(cycle.c.id.label("cycle"), *(cycle.c[name] for name in sorted(_OF_CLASSES)))
    .where(cycle.c.id.between(sa.bindparam(_LOW), sa.bindparam(_HIGH)))
    .subquery()
    .c
)
"""Classes with numbers between two."""

TEXTS = {
    "symmetry": sorted(map(label, GROUPS)),
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
    with reader.reading() as connection, little_kept(connection):
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

    def marked(rows: Columns) -> sa.Select[Any]:
        mark = sa.case((sa.and_(*conditions_of(selection, rows)), "1"), else_="0").label("mark")
        listed = sa.select(mark).order_by(rows.cycle).subquery()
        return sa.select(sa.func.group_concat(listed.c.mark, ""))

    for query, values, first, count in _pieces(connection, index, marked):
        with answering(connection, selection, patience, authorize_joined):
            marks = connection.scalar(query, values) or ""
        if len(marks) != count:
            raise unsound("classes without what became of them at a =", index.a)
        yield first, np.frombuffer(marks.encode(), dtype=np.uint8) == ord("1")


def _pieces(
    connection: sa.Connection, index: Index, asked: Callable[[Columns], sa.Select[Any]]
) -> Iterator[tuple[sa.Select[Any], dict[str, Any], int, int]]:
    """Yield a query of classes, with its values, for each piece; where that begins, and its classes.

    Of pruned words, which have no class, there is none.
    """
    here = connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == index.a))
    queries: dict[bool, sa.Select[Any]] = {}
    for part, start in zip(index.parts, index.class_starts.tolist(), strict=False):
        numbers, p = part.numbers[part.statuses != _GEOMETRIC], part.words.p
        if bool(p) not in queries:
            queries[bool(p)] = asked(_class_rows(index.a, here, not p).c)
        for begin in range(0, len(numbers), _PIECE):
            piece = numbers[begin : begin + _PIECE]
            values = {_LOW: int(piece[0]), _HIGH: int(piece[-1])} | ({_PERIOD: p} if p else {})
            yield queries[bool(p)], values, start + begin, len(piece)


def _class_rows(a: float, here: int | None, long: bool) -> sa.Subquery:
    """Return the rows of `class_view` with numbers between two, which SQLite finds in their order.

    What is known of all of them is written out, and the class is looked up only where it is asked for.
    """
    known = sa.cast(sa.bindparam(_PERIOD), sa.Integer)  # cast, as of a column: it is compared with texts
    p = cycle.c.p if long else known
    return (
        sa.select(
            sa.cast(a, sa.REAL).label("a"),
            orbit.c.cycle,
            p.label("p"),
            cycle.c.word.label("representative"),
            *(cycle.c[name] for name in ("class_size", "walls", "time_reversal", "symmetry")),
            orbit.c.status,
            *(orbit.c[name] for name in (*NUMBERS, "iterations", "solver")),
            (orbit.c.lyapunov / p).label("lambda_d"),
            (orbit.c.lyapunov / orbit.c.length).label("lambda_c"),
            *(_end(number).label(name) for number, name in enumerate(ENDS, 1)),
        )
        .select_from(orbit.outerjoin(cycle, cycle.c.id == orbit.c.cycle))
        .where(orbit.c.stadium == here, orbit.c.cycle.between(sa.bindparam(_LOW), sa.bindparam(_HIGH)))
        .subquery(view.name)
    )


def _end(number: int) -> sa.ScalarSelect[float]:
    """Return the first birth or death of a class, as `class_view` has it."""
    found = sa.select(sa.func.nullif(change.c.a, 0.0)).where(change.c.cycle == orbit.c.cycle)
    return found.where(change.c.number == number).correlate(orbit).scalar_subquery()


def class_values(
    reader: Reader, index: Index, column: str, cancelled: Callable[[], bool] = never
) -> Values | None:
    """Return a number a class that sorts as a column of it does, NaN for none; None if there is no such.

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
    found = index.last_values.get(column)  # another thread may forget it at any time
    if found is None:
        index.last_values.clear()  # of millions of classes each takes some tens of megabytes
        found = _read_values(reader, index, column, cancelled)
        if column not in ENDS:  # births may come while the fills stay
            index.last_values[column] = found
    return found


def _read_values(reader: Reader, index: Index, column: str, cancelled: Callable[[], bool]) -> Values:
    """Return the values of a column, which are numbers or stand for texts in their order."""
    found = np.full(len(index.numbers), np.nan)
    with reader.reading() as connection, little_kept(connection):
        pieces = _pieces(connection, index, lambda rows: _valued(rows, column))
        for query, values, first, count in pieces:
            if cancelled():
                raise CancelledError
            here = np.arange(first, first + count)
            if column in _OF_ORBITS:
                here = here[np.isin(index.statuses[here], _WITH_NUMBERS)]
            found[here] = _read_piece(connection, query, values, len(here), column)
    return found


def _read_piece(
    connection: sa.Connection, query: sa.Select[Any], values: dict[str, Any], count: int, column: str
) -> Values:
    """Return the numbers of a piece, NaN where there is none.

    What is the same at every a stands with the classes: where as many are there as are asked for, they are
    those, and need not be looked up one by one.
    """
    queries = [query]
    if column in _OF_CLASSES:
        queries.insert(0, _valued(_CLASSES, column))
    for each in queries:
        numbers = joined_numbers(connection, each, values, kind_of(column) != "number")
        if len(numbers) == count:
            numbers[numbers == np.inf] = np.nan
            return numbers
    raise unsound("classes without what became of them, sorted by", column)


def _valued(rows: Columns, column: str) -> sa.Select[Any]:
    """Return the query of a column's values, as numbers; without those that are known to be none."""
    value, query = rows[column], sa.select().order_by(rows.cycle)
    if column in TEXTS:
        value = sa.case({text: place for place, text in enumerate(TEXTS[column])}, value=value, else_=None)
    elif column in _OF_ORBITS:
        query = query.where(rows.status.in_([STATUSES[place].value for place in _WITH_NUMBERS]))
    return query.add_columns(sa.func.coalesce(value, sa.literal_column("9e999")).label("value"))


def _ranks_of_words(index: Index, column: str) -> Values | None:
    """Return numbers that sort as the least words, or the numbers, of classes do; pruned words have none."""
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
