"""Estimate the disk space and time that a fill or sweep takes, and check the free space."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

from sqlalchemy import Connection

from orbitdb.answers.export import check_space
from orbitdb.store.file import check_file, reading
from orbitdb.store.fills import Fill, Sweep, read_fills, read_sweeps
from orbitdb.store.lookup import a_values
from orbitdb.store.tables import SCHEMA_VERSION
from orbitdb.symbols.pruning import count_admissible

Record = TypeVar("Record", Fill, Sweep)

LARGE = 1_000_000
"""A fill of at least this many words begins with an estimate."""

BYTES = 41.0
"""Bytes per word at p = 15: an eighth of a class and its orbit."""

_RATES = {"newton": (3.2e-7, 1.0e-6, 5.0e-7, 0.0), "relaxation": (1.3e-5, 2.1e-3, 3.2e-6, 0.0)}
"""Seconds per word for enumerating, solving and storing, on one core of a recent server, and at least in all.

Measured at p = 15 for Newton's method, and at p = 9 for the relaxation, which slows down with p.
"""

_SWEEPING = 8.0e-7
"""Seconds per word for a sweep at p = 14, on one core of a recent server."""

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
        Number of words still to do, and the disk space that they need.
    seconds, alone : float
        Time with the given number of processes, and with one process.
    """

    words: int
    bytes: int
    seconds: float
    alone: float


def need(path: Path, a: float, periods: Sequence[int], jobs: int, method: str = "newton") -> Need:
    """Estimate what a fill takes.

    With Newton's method, the rates are those of earlier large fills in the file, if there are any. The
    catalogue need not exist. Each of the `jobs` processes is assumed to have its own core.
    """
    stored = _stored(path, read_fills)
    words = _missing(periods, {fill.p: fill.words for at, fill in stored if at == a})
    done = [
        (fill.words, (fill.enumerating, fill.solving, fill.storing, fill.seconds))
        for _, fill in stored
        if method == "newton" and fill.storing and fill.enumerating
    ]
    enumerating, solving, storing, wall = _rates(done) or _RATES[method]
    alone = max(enumerating + solving + storing, wall)  # the disk or other programs may slow this machine
    return Need(words, round(BYTES * words), max(storing, alone / jobs) * words, alone * words)


def sweep_need(path: Path, a: float, periods: Sequence[int], jobs: int) -> Need:
    """Estimate what a sweep takes, at the rate of earlier large sweeps, if there are any.

    A sweep stores no rows, so it needs hardly any space.
    """
    stored = _stored(path, read_sweeps)
    words = _missing(periods, {sweep.p: sweep.tally.words for at, sweep in stored if at == a})
    (rate,) = _rates([(sweep.tally.words, (sweep.processor,)) for _, sweep in stored]) or [_SWEEPING]
    return Need(words, 0, rate * words / jobs, rate * words)


def _missing(periods: Sequence[int], stored: Mapping[int, int]) -> int:
    return sum(count_admissible(p) - stored.get(p, 0) for p in periods)


def _rates(done: Sequence[tuple[int, Sequence[float]]]) -> list[float]:
    """Return the means of the seconds per word in the largest fills or sweeps, [] if all were small."""
    least = max(ENOUGH, max((words for words, _ in done), default=0) / _ALIKE)
    large = [(words, seconds) for words, seconds in done if words >= least]
    total = sum(words for words, _ in large)
    return [sum(column) / total for column in zip(*(seconds for _, seconds in large), strict=True)]


def _stored(path: Path, read: Callable[[Connection, float], list[Record]]) -> list[tuple[float, Record]]:
    """Return the fills or sweeps with their a; none if the file is not a catalogue with the latest schema."""
    if check_file(path) != SCHEMA_VERSION:
        return []
    with reading(path) as moment:
        return [(a, record) for a in a_values(moment) for record in read(moment, a)]


def check_room(path: Path, needed: Need) -> None:
    """Raise `StoreError` if the disk has less free space than a fill and its journal need."""
    check_space(
        path, needed.bytes + min(needed.bytes, _JOURNAL), f"{needed.words} words and their journal take"
    )


def duration(seconds: float) -> str:
    """Format a time in a suitable unit."""
    for unit, length in (("days", 86_400), ("hours", 3_600), ("minutes", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.0f} s" if seconds >= 1 else f"{seconds:.2g} s"


def about(seconds: float) -> str:
    """Format an estimated time without fractions of a second."""
    return "under a second" if seconds < 1 else f"about {duration(seconds)}"
