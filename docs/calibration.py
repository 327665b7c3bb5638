"""Measure how often the statements of `orbitdb assess` are right, in windows cut from complete lists.

``python docs/calibration.py`` prints the table on the page about levels in a quarter of an hour of processor
time, a third of it for exact levels. With a file, ``python docs/calibration.py some.db`` keeps these in a
catalogue for the next time. Numbers after it choose rows: ``python docs/calibration.py some.db 3`` measures
the public levels only.

None of the lists was used to tune the program: tests/benchmarks/bench_levels.py does that with the first half
of the public levels, and exact levels of other stadiums.
"""

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from orbitdb import Catalogue, Selection, Stadium, read_levels
from orbitdb.answers.stadium_levels import orbits_for, read_orbits
from orbitdb.arrays import Floats
from orbitdb.quantum.levels_from_orbits import Staircase
from orbitdb.quantum.missing_levels import Assessment, assess
from orbitdb.quantum.weyl import Parity, parities_of
from orbitdb.store.stored_values import stored_levels

PUBLIC = Path(__file__).parents[1] / "tests" / "published" / "quarter_stadium_k770.txt"
FIRST_PUBLIC = 83898


class Source(NamedTuple):
    """A complete list of levels: half length, parity, the levels, and the number of the first."""

    a: float
    parity: Parity | None
    k: Floats
    first: int


class Kind(NamedTuple):
    """What is done to windows: shares of the levels that are missing, and that are spurious."""

    name: str
    missing: float
    spurious: float


KINDS = (
    Kind("complete", 0.0, 0.0),
    Kind("2 % missing", 0.02, 0.0),
    Kind("10 % missing", 0.1, 0.0),
    Kind("2 % spurious", 0.0, 0.02),
    Kind("2 % missing, 2 % spurious", 0.02, 0.02),
)
ROWS = (
    ("k = 20 to 92", ((1.4, Parity.EO, 20.0, 50.0), (1.8, Parity.EE, 85.0, 92.0)), {100: 32}),
    ("k = 110 to 156", ((1.2, Parity.EE, 110.0, 118.0), (0.8, Parity.OE, 150.0, 156.0)), {100: 32}),
    ("k = 774 to 778", (), {100: 60, 400: 40}),
    ("all parities, k = 4 to 40", ((1.2, None, 4.0, 31.0), (0.7, None, 30.0, 40.0)), {100: 32}),
)
"""Name of each row, the exact levels (none for the public ones), and the number of windows of each length."""
SEED = 1992


class Window(NamedTuple):
    """Levels of a window, the true number of its first level, and its missing and spurious levels."""

    a: float
    parity: Parity | None
    k: Floats
    first: int
    missing: Floats
    spurious: Floats


def windows(
    rng: np.random.Generator, source: Source, length: int, kind: Kind, count: int
) -> Iterator[Window]:
    """Cut windows from a list, take some of their levels away, and add others at random.

    The first and the last level stay: the list does not tell what is missing beyond them.
    """
    lost = round(length * kind.missing)
    for _ in range(count):
        begin = int(rng.integers(0, len(source.k) - length - lost + 1))
        whole = source.k[begin : begin + length + lost]
        gone = np.sort(rng.choice(np.arange(1, len(whole) - 1), lost, replace=False))
        added = np.sort(rng.uniform(whole[0], whole[-1], round(length * kind.spurious)))
        given = np.sort(np.concatenate([np.delete(whole, gone), added]))
        yield Window(source.a, source.parity, given, source.first + begin, whole[gone], added)


@dataclass
class Tally:
    """Statements about windows: their probabilities, and whether each was right.

    Attributes
    ----------
    first, sure, rows : list of (float, bool)
        About the first number, that number with P above .99, and the rows.
    within : list of bool
        Whether the number of missing levels, in a crowded list less the spurious ones, is within twice its
        error.
    refused : int
        Lists that do not fit, though they do.
    """

    first: list[tuple[float, bool]] = field(default_factory=list)
    sure: list[tuple[float, bool]] = field(default_factory=list)
    rows: list[tuple[float, bool]] = field(default_factory=list)
    within: list[bool] = field(default_factory=list)
    refused: int = 0

    def measure(self, orbits: Staircase, some: Iterator[Window]) -> None:
        """Assess windows, and count which statements are right."""
        for window in some:
            self.add(window, assess(window.k, orbits, Stadium(window.a), window.parity, window=True))

    def add(self, window: Window, said: Assessment) -> None:
        """Count the statements about one window."""
        if not said.fits:
            self.refused += 1
            return
        self.first.append((said.first_probability, said.first == window.first))
        self.sure += [self.first[-1]] if said.first_probability > 0.99 else []
        for gap in said.gaps:
            low, high = gap.after or -np.inf, gap.before or np.inf
            missing, spurious = (((low < k) & (k < high)).sum() for k in (window.missing, window.spurious))
            right = (
                missing - spurious == gap.missing
                if gap.spurious is None
                else (missing, spurious) == (gap.missing, gap.spurious)
            )
            self.rows.append((gap.probability, bool(right)))
        net = len(window.missing) - len(window.spurious)
        off = said.net - net if said.crowded else said.missing - len(window.missing)
        error = said.net_error if said.crowded else said.missing_error
        self.within.append(abs(off) <= 2 * max(error, 0.1))

    def row(self) -> list[str]:
        """Return the cells of a row of the table."""
        sure = f"{sum(right for _, right in self.sure)} of {len(self.sure)}"
        within = f"{np.mean(self.within):.2f}" if self.within else ""
        total = self.refused + len(self.first)
        return [shares(self.first), sure, shares(self.rows), within, f"{self.refused} of {total}"]


def shares(statements: Sequence[tuple[float, bool]]) -> str:
    """Return the share of statements that were right, and their mean probability."""
    if not statements:
        return ""
    said, right = np.mean(statements, axis=0).tolist()
    return f"{right:.2f} / {said:.2f} ({len(statements)})"


def staircase_of(catalogue: Catalogue, source: Source) -> Staircase:
    """Return the staircase from the orbits of a catalogue, over the range of a list."""
    with catalogue._reading() as connection:
        classes, period = read_orbits(connection, Selection(source.a))
    return orbits_for(Stadium(source.a), classes, source.parity, source.k, window=True, period=period)


def exact(catalogue: Catalogue, a: float, parity: Parity | None, low: float, high: float) -> Source:
    """Return exact levels from a catalogue, which computes those that it does not hold."""
    k = catalogue.fill_levels((low, high), parity=parity, a=a).k
    with catalogue._reading() as connection:
        first = [
            next(window for window in stored_levels(connection, a, one) if window.low <= low < window.high)
            for one in parities_of(parity)
        ]
    return Source(a, parity, k, 1 + sum(window.below + int((window.k < low).sum()) for window in first))


def public() -> tuple[Source, Source]:
    """Return the two halves of the public levels: the first one to tune the program, the other to test it."""
    low, high = np.array_split(read_levels(PUBLIC), 2)
    halves = ((low, FIRST_PUBLIC), (high, FIRST_PUBLIC + len(low)))
    one, other = (Source(1.0, Parity.OO, k, first) for k, first in halves)
    return one, other


def main(path: Path, rows: Sequence[int]) -> None:
    """Print the table, or some of its rows, counted from 1."""
    catalogue = Catalogue(path, 1.6) if path.exists() else Catalogue.create(path, 1.6)
    heads = (
        "windows", "levels", "first number: right / stated", "P > .99 right", "rows: right / stated",
        "missing levels within twice the error", "refused",
    )  # fmt: skip
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    for name, ranges, lengths in (ROWS[row - 1] for row in rows):
        for a in {a for a, *_ in ranges} or {1.0}:
            catalogue.fill("2-12", a=a)
        sources = [exact(catalogue, *one) for one in ranges] or [public()[1]]
        compared = [(one, staircase_of(catalogue, one)) for one in sources]
        for length, count in lengths.items():
            for kind in KINDS:
                tally, rng = Tally(), np.random.default_rng(SEED)
                for one, orbits in compared:
                    tally.measure(orbits, windows(rng, one, length, kind, count // len(compared)))
                cells = [f"{name}, {kind.name}", str(length), *tally.row()]
                print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    given = [*sys.argv[1:]]
    kept = Path(given.pop(0)) if given and not given[0].isdigit() else None
    chosen = [int(row) for row in given] or range(1, len(ROWS) + 1)
    if kept is not None:
        main(kept, chosen)
    else:
        with tempfile.TemporaryDirectory() as folder:
            main(Path(folder) / "orbits.db", chosen)
