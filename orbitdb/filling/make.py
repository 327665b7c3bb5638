"""Fills, sweeps and births for `Catalogue` and the commands.

Each reports its progress, and resumes if it was interrupted.
"""

from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from pathlib import Path

from orbitdb.errors import InputError
from orbitdb.filling.births import fill_births
from orbitdb.filling.estimate import check_room, need, sweep_need
from orbitdb.filling.fill import METHODS, fill_geometric, fill_periods
from orbitdb.filling.resuming import Step
from orbitdb.filling.workers import Workers, at_work, cores
from orbitdb.progress import Tell, nobody
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import reading
from orbitdb.symbols.pruning import count_admissible, count_primitive

_BIRTHS_A_SECOND = 40_000
"""Approximate number of words whose births are found in a second."""


def watched(steps: Generator[Step], what: str, totals: Mapping[int, int], tell: Tell, known: int = 0) -> None:
    """Run a fill and report progress over all its periods; `known` words were stored before."""
    total = sum(totals.values())
    with closing(steps):
        tell(known, total, what)
        for step in steps:
            before = sum(count for p, count in totals.items() if p < step.p)
            tell(before + step.words, total, f"{what}, p = {step.p:>2} of {max(totals)}")


def fill(
    path: Path,
    a: float,
    periods: Sequence[int],
    jobs: int | None = None,
    workers: Workers | None = None,
    geometric: bool = False,
    method: str = "newton",
    tell: Tell = nobody,
) -> None:
    """Fill periods at one a, if asked with their geometrically pruned words.

    Raises
    ------
    InputError
        If the method cannot be used.
    StoreError
        If the disk has too little room, or the file cannot be written.
    """
    if method not in METHODS:
        raise InputError(f"method {method!r}: use {' or '.join(METHODS)}")
    coming = need(path, a, periods, workers.jobs if workers else jobs or cores(), method)
    check_room(path, coming)
    with at_work(coming.alone, jobs, workers) as solving:
        words = {p: count_admissible(p) for p in periods}
        steps = fill_periods(path, a, periods, method, solving)
        watched(steps, "words", words, tell, sum(words.values()) - coming.words)
        if geometric:
            words = {p: count_primitive(p) for p in periods}
            watched(fill_geometric(path, periods), "pruned words", words, tell)


def sweep(
    path: Path,
    chosen: Selection,
    periods: Sequence[int],
    jobs: int | None = None,
    workers: Workers | None = None,
    tell: Tell = nobody,
) -> None:
    """Sweep periods, and sum over chosen orbits at the a of the selection."""
    from orbitdb.filling.sweeps import sweep_periods  # imports the averages, which a fill does not need

    coming = sweep_need(path, chosen.a, periods, workers.jobs if workers else jobs or cores(), chosen)
    with at_work(coming.alone, jobs, workers) as solving:
        words = {p: count_admissible(p) for p in periods}
        steps = sweep_periods(path, chosen.a, periods, solving, chosen)
        watched(steps, "words", words, tell, sum(words.values()) - coming.words)


def births(path: Path, periods: Sequence[int], jobs: int | None = None, tell: Tell = nobody) -> None:
    """Find the births and deaths of all classes of some periods."""
    totals = {p: count_admissible(p) for p in periods}
    with reading(path) as moment:
        known = sum(each.words for each in moment.birth_fills() if each.p in totals)
    with at_work((sum(totals.values()) - known) / _BIRTHS_A_SECOND, jobs) as workers:
        watched(fill_births(path, periods, workers), "births", totals, tell, known)
