"""The loop shared by fills, sweeps and births: solve what is missing, block by block, and store it.

Each kind of work has a table of cursors with one row per period: its state, the word up to which everything
is stored, and the counts and times so far. A block and its cursor are written in one transaction, so the work
can be stopped or killed at any moment, and continues from the cursor.
"""

import time
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterable, Iterator, Mapping
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from orbitdb.errors import StoreError
from orbitdb.filling.workers import Task, Workers
from orbitdb.progress import Tell
from orbitdb.store.connection import Connection
from orbitdb.store.schema import DONE, FILLING
from orbitdb.store.writing import Writer, insert_row
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.pruning import count_admissible


class OvertakenError(Exception):
    """Another process has moved the cursor, so it must be read again."""


@dataclass(frozen=True)
class Cursor:
    """Progress of the work on one period: a stored or initial row of `fill`, `sweep` or `birth_fill`."""

    table: str
    row: dict[str, Any]

    @property
    def p(self) -> int:
        """The period."""
        return int(self.row["p"])

    @property
    def done(self) -> bool:
        """Whether the period is complete."""
        return bool(self.row["state"] == DONE)

    @property
    def words(self) -> int:
        """Number of words in the stored classes."""
        return int(self.row["words"])

    @property
    def after(self) -> int:
        """The packed symbols after which the work continues; they need not be a word of the period.

        All classes whose representatives come before or at this point are stored.
        """
        return -1 if self.row["cursor"] is None else int(self.row["cursor"], 8)

    @property
    def own(self) -> str:
        """The SQL condition for this row, and for rows of other tables with the same stadium and period."""
        return " AND ".join(f"{name} = :{name}" for name in ("stadium", "p") if name in self.row)


def open_cursor(connection: Connection, table: str, **begun: object) -> Cursor:
    """Return the stored progress of a period, or an initial row with the given values and zero counts."""
    columns = list(connection.records(f"PRAGMA table_info({table})"))
    zero = {column["name"]: 0 for column in columns if column["notnull"] and not column["pk"]}
    cursor = Cursor(table, zero | {"cursor": None} | begun | {"state": FILLING})
    stored = connection.records(f"SELECT * FROM {table} WHERE {cursor.own}", cursor.row)
    return Cursor(table, next(stored, cursor.row))


def hold(connection: Connection, cursor: Cursor) -> None:
    """Raise `OvertakenError` if another process has moved the cursor; during this transaction, none can."""
    query = f"SELECT state, cursor FROM {cursor.table} WHERE {cursor.own}"
    stored = connection.execute(query, cursor.row).fetchone() or (FILLING, None)
    if stored != (FILLING, cursor.row["cursor"]):
        raise OvertakenError


def move(connection: Connection, cursor: Cursor, span: Span, spent: Mapping[str, float]) -> Cursor:
    """Move a cursor to the end of the next span, and add the counts and times of that span."""
    row = cursor.row
    added = {name: row[name] + value for name, value in spent.items()} | {"cursor": f"{span.upto:0{span.p}o}"}
    return _stored(connection, cursor, added)


def _stored(connection: Connection, cursor: Cursor, values: Mapping[str, Any]) -> Cursor:
    """Store new values of a cursor's row, and return the cursor with them."""
    row = cursor.row | dict(values)
    insert_row(connection, cursor.table, row)
    return replace(cursor, row=row)


class Step(NamedTuple):
    """Progress of a fill, a sweep or a search for births: how many of the words of a period are done."""

    p: int
    words: int
    total: int


class Work(ABC):
    """Base class of work that is done one period at a time."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer

    @abstractmethod
    def open(self, connection: Connection, p: int) -> Cursor:
        """Return the progress of a period."""

    @abstractmethod
    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task[Any]]:
        """Cut the work after a cursor into blocks, in order; the result of each block has a `span`."""

    @abstractmethod
    def store(self, connection: Connection, cursor: Cursor, part: Any) -> dict[str, float]:
        """Store the result of the span after a cursor; return the numbers to add to the cursor's row."""

    def counted(self, connection: Connection, cursor: Cursor) -> tuple[int, Mapping[str, Any]]:
        """Return the number of words stored, and final values for the cursor's row."""
        return cursor.words, {}

    def closing(self, connection: Connection, cursor: Cursor) -> Mapping[str, Any]:
        """Finish a complete period; return further final values for the cursor's row."""
        return {}


def resume(work: Work, periods: Iterable[int], workers: Workers) -> Generator[Step]:
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
        with work.writer.writing() as connection:
            cursors = {p: work.open(connection, p) for p in periods}
        missing = {p: cursor for p, cursor in cursors.items() if not cursor.done}
        if not missing:
            return
        with suppress(OvertakenError):
            yield from _blocks(work, missing, workers)


def _blocks(work: Work, cursors: dict[int, Cursor], workers: Workers) -> Generator[Step]:
    """Solve and store the blocks after the cursors, and close each period after its last block."""
    clock = time.monotonic()
    blocks = (block for cursor in [*cursors.values()] for block in work.blocks(cursor, workers.jobs))
    for part in workers.solved(blocks):
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
    """Check that a period is complete, and mark it as done; raise `OvertakenError` if it already is."""
    with work.writer.reading() as connection:  # takes a while; others may write meanwhile
        words, values = work.counted(connection, cursor)
    if words != (total := count_admissible(cursor.p)):
        raise StoreError(
            f"period {cursor.p} has {words} words instead of {total}: {work.writer.path} is damaged"
        )
    with work.writer.writing() as connection:
        hold(connection, cursor)
        final = {**values, **work.closing(connection, cursor), "state": DONE}
        _stored(connection, cursor, final)


def run_steps(
    steps: Generator[Step], what: str, totals: Mapping[int, int], tell: Tell, stored: int = 0
) -> None:
    """Run a fill, a sweep or a search for births, and report its progress over all periods.

    `totals` has the number of words of each period; `stored` is the number of words stored before.
    """
    total = sum(totals.values())
    with closing(steps):
        tell(stored, total, what)
        for step in steps:
            before = sum(count for p, count in totals.items() if p < step.p)
            tell(before + step.words, total, f"{what}, p = {step.p:>2} of {max(totals)}")
