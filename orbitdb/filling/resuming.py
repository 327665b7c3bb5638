"""The loop that fills, sweeps and births share: solve what is missing, block by block, and store it.

Every block is written in one transaction together with the cursor that says how far its period has come
(`orbitdb.store.writing.cursors`), so that the work can be stopped at any moment, by Ctrl-C or a kill, and
goes on there.
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
    """How far a fill, a sweep or births have come.

    Attributes
    ----------
    p : int
        The period at work.
    words : int
        Words of this period of which the classes are done.
    total : int
        Words of this period there are.
    """

    p: int
    words: int
    total: int


class Work(ABC):
    """What is to be done with periods."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer

    @abstractmethod
    def open(self, connection: sa.Connection, p: int) -> Cursor:
        """Return how far a period has come."""

    @abstractmethod
    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[Any]]:
        """Cut what is behind a cursor into blocks, in order; each tells what becomes of its `span`."""

    @abstractmethod
    def store(self, connection: sa.Connection, cursor: Cursor, part: Any) -> dict[str, float]:
        """Store what became of the span behind a cursor; return what its row adds up, words among it."""

    def counted(self, connection: sa.Connection, cursor: Cursor) -> tuple[int, Mapping[str, Any]]:
        """Return of how many words of a period something is stored, and what its row is to say in the end."""
        return cursor.words, {}

    def closing(self, connection: sa.Connection, cursor: Cursor) -> Mapping[str, Any]:
        """Write what is to be written when a period is whole; return what else its row is to say."""
        return {}


def resume(work: Work, periods: Iterable[int], workers: Workers) -> Generator[Step]:
    """Do what is missing of some periods; go on behind another process that does the same.

    Yields
    ------
    Step
        Behind every block that is safely stored.

    Raises
    ------
    StoreError
        If the database cannot be written, or a period that is complete does not hold what it should.
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
    """Store the blocks behind the cursors, and close every period behind its last one."""
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
    """Check that a period is whole, and note it; `OvertakenError` tells that another process has done so."""
    with work.writer.reading() as connection:  # it takes a while, in which others may write
        words, values = work.counted(connection, cursor)
    if words != (total := count_admissible(cursor.p)):
        raise StoreError(
            f"period {cursor.p} holds {words} words instead of {total}: {work.writer.path} is damaged"
        )
    with work.writer.writing() as connection:
        hold(connection, cursor)
        close(connection, cursor, {**values, **work.closing(connection, cursor)})
