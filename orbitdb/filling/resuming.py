"""The loop that fills, sweeps and births share: solve what is missing, block by block, and store it.

Every block is written in one transaction together with the cursor that says how far its period has come
(`orbitdb.store.writing.cursors`), so that the work can be stopped at any moment, by Ctrl-C or a kill, and
goes on there.
"""

import time
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple, Protocol, TypeVar

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.filling.workers import Task, Workers
from orbitdb.store.writing.cursors import Cursor, OvertakenError, close, hold, move
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span


class Progress(NamedTuple):
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


class Solved(Protocol):
    """What became of a span of a period."""

    @property
    def span(self) -> Span:
        """The span."""


Part = TypeVar("Part", bound=Solved)


class Work(Protocol[Part]):
    """What is to be done with periods."""

    def open(self, connection: sa.Connection, p: int) -> Cursor:
        """Return how far a period has come."""

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[Part]]:
        """Cut what is behind a cursor into blocks, in order; each tells what becomes of its span."""

    def store(self, connection: sa.Connection, cursor: Cursor, part: Part) -> dict[str, float]:
        """Store what became of the span behind a cursor; return what its row adds up, words among it."""

    def counted(self, connection: sa.Connection, cursor: Cursor) -> tuple[int, Mapping[str, Any]]:
        """Return of how many words of a period something is stored, and what its row is to say in the end."""

    def closing(self, connection: sa.Connection, cursor: Cursor) -> Mapping[str, Any]:
        """Write what is to be written when a period is whole; return what else its row is to say."""


def resume(writer: Writer, work: Work[Part], periods: Iterable[int], workers: Workers) -> Generator[Progress]:
    """Do what is missing of some periods; go on behind another process that does the same.

    Yields
    ------
    Progress
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
        with writer.writing() as connection:
            cursors = {p: work.open(connection, p) for p in periods}
        missing = {p: cursor for p, cursor in cursors.items() if not cursor.done}
        if not missing:
            return
        with suppress(OvertakenError):
            yield from _blocks(writer, work, missing, workers)


def _blocks(
    writer: Writer, work: Work[Part], cursors: dict[int, Cursor], workers: Workers
) -> Generator[Progress]:
    """Store the blocks behind the cursors, and close every period behind its last one."""
    clock = time.monotonic()
    begun = list(cursors.values())
    for part in workers.solved(block for each in begun for block in work.blocks(each, workers.jobs)):
        before, clock = clock, time.monotonic()
        p = part.span.p
        with writer.writing() as connection:
            hold(connection, cursors[p])
            spent = work.store(connection, cursors[p], part) | {"seconds": clock - before}
            cursors[p] = move(connection, cursors[p], part.span, spent)
        if part.span.upto == Span.whole(p).upto:
            _close(writer, work, cursors[p])
        yield Progress(p, cursors[p].words, count_admissible(p))


def _close(writer: Writer, work: Work[Part], cursor: Cursor) -> None:
    """Check that a period is whole, and note it; `OvertakenError` tells that another process has done so."""
    with writer.reading() as connection:  # it takes a while, in which others may write
        words, values = work.counted(connection, cursor)
    if words != (total := count_admissible(cursor.p)):
        raise StoreError(
            f"period {cursor.p} holds {words} words instead of {total}: {writer.path} is damaged"
        )
    with writer.writing() as connection:
        hold(connection, cursor)
        close(connection, cursor, {**values, **work.closing(connection, cursor)})
