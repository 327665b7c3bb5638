"""``orbitdb levels``: the quantum levels of the stadium."""

from collections.abc import Iterator
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.progress.line import progress
from orbitdb.cli.render import note, write
from orbitdb.cli.storing import WORTH_PROCESSES, Jobs, Solvers, bring
from orbitdb.errors import InputError
from orbitdb.numerals import real
from orbitdb.plaintext import several

if TYPE_CHECKING:
    from orbitdb.quantum.levels import Levels, LevelTask
    from orbitdb.quantum.weyl import Parity

EXAMPLES = """
Examples:

  orbitdb levels --k 0:30

  orbitdb levels --k 0:12 --parity oo --a 0.5 --json

  orbitdb levels --k 20:21 --no-store --format csv
"""
COLUMNS = ("k", "error", "parity")
_WORTH = 200
"""Levels from which on further processes pay."""


def levels(
    *,
    k: Annotated[str, typer.Option("--k", metavar="FROM:TO", help="The range of wavenumbers, in 1/radius.")],
    parity: Annotated[
        str | None,
        typer.Option("--parity", help="ee, eo, oe or oo, several with commas [default: all four]."),
    ] = None,
    a: options.HalfLength = 1.6,
    jobs: Jobs = None,
    store: Annotated[bool, typer.Option(help="Keep the levels in the catalogue.")] = True,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Find all levels of the quantum stadium in a range of k, each with an estimate of its error.

    k^2 are the eigenvalues of minus the Laplacian, with functions that are 0 on the boundary. A parity is
    two letters, even or odd under x -> -x and then under y -> -y. Levels that the catalogue holds are not
    computed again, so that a run that was ended goes on where it was.
    """
    import numpy as np

    from orbitdb.billiard.stadium import Stadium
    from orbitdb.quantum.levels import windows
    from orbitdb.quantum.weyl import weyl
    from orbitdb.store.file.database import default_path

    low, high = read_range("--k", k)
    stadium, parities = Stadium(a), read_parities(parity)
    for each in parities:
        list(windows(stadium, each, low, high))  # so that a range that is refused leaves no file
    path = (db or default_path()) if store else None
    if path is not None:
        bring(path)
    found = {each: _known(path, a, each) for each in parities}
    from orbitdb.catalogue.spectrum import missing_levels

    tasks = [
        task
        for each in parities
        for gap in missing_levels(found[each], low, high)
        for task in windows(stadium, each, *gap)
    ]
    for solved in _solve(tasks, Solvers.chosen(None, None, jobs), path, k):
        found[solved.parity].append(solved)
    rows = sorted(
        (level, error, str(each))
        for each, parts in found.items()
        for part in parts
        for level, error in zip(part.k.tolist(), part.error.tolist(), strict=True)
        if low <= level < high
    )
    write(COLUMNS, rows, options.chosen(format_, json))
    for each, parts in found.items():
        below = min(part.below + int((part.k < low).sum()) for part in parts if part.high > low)
        own = [row for row in rows if row[2] == each]
        places = np.linspace(low, high, 2000)
        count = below + np.searchsorted([row[0] for row in own], places)
        off = float((count - weyl(stadium, each)(places)).mean())
        worst = f", errors up to {max(row[1] for row in own):.0e}" if own else ""
        levels_of = several(len(own), "level", "levels")
        note(f"{each}: {levels_of}, none missing; on the mean {off:+.2f} from Weyl's law{worst}")
    if not rows:
        raise typer.Exit(1)


def read_range(name: str, text: str) -> tuple[float, float]:
    """Return the ends of a range such as 0:30.

    Raises
    ------
    InputError
        If it is none.
    """
    first, colon, last = text.partition(":")
    try:
        low, high = real(first), real(last)
    except ValueError:
        low, high = 0.0, -1.0
    if not colon or not 0 <= low < high:
        raise InputError(f"{name} {text!r:.40}: give a range from 0 up, such as 0:30")
    return low, high


def read_parities(text: str | None) -> "list[Parity]":
    """Return the parities that are named, all four by default.

    Raises
    ------
    InputError
        If one is none.
    """
    from orbitdb.quantum.weyl import Parity

    if text is None:
        return list(Parity)
    try:
        return list(dict.fromkeys(Parity(each.strip()) for each in text.split(",")))
    except ValueError:
        raise InputError(f"--parity {text!r:.40}: use ee, eo, oe, oo, with commas between") from None


def _known(path: Path | None, a: float, parity: "Parity") -> "list[Levels]":
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.catalogue.spectrum import stored_levels

    if path is None:
        return []
    with closing(Catalogue(path)) as catalogue, catalogue.reading() as connection:
        return stored_levels(connection, a, parity)


def _solve(tasks: "list[LevelTask]", solvers: Solvers, path: Path | None, k: str) -> "Iterator[Levels]":
    """Solve tasks, and keep what they give if there is a catalogue."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.quantum.weyl import weyl
    from orbitdb.store.writing.records import keep_levels
    from orbitdb.store.writing.writer import Writer

    if not tasks:
        return
    stadium = Stadium(tasks[0].a)
    smooth = {task: weyl(stadium, task.parity) for task in tasks}
    expected = sum(number(task.high) - number(task.low) for task, number in smooth.items())
    worth = WORTH_PROCESSES if expected > _WORTH else 1
    parameters = {"command": "levels", "k": k, "a": stadium.a}
    with (
        nullcontext() if path is None else closing(Writer(path, parameters)) as writer,
        progress("levels") as shown,
        solvers.at_work(worth, 1) as workers,
    ):
        shown.tell("levels", 0, len(tasks), counted=False)
        for done, solved in enumerate(workers.solved(tasks), 1):
            if writer is not None:
                keep_levels(writer, solved)
            shown.tell(f"levels {solved.parity} to k = {solved.high:.4g}", done, len(tasks), counted=False)
            yield solved
