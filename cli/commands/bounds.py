"""``orbitdb bounds``: proved bounds on the topological entropy."""

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import note, progress
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import given_a, storable

if TYPE_CHECKING:
    from orbitdb.entropy_bounds.bounds import EntropyBounds


EXAMPLES = (
    "bounds",
    "bounds --a 0.5 --width 0.01",
    "bounds --a 3 --seconds 30 --json",
    "bounds --edges 12 --prove",
    "bounds --a 0.5 --a 1 --edges 12",
    "bounds --a 0.3:10:40 --edges 12",
)
COLUMNS = ("a", "edges", "lower", "upper", "estimate", "windows", "undecided", "arithmetic")
_WHY = "the time, the window length or the memory was not enough"


def bounds(
    *,
    context: typer.Context,
    a: options.HalfLengths = None,
    edges: Annotated[
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
        float | None, options.number_option(help="Stop after about this many seconds.")
    ] = None,
    prove: Annotated[
        bool, typer.Option("--prove", help="Check every decision in ball arithmetic; use only proved ones.")
    ] = False,
    jobs: options.Jobs = None,
    store: options.Store = None,
    output: Output,
    db: options.Database,
) -> None:
    """Prove bounds on the topological entropy per bounce; no orbits are needed.

    A window is a piece of a path, whatever the path does before and after. Its length is counted in edges,
    from one bounce to the next. Each row is for one window length. windows is the number of windows examined
    so far, where mirror images and reversals count once, and undecided is the number of windows of this
    length that could not be decided. Bounds are rounded outward. estimate is the middle of the bounds: it is
    the best value of the entropy, but not proved. The search ends as soon as it reaches
    --edges, --width or --seconds. For several a, you see the last row of each a, and --seconds applies to
    each a.
    The bounds are saved in the catalogue, and 'orbitdb entropy' shows them.
    """
    from orbitdb.catalogue import Catalogue

    values = given_a(db, a)
    if len(values) == 1:
        options.refuse_idle(context, "at a single a", "jobs")
    catalogue = Catalogue(db, missing_ok=True)
    search = partial(
        catalogue.search_bounds, edges, width=width, seconds=seconds, prove=prove, jobs=jobs, a=values
    )
    search(store=False)  # wrong limits must leave no file
    last = _show(partial(search, store=storable(catalogue, store)), len(values) > 1, output)
    if width is not None and (wide := [level.width for level in last if level.width > width]):
        where = f" at {len(wide)} of {len(last)} values of a" if len(values) > 1 else ""
        note(f"the bounds are {max(wide):.1e} apart, more than {width:g}{where}: {_WHY}")
        raise typer.Exit(1)


def _show(
    search: "Callable[..., Generator[EntropyBounds]]",
    many: bool,
    output: Output,
) -> "list[EntropyBounds]":
    """Search, and write the bounds at a single a, or the last ones at each of many; return the last ones."""
    levels: list[EntropyBounds] = []
    try:
        with progress("windows") as shown, closing(search(progress=shown)) as steps:
            levels.extend(steps)  # one by one, so that after Ctrl-C the earlier ones are still shown
    finally:
        last = list({level.a: level for level in levels}.values())
        names = COLUMNS[:-1] if output.table else COLUMNS  # in a table, a note says how they are proved
        output.write(names, map(attrgetter(*names), last if many else levels))
        if last and last[-1].proved + last[-1].left_open:
            note(balls_of(last))
    return last


def balls_of(last: "Sequence[EntropyBounds]") -> str:
    """Summarise how many of the windows decided in double precision are proved in ball arithmetic."""
    proved, left_open = (sum(getattr(bounds, name) for bounds in last) for name in ("proved", "left_open"))
    return (
        f"ball arithmetic proves {proved} of {proved + left_open} windows decided in double precision, "
        f"{left_open} left open"
    )
