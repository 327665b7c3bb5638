"""Sweep periods: enumerate, solve and add up orbits block by block, and store only counts and sums."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from time import thread_time
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.averages.by_period import PeriodSums
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.estimate import SWEEP, filled_periods, need
from orbitdb.filling.period_jobs import PeriodJob, Step, resume, run_steps
from orbitdb.filling.workers import HERE, Task, Workers, at_work, number_of
from orbitdb.orbits.exponents import OrbitClasses, Tally, exponents
from orbitdb.progress import Tell, nobody
from orbitdb.store import tables
from orbitdb.store.cursors import Cursor, delete_blocks, open_cursor, sums_of_blocks
from orbitdb.store.writer import Writer, replace_row
from orbitdb.symbols.enumeration import LeastWords, Span, all_least_words, class_spans
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.symmetry import SIZES

if TYPE_CHECKING:
    from orbitdb.store.sqlite import Connection

CLASSES = 1 << 15
"""Maximum number of classes in a block; it limits the memory used."""

SMALL = 200_000
"""A period of at most this many words is swept in this process, before other processes could start."""


def sweep(
    path: Path,
    a: float,
    periods: Sequence[int],
    jobs: int | None = None,
    workers: Workers | None = None,
    tell: Tell = nobody,
) -> None:
    """Sweep the given periods at the given a that are not filled (`Catalogue.sweep`)."""
    number, filled = number_of(jobs, workers), filled_periods(path, a)
    if not (periods := [p for p in periods if p not in filled]):
        return
    coming = need(path, a, periods, number, SWEEP)
    with at_work(coming.alone, jobs, workers) as solving:
        words = {p: count_admissible(p) for p in periods}
        steps = sweep_periods(path, a, periods, solving)
        run_steps(steps, "words", words, tell, sum(words.values()) - coming.words)


def sweep_periods(
    path: Path,
    a: float,
    periods: Iterable[int],
    workers: Workers = HERE,
) -> Generator[Step]:
    """Count the words of the given periods, sum over their orbits, and store the sums (as `fill_periods`)."""
    stadium, periods = Stadium(a), list(periods)
    parameters = {"command": "sweep", "a": a, "periods": periods}
    with closing(Writer(path, parameters, references=False)) as writer:
        work = _Sweep(writer, stadium.a)
        yield from resume(work, [p for p in periods if count_admissible(p) <= SMALL], HERE)
        yield from resume(work, periods, workers)  # including those of the small that were deleted meanwhile


class _Sweep(PeriodJob):
    def __init__(self, writer: Writer, a: float) -> None:
        super().__init__(writer)
        self.a = a

    def open(self, connection: "Connection", p: int) -> Cursor:
        return open_cursor(connection, tables.sweep, stadium=self.writer.stadium_id(connection, self.a), p=p)

    def blocks(self, cursor: Cursor, jobs: int) -> Iterator[Task["SweptSums"]]:
        """Cut a period into the same blocks for any number of jobs, so that the sums do not depend on it."""
        spans = class_spans(cursor.p, CLASSES, cursor.after)
        return (partial(solve_swept, self.a, span) for span in spans)

    def store(self, connection: "Connection", cursor: Cursor, part: "SweptSums") -> dict[str, float]:
        block = {
            "stadium": cursor.row["stadium"],
            "p": cursor.p,
            "number": cursor.row["blocks"],
            "sums": part.sums.numbers(),
            "run": self.writer.run_id(connection, part.arithmetic),
        }
        replace_row(connection, tables.sweep_block, block)
        return {**asdict(part.tally), "blocks": 1, "processor": part.processor}

    def closing(self, connection: "Connection", cursor: Cursor) -> dict[str, Any]:
        """Add up the blocks of a period, and delete them."""
        blocks, arithmetics = sums_of_blocks(connection, cursor)
        sums = [PeriodSums.from_numbers(cursor.p, numbers) for numbers in blocks]
        delete_blocks(connection, cursor)
        number = self.writer.run_id(connection, arithmetics or None)
        total = PeriodSums.joined(sums, cursor.p)
        return {"sums": total.numbers(), "run": number}


@dataclass(frozen=True, eq=False)
class SweptSums:
    """The counts of a block, and the sums over its orbits; `processor` is a processor time in seconds."""

    span: Span
    tally: Tally
    sums: PeriodSums
    processor: float
    arithmetic: str


def solve_swept(a: float, span: Span) -> SweptSums:
    """Find the classes whose representatives lie in a span, solve them, and sum over their orbits."""
    clock = thread_time()
    summed = _summed(all_least_words(span), span.p, a)
    return SweptSums(span, *summed, thread_time() - clock, arithmetic())


def _summed(part: LeastWords, p: int, a: float) -> tuple[Tally, PeriodSums]:
    """Solve classes and add up their orbits, each weighted by the number of words of its class."""
    rows = np.flatnonzero(SIZES[part.stabiliser])
    sizes = SIZES[part.stabiliser[rows]]
    solved = list(exponents(part.codes[rows], p, Stadium(a))) if len(rows) else []
    none = (np.zeros(0, int), np.zeros(0), np.zeros(0), np.zeros(0, int))
    columns = [(sizes[of.orbits], of.length, of.lyapunov, of.legs.n.sum(axis=0)) for of in solved]
    size, length, lyapunov, walls = (np.concatenate(parts) for parts in zip(none, *columns, strict=True))
    of_orbits = OrbitClasses(np.full(len(size), p), size, length, lyapunov, walls)
    return Tally.of(sizes, solved), PeriodSums.of(of_orbits, p)
