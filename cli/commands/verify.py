"""``orbitdb verify``: check the catalogue."""

import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import astuple
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import note, notes, progress, takes_a
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import chosen_codes
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.verification.checks import Check

EXAMPLES = (
    "verify",
    "verify --p 2-11 --a 1.6 --prove",
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
    code: options.OnlyCodes = None,
    choice: SelectionOptions,
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
    prove: Annotated[
        bool, typer.Option("--prove", help="Prove every row in ball arithmetic and store its certificate.")
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
    from orbitdb.catalogue import Catalogue

    if folder is not None:
        options.takes_only(context, "with FOLDER", "folder")
        _verify_dataset(folder, output)
        return
    if sample is None and not restarts:
        options.refuse_idle(context, "without --sample or --restarts", "seed")
    start = time.monotonic()
    criteria, catalogue = choice.criteria(code=chosen_codes(code)), Catalogue(db)
    with catalogue.snapshot() as then:
        stored = then.a_values(with_levels=True)
        if a is not None and a not in stored:
            note(f"{'; '.join(then.rows(a=a).notes)}; there is nothing to check")
            raise typer.Exit(1)
    if a is not None:
        takes_a(a)
    with progress("the catalogue") as shown:
        found = catalogue.verify(
            sample=sample, restarts=restarts, seed=seed, births=births, prove=prove, jobs=jobs,
            progress=shown, a=a, **criteria,
        )  # fmt: skip
    notes(found.notes)
    _report(found.checks, catalogue.path, start, output)


def _verify_dataset(folder: Path, output: Output) -> None:
    """Check the checksums and counts of a dataset (`orbitdb export FOLDER --dataset`)."""
    from orbitdb.answers.dataset import Dataset

    files = Dataset.check(folder)
    wrong = [f"{name} {what}" for name, what in files if what]
    output.write(COLUMNS, [("dataset", len(files), len(wrong), None, None, next(iter(wrong), None))])
    if wrong:
        note(f"{folder}: {len(wrong)} of {several(len(files), 'file')} changed since the export")
        raise typer.Exit(1)
    note(f"{folder}: no errors in {several(len(files), 'file')}")


def _report(checks: "Sequence[Check]", path: Path, start: float, output: Output) -> None:
    """Write the checks and a one-line verdict; exit with code 1 after a failure."""
    output.write(COLUMNS, map(astuple, checks))
    rows = Counter({check.name: check.rows for check in checks})
    broken = [check.name for check in checks if check.failures]
    if broken:
        from orbitdb.verification.verify import PROMISES

        for name in broken:
            note(f"{name}: some rows break this rule: {PROMISES[name]}")
        raise typer.Exit(1)
    counted = ", ".join(several(rows[name], *what) for name, what in _COUNTED.items() if rows[name])
    if not counted:
        note(f"nothing to check in {path}: the file is sound, but contains none of the classes you chose")
        raise typer.Exit(1)
    note(f"{path}: no errors in {counted}, {time.monotonic() - start:.1f} s")
