"""``orbitdb bounds``: proved bounds on the topological entropy."""

import math
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import lengths
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note
from orbitdb.cli.storing import Jobs, Solvers, bring
from orbitdb.errors import InputError
from orbitdb.numerals import exact

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.entropy.proof import Proof

    Keep = Callable[[EntropyBounds, str | None], object]
    Limits = tuple[int | None, float, float]
    Solving = Generator[tuple[EntropyBounds, str | None]]

EXAMPLES = (
    "bounds",
    "bounds --a 0.5 --width 0.01",
    "bounds --a 3 --time 30 --json",
    "bounds --window 12 --prove",
    "bounds --a 0.3:10:40 --window 12",
)
COLUMNS = ("a", "window", "lower", "upper", "windows", "undecided")
_USUAL_WINDOW = 14
_SECONDS = 0.4
"""In which the entropy is enclosed at one a with the usual windows, about."""
_WHY = "the time, the length of windows or the memory was not enough"


def bounds(
    *,
    context: typer.Context,
    a: Annotated[
        str,
        typer.Option(
            metavar="NUMBER|FROM:TO:COUNT",
            help="Half length of a straight wall, or a logarithmic grid of them.",
        ),
    ] = str(options.USUAL_A),
    window: Annotated[
        int | None,
        options.count_option(
            help="Edges of the longest windows [default: 14, or as many as needed].", least=2, most=40
        ),
    ] = None,
    width: Annotated[float | None, options.number_option(help="Stop when the bounds are this close.")] = None,
    seconds: Annotated[
        float | None, options.number_option("--time", help="Stop after about this many seconds.")
    ] = None,
    prove: Annotated[
        bool,
        typer.Option("--prove", help="Check every decision in ball arithmetic, and use only what it proves."),
    ] = False,
    jobs: Jobs = None,
    store: Annotated[
        bool | None,
        typer.Option(help="Keep the bounds in the catalogue [default: if there is one]."),
    ] = None,
    output: Output,
    db: options.Database,
) -> None:
    """Prove bounds on the topological entropy per bounce; no orbits are needed.

    Windows are stretches of a code that are decided for all their continuations at once. Each row has one
    length of windows: their number so far (mirror images and reversals count once), and how many of this
    length are undecided. All numbers are rounded outward. The first of --window, --width and --time that is
    reached ends the search. For a grid, you see the last row of each a, and --time applies to each a. If
    there is a catalogue, it keeps the bounds, and 'orbitdb entropy' shows them.
    """
    for name, limit in (("--width", width), ("--time", seconds)):
        if limit is not None and not 0 < limit < math.inf:
            raise InputError(f"{name} {limit:g}: give a number above 0")
    values = lengths(a)
    if len(values) == 1:
        options.refuse_idle(context, "at one a", "jobs")
    most = window or (_USUAL_WINDOW if width is None and seconds is None else None)
    limits = most, width or 0.0, seconds or math.inf
    asked = {"a": a, "window": most, "width": width, "time": seconds, "prove": prove}
    found: list[EntropyBounds] = []
    proofs: list[Proof] = []
    solving = _solve(values, limits, prove, Solvers(jobs), proofs)
    try:
        with _keeping(db, store, prove, asked) as keep, closing(solving) as levels:
            for level, computed in levels:
                found.append(level)
                keep(level, computed)
    finally:
        last = list({level.a: level for level in found}.values())
        output.write(COLUMNS, map(attrgetter(*COLUMNS), found if len(values) == 1 else last))
        if prove:
            note(balls_of(proofs))
    apart = [level.width for level in last]
    if width is not None and max(apart) > width:
        where = f" at {sum(each > width for each in apart)} of {len(apart)} a" if len(values) > 1 else ""
        note(f"the bounds are {max(apart):.1e} apart, not {width:g}{where}: {_WHY}")
        raise typer.Exit(1)


def balls_of(proofs: "Sequence[Proof]") -> str:
    """Say in one line what balls made of the windows that doubles have decided."""
    proved, left_open = (sum(getattr(each, name) for each in proofs) for name in ("proved", "left_open"))
    return (
        f"balls prove {proved} of {proved + left_open} windows that doubles decide, "
        f"{left_open} left open; {sum(each.seconds for each in proofs):.1f} s"
    )


def _solve(
    values: Sequence[float], limits: "Limits", prove: bool, solvers: Solvers, proofs: "list[Proof]"
) -> "Solving":
    """Enclose the entropy with longer and longer windows, at many a in processes; note what balls did."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.entropy.bounds import enclose, search
    from orbitdb.entropy.verdicts import decide

    judges: list[Any] = [None] * len(values)
    if prove:
        from orbitdb.entropy.proof import Proof  # it loads flint, which doubles alone do not need

        judges = [Proof() for _ in values]
    if len(values) == 1:
        proofs += filter(None, judges)
        judge = proofs[0].decide if prove else decide
        with progress("windows") as shown:
            yield from ((each, None) for each in search(Stadium(values[0]), *limits, shown.tell, judge))
        return
    seconds = _SECONDS * 1.8 ** ((limits[0] or _USUAL_WINDOW) - _USUAL_WINDOW)
    tasks = [partial(enclose, a, *limits, proof) for a, proof in zip(values, judges, strict=True)]
    with progress("windows") as shown, solvers.at_work(len(tasks) * seconds) as workers:
        for done, solved in enumerate(workers.solved(tasks), 1):
            proofs += filter(None, [solved.proof])
            yield from ((level, solved.arithmetic) for level in solved.levels)
            shown.tell(f"a = {exact(solved.levels[-1].a)}", done, len(tasks))


@contextmanager
def _keeping(db: Path, store: bool | None, prove: bool, asked: dict[str, Any]) -> "Iterator[Keep]":
    """Give what keeps bounds in the catalogue; it does nothing where there is none, and none is asked for."""
    from orbitdb.entropy.bounds import BALLS, DOUBLES
    from orbitdb.store.file.database import check_file
    from orbitdb.store.file.schema import SCHEMA_VERSION

    version = None if store else check_file(db)
    if store is False or (store is None and version != SCHEMA_VERSION):
        yield lambda level, computed: None
        if store is None and version is None:
            note(f"not kept: there is no catalogue at {db}; --store makes one")
        elif store is None:
            note(
                f"not kept: {db} has the older schema {version}; --store, or 'orbitdb migrate', "
                "brings it to the newest"
            )
        return
    from orbitdb.store.reading.moment import Reader
    from orbitdb.store.writing.writer import Writer, keep_bounds

    bring(db)
    Reader(db).close()  # what is wrong with it is to be known before
    with closing(Writer(db, {"command": "bounds", **asked})) as writer:
        yield lambda level, computed: keep_bounds(writer, level, BALLS if prove else DOUBLES, computed)
