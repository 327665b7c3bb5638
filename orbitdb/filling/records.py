"""Compute and store averages over trajectories, quantum levels and entropy bounds."""

import math
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbitdb.answers.levels import ranges_not_stored, stored_levels
from orbitdb.averages.simulation import simulate as averages_of
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy_bounds.bounds import BALLS, DOUBLES, EntropyBounds, enclose, search
from orbitdb.entropy_bounds.verdicts import decide
from orbitdb.errors import InputError
from orbitdb.filling.workers import at_work
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.levels import LevelWindow, in_order, windows
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file import reading
from orbitdb.store.writing import Writer, add_reference, keep_bounds, keep_levels
from orbitdb.text import format_float, with_error
from orbitdb.trajectories.ensemble import Reference

if TYPE_CHECKING:
    from orbitdb.entropy_bounds.proof import Proof

_SECONDS_A_WINDOW = 0.6
"""Approximate time to find the levels of a window; it is longer at large k."""
_FEWEST, MOST_EDGES = 2, 40
_USUAL_WINDOW = 14
"""Default number of edges of the longest windows for entropy bounds."""
_SECONDS_OF_BOUNDS = 0.4
"""Approximate time to find entropy bounds at a single a with the default windows."""

Limits = tuple[int | None, float, float]
"""Limits that end a search for bounds: edges of the longest windows, width of the bounds, time in seconds."""


def simulate(stadium: Stadium, bounces: int, seed: int, legwise: bool, tell: Tell = nobody) -> Reference:
    """Average over random trajectories, bounce by bounce or leg by leg."""

    def show(done: float, so_far: Reference) -> None:
        tell(done, 1.0, f"lambda_d = {with_error(so_far.lambda_d, so_far.lambda_d_error)}")

    return averages_of(stadium, bounces, seed, progress=show, legwise=legwise)


def check_writable(path: Path) -> None:
    """Raise `StoreError` if a catalogue cannot be written, before work whose result it should keep."""
    with closing(Writer(path, {})) as writer:
        writer.try_to_write()


def keep_simulated(path: Path, averages: Reference) -> None:
    """Store averages over random trajectories."""
    parameters = {"command": "simulate", "a": averages.a, "bounces": averages.bounces, "seed": averages.seed}
    with closing(Writer(path, parameters)) as writer:
        add_reference(writer, averages)


def find_levels(
    path: Path | None,
    stadium: Stadium,
    low: float,
    high: float,
    parities: Sequence[Parity],
    jobs: int | None = None,
    tell: Tell = nobody,
) -> dict[Parity, list[LevelWindow]]:
    """Return the levels in a range of k by parity; take stored ones from a catalogue, and store new ones."""
    for parity in parities:
        list(windows(stadium, parity, low, high))  # raises for a bad range before anything is stored
    levels: dict[Parity, list[LevelWindow]] = {parity: [] for parity in parities}
    if path is not None:
        with reading(path) as connection:
            levels = {parity: stored_levels(connection, stadium.a, parity) for parity in parities}
    tasks = in_order(
        task
        for parity in parities
        for gap in ranges_not_stored(levels[parity], low, high)
        for task in windows(stadium, parity, *gap)
    )
    if not tasks:
        return levels
    parameters = {"command": "levels", "k": f"{low:g}:{high:g}", "a": stadium.a}
    with (
        nullcontext() if path is None else closing(Writer(path, parameters)) as writer,
        at_work(_SECONDS_A_WINDOW * len(tasks), jobs) as workers,
    ):
        tell(0, len(tasks), "levels")
        for done, solved in enumerate(workers.solved(task.solved for task in tasks), 1):
            if writer is not None:
                keep_levels(writer, solved)
            levels[solved.parity].append(solved)
            tell(done, len(tasks), f"levels {solved.parity} up to k = {solved.high:.4g}")
    return levels


def find_bounds(
    path: Path | None,
    values: Sequence[float],
    limits: Limits,
    proofs: "list[Proof] | None" = None,
    jobs: int | None = None,
    tell: Tell = nobody,
    asked: Mapping[str, Any] | None = None,
) -> Generator[EntropyBounds]:
    """Bound the topological entropy with longer and longer windows, and store the bounds.

    Parameters
    ----------
    path : Path or None
        The catalogue; None to store nothing.
    values : sequence of float
        Values of a; if there are several, they are divided among processes.
    limits : (int or None, float, float)
        See `Limits`.
    proofs : list of Proof, optional
        If given, ball arithmetic checks each decision, and the proofs are appended to the list.
    jobs, tell : optional
    asked : mapping, optional
        Parameters to store with the run.

    Yields
    ------
    EntropyBounds
        Bounds for each a and length of windows, in ascending order.
    """
    kind = DOUBLES if proofs is None else BALLS
    parameters = {"command": "bounds", **(asked or {})}
    with nullcontext() if path is None else closing(Writer(path, parameters)) as writer:
        for level, computed in _enclosed(values, limits, proofs, jobs, tell):
            if writer is not None:
                keep_bounds(writer, level, kind, computed)
            yield replace(level, proof=kind)


def _enclosed(
    values: Sequence[float], limits: Limits, proofs: "list[Proof] | None", jobs: int | None, tell: Tell
) -> Iterator[tuple[EntropyBounds, str | None]]:
    """Yield bounds, each time with the arithmetic that computed them, or None if this process did."""
    judges: list[Proof | None] = [None] * len(values)
    if proofs is not None:
        from orbitdb.entropy_bounds import proof  # loads flint, which double precision does not need

        judges = [proof.Proof() for _ in values]
    if len(values) == 1:
        if proofs is not None:
            proofs += filter(None, judges)
        judge = decide if judges[0] is None else judges[0].decide
        yield from ((level, None) for level in search(Stadium(values[0]), *limits, tell, judge))
        return
    seconds = _SECONDS_OF_BOUNDS * 1.8 ** ((limits[0] or _USUAL_WINDOW) - _USUAL_WINDOW)
    tasks = [partial(enclose, a, *limits, proof) for a, proof in zip(values, judges, strict=True)]
    with at_work(len(tasks) * seconds, jobs) as workers:
        for done, solved in enumerate(workers.solved(tasks), 1):
            if proofs is not None:
                proofs += filter(None, [solved.proof])
            yield from ((level, solved.arithmetic) for level in solved.levels)
            tell(done, len(tasks), f"a = {format_float(solved.levels[-1].a)}")


def limits_of(window: int | None, width: float | None, seconds: float | None) -> Limits:
    """Return the limits of a search for bounds, which stops at the first limit that it reaches.

    Raises `InputError` unless width and time are above 0, and the windows have 2 to 40 edges.
    """
    if window is not None and window not in range(_FEWEST, MOST_EDGES + 1):
        raise InputError(f"windows of {window} edges: give a whole number from {_FEWEST} to {MOST_EDGES}")
    for name, limit in (("width", width), ("time", seconds)):
        if limit is not None and not 0 < limit < math.inf:
            raise InputError(f"{name} {limit:g}: give a number above 0")
    most = int(window) if window else _USUAL_WINDOW if width is None and seconds is None else None
    return most, width or 0.0, seconds or math.inf
