"""``orbitdb verify``: check the catalogue."""

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import astuple, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.options import Choice
from orbitdb.cli.output import Output, note, progress
from orbitdb.errors import AlteredError
from orbitdb.text import several

if TYPE_CHECKING:
    from sqlalchemy import Connection

    from orbitdb.store.selection import Selection
    from orbitdb.verification.checks import Check

EXAMPLES = (
    "verify",
    "verify --p 2-11 --a 1.6 --rigorous",
    "verify --sample 1000 --restarts 10 --seed 7 --json",
)

COLUMNS = ("check", "rows", "failures", "worst", "share", "first")
_COUNTED = {
    "statuses": ("class", "classes"),
    "births": ("birth or death", "births and deaths"),
    "sweeps": ("swept period", "swept periods"),
    "levels": ("quantum level", "quantum levels"),
}
"""Nouns for checks with one row per item."""


def verify(
    *,
    context: typer.Context,
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="FOLDER", parser=options.read_path, help="Dataset to check instead of the catalogue."
        ),
    ] = None,
    a: Annotated[float | None, options.a_option(" [default: all stored]")] = None,
    choice: Choice,
    sample: Annotated[
        int | None, options.count_option(least=1, help="Check only this many classes, drawn at random.")
    ] = None,
    restarts: Annotated[
        int,
        options.count_option(
            least=0, most=1000, help="Solve every word again from this many random starting points."
        ),
    ] = 0,
    seed: Annotated[int, options.count_option(least=0, help="Seed for --sample and --restarts.")] = 0,
    rigorous: Annotated[
        bool, typer.Option("--rigorous", help="Prove every row in ball arithmetic and store its certificate.")
    ] = False,
    births: Annotated[
        bool,
        typer.Option("--births", help="Prove that no birth or death is missing between a = 0.02 and 1000."),
    ] = False,
    jobs: options.Jobs = None,
    output: Output,
    db: options.Database,
) -> None:
    """Recompute the catalogue from its words alone, and compare the results.

    Each line is one check: the number of rows checked, the number of failures, the worst deviation, its share
    of what rounding and the error bound of the row allow (above 1 is a failure), and the first row that
    fails. The exit code is 1 if a check fails. Counts are checked for whole periods. Rows are checked if you
    choose them, even in a partly filled period. Quantum levels are checked if you choose no rows.
    """
    from orbitdb.answers.completeness import unfilled
    from orbitdb.store.connection import path_of
    from orbitdb.store.file import reading
    from orbitdb.store.selection import Selection
    from orbitdb.verification.verify import verifiable, verified

    if folder is not None:
        options.takes_only(context, "with FOLDER", "folder")
        _verify_dataset(folder, output)
        return
    if sample is None and not restarts:
        options.refuse_idle(context, "without --sample or --restarts", "seed")
    start = time.monotonic()
    missing: list[str] = []
    with reading(db) as moment:
        path, stored = path_of(moment), verifiable(moment)
        stadiums = stored if a is None else [a]
        subset = choice.at(USUAL_A)
        chosen = [replace(subset, a=at) for at in stadiums]  # a stored value may be invalid
        if a is not None and stadiums[0] not in stored:
            note(f"{unfilled(moment, Selection(stadiums[0]))}; there is nothing to check")
            raise typer.Exit(1)
        with suppress(AlteredError):  # one of the checks reports it
            missing.extend(_gaps(moment, chosen, a is not None))
    with progress("the catalogue") as shown:
        verification = verified(db, chosen, sample, restarts, seed, births, rigorous, jobs, shown)
    for gap in missing:
        note(gap)
    _report(verification.checks, path, start, restarts, output)


def _verify_dataset(folder: Path, output: Output) -> None:
    """Check the checksums and counts of a dataset (`orbitdb export FOLDER --dataset`)."""
    from orbitdb.answers.dataset import wrong_files

    files = list(wrong_files(folder))
    wrong = [f"{name} {what}" for name, what in files if what]
    output.write(COLUMNS, [("dataset", len(files), len(wrong), None, None, next(iter(wrong), None))])
    if wrong:
        note(f"{folder}: {len(wrong)} of {several(len(files), 'file')} changed since the export")
        raise typer.Exit(1)
    note(f"{folder}: no errors in {several(len(files), 'file')}")


def _report(checks: "Sequence[Check]", path: Path, start: float, restarts: int, output: Output) -> None:
    """Write the checks and a one-line verdict; exit with code 1 after a failure."""
    output.write(COLUMNS, map(astuple, checks))
    rows = Counter({check.name: check.rows for check in checks})
    if (unsettled := restarts * rows["statuses"] - rows["restarts"]) > 0:
        note(f"{unsettled} restarts did not converge and prove nothing")
    broken = [check.name for check in checks if check.failures]
    if broken:
        from orbitdb.verification.verify import PROMISES

        for name in broken:
            note(f"{name}: some rows break this rule: {PROMISES[name]}")
        raise typer.Exit(1)
    if lives := rows["lives"] + rows["undecided"]:
        note(f"{rows['lives']} of {lives} classes have all births and deaths between a = 0.02 and 1000")
    counted = ", ".join(several(rows[name], *what) for name, what in _COUNTED.items() if rows[name])
    if not counted:
        note(f"nothing to check in {path}: the file is sound, but contains none of the classes you chose")
        raise typer.Exit(1)
    if anew := rows["sweeps"] - rows["sums"]:
        from orbitdb.verification.births_sweeps_levels import SWEPT_ANEW

        what = "the sums of a swept period were" if anew == 1 else f"the sums of {anew} swept periods were"
        note(f"{what} not recomputed: only sums of whole periods up to {SWEPT_ANEW} are")
    note(f"{path}: no errors in {counted}, {time.monotonic() - start:.1f} s")


def _gaps(moment: "Connection", chosen: "Sequence[Selection]", at_one: bool) -> "Iterator[str]":
    """Yield notes on chosen periods that are partly filled, and on requested periods that are not stored.

    At an a without fills, periods that are not stored are only reported if --a was given (`at_one`).
    """
    from orbitdb.answers.completeness import describe_partial, partial_periods, unfilled
    from orbitdb.store.fills import read_fills, read_sweeps

    for selection in chosen:
        if partial := partial_periods(moment, selection):
            yield describe_partial(partial, selection.a)
        if not selection.periods or not (at_one or read_fills(moment, selection.a)):
            continue
        swept = [sweep.p for sweep in read_sweeps(moment, selection.a)]
        if said := unfilled(moment, selection, swept):
            yield said
