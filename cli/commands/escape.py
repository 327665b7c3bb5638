"""``orbitdb escape``: open the stadium, and see what escapes."""

from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import notes, progress
from orbitdb.cli.output import Output, write_facts
from orbitdb.cli.snapshots import given_a, storable
from orbitdb.text import concise, format_float

if TYPE_CHECKING:
    from orbitdb.open_stadium.escape import Escape

EXAMPLES = (
    "escape --opening top:-0.3:0.3",
    "escape --opening top:-0.3:0.3 --by time --bounces 500",
    "escape --a 1 --opening left:0: --opening bottom:-0.5:0 --rates --json",
    "escape --without 0202 --trajectories 1e5 --no-store",
)


def escape(
    *,
    context: typer.Context,
    a: options.HalfLength = None,
    opening: options.Openings = None,
    without: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SYMBOLS",
            help="A pattern of symbols; a trajectory escapes when it completes it; repeatable.",
        ),
    ] = None,
    trajectories: Annotated[
        int, options.count_option(help="Number of random trajectories, such as 1e5.", least=1, most=10**9)
    ] = 1_000_000,
    bounces: Annotated[
        int,
        options.count_option(help="Number of bounces, and time, up to which to go.", least=1, most=10**7),
    ] = 2000,
    by: Annotated[
        Literal["bounce", "time", "leg"], typer.Option(help="What survival is counted by.")
    ] = "bounce",
    rates: Annotated[
        bool, typer.Option("--rates", help="Instead, show the constants of the tails and the escape rates.")
    ] = False,
    seed: Annotated[
        int, options.count_option(least=0, help="Random seed; the same seed gives the same result.")
    ] = 0,
    jobs: options.Jobs = None,
    store: options.Store = None,
    output: Output,
    db: options.Database,
) -> None:
    """Open the stadium, and find how fast random trajectories escape; no orbits are needed.

    A trajectory escapes at a bounce in an opening, or when it completes a pattern. survival is the share that
    is left: after n bounces, starting from the invariant measure of the bounces; after a time t, in radius /
    speed, starting from the Liouville measure; or after a number of legs, crossings from one semicircle to
    the other. tail is the limit for large n or t: c1/n + c2/n^2, or d1/t.

    With --rates, measure is the open share of the perimeter. The rates per leg, time and bounce come from a
    transfer matrix; a rate that is not defined is empty, and a note says why. n_tail and t_tail are where the
    tail overtakes the exponential.
    """
    from orbitdb.catalogue import Catalogue
    from orbitdb.open_stadium.question import Question

    if rates:
        options.refuse_idle(context, "with --rates", "trajectories", "bounces", "by", "seed", "jobs")
        trajectories = 0
    (at,) = given_a(db, a)
    Question.of(at, opening or (), without or (), trajectories, bounces, seed)  # raises before a file is made
    catalogue = Catalogue(db, at, missing_ok=True)
    keeps = storable(catalogue, store)
    file = catalogue.check_writable() if keeps else None
    with progress("trajectories") as shown:
        found = catalogue.escape(
            opening or (), without or (), trajectories=trajectories, bounces=bounces, seed=seed, jobs=jobs,
            store=False, progress=shown,
        )  # fmt: skip
    try:
        if keeps:
            catalogue.keep(found, file)
    finally:
        _show(found, by, rates, output)
    notes(found.notes)


def _show(found: "Escape", by: str, rates: bool, output: Output) -> None:
    """Write the rows of a result, or its rates; in a table, these are facts with their errors in brackets."""
    if not rates:
        columns = found.columns(by)
        output.write([*columns], [*zip(*columns.values(), strict=True)])
    elif output.table:
        write_facts([("a", format_float(found.a)), *_facts(found.rates())])
    else:
        output.write([*found.rates()], [[*found.rates().values()]])


def _facts(values: dict[str, float | None]) -> "list[tuple[str, str]]":
    """Return the rates as pairs of a name and a text."""
    texts = {
        name: concise(value, values[f"{name}_error"]) if f"{name}_error" in values else f"{value:.6g}"
        for name, value in values.items()
        if value is not None and not name.endswith("_error")
    }
    return [(name, text or "") for name, text in texts.items()]
