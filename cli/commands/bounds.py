"""``orbitdb bounds``: proved bounds on the topological entropy."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.commands.info import bring
from orbitdb.cli.endings import until_interrupted
from orbitdb.cli.options import Format
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note, write
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.entropy.proof import Proof

EXAMPLES = """
Examples:

  orbitdb bounds

  orbitdb bounds --a 0.5 --width 0.01

  orbitdb bounds --a 3 --time 30 --json

  orbitdb bounds --window 12 --prove
"""
COLUMNS = ("a", "window", "lower", "upper", "windows", "undecided")
_USUAL_WINDOW = 14
_WHY = "the time, the length of windows or the memory was not enough"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(bounds)


def bounds(
    a: options.HalfLength = options.USUAL_A,
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
    All numbers are rounded outward. What is given first ends it: --window, --width or --time. Where there is
    a catalogue the bounds are kept in it, and shown beside entropies from orbits from then on.
    """
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.entropy.bounds import search
    from orbitdb.entropy.verdicts import decide

    stadium = Stadium(a)
    for name, limit in (("--width", width), ("--time", seconds)):
        if limit is not None and not 0 < limit < math.inf:
            raise InputError(f"{name} {limit:g}: give a number above 0")
    most = window or (_USUAL_WINDOW if width is None and seconds is None else None)
    found: list[EntropyBounds] = []
    proof = _proof() if prove else None
    asked = {"a": stadium.a, "window": most, "width": width, "time": seconds, "prove": prove}
    try:
        with _keeping(db, store, prove, asked) as keep, progress("windows") as shown:
            judge = proof.decide if proof else decide
            steps = search(stadium, most, width or 0.0, seconds or math.inf, shown.tell, judge)
            for level in until_interrupted(steps):
                found.append(level)
                keep(level)
    finally:
        rows = [[asdict(level)[name] for name in COLUMNS] for level in found]
        write(COLUMNS, rows, options.chosen(format_, json))
        if proof:
            note(
                f"balls prove {proof.proved} of {proof.proved + proof.left_open} windows that doubles decide,"
                f" {proof.left_open} left open; {proof.seconds:.1f} s"
            )
    apart = found[-1].upper - found[-1].lower
    if width is not None and apart > width:
        note(f"the bounds are {apart:.1e} apart, not {width:g}: {_WHY}")
        raise typer.Exit(1)


@contextmanager
def _keeping(
    db: Path | None, store: bool | None, prove: bool, asked: dict[str, Any]
) -> "Iterator[Callable[[EntropyBounds], None]]":
    """Give what keeps bounds in the catalogue; it does nothing where there is none, and none is asked for."""
    from orbitdb.store.file.database import check_file, default_path
    from orbitdb.store.file.schema import BALLS, DOUBLES

    path = db or default_path()
    if not (store or (store is None and check_file(path) is not None)):
        yield lambda level: None
        if store is None:
            note(f"not kept: there is no catalogue at {path}; --store makes one")
        return
    from orbitdb.store.reading.catalogue import Catalogue
    from orbitdb.store.writing.enclosures import keep_bounds
    from orbitdb.store.writing.writer import Writer

    bring(path)
    Catalogue(path).close()  # what is wrong with it is to be known before
    writer = Writer(path, {"command": "bounds", **asked})

    def keep(level: "EntropyBounds") -> None:
        keep_bounds(writer, level, BALLS if prove else DOUBLES)

    try:
        yield keep
    finally:
        writer.close()


def _proof() -> "Proof":
    from orbitdb.entropy.proof import Proof  # it loads flint, which doubles alone do not need

    return Proof()
