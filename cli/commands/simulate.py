"""``orbitdb simulate``: averages over random trajectories."""

from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note, write_facts
from orbitdb.cli.storing import bring
from orbitdb.numerals import exact, with_error

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference

EXAMPLES = ("simulate", "simulate --a 1 --bounces 100000000 --seed 7 --json", "simulate --legwise")
COLUMNS = (
    "a", "lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error", "mean_free_path", "mean_free_path_error",
    "bounces", "seed",
)  # fmt: skip
_NEAR = 0.05


def simulate(
    *,
    a: options.HalfLength = USUAL_A,
    wanted: Annotated[
        int,
        options.count_option("--bounces", least=1, most=10**12, help="Total number of bounces, such as 1e8."),
    ] = 20_000_000,
    seed: Annotated[
        int, options.count_option(least=0, help="Random seed; the same seed gives the same result.")
    ] = 0,
    legwise: Annotated[
        bool,
        typer.Option("--legwise", help="Sample leg by leg and use exact means, for much smaller errors."),
    ] = False,
    store: Annotated[bool, typer.Option(help="Save the result in the catalogue.")] = True,
    output: Output,
    db: options.Database,
) -> None:
    """Average over random trajectories: Lyapunov exponents and mean free path, with standard errors.

    The result is stored, and 'orbitdb lyapunov' shows it beside the averages over orbits. With --legwise,
    only the small part of lambda whose mean is not known exactly is sampled.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.filling.records import check_writable, keep_simulated
    from orbitdb.filling.records import simulate as follow

    stadium = Stadium(a)
    if store:
        bring(db)
        check_writable(db)
    with progress("trajectories") as shown:
        found = follow(stadium, wanted, seed, legwise, shown)
    try:
        if store:
            keep_simulated(db, a, found)
    finally:
        if output.table:
            write_facts(_facts(a, found))
        else:
            values = {"a": a, **found.row()}
            output.write(COLUMNS, [[values[name] for name in COLUMNS]])
    off = (found.mean_free_path - stadium.mean_free_path) / found.mean_free_path_error
    note(
        f"the mean free path is {abs(off):.1f} standard errors {'above' if off > 0 else 'below'} "
        f"pi Area / Perimeter = {stadium.mean_free_path:.6f}"
    )
    if abs(found.bounces - wanted) > _NEAR * wanted:
        note(f"{found.bounces} bounces were followed, not {wanted}: errors need many complete trajectories")


def _facts(a: float, found: "Reference") -> list[tuple[str, str]]:
    """Return the result as pairs of a name and a text."""
    return [
        ("a", f"{exact(a)}"),
        ("lambda_d", with_error(found.lambda_d, found.lambda_d_error)),
        ("lambda_c", with_error(found.lambda_c, found.lambda_c_error)),
        ("mean free path", with_error(found.mean_free_path, found.mean_free_path_error)),
        ("bounces", str(found.bounces)),
        ("seed", str(found.seed)),
    ]
