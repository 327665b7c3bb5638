"""Find quantum levels, and store them."""

from collections.abc import Sequence
from contextlib import closing, nullcontext
from pathlib import Path

from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.workers import at_work
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.exact_levels import LevelWindow, in_order, ranges_not_stored, windows
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file import reading
from orbitdb.store.stored_values import stored_levels
from orbitdb.store.storing import keep_levels
from orbitdb.store.writer import Writer

_SECONDS_A_WINDOW = 0.6
"""Approximate time to find the levels of a window; it is longer at large k."""


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
