"""``orbitdb assess``: find missing levels by means of the orbits, and show the statistics of levels."""

from pathlib import Path
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.given_levels import OF_FILE, MeasuredLevels
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import Output, note, progress
from orbitdb.cli.reading import reading
from orbitdb.text import with_error

EXAMPLES = (
    "assess levels.csv --parity oo",
    "assess measured.txt --parity oo --frequency GHz --radius 0.2 --fit-radius",
    "assess window.txt --window --parity oo --a 1",
    "assess --statistics",
)
COLUMNS = ("after", "before", "missing")
NUMBERS = ("k", "number", "excess")


def assess(
    *,
    context: typer.Context,
    given: MeasuredLevels,
    fit_radius: Annotated[
        bool, typer.Option("--fit-radius", help="Fit the radius, which must be known to half a per cent.")
    ] = False,
    window: Annotated[
        bool, typer.Option("--window", help="The list may begin with any level; say with which.")
    ] = False,
    numbers: Annotated[
        bool, typer.Option("--numbers", help="Instead, show the true number of each level of the list.")
    ] = False,
    statistics: Annotated[
        bool, typer.Option("--statistics", help="Instead, show the statistics of the levels of each parity.")
    ] = False,
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Find the levels that are missing from a list.

    The list is compared with the number of levels below each k, computed from the stored orbits. Give all
    levels from the lowest upwards, with k in units of 1/radius, or with --window the levels of any range.
    Each row is an interval between two levels. missing is the number of levels missing there; a negative
    number counts spurious or duplicate levels. The exit code is 1 if there is such an interval, or if the
    list does not fit the stadium. --numbers shows the true number of each level, 0 for a spurious one, and
    excess, how many levels are missing below it according to the orbits. --statistics shows gap ratios, the
    variance of the spacings, Delta_3 and the number variance, first for the levels unfolded with Weyl's law
    (balls: in), then with the contribution of the bouncing balls removed as well (balls: out).
    """
    if given.levels is None:
        options.refuse_idle(context, "without FILE", *OF_FILE, "fit_radius", "window")
    if window:
        options.refuse_idle(context, "with --window", "fit_radius")
    if statistics:
        options.refuse_idle(context, "with --statistics", "fit_radius", "window", "numbers")
        _show_statistics(given, a, output, db)
        return
    parity = given.of_one()
    read = given.read(parity)
    with progress("summing orbits"), reading(db, a, SelectionOptions()) as (catalogue, (chosen,)):
        assessment = catalogue.assess(read, parity=parity, window=window, fit_radius=fit_radius, a=chosen.a)
    if numbers:
        output.write(NUMBERS, assessment.numbers())
    else:
        output.write(COLUMNS, assessment.gaps if assessment.fits else [])
    if fit_radius:
        unit = given.radius or 1.0
        scaled = with_error(assessment.scale * unit, assessment.scale_error * unit)
        note(f"radius {scaled} {'m' if given.radius else 'times the one you used'}; the k above use it")
    for line in [assessment.verdict(), *assessment.notes]:
        note(line)
    if assessment.gaps or not assessment.fits:
        raise typer.Exit(1)


def _show_statistics(given: MeasuredLevels, asked: float | None, output: Output, db: Path) -> None:
    """Show the statistics of the levels of each parity, and of random matrices and random numbers."""
    with reading(db, asked, SelectionOptions()) as (catalogue, (chosen,)):
        levels = given.by_parity(catalogue, chosen.a)
        found = catalogue.level_statistics(levels, a=chosen.a)
    output.write([*found.columns], found.rows())
    for line in found.notes:
        note(line)
