"""Find quantum levels, and store them."""

import logging
import math
from collections.abc import Sequence
from contextlib import closing, nullcontext
from pathlib import Path

from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.estimate import about
from orbitdb.filling.workers import at_work
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.exact_levels import LevelTask, LevelWindow, in_order, level_tasks, ranges_not_stored
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file import reading
from orbitdb.store.stored_values import stored_levels
from orbitdb.store.storing import keep_levels
from orbitdb.store.writer import Writer

_SECONDS_A_WINDOW = 0.6
"""Approximate time to find the levels of a window at small k."""
_SECONDS_AN_AREA = 2.7e-4
"""The same time at large k, divided by k^2 and the area of the quarter stadium."""

_LONG, _HIGH = 60.0, 200.0
"""Levels that may take this long, in seconds, or lie above this k say first how long they take."""


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
        list(level_tasks(stadium, parity, low, high))  # raises for a bad range before anything is stored
    levels: dict[Parity, list[LevelWindow]] = {parity: [] for parity in parities}
    if path is not None:
        with reading(path) as connection:
            levels = {parity: stored_levels(connection, stadium.a, parity) for parity in parities}
    tasks = in_order(
        task
        for parity in parities
        for gap in ranges_not_stored(levels[parity], low, high)
        for task in level_tasks(stadium, parity, *gap)
    )
    if not tasks:
        return levels
    takes = sum(map(_seconds, tasks))
    if takes >= _LONG or high > _HIGH:
        logging.getLogger("orbitdb").warning(
            "levels up to k = %g take %s of processor time", high, about(takes)
        )
    parameters = {"command": "levels", "k": f"{low:g}:{high:g}", "a": stadium.a}
    with (
        nullcontext() if path is None else closing(Writer(path, parameters)) as writer,
        at_work(takes, jobs) as workers,
    ):
        tell(0, len(tasks), "levels")
        for done, solved in enumerate(workers.solved(task.solved for task in tasks), 1):
            if writer is not None:
                keep_levels(writer, solved)
            levels[solved.parity].append(solved)
            tell(done, len(tasks), f"levels {solved.parity} up to k = {solved.high:.4g}")
    return levels


def _seconds(task: LevelTask) -> float:
    """Estimate the processor time to find the levels of a window."""
    return max(_SECONDS_A_WINDOW, _SECONDS_AN_AREA * (task.a + math.pi / 4) * task.high**2)
