"""``orbitdb levels``: the quantum levels of the stadium."""

from collections.abc import Iterator
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note
from orbitdb.cli.storing import Jobs, Solvers, bring
from orbitdb.errors import InputError
from orbitdb.numerals import real
from orbitdb.plaintext import several

if TYPE_CHECKING:
    from orbitdb.quantum.amplitudes import Parity
    from orbitdb.quantum.levels import Levels, LevelTask

EXAMPLES = (
    "levels --k 0:30",
    "levels --k 0:12 --parity oo --a 0.5 --json",
    "levels --k 20:21 --no-store --format csv",
)
COLUMNS = ("k", "error", "parity")
_SECONDS = 0.6
"""In which the levels of a window are found, about, and more at large k."""


def levels(
    *,
    k: Annotated[str, typer.Option(metavar="FROM:TO", help="Range of wavenumbers, in units of 1/radius.")],
    parity: Annotated[
        str | None, typer.Option(help="ee, eo, oe or oo, several separated by commas [default: all four].")
    ] = None,
    a: options.HalfLength = 1.6,
    jobs: Jobs = None,
    store: Annotated[bool, typer.Option(help="Keep the levels in the catalogue.")] = True,
    output: Output,
    db: options.Database,
) -> None:
    """Find all levels of the quantum stadium in a range of k, each with an estimate of its error.

    k^2 are the eigenvalues of minus the Laplacian, for functions that vanish on the boundary. A parity has
    two letters: even or odd under x -> -x, then under y -> -y. Levels that the catalogue already has are not
    computed again, so an interrupted run goes on where it stopped.
    """
    import numpy as np

    from orbitdb.answers.spectrum import missing_levels, stored_levels
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.quantum.amplitudes import weyl
    from orbitdb.quantum.levels import windows
    from orbitdb.store.reading.moment import reading

    low, high = read_range("--k", k)
    stadium, parities = Stadium(a), read_parities(parity)
    for each in parities:
        list(windows(stadium, each, low, high))  # so that a range that is refused leaves no file
    found: dict[Parity, list[Levels]] = {each: [] for each in parities}
    if store:
        bring(db)
        with reading(db) as moment:
            found = {each: stored_levels(moment.connection, a, each) for each in parities}
    tasks = [
        task
        for each in parities
        for gap in missing_levels(found[each], low, high)
        for task in windows(stadium, each, *gap)
    ]
    for solved in _solve(tasks, Solvers(jobs), db if store else None, k):
        found[solved.parity].append(solved)
    rows = sorted(
        (level, error, str(each))
        for each, parts in found.items()
        for part in parts
        for level, error in zip(part.k.tolist(), part.error.tolist(), strict=True)
        if low <= level < high
    )
    output.write(COLUMNS, rows)
    for each, parts in found.items():
        below = min(part.below + int((part.k < low).sum()) for part in parts if part.high > low)
        own = [row for row in rows if row[2] == each]
        places = np.linspace(low, high, 2000)
        staircase = below + np.searchsorted([row[0] for row in own], places)
        off = float((staircase - weyl(stadium, each)(places)).mean())
        worst = f", errors up to {max(row[1] for row in own):.0e}" if own else ""
        count = several(len(own), "level")
        note(f"{each}: {count}, none missing; on average {off:+.2f} from Weyl's law{worst}")
    if not rows:
        raise typer.Exit(1)


def read_range(name: str, text: str) -> tuple[float, float]:
    """Return the ends of a range such as 0:30, or refuse what is none."""
    first, colon, last = text.partition(":")
    try:
        low, high = real(first), real(last)
    except ValueError:
        low, high = 0.0, -1.0
    if not colon or not 0 <= low < high:
        raise InputError(f"{name} {text!r:.40}: give a range from 0 up, such as 0:30")
    return low, high


def read_parities(text: str | None) -> "list[Parity]":
    """Return the parities that are named, all four by default, or refuse what is none."""
    from orbitdb.quantum.amplitudes import Parity

    if text is None:
        return list(Parity)
    try:
        return list(dict.fromkeys(Parity(each.strip()) for each in text.split(",")))
    except ValueError:
        raise InputError(f"--parity {text!r:.40}: use ee, eo, oe or oo, separated by commas") from None


def _solve(tasks: "list[LevelTask]", solvers: Solvers, path: Path | None, k: str) -> "Iterator[Levels]":
    """Solve tasks, and keep what they give if there is a catalogue."""
    from orbitdb.store.writing.writer import Writer, keep_levels

    if not tasks:
        return
    parameters = {"command": "levels", "k": k, "a": tasks[0].a}
    with (
        nullcontext() if path is None else closing(Writer(path, parameters)) as writer,
        progress("levels") as shown,
        solvers.at_work(_SECONDS * len(tasks)) as workers,
    ):
        shown.tell("levels", 0, len(tasks))
        for done, solved in enumerate(workers.solved(task.solved for task in tasks), 1):
            if writer is not None:
                keep_levels(writer, solved)
            shown.tell(f"levels {solved.parity} to k = {solved.high:.4g}", done, len(tasks))
            yield solved
