"""The loop shared by fills, sweeps, births and pruned words: do what is missing, block by block.

Each kind of work has a table of cursors with one row per period: its state, the word up to which everything
is stored, and the counts and times so far. A block and its cursor are written in one transaction, so the work
can be stopped or killed at any moment, and continues from the cursor.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing, suppress
from typing import TYPE_CHECKING, Any, NamedTuple

from orbitdb.errors import StoreError
from orbitdb.filling.workers import Task, Workers
from orbitdb.progress import Tell
from orbitdb.store.cursors import Cursor, OvertakenError, hold, keep, move
from orbitdb.store.tables import DONE
from orbitdb.store.writer import Writer
from orbitdb.symbols.edges import count_by_edges
from orbitdb.symbols.enumeration import Span

if TYPE_CHECKING:
    from orbitdb.store.sqlite import Connection


class Step(NamedTuple):
    """Progress of work on a period: how many of its words are done, and how many of them in this step."""

    p: int
    words: int
    total: int
    new: int


class PeriodJob(ABC):
    """Base class of work that is done one period at a time."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer

    def total(self, p: int) -> int:
        """Return the number of words that a period must have in the end, by an independent count."""
        return count_by_edges(p)

    @abstractmethod
    def open(self, connection: "Connection", p: int) -> Cursor:
        """Return the progress of a period."""

    @abstractmethod
    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[Any]]:
        """Cut the work after a cursor into blocks, in order; the result of each block has a `span`."""

    @abstractmethod
    def store(self, connection: "Connection", cursor: Cursor, part: Any) -> dict[str, float]:
        """Store the result of the span after a cursor; return the numbers to add to the cursor's row."""

    def counted(self, connection: "Connection", cursor: Cursor) -> tuple[int, Mapping[str, Any]]:
        """Return the number of words stored, and final values for the cursor's row."""
        return cursor.words, {}

    def closing(self, connection: "Connection", cursor: Cursor) -> Mapping[str, Any]:
        """Finish a complete period; return further final values for the cursor's row."""
        return {}


def resume(work: PeriodJob, periods: Iterable[int], workers: Workers) -> Generator[Step]:
    """Do the work that is left on the given periods, from where this or another process stopped.

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
        with work.writer.transaction() as connection:
            cursors = {p: work.open(connection, p) for p in periods}
        missing = {p: cursor for p, cursor in cursors.items() if not cursor.done}
        if not missing:
            return
        with suppress(OvertakenError):
            yield from _blocks(work, missing, workers)


def _blocks(work: PeriodJob, cursors: dict[int, Cursor], workers: Workers) -> Generator[Step]:
    """Solve and store the blocks after the cursors, and close each period after its last block."""
    clock = time.monotonic()
    blocks = (block for cursor in [*cursors.values()] for block in work.blocks(cursor, workers.jobs))
    for part in workers.solved(blocks):
        before, clock = clock, time.monotonic()
        p = part.span.p
        with work.writer.transaction() as connection:
            hold(connection, cursors[p])
            spent = work.store(connection, cursors[p], part) | {"seconds": clock - before}
            done = cursors[p].words
            cursors[p] = move(connection, cursors[p], part.span, spent)
        if part.span.upto == Span.of_period(p).upto:
            _close(work, cursors[p])
        yield Step(p, cursors[p].words, work.total(p), cursors[p].words - done)


def _close(work: PeriodJob, cursor: Cursor) -> None:
    """Check that a period is complete, and mark it as done; raise `OvertakenError` if it already is."""
    with work.writer.reading() as connection:  # takes a while; others may write meanwhile
        words, values = work.counted(connection, cursor)
    if words != (total := work.total(cursor.p)):
        raise StoreError(
            f"period {cursor.p} has {words} words instead of {total}: {work.writer.path} is damaged"
        )
    with work.writer.transaction() as connection:
        hold(connection, cursor)
        final = {**values, **work.closing(connection, cursor), "state": DONE}
        keep(connection, cursor, final)


def run_steps(
    steps: Generator[Step], what: str, totals: Mapping[int, int], tell: Tell, stored: int = 0
) -> None:
    """Run the work on periods, and report its progress over all of them.

    `totals` has the number of words of each period; `stored` is the number of words stored before.
    """
    total = sum(totals.values())
    with closing(steps):
        tell(stored, total, what)
        for step in steps:
            stored += step.new
            tell(stored, total, f"{what}, p = {step.p:>2} of {max(totals)}")
