"""``orbitdb simulate``: the trajectory reference."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.progress.line import progress
from orbitdb.cli.render import note, write, write_facts
from orbitdb.cli.storing import bring
from orbitdb.errors import InputError
from orbitdb.numerals import with_error

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
_NEAR = 0.05


def simulate(
    a: options.HalfLength = 1.6,
    bounces: Annotated[
        int, options.count_option("--bounces", help="Bounces in all, such as 1e8.")
    ] = 20_000_000,
    seed: Annotated[int, options.count_option("--seed", help="The same seed gives the same result.")] = 0,
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
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.file.database import default_path
    from orbitdb.trajectories import ensemble

    if not 1 <= bounces <= _MOST:
        raise InputError(f"bounces {bounces}: give 1 to {_MOST:g}")
    if seed < 0:
        raise InputError(f"seed {seed}: give 0 or more")
    stadium = Stadium(a)
    if store:
        bring(db or default_path())
        Catalogue(db)  # what is wrong with the catalogue is to be known before
        _need_to_write(db or default_path())
    with progress("trajectories") as shown:

        def show(done: float, found: "Reference") -> None:
            so_far = with_error(found.lambda_d, found.lambda_d_error)
            shown.tell(f"lambda_d = {so_far}", done, 1.0, counted=False)

        if legwise:
            found = _simulate_legs(stadium, bounces, seed, show)
        else:
            found = ensemble.simulate(stadium, bounces, seed, progress=show)
    values = {"a": a, **asdict(found)}
    try:
        if store:
            _store(a, found, db or default_path())
    finally:
        form = options.chosen(format_, json)
        if form is Format.TABLE:
            write_facts(_facts(a, found))
        else:
            write(COLUMNS, [[values[name] for name in COLUMNS]], form)
    off = (found.mean_free_path - stadium.mean_free_path) / found.mean_free_path_error
    note(
        f"pi Area / Perimeter = {stadium.mean_free_path:.6f}: "
        f"the mean free path is {abs(off):.1f} errors {'above' if off > 0 else 'below'} it"
    )
    if abs(found.bounces - bounces) > _NEAR * bounces:
        note(f"{found.bounces} bounces were made, not {bounces}: errors need many whole trajectories")


def _facts(a: float, found: "Reference") -> list[tuple[str, str]]:
    """Return the result in words."""
    return [
        ("a", f"{a:g}"),
        ("lambda_d", with_error(found.lambda_d, found.lambda_d_error)),
        ("lambda_c", with_error(found.lambda_c, found.lambda_c_error)),
        ("mean free path", with_error(found.mean_free_path, found.mean_free_path_error)),
        ("bounces", str(found.bounces)),
        ("seed", str(found.seed)),
    ]


def _simulate_legs(
    stadium: "Stadium", bounces: int, seed: int, show: "Callable[[float, Reference], None] | None"
) -> "Reference":
    from orbitdb.averages.exact_means import exact_means
    from orbitdb.trajectories.legwise import simulate_legs

    growth = exact_means(stadium.a).growth
    return simulate_legs(stadium, bounces, (growth.value, growth.error), seed, show)


def _need_to_write(path: Path) -> None:
    """Refuse a catalogue that nothing can be stored in, without a change of it."""
    from orbitdb.store.writing.writer import Writer

    writer = Writer(path, {})
    try:
        writer.try_to_write()
    finally:
        writer.close()


def _store(a: float, found: "Reference", path: Path) -> None:
    from orbitdb.store.writing.records import add_reference
    from orbitdb.store.writing.writer import Writer

    parameters = {"command": "simulate", "a": a, "bounces": found.bounces, "seed": found.seed}
    writer = Writer(path, parameters)
    try:
        add_reference(writer, a, found)
    finally:
        writer.close()
