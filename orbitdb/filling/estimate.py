"""Estimate the disk space and time that a fill or sweep takes, and check the free space."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from orbitdb.output_files import check_space
from orbitdb.store.file import reading
from orbitdb.store.file_kind import check_file
from orbitdb.store.lookup import a_values
from orbitdb.store.periods import read_fills, read_pruned_fills, read_sweeps
from orbitdb.store.tables import SCHEMA_VERSION
from orbitdb.symbols.pruning import count_admissible, count_pruned

LARGE = 1_000_000
"""A fill of at least this many words begins with an estimate."""

BYTES = 25.0
_BYTES_A_BOUNCE = 2.0
"""A word of period p takes at most 25 + 2 p bytes: an eighth of a class and of its orbit.

That is for large a, where almost all words are orbits; at a = 1.6, about half of them are.
"""

PRUNED_BYTES = 45.0
_PRUNED_BYTES_A_BOUNCE = 4.0
_FINDING_PRUNED, _STORING_PRUNED = 1.0e-6, 2.0e-6
"""A geometrically pruned word of period p takes at most 45 + 4 p bytes, and about these times in seconds."""

MANY_PRUNED = 10_000_000
"""From this number of pruned words on, the command asks before it stores them."""

_EMPTY = 400_000
"""Bytes of a file with a few words."""

SWEEP = "sweep"
_RATES = {
    "newton": (3.2e-7, 1.0e-6, 5.0e-7, 0.0),
    "relaxation": (1.3e-5, 2.1e-3, 3.2e-6, 0.0),
    SWEEP: (0.0, 8.0e-7, 0.0, 0.0),
}
"""Seconds per word for enumerating, solving and storing on one core of a recent server; then the least total.

Measured at p = 15 for Newton's method, at p = 14 for sweeps, which only solve, and at p = 9 for the
relaxation, which slows down with p.
"""

ENOUGH = 5_000
"""Earlier fills and sweeps of at least this many words show how fast this machine is."""

_ALIKE = 4
"""Of these, those with at least a quarter of the largest number count; small periods take longer per word."""

_JOURNAL = 64 << 20
"""Maximum size of the write-ahead log in bytes."""


class Need(NamedTuple):
    """What a fill or sweep takes.

    Attributes
    ----------
    words, bytes : int
        Number of words still to do, and the disk space that they need at most; 0 for a sweep.
    seconds, alone : float
        Time with the given number of processes, and with one process.
    """

    words: int
    bytes: int
    seconds: float
    alone: float


def need(path: Path, a: float, periods: Sequence[int], jobs: int, method: str = "newton") -> Need:
    """Estimate what a fill by a method takes, or a sweep if the method is `SWEEP`.

    The rates are those of earlier large fills or sweeps in the file, if there are any, but for the
    relaxation. The catalogue need not exist. Each of the `jobs` processes is assumed to have its own core.
    """
    stored, filled = list(_stored(path, method)), filled_periods(path, a) if method == SWEEP else set()
    left = {p: count_admissible(p) for p in periods if p not in filled}
    for at, p, done, _ in stored:
        if at == a and p in left:
            left[p] -= done
    words = sum(left.values())
    earlier = [] if method == "relaxation" else [(done, seconds) for _, _, done, seconds in stored]
    enumerating, solving, storing, wall = _rates(earlier) or _RATES[method]
    alone = max(enumerating + solving + storing, wall)  # the disk or other programs may slow this machine
    room = _EMPTY * (words > 0) + sum((BYTES + _BYTES_A_BOUNCE * p) * count for p, count in left.items())
    seconds = max(storing, alone / jobs) * words
    return Need(words, 0 if method == SWEEP else round(room), seconds, alone * words)


def filled_periods(path: Path, a: float) -> set[int]:
    """Return the periods that are completely filled, and so need no sweep; none without a catalogue."""
    if check_file(path) != SCHEMA_VERSION:
        return set()
    with reading(path) as connection:
        return {fill.p for fill in read_fills(connection, a) if fill.done}


def need_of_pruned(path: Path, periods: Sequence[int], jobs: int) -> Need:
    """Estimate what storing the geometrically pruned words of periods takes (see `need`)."""
    left = {p: count_pruned(p) for p in periods}
    if check_file(path) == SCHEMA_VERSION:
        with reading(path) as connection:
            for p, (done, _) in read_pruned_fills(connection).items():
                if p in left:
                    left[p] -= done
    words = sum(left.values())
    room = sum((PRUNED_BYTES + _PRUNED_BYTES_A_BOUNCE * p) * count for p, count in left.items())
    seconds = max(_STORING_PRUNED, (_FINDING_PRUNED + _STORING_PRUNED) / jobs) * words
    return Need(words, round(room), seconds, (_FINDING_PRUNED + _STORING_PRUNED) * words)


def _rates(done: Sequence[tuple[int, Sequence[float]]]) -> list[float]:
    """Return the means of the seconds per word in the largest fills or sweeps, [] if all were small."""
    least = max(ENOUGH, max((words for words, _ in done), default=0) / _ALIKE)
    large = [(words, seconds) for words, seconds in done if words >= least]
    total = sum(words for words, _ in large)
    return [sum(column) / total for column in zip(*(seconds for _, seconds in large), strict=True)]


def _stored(path: Path, method: str) -> Iterator[tuple[float, int, int, tuple[float, ...]]]:
    """Yield a, p, the number of words and the times of each fill or sweep; the times are those of `_RATES`.

    A file that is missing, or has not the latest schema, has none.
    """
    if check_file(path) != SCHEMA_VERSION:
        return
    with reading(path) as connection:
        for a in a_values(connection):
            if method == SWEEP:
                for sweep in read_sweeps(connection, a):
                    yield a, sweep.p, sweep.tally.words, (0.0, sweep.processor, 0.0, 0.0)
            else:
                for fill in read_fills(connection, a):
                    yield a, fill.p, fill.words, (fill.enumerating, fill.solving, fill.storing, fill.seconds)


def check_room(path: Path, *needed: Need) -> None:
    """Raise `StoreError` if the disk has less free space than fills and their journal need."""
    room, words = sum(each.bytes for each in needed), sum(each.words for each in needed)
    check_space(path, room + min(room, _JOURNAL), f"{words} words and their journal take up to")


def duration(seconds: float) -> str:
    """Format a time in a suitable unit."""
    for unit, length in (("days", 86_400), ("hours", 3_600), ("minutes", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.0f} s" if seconds >= 1 else f"{seconds:.2g} s"


def about(seconds: float) -> str:
    """Format an estimated time without fractions of a second."""
    return "under a second" if seconds < 1 else f"about {duration(seconds)}"
