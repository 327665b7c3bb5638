"""How far the fill of a period has come, and its moving on, in the transaction that stores the rows."""

from dataclasses import dataclass, replace

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.file.schema import DONE, FILLING, cycle, fill, orbit
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.words import keys_of_period, packed


class OvertakenError(Exception):
    """Another process has moved the cursor of the same fill: what it says is to be read again."""


@dataclass(frozen=True)
class Cursor:
    """How far a fill of one period at one a has come.

    Attributes
    ----------
    stadium, p : int
        What is filled.
    state : str
        ``filling`` or ``done``.
    word : str or None
        All words up to this one, in the order of their texts, are stored; it need not be a word itself.
    words : int
        How many words that are.
    sequences_done : bool
        Whether all words of the period are stored, by a fill at any a.
    """

    stadium: int
    p: int
    state: str
    word: str | None
    words: int
    sequences_done: bool

    @property
    def after(self) -> int:
        """The packed word behind which the fill goes on."""
        return -1 if self.word is None else int(self.word, 8)


@dataclass(frozen=True)
class Spent:
    """Time spent on a part of a fill, in seconds.

    Attributes
    ----------
    seconds : float
        As it passed.
    enumerating, solving, storing : float
        Of processors: on words and their classes, on orbits, and on the database.
    """

    seconds: float
    enumerating: float
    solving: float
    storing: float


def open_fill(writer: Writer, connection: sa.Connection, a: float, p: int) -> Cursor:
    """Return where the fill of a period stands, beginning it if need be."""
    here = {"stadium": writer.stadium_id(connection, a), "p": p}
    connection.execute(sa.insert(fill).prefix_with("OR IGNORE").values(**here, state=FILLING, seconds=0.0))
    row = connection.execute(sa.select(fill.c.state, fill.c.cursor, fill.c.words).filter_by(**here)).one()
    complete = sa.select(fill.c.p).where(fill.c.p == p, fill.c.state == DONE).limit(1)
    return Cursor(**here, state=row.state, word=row.cursor, words=row.words,
                  sequences_done=connection.scalar(complete) is not None)  # fmt: skip


def move_cursor(connection: sa.Connection, cursor: Cursor, span: Span, words: int, spent: Spent) -> Cursor:
    """Note that the words of the span behind the cursor are stored, and what it took.

    Raises
    ------
    OvertakenError
        If another process has moved the same cursor.
    """
    last = end_of(span)
    moved = connection.execute(
        sa.update(fill)
        .where(_of(cursor), fill.c.state == FILLING, fill.c.cursor.is_not_distinct_from(cursor.word))
        .values(
            cursor=last,
            words=fill.c.words + words,
            **{name: fill.c[name] + value for name, value in vars(spent).items()},
        )
    )
    if moved.rowcount != 1:
        raise OvertakenError
    return replace(cursor, word=last, words=cursor.words + words)


def end_of(span: Span) -> str:
    """Return the end of a span as text, one octal digit a symbol."""
    return f"{span.upto:0{span.p}o}"


def close_fill(connection: sa.Connection, cursor: Cursor, counts: dict[str, int]) -> None:
    """Note that a period is complete, with its counts."""
    connection.execute(sa.update(fill).where(_of(cursor)).values(state=DONE, **counts))


def _of(cursor: Cursor) -> sa.ColumnElement[bool]:
    return (fill.c.stadium == cursor.stadium) & (fill.c.p == cursor.p)


def count_statuses(connection: sa.Connection, cursor: Cursor) -> dict[str, tuple[int, int]]:
    """Return for each status the number of words and of classes among a period's orbits."""
    query = (
        sa.select(orbit.c.status, sa.func.sum(cycle.c.class_size), sa.func.count())
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .where(orbit.c.stadium == cursor.stadium, orbit.c.cycle.between(*keys_of_period(cursor.p)))
        .group_by(orbit.c.status)
    )
    return {status: (words, classes) for status, words, classes in connection.execute(query)}


def next_classes(connection: sa.Connection, p: int, after: int, count: int) -> NDArray[np.int64]:
    """Return the packed least words of the stored classes of order p behind one, so many at most."""
    low, high = keys_of_period(p)
    numbers = sa.select(cycle.c.id).where(cycle.c.id > low + after, cycle.c.id <= high)
    found = connection.scalars(numbers.order_by(cycle.c.id).limit(count)).all()
    return packed(np.array(found, dtype=np.int64), p)


def count_words(connection: sa.Connection, span: Span) -> int:
    """Return how many words the stored classes of a span have."""
    low, _ = keys_of_period(span.p)
    here = cycle.c.id.between(low + span.after + 1, low + span.upto)
    return connection.scalar(sa.select(sa.func.sum(cycle.c.class_size)).where(here)) or 0
