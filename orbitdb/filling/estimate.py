"""Estimate the disk space and time that a fill or sweep takes, and check the free space."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from orbitdb.export import check_space
from orbitdb.store.file import check_file, reading
from orbitdb.store.fills import read_fills, read_sweeps
from orbitdb.store.schema import SCHEMA_VERSION
from orbitdb.symbols.pruning import count_admissible

if TYPE_CHECKING:
    import sqlalchemy as sa

LARGE = 1_000_000
"""A fill of at least this many words begins with an estimate."""

BYTES = 41.0
"""Bytes per word at p = 15: an eighth of a class and its orbit."""

_RATES = {"newton": (1.3e-6, 5.0e-7), "relaxation": (2.1e-3, 3.2e-6)}
"""Seconds per word for finding and for storing orbits, on one core of a recent server.

Measured at p = 15 for Newton's method, and at p = 9 for the relaxation, which slows down with p.
"""

_SWEEPING = 8.0e-7
"""Seconds per word for a sweep at p = 14, on one core of a recent server."""

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
    """Estimate what a fill takes; the catalogue need not exist.

    Each of the `jobs` processes is assumed to have its own core; one of them stores the results.
    """

    def stored(connection: "sa.Connection") -> dict[int, int]:
        return {fill.p: fill.words for fill in read_fills(connection, a)}

    words = _missing(path, periods, stored)
    solving, storing = _RATES[method]
    alone = solving + storing
    return Need(words, round(BYTES * words), max(storing, alone / jobs) * words, alone * words)


def sweep_need(path: Path, a: float, periods: Sequence[int], jobs: int) -> Need:
    """Estimate what a sweep takes; it stores no rows, so it needs hardly any space."""

    def stored(connection: "sa.Connection") -> dict[int, int]:
        return {sweep.p: sweep.tally.words for sweep in read_sweeps(connection, a)}

    words = _missing(path, periods, stored)
    return Need(words, 0, _SWEEPING * words / jobs, _SWEEPING * words)


def _missing(
    path: Path, periods: Sequence[int], words_stored: Callable[["sa.Connection"], Mapping[int, int]]
) -> int:
    """Return the number of words of the given periods that are not stored."""
    stored: Mapping[int, int] = {}
    if check_file(path) == SCHEMA_VERSION:
        with reading(path) as moment:
            stored = words_stored(moment.connection)
    return sum(count_admissible(p) - stored.get(p, 0) for p in periods)


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
