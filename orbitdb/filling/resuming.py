"""The loop shared by fills, sweeps and births: solve what is missing block by block, and store it.

Each block is written in one transaction with the cursor that records the progress of its period
(`orbitdb.store.writing.cursors`), so the work can be stopped at any moment, even by a kill, and resumes
there.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.filling.workers import Task, Workers
from orbitdb.store.writing.cursors import Cursor, OvertakenError, close, hold, move
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.pruning import count_admissible


class Step(NamedTuple):
    """Progress of a fill, a sweep or births.

    Attributes
    ----------
    p : int
        The current period.
    words : int
        Words of this period whose classes are done.
    total : int
        Number of words of this period.
    """

    p: int
    words: int
    total: int


class Work(ABC):
    """A kind of work on periods."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer

    @abstractmethod
    def open(self, connection: sa.Connection, p: int) -> Cursor:
        """Return the progress of a period."""

    @abstractmethod
    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[Any]]:
        """Cut the work after a cursor into blocks, in order; each result has its `span`."""

    @abstractmethod
    def store(self, connection: sa.Connection, cursor: Cursor, part: Any) -> dict[str, float]:
        """Store the result of the span after a cursor; return what its row adds up, such as words."""

    def counted(self, connection: sa.Connection, cursor: Cursor) -> tuple[int, Mapping[str, Any]]:
        """Return the number of stored words of a period, and the final values of its row."""
        return cursor.words, {}

    def closing(self, connection: sa.Connection, cursor: Cursor) -> Mapping[str, Any]:
        """Finish a complete period; return further values of its row."""
        return {}


def resume(work: Work, periods: Iterable[int], workers: Workers) -> Generator[Step]:
    """Do what is missing of some periods; continue after another process that does the same.

    Yields
    ------
    Step
        After every stored block.

    Raises
    ------
    StoreError
        If the database cannot be written, or a finished period has the wrong number of words.
    WorkError
        If the workers fail.
    """
    periods = sorted(set(periods))
    while True:
        with work.writer.writing() as connection:
            cursors = {p: work.open(connection, p) for p in periods}
        missing = {p: cursor for p, cursor in cursors.items() if not cursor.done}
        if not missing:
            return
        with suppress(OvertakenError):
            yield from _blocks(work, missing, workers)


def _blocks(work: Work, cursors: dict[int, Cursor], workers: Workers) -> Generator[Step]:
    """Store the blocks after the cursors, and close each period after its last block."""
    clock = time.monotonic()
    begun = list(cursors.values())
    for part in workers.solved(block for each in begun for block in work.blocks(each, workers.jobs)):
        before, clock = clock, time.monotonic()
        p = part.span.p
        with work.writer.writing() as connection:
            hold(connection, cursors[p])
            spent = work.store(connection, cursors[p], part) | {"seconds": clock - before}
            cursors[p] = move(connection, cursors[p], part.span, spent)
        if part.span.upto == Span.whole(p).upto:
            _close(work, cursors[p])
        yield Step(p, cursors[p].words, count_admissible(p))


def _close(work: Work, cursor: Cursor) -> None:
    """Check and record that a period is complete; `OvertakenError` if another process already did."""
    with work.writer.reading() as connection:  # takes a while, during which others may write
        words, values = work.counted(connection, cursor)
    if words != (total := count_admissible(cursor.p)):
        raise StoreError(
            f"period {cursor.p} holds {words} words instead of {total}: {work.writer.path} is damaged"
        )
    with work.writer.writing() as connection:
        hold(connection, cursor)
        close(connection, cursor, {**values, **work.closing(connection, cursor)})
