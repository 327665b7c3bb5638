"""Estimate the disk space and time that a fill or sweep takes, and check the free space."""

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

from orbitdb.errors import StoreError
from orbitdb.store.file.database import check_file
from orbitdb.store.file.schema import SCHEMA_VERSION
from orbitdb.store.reading.fills import Fill, Sweep
from orbitdb.store.reading.moment import Moment, reading
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

ENOUGH = 50_000
"""Earlier fills and sweeps of at least this many words supply the rates instead."""

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
    known = _at_every_a(path, Moment.fills)
    stored = {f.p: f.words for f in known.get(a, ())}
    words = sum(count_admissible(p) - stored.get(p, 0) for p in periods)
    fills = [] if method != "newton" else [f for found in known.values() for f in found]
    enumerating, solving, storing = _rates(fills) or _RATES[method]
    solvers, writer = (enumerating + solving) * words, storing * words
    alone = solvers + writer
    return Need(words, round(BYTES * words), max(writer, alone / jobs), alone)


def sweep_need(path: Path, a: float, periods: Sequence[int], jobs: int) -> Need:
    """Estimate what a sweep takes, at the rate of earlier large sweeps, if there are any.

    A sweep stores no rows, so it needs hardly any space.
    """
    known = _at_every_a(path, Moment.sweeps)
    here = {each.p: each.tally.words for each in known.get(a, ())}
    words = sum(count_admissible(p) - here.get(p, 0) for p in periods)
    large = [each for found in known.values() for each in found if each.tally.words >= ENOUGH]
    swept = sum(each.tally.words for each in large)
    rate = sum(each.processor for each in large) / swept if swept else _SWEEPING
    return Need(words, 0, rate * words / jobs, rate * words)


def _at_every_a(path: Path, ask: Callable[[Moment, float], list[Record]]) -> dict[float, list[Record]]:
    """Return the fills or sweeps at each a; none if the file is not a catalogue with the latest schema."""
    if check_file(path) != SCHEMA_VERSION:
        return {}
    with reading(path) as moment:
        return {a: ask(moment, a) for a in moment.a_values()}


def _rates(fills: Sequence[Fill]) -> tuple[float, ...]:
    """Return seconds per word for enumerating, solving and storing in large fills; () if there are none."""
    large = [f for f in fills if f.words >= ENOUGH and f.storing and f.enumerating]
    if not large:
        return ()
    words, *seconds = map(
        sum, zip(*((f.words, f.enumerating, f.solving, f.storing) for f in large), strict=True)
    )
    return tuple(each / words for each in seconds)


def check_room(path: Path, needed: Need) -> None:
    """Raise `StoreError` if the disk has less free space than a fill needs."""
    folder = next(parent for parent in path.resolve().parents if parent.exists())
    free = shutil.disk_usage(folder).free
    room = needed.bytes + min(needed.bytes, _JOURNAL)
    if room > free:
        raise StoreError(
            f"no room for {path}: {needed.words} words and their journal take about {gigabytes(room)}, "
            f"but only {gigabytes(free)} is free: make room, or name a file on another disk"
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


def gigabytes(count: float) -> str:
    """Format a number of bytes in a suitable unit."""
    if count >= 1e11:
        return f"{count / 1e9:.0f} GB"
    for unit, size in (("GB", 1e9), ("MB", 1e6)):
        if count >= size:
            return f"{count / size:.2g} {unit}" if count < 99.5 * size else f"{count / size:.0f} {unit}"
    return f"{max(count / 1e3, 1):.0f} kB"
