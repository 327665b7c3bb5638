"""Measure how often the statements of `orbitdb assess` are right, in windows cut from exact levels.

``python docs/calibration.py`` prints the table on the page about levels, in about ten minutes. Numbers after
it choose rows of the table: ``python docs/calibration.py 3`` prints the last one only. Windows have 12 to 200
levels, and 0 to 20 % of the levels are missing, two fifths of them in blocks. In the second row, a third of
the windows also have spurious levels.
"""

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from orbitdb import Catalogue, Stadium, levels
from orbitdb.arrays import Floats
from orbitdb.quantum.missing_levels import Assessment
from orbitdb.quantum.weyl import Parity, weyl

LISTS = [(1.6, "ee", 50.0), (1.6, "oo", 50.0), (1.8, "oo", 60.0), (1.3, "ee", 45.0), (1.0, "oo", 60.0)]
MIXED = [(1.6, None, 34.0), (1.0, None, 36.0)]
"""Half length, parity and largest k of the exact levels; None for all parities."""
ROWS = (
    ("one parity", LISTS, False, 57, 400),
    ("one parity, spurious levels", LISTS, True, 57, 400),
    ("all parities", MIXED, False, 1128, 100),
)
"""Name of each row of the table, its exact levels, whether there are spurious ones, seed, number of windows.
The largest probability that is stated for a gap in a list of all parities was chosen on windows with seed 57.
"""

_NEAR = 1.5
"""Distance in mean spacings within which a missing level counts as found."""
_LEAST, _MOST = 12, 200
_LARGEST_SHARE, _IN_BLOCKS, _LONGEST_BLOCK = 0.2, 0.4, 7
_LOWEST = 4.0


class Window(NamedTuple):
    """Levels of a window, the true number of its first level, and its missing and spurious levels."""

    a: float
    parity: Parity | None
    k: Floats
    first: int
    missing: Floats
    spurious: Floats


def exact(a: float, parity: str | None, k_max: float) -> Floats:
    """Return all levels of one parity, or of all, below `k_max`."""
    return np.sort(levels(a, k_max, parity=None if parity is None else [parity]).k)


def windows(
    rng: np.random.Generator, a: float, parity: str | None, k: Floats, count: int, spurious: bool = False
) -> Iterator[Window]:
    """Cut windows from exact levels, and remove some of their levels."""
    lowest = int(np.searchsorted(k, _LOWEST))
    most = min(_MOST, (len(k) - lowest) // 2)
    for _ in range(count):
        length = int(np.exp(rng.uniform(np.log(_LEAST), np.log(most))))
        lost = _lost(rng, length, rng.uniform(0, _LARGEST_SHARE))
        length += len(lost)
        begin = int(rng.integers(lowest, len(k) - length))
        whole = k[begin : begin + length]
        some = rng.integers(1, max(2, length // 30) + 1) if spurious and rng.random() < 1 / 3 else 0
        added = np.sort(rng.uniform(whole[1], whole[-2], some))
        given = np.sort(np.concatenate([np.delete(whole, lost), added]))
        yield Window(a, None if parity is None else Parity(parity), given, begin + 1, whole[lost], added)


def _lost(rng: np.random.Generator, length: int, share: float) -> list[int]:
    """Return which levels are lost, singly or in blocks; neither the first nor the last of them all."""
    count = round(length * share / (1 - share))
    lost: set[int] = set()
    while len(lost) < count:
        first = int(rng.integers(1, length + count - 1))
        block = int(rng.integers(2, _LONGEST_BLOCK + 1)) if rng.random() < _IN_BLOCKS else 1
        room = range(first, min(first + block, length + count - 1))
        lost.update([*room][: count - len(lost)])
    return sorted(lost)


CLAIMS = ("first > .99", "first < .99", "gap > .99", "gap < .99")
"""The statements that are counted, by their probability."""


@dataclass
class Tally:
    """How many statements were right, of how many."""

    windows: int = 0
    first: int = 0
    missing: int = 0
    found: int = 0
    false: int = 0
    claims: dict[str, list[bool]] = field(default_factory=lambda: {name: [] for name in CLAIMS})

    def add(self, window: Window, said: Assessment) -> None:
        """Count the statements about one window."""
        smooth = weyl(Stadium(window.a), window.parity)
        true, placed = smooth(window.missing), smooth(np.sort(said.places))
        self.windows += 1
        self.first += said.first == window.first
        self.missing += len(true)
        self.found += matched(true, placed)
        self.false += sum(not (np.abs(true - each) < _NEAR).any() for each in placed)
        self._claim("first", said.first_probability, said.first == window.first)
        for gap in said.gaps:
            low, high = gap.after or -np.inf, gap.before or np.inf
            counts = [int(((low < k) & (k < high)).sum()) for k in (window.missing, window.spurious)]
            self._claim("gap", gap.probability, counts == [gap.missing, gap.spurious])

    def _claim(self, what: str, probability: float, right: bool) -> None:
        if probability > 0.9:
            self.claims[f"{what} {'>' if probability > 0.99 else '<'} .99"].append(right)

    def shares(self) -> tuple[float, float, float]:
        """Return the shares of right first numbers, of levels found, and of false ones, of those missing."""
        return self.first / self.windows, self.found / self.missing, self.false / self.missing

    def row(self) -> list[str]:
        """Return the cells of a row of the table."""
        claims = [f"{sum(right)} of {len(right)}" for right in self.claims.values()]
        return [
            f"{self.first} of {self.windows}", f"{self.found} of {self.missing}", str(self.false), *claims,
        ]  # fmt: skip


def matched(true: Floats, placed: Floats) -> int:
    """Return how many true levels can be paired with different placed ones within `_NEAR`; both ascend."""
    count = here = 0
    for each in true.tolist():
        while here < len(placed) and placed[here] <= each - _NEAR:
            here += 1
        if here < len(placed) and placed[here] < each + _NEAR:
            count, here = count + 1, here + 1
    return count


def measure(catalogue: Catalogue, some: Iterator[Window]) -> Tally:
    """Assess windows, and count which statements are right."""
    tally = Tally()
    for window in some:
        tally.add(window, catalogue.assess(window.k, parity=window.parity, window=True, a=window.a))
    return tally


def main(rows: Sequence[int]) -> None:
    """Print the table, or some of its rows, counted from 1."""
    heads = (
        "windows", "first number right", "missing levels found", "false", "P of first number > .99",
        ".9 to .99", "P of gap > .99", ".9 to .99",
    )  # fmt: skip
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    with tempfile.TemporaryDirectory() as folder:
        catalogue = Catalogue.create(Path(folder) / "orbits.db", 1.6)
        for a in {a for a, *_ in [*LISTS, *MIXED]}:
            catalogue.fill("2-12", a=a)
        for row in rows:
            name, lists, spurious, seed, count = ROWS[row - 1]
            tally = measure(catalogue, _cut(lists, count, spurious, seed))
            print(f"| {' | '.join([name, *tally.row()])} |", flush=True)


def _cut(
    lists: Sequence[tuple[float, str | None, float]], count: int, spurious: bool, seed: int
) -> Iterator[Window]:
    """Yield the windows of all lists."""
    rng = np.random.default_rng(seed)
    for a, parity, k_max in lists:
        yield from windows(rng, a, parity, exact(a, parity, k_max), count // len(lists), spurious)


if __name__ == "__main__":
    main([int(row) for row in sys.argv[1:]] or range(1, len(ROWS) + 1))
