"""``orbitdb bounds``: proved bounds on the topological entropy."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import lengths
from orbitdb.cli.options import Format
from orbitdb.cli.progress.line import progress
from orbitdb.cli.render import note, write
from orbitdb.cli.storing import Solvers, bring
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.entropy.proof import Proof
    from orbitdb.filling.enclosures import Enclosed, EnclosureTask

    Keep = Callable[[EntropyBounds, str | None], None]

EXAMPLES = """
Examples:

  orbitdb bounds

  orbitdb bounds --a 0.5 --width 0.01

  orbitdb bounds --a 3 --time 30 --json

  orbitdb bounds --window 12 --prove

  orbitdb bounds --a 0.3:10:40 --window 12
"""
COLUMNS = ("a", "window", "lower", "upper", "windows", "undecided")
_USUAL_WINDOW = 14
_WORK = 200_000
"""Sequences that a fill solves while the entropy is enclosed at one a with the usual windows, roughly."""
_WHY = "the time, the length of windows or the memory was not enough"


def bounds(
    *,
    context: typer.Context,
    a: Annotated[
        str,
        typer.Option(
            "--a",
            metavar="NUMBER|FROM:TO:COUNT",
            help="Half length of a straight wall, or a logarithmic grid of them.",
        ),
    ] = str(options.USUAL_A),
    window: Annotated[
        int | None,
        options.count_option(
            "--window",
            help="Edges of the longest windows [default: 14, or as many as it takes].",
            least=2,
            most=40,
        ),
    ] = None,
    width: Annotated[
        float | None, options.number_option("--width", help="Until the bounds are as close as this.")
    ] = None,
    seconds: Annotated[
        float | None, options.number_option("--time", help="Until about so many seconds have passed.")
    ] = None,
    prove: Annotated[
        bool,
        typer.Option(
            "--prove", help="Decide every window in ball arithmetic, too; bounds are of what that proves."
        ),
    ] = False,
    jobs: Annotated[
        int | None,
        options.count_option("--jobs", help="Processes for a grid [default: all cores where it pays]."),
    ] = None,
    store: Annotated[
        bool | None,
        typer.Option(help="Keep the bounds in the catalogue [default: if there is one]."),
    ] = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Enclose the topological entropy (per bounce) between proved bounds; no orbit is needed.

    One row a length of windows, stretches of a code that are decided for every continuation at once:
    windows so far (mirror images and reversals not counted) and those of this length still undecided.
    All numbers are rounded outward. What is given first ends it: --window, --width or --time. Of a grid the
    last row of each a is shown, and --time is for each a. Where there is a catalogue the bounds are kept in
    it, and shown beside entropies from orbits from then on.
    """
    from orbitdb.filling.enclosures import EnclosureTask

    for name, limit in (("--width", width), ("--time", seconds)):
        if limit is not None and not 0 < limit < math.inf:
            raise InputError(f"{name} {limit:g}: give a number above 0")
    values = lengths(a)
    if len(values) == 1:
        options.refuse_idle(context, "at one a", "jobs")
    most = window or (_USUAL_WINDOW if width is None and seconds is None else None)
    tasks = [EnclosureTask(each, most, width or 0.0, seconds or math.inf, prove) for each in values]
    asked = {"a": a, "window": most, "width": width, "time": seconds, "prove": prove}
    found: list[EntropyBounds] = []
    balls = Balls()
    try:
        with _keeping(db, store, prove, asked) as keep:
            if len(tasks) == 1:
                _at_one(tasks[0], found, balls, keep)
            else:
                _at_many(tasks, Solvers.chosen(None, None, jobs), found, balls, keep)
    finally:
        rows = [[asdict(level)[name] for name in COLUMNS] for level in found]
        write(COLUMNS, rows, options.chosen(format_, json))
        if prove:
            note(balls.describe())
    reached = found if len(tasks) > 1 else found[-1:]
    apart = [level.upper - level.lower for level in reached]
    if width is not None and max(apart) > width:
        where = f" at {sum(each > width for each in apart)} of {len(apart)} a" if len(tasks) > 1 else ""
        note(f"the bounds are {max(apart):.1e} apart, not {width:g}{where}: {_WHY}")
        raise typer.Exit(1)


@dataclass
class Balls:
    """What balls made of the windows that doubles have decided."""

    proved: int = 0
    left_open: int = 0
    seconds: float = 0.0

    def add(self, found: "Proof | Enclosed") -> None:
        """Count what came of some windows."""
        self.proved += found.proved
        self.left_open += found.left_open
        self.seconds += found.seconds

    def describe(self) -> str:
        """Say it in one line."""
        decided = self.proved + self.left_open
        return (
            f"balls prove {self.proved} of {decided} windows that doubles decide, "
            f"{self.left_open} left open; {self.seconds:.1f} s"
        )


def _at_one(task: "EnclosureTask", found: "list[EntropyBounds]", balls: Balls, keep: "Keep") -> None:
    """Enclose the entropy at one a; every level is found."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.entropy.bounds import search
    from orbitdb.entropy.verdicts import decide

    proof = _proof() if task.prove else None
    judge = proof.decide if proof else decide
    try:
        with progress("windows") as shown:
            steps = search(Stadium(task.a), task.window, task.width, task.seconds, shown.tell, judge)
            for level in steps:
                found.append(level)
                keep(level, None)
    finally:
        if proof:
            balls.add(proof)


def _at_many(
    tasks: "list[EnclosureTask]", solvers: Solvers, found: "list[EntropyBounds]", balls: Balls, keep: "Keep"
) -> None:
    """Enclose the entropy at many a, in processes; the last level of each is found."""
    each = _WORK * 1.8 ** ((tasks[0].window or _USUAL_WINDOW) - _USUAL_WINDOW)
    with (
        progress("windows") as shown,
        solvers.at_work(round(len(tasks) * each), 1) as workers,
    ):
        for done, solved in enumerate(workers.solved(tasks), 1):
            for level in solved.levels:
                keep(level, solved.arithmetic)
            found.append(solved.levels[-1])
            balls.add(solved)
            shown.tell(f"a = {found[-1].a:g}", done, len(tasks))


@contextmanager
def _keeping(db: Path | None, store: bool | None, prove: bool, asked: dict[str, Any]) -> "Iterator[Keep]":
    """Give what keeps bounds in the catalogue; it does nothing where there is none, and none is asked for."""
    from orbitdb.store.file.database import check_file, default_path
    from orbitdb.store.file.schema import BALLS, DOUBLES, SCHEMA_VERSION

    path = db or default_path()
    if store is False or (store is None and check_file(path) != SCHEMA_VERSION):
        yield lambda level, computed: None
        if store is None:
            note(f"not kept: {_why_not_kept(path)}")
        return
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.writing.records import keep_bounds
    from orbitdb.store.writing.writer import Writer

    bring(path)
    Catalogue(path).close()  # what is wrong with it is to be known before
    writer = Writer(path, {"command": "bounds", **asked})

    def keep(level: "EntropyBounds", computed: str | None) -> None:
        keep_bounds(writer, level, BALLS if prove else DOUBLES, computed)

    try:
        yield keep
    finally:
        writer.close()


def _why_not_kept(path: Path) -> str:
    """Say why bounds are not kept where nobody has asked for it; what is only read is not migrated."""
    from orbitdb.store.file.database import check_file

    version = check_file(path)
    if version is None:
        return f"there is no catalogue at {path}; --store makes one"
    return f"{path} has the older schema {version}; --store, or 'orbitdb migrate', brings it to the newest"


def _proof() -> "Proof":
    from orbitdb.entropy.proof import Proof  # it loads flint, which doubles alone do not need

    return Proof()
