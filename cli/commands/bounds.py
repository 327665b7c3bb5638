"""``orbitdb bounds``: proved bounds on the topological entropy."""

import os
from collections.abc import Sequence
from contextlib import closing
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.arguments import lengths
from orbitdb.cli.output import Output, note
from orbitdb.cli.progress import progress
from orbitdb.cli.storing import Jobs, bring

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.entropy.proof import Proof


EXAMPLES = (
    "bounds",
    "bounds --a 0.5 --width 0.01",
    "bounds --a 3 --time 30 --json",
    "bounds --window 12 --prove",
    "bounds --a 0.3:10:40 --window 12",
)
COLUMNS = ("a", "window", "lower", "upper", "windows", "undecided")
_WHY = "the time, the window length or the memory was not enough"


def bounds(
    *,
    context: typer.Context,
    a: Annotated[
        str,
        typer.Option(
            metavar="NUMBER|FROM:TO:COUNT",
            help="Half length of the straight walls, or a logarithmic grid of values.",
        ),
    ] = str(USUAL_A),
    window: Annotated[
        int | None,
        options.count_option(
            help="Number of edges of the longest windows [default: 14, or as many as needed].",
            least=2,
            most=40,
        ),
    ] = None,
    width: Annotated[
        float | None, options.number_option(help="Stop when the bounds differ by no more than this.")
    ] = None,
    seconds: Annotated[
        float | None, options.number_option("--time", help="Stop after about this many seconds.")
    ] = None,
    prove: Annotated[
        bool,
        typer.Option("--prove", help="Check every decision in ball arithmetic; use only proved ones."),
    ] = False,
    jobs: Jobs = None,
    store: Annotated[
        bool | None,
        typer.Option(help="Save the bounds in the catalogue [default: if there is one]."),
    ] = None,
    output: Output,
    db: options.Database,
) -> None:
    """Prove bounds on the topological entropy per bounce; no orbits are needed.

    A window is a stretch of a code that is decided for all its continuations at once. Each row is for one
    window length. windows is the number of windows examined so far, where mirror images and reversals count
    once, and undecided is the number of windows of this length that could not be decided. All numbers are
    rounded outward. The search ends as soon as it reaches --window, --width or --time. For a grid, you see
    the last row of each a, and --time applies to each a. If there is a catalogue, the bounds are saved in it,
    and 'orbitdb entropy' shows them.
    """
    from orbitdb.filling.records import find_bounds, limits_of

    values, limits = lengths(a), limits_of(window, width, seconds)
    if len(values) == 1:
        options.refuse_idle(context, "at a single a", "jobs")
    asked = {"a": a, "window": limits[0], "width": width, "time": seconds, "prove": prove}
    found: list[EntropyBounds] = []
    proofs: list[Proof] | None = [] if prove else None
    kept = _kept(db, store)
    try:
        with progress("windows") as shown:
            steps = find_bounds(kept, values, limits, proofs, jobs, shown, asked)
            with closing(steps):
                found.extend(steps)  # one by one, so that after Ctrl-C the earlier ones are still shown
    finally:
        last = list({level.a: level for level in found}.values())
        output.write(COLUMNS, map(attrgetter(*COLUMNS), found if len(values) == 1 else last))
        if proofs is not None:
            note(balls_of(proofs))
    if kept is None and store is None:
        note(_why_not_kept(db))
    apart = [level.width for level in last]
    if width is not None and max(apart) > width:
        where = (
            f" at {sum(each > width for each in apart)} of {len(apart)} values of a"
            if len(values) > 1
            else ""
        )
        note(f"the bounds are {max(apart):.1e} apart, more than {width:g}{where}: {_WHY}")
        raise typer.Exit(1)


def balls_of(proofs: "Sequence[Proof]") -> str:
    """Summarise how many of the windows decided in double precision are proved in ball arithmetic."""
    proved, left_open = (sum(getattr(each, name) for each in proofs) for name in ("proved", "left_open"))
    return (
        f"ball arithmetic proves {proved} of {proved + left_open} windows decided in double precision, "
        f"{left_open} left open; {sum(each.seconds for each in proofs):.1f} s"
    )


def _kept(db: Path, store: bool | None) -> Path | None:
    """Return the catalogue to save bounds in, made or updated with --store; None if none are saved."""
    from orbitdb.store.file import check_file
    from orbitdb.store.schema import SCHEMA_VERSION

    usable = check_file(db) == SCHEMA_VERSION and os.access(db, os.W_OK)
    if store is False or (store is None and not usable):
        return None
    bring(db)
    return db


def _why_not_kept(db: Path) -> str:
    from orbitdb.store.file import check_file
    from orbitdb.store.schema import SCHEMA_VERSION

    if (version := check_file(db)) is None:
        return f"not saved: there is no catalogue at {db}; --store creates one"
    if version == SCHEMA_VERSION:
        return f"not saved: {db} cannot be written"
    older = f"not saved: {db} has the older schema {version}"
    return f"{older}; --store, or 'orbitdb migrate', updates it"
