"""``orbitdb simulate``: the trajectory reference."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.commands.info import bring
from orbitdb.cli.options import Format
from orbitdb.cli.render import note, write
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.trajectories.ensemble import Reference

EXAMPLES = """
Examples:

  orbitdb simulate

  orbitdb simulate --a 1 --bounces 100000000 --seed 7 --json

  orbitdb simulate --legwise
"""
COLUMNS = (
    "a", "lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error", "mean_free_path", "mean_free_path_error",
    "bounces", "seed",
)  # fmt: skip
_MOST = 10**12


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(simulate)


def simulate(
    a: options.HalfLength = 1.6,
    bounces: Annotated[int, typer.Option("--bounces", help="Bounces in all.")] = 20_000_000,
    seed: Annotated[int, typer.Option("--seed", help="The same seed gives the same result.")] = 0,
    legwise: Annotated[
        bool, typer.Option("--legwise", help="Leg by leg, with exact means: far smaller errors.")
    ] = False,
    store: Annotated[bool, typer.Option(help="Keep the result in the catalogue.")] = True,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Average over random trajectories: Lyapunov exponents and mean free path, with standard errors.

    The result is stored, and shown beside averages over orbits from then on. With --legwise only the
    small part of lambda is sampled whose exact mean is not known.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.store.file.database import default_path
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.trajectories import ensemble

    if not 1 <= bounces <= _MOST:
        raise InputError(f"bounces {bounces}: give 1 to {_MOST:g}")
    if seed < 0:
        raise InputError(f"seed {seed}: give 0 or more")
    stadium = Stadium(a)
    if store:
        bring(db or default_path())
        Catalogue(db)  # what is wrong with the catalogue is to be known before
    with _progress() as show:
        if legwise:
            found = _simulate_legs(stadium, bounces, seed, show)
        else:
            found = ensemble.simulate(stadium, bounces, seed, progress=show)
    values = {"a": a, **asdict(found)}
    try:
        if store:
            _store(a, found, db or default_path())
    finally:
        write(COLUMNS, [[values[name] for name in COLUMNS]], options.chosen(format_, json))
    note(f"mean free path by the invariant measure: {stadium.mean_free_path:.6f}")


def _simulate_legs(
    stadium: "Stadium", bounces: int, seed: int, show: "Callable[[float, Reference], None] | None"
) -> "Reference":
    from orbitdb.averages.exact_means import exact_means
    from orbitdb.trajectories.legwise import simulate_legs

    growth = exact_means(stadium.a).growth
    return simulate_legs(stadium, bounces, (growth.value, growth.error), seed, show)


def _store(a: float, found: "Reference", path: Path) -> None:
    from orbitdb.store.writing.references import add_reference
    from orbitdb.store.writing.writer import Writer

    parameters = {"command": "simulate", "a": a, "bounces": found.bounces, "seed": found.seed}
    writer = Writer(path, parameters)
    try:
        add_reference(writer, a, found)
    finally:
        writer.close()


@contextmanager
def _progress() -> "Iterator[Callable[[float, Reference], None] | None]":
    """Show how far the work is and what is known so far, if somebody watches."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich import progress as rich
    from rich.console import Console

    columns = (
        rich.BarColumn(),
        rich.TaskProgressColumn(),
        rich.TextColumn("{task.description}"),
        rich.TimeRemainingColumn(),
    )
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=1.0)

        def show(done: float, found: "Reference") -> None:
            said = f"lambda_d = {found.lambda_d:.5f} +- {found.lambda_d_error:.5f}"
            bar.update(task, completed=done, description=said)

        yield show
