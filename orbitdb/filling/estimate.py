"""Estimate the disk space and time that a fill or sweep takes, and check the free space."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from orbitdb.answers.export import check_space
from orbitdb.store.connection import Connection
from orbitdb.store.file import check_file, reading
from orbitdb.store.fills import Fill, Sweep, read_fills, read_sweeps
from orbitdb.store.lookup import a_values
from orbitdb.store.schema import SCHEMA_VERSION
from orbitdb.symbols.pruning import count_admissible

Record = TypeVar("Record", Fill, Sweep)

LARGE = 1_000_000
"""A fill of at least this many words begins with an estimate."""

BYTES = 41.0
"""Bytes per word at p = 15: an eighth of a class and its orbit."""

_RATES = {"newton": (3.2e-7, 1.0e-6, 5.0e-7), "relaxation": (1.3e-5, 2.1e-3, 3.2e-6)}
"""Seconds per word for enumerating, solving and storing, on one core of a recent server.

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
    stored = _at_every_a(path, read_fills)
    words = _missing(periods, {fill.p: fill.words for fill in stored.get(a, ())})
    fills = [fill for of_a in stored.values() for fill in of_a if fill.storing and fill.enumerating]
    large = _largest(fills, [fill.words for fill in fills]) if method == "newton" else []
    if large:
        enumerating, solving, storing = _mean(large, ("enumerating", "solving", "storing"), large)
        wall = _mean(large, ("seconds",), large)[0]
    else:
        (enumerating, solving, storing), wall = _RATES[method], 0.0
    alone = max(enumerating + solving + storing, wall)  # the disk or other programs may slow this machine
    return Need(words, round(BYTES * words), max(storing, alone / jobs) * words, alone * words)


def sweep_need(path: Path, a: float, periods: Sequence[int], jobs: int) -> Need:
    """Estimate what a sweep takes, at the rate of earlier large sweeps, if there are any.

    A sweep stores no rows, so it needs hardly any space.
    """
    stored = _at_every_a(path, read_sweeps)
    words = _missing(periods, {sweep.p: sweep.tally.words for sweep in stored.get(a, ())})
    sweeps = [sweep for of_a in stored.values() for sweep in of_a]
    large = _largest(sweeps, [sweep.tally.words for sweep in sweeps])
    rate = _mean(large, ("processor",), [sweep.tally for sweep in large])[0] if large else _SWEEPING
    return Need(words, 0, rate * words / jobs, rate * words)


def _missing(periods: Sequence[int], stored: Mapping[int, int]) -> int:
    """Return the number of words of the given periods that are not stored."""
    return sum(count_admissible(p) - stored.get(p, 0) for p in periods)


def _largest(done: Sequence[Record], words: Sequence[int]) -> list[Record]:
    """Return the largest fills or sweeps, each with its number of words."""
    least = max(ENOUGH, max(words, default=0) / _ALIKE)
    return [each for each, count in zip(done, words, strict=True) if count >= least]


def _mean(done: Sequence[Record], names: Sequence[str], counted: Sequence[Any]) -> list[float]:
    """Return seconds per word, averaged over fills or sweeps."""
    words = sum(each.words for each in counted)
    return [sum(getattr(each, name) for each in done) / words for name in names]


def _at_every_a(path: Path, read: Callable[[Connection, float], list[Record]]) -> dict[float, list[Record]]:
    """Return the fills or sweeps at each a; none if the file is not a catalogue with the latest schema."""
    if check_file(path) != SCHEMA_VERSION:
        return {}
    with reading(path) as moment:
        return {a: read(moment, a) for a in a_values(moment)}


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
