"""``orbitdb bounds``: proved bounds on the topological entropy."""

from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.grids import GivenValues, named
from orbitdb.cli.output import Output, note, progress
from orbitdb.cli.snapshots import bring
from orbitdb.errors import StoreError

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.entropy_bounds.bounds import EntropyBounds
    from orbitdb.entropy_bounds.proof import Proof


EXAMPLES = (
    "bounds",
    "bounds --a 0.5 --width 0.01",
    "bounds --a 3 --time 30 --json",
    "bounds --window 12 --prove",
    "bounds --a 0.5 --a 1 --window 12",
    "bounds --a 0.3:10:40 --window 12",
)
COLUMNS = ("a", "window", "lower", "upper", "estimate", "windows", "undecided", "proof")
_WHY = "the time, the window length or the memory was not enough"


def bounds(
    *,
    context: typer.Context,
    asked: Annotated[
        list[GivenValues] | None,
        typer.Option(
            "--a",
            "-a",
            metavar="NUMBER|FROM:TO:COUNT",
            parser=options.read_half_lengths,
            help=f"Half length of the straight walls, or a logarithmic grid of values; repeatable "
            f"[default: {USUAL_A}].",
        ),
    ] = None,
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
        bool, typer.Option("--prove", help="Check every decision in ball arithmetic; use only proved ones.")
    ] = False,
    jobs: options.Jobs = None,
    store: Annotated[
        bool | None, typer.Option(help="Save the bounds in the catalogue [default: if there is one].")
    ] = None,
    output: Output,
    db: options.Database,
) -> None:
    """Prove bounds on the topological entropy per bounce; no orbits are needed.

    A window is a piece of a path, whatever the path does before and after. Its length is counted in edges,
    from one bounce to the next. Each row is for one window length. windows is the number of windows examined
    so far, where mirror images and reversals count once, and undecided is the number of windows of this
    length that could not be decided. Bounds are rounded outward. estimate is the middle of the bounds: it is
    the best value of the entropy, but not proved. The search ends as soon as it reaches
    --window, --width or --time. For several a, you see the last row of each a, and --time applies to each a.
    If there is a catalogue, the bounds are saved in it, and 'orbitdb entropy' shows them.
    """
    from orbitdb.catalogue import Catalogue

    a = named(asked) or (USUAL_A,)
    if len(a) == 1:
        options.refuse_idle(context, "at a single a", "jobs")
    proofs: list[Proof] | None = [] if prove else None
    catalogue = Catalogue(db, missing_ok=True)
    search = partial(
        catalogue.search_bounds, window, width=width, seconds=seconds, proofs=proofs, jobs=jobs, a=a
    )
    search(store=False)  # wrong limits must leave no file
    why_not = _why_not_kept(catalogue, db, store)
    last = _show(partial(search, store=why_not is None), len(a) > 1, proofs, output)
    if why_not:
        note(f"not saved: {why_not}")
    if width is not None and (wide := [level.width for level in last if level.width > width]):
        where = f" at {len(wide)} of {len(last)} values of a" if len(a) > 1 else ""
        note(f"the bounds are {max(wide):.1e} apart, more than {width:g}{where}: {_WHY}")
        raise typer.Exit(1)


def _show(
    search: "Callable[..., Generator[EntropyBounds]]",
    many: bool,
    proofs: "list[Proof] | None",
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
        if proofs is not None:
            note(balls_of(proofs))
    return last


def balls_of(proofs: "Sequence[Proof]") -> str:
    """Summarise how many of the windows decided in double precision are proved in ball arithmetic."""
    proved, left_open = (sum(getattr(proof, name) for proof in proofs) for name in ("proved", "left_open"))
    return (
        f"ball arithmetic proves {proved} of {proved + left_open} windows decided in double precision, "
        f"{left_open} left open; {sum(proof.seconds for proof in proofs):.1f} s"
    )


def _why_not_kept(catalogue: "Catalogue", db: Path, store: bool | None) -> str | None:
    """Make or update the catalogue if bounds are to be saved in it; otherwise, return the reason, or ''."""
    if store is False:
        return ""
    if store is None and catalogue.missing:
        return f"there is no catalogue at {db}; --store creates one"
    try:
        bring(db)
        catalogue.check_writable()
    except StoreError as error:
        if store:
            raise
        return str(error)
    return None
