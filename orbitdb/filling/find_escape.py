"""Find what escapes from open stadiums, in several processes, and store it."""

from contextlib import closing
from pathlib import Path

from orbitdb.filling.workers import at_work
from orbitdb.open_stadium.escape import Escape
from orbitdb.open_stadium.question import Question
from orbitdb.open_stadium.rates import EscapeRates, escape_rates
from orbitdb.progress import Tell, nobody
from orbitdb.store.paths import FileId, check_same_file
from orbitdb.store.storing import keep_escape
from orbitdb.store.writer import Writer

_SECONDS = 2e-7
"""Approximate time to follow a trajectory for one bounce."""


def find_escape(
    asked: Question, known: EscapeRates | None = None, jobs: int | None = 1, tell: Tell = nobody
) -> Escape:
    """Answer a question about an open stadium, whose rates may be known.

    The number of processes does not change the answer.
    """
    with at_work(asked.trajectories * asked.expected * _SECONDS, jobs) as workers:
        sampled = asked.sampled(workers.solved(asked.tasks()), tell)
    return asked.answer(sampled, known or escape_rates(asked.opened, asked.left, tell))


def keep_found(path: Path, found: Escape, file: FileId | None = None) -> None:
    """Store what escapes from an open stadium, if `file` is given only in this one."""
    parameters = {
        "command": "escape",
        "a": found.a,
        "opening": [*map(str, found.opening)],
        "without": found.without,
        "trajectories": found.trajectories,
        "bounces": found.bounces,
        "seed": found.seed,
    }
    if file is not None:
        check_same_file(path, file, "was computing, so the result was not stored")
    with closing(Writer(path, parameters)) as writer:
        keep_escape(writer, found)
