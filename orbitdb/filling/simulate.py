"""Average over random trajectories, and store the averages."""

from contextlib import closing
from pathlib import Path

from orbitdb.averages.simulation import simulate as averages_of
from orbitdb.billiard.stadium import Stadium
from orbitdb.progress import Tell, nobody
from orbitdb.store.writing import Writer, add_reference
from orbitdb.text import with_error
from orbitdb.trajectories.ensemble import Reference


def simulate(stadium: Stadium, bounces: int, seed: int, legwise: bool, tell: Tell = nobody) -> Reference:
    """Average over random trajectories, bounce by bounce or leg by leg."""

    def show(done: float, so_far: Reference) -> None:
        tell(done, 1.0, f"lambda_d = {with_error(so_far.lambda_d, so_far.lambda_d_error)}")

    return averages_of(stadium, bounces, seed, progress=show, legwise=legwise)


def keep_simulated(path: Path, averages: Reference) -> None:
    """Store averages over random trajectories."""
    parameters = {"command": "simulate", "a": averages.a, "bounces": averages.bounces, "seed": averages.seed}
    with closing(Writer(path, parameters)) as writer:
        add_reference(writer, averages)
