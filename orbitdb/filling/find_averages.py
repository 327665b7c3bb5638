"""Find averages over random trajectories, and store them."""

from contextlib import closing
from pathlib import Path

from orbitdb.averages.simulation import simulate
from orbitdb.billiard.stadium import Stadium
from orbitdb.progress import Tell, nobody
from orbitdb.store.paths import FileId, check_same_file
from orbitdb.store.storing import keep_reference
from orbitdb.store.writer import Writer
from orbitdb.text import with_error
from orbitdb.trajectories.ensemble import Reference


def find_averages(stadium: Stadium, bounces: int, seed: int, legwise: bool, tell: Tell = nobody) -> Reference:
    """Average over random trajectories, bounce by bounce or leg by leg."""

    def show(done: float, so_far: Reference) -> None:
        tell(done, 1.0, f"lambda_d = {with_error(so_far.lambda_d, so_far.lambda_d_error)}")

    return simulate(stadium, bounces, seed, progress=show, legwise=legwise)


def keep_averages(path: Path, averages: Reference, file: FileId | None = None) -> None:
    """Store averages over random trajectories, if `file` is given only in this one."""
    parameters = {"command": "simulate", "a": averages.a, "bounces": averages.bounces, "seed": averages.seed}
    if file is not None:
        check_same_file(path, file, "was computing, so the averages were not stored")
    with closing(Writer(path, parameters)) as writer:
        keep_reference(writer, averages)
