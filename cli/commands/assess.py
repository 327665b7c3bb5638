"""``orbitdb assess``: find missing levels by means of the orbits, and show the statistics of levels."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.given_levels import OF_FILE, MeasuredLevels
from orbitdb.cli.notes import note, notes, progress
from orbitdb.cli.output import Format, Output
from orbitdb.cli.snapshots import snapshot_at
from orbitdb.text import with_error

if TYPE_CHECKING:
    from orbitdb.quantum.conclusions import Gap

EXAMPLES = (
    "assess levels.csv --parity oo",
    "assess measured.txt --parity oo --frequency GHz --radius 0.2+-0.0005",
    "assess window.txt --window --parity oo --a 1",
    "assess --statistics",
)
COLUMNS = ("after", "before", "levels", "missing", "spurious", "probability", "gaps")
NUMBERS = ("k", "number", "probability", "excess")


def assess(
    *,
    context: typer.Context,
    given: MeasuredLevels,
    fit_radius: Annotated[
        bool, typer.Option("--fit-radius", help="Fit the radius, which must be known to half a per cent.")
    ] = False,
    noise: Annotated[float, options.number_option(help="Scatter of the levels, in mean spacings.")] = 0.0,
    numbers: Annotated[
        bool, typer.Option("--numbers", help="Instead, show the true number of each level of the list.")
    ] = False,
    statistics: Annotated[
        bool, typer.Option("--statistics", help="Instead, show the statistics of the levels of each parity.")
    ] = False,
    a: options.HalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Find the levels that are missing from a list, with probabilities.

    The list is compared with the number of levels below each k, computed from the stored orbits. Give all
    levels from the lowest upwards, with k in units of 1/radius, or with --window the levels of any range.
    Each row is a range between two levels of the list: how many levels are missing there, how many are
    spurious or duplicate, and the probability that both numbers are right. levels counts those in the range
    next to which the missing ones may be. The last line has the total. The exit code is 1 if anything is
    missing or spurious, or if the list does not fit the stadium. JSON also has gaps, with the probability of
    each number of missing levels between two neighbours. --numbers shows the true number of each level, 0
    for a spurious one, its probability, and excess, how many levels are missing below it according to the
    orbits. --statistics shows gap ratios, the variance of the spacings, Delta_3 and the number variance,
    first for the levels unfolded with Weyl's law (balls: in), then with the contribution of the bouncing
    balls removed as well (balls: out).
    """
    if given.levels is None:
        options.refuse_idle(context, "without FILE", *OF_FILE, "fit_radius", "noise")
    if statistics:
        options.refuse_idle(context, "with --statistics", "fit_radius", "numbers", "noise")
        _show_statistics(given, a, output, db)
        return
    parity, error = given.of_one(), given.radius_error
    fitted = fit_radius or error is not None
    read = given.read(parity)
    with progress("summing orbits"), snapshot_at(db, a) as (catalogue, at):
        assessment = catalogue.assess(
            read,
            parity=parity,
            window=given.window,
            fit_radius=fitted,
            radius_error=error,
            noise=noise,
            a=at,
        )
    if numbers:
        count = output.write(NUMBERS, assessment.numbers())
    else:
        columns = COLUMNS if output.form in (Format.JSON, Format.JSONL) else COLUMNS[:-1]
        count = output.write(
            columns, [_row(gap)[: len(columns)] for gap in assessment.gaps if assessment.fits]
        )
    if fitted and assessment.fits and not assessment.short and not assessment.at_limit:
        unit = given.radius.metres if given.radius else 1.0
        scaled = with_error(assessment.scale * unit, assessment.scale_error * unit)
        uses = "; the k above use it" if count else ""
        note(f"radius {scaled} {'m' if given.radius else 'times the one you used'}{uses}")
    notes([*assessment.notes, assessment.verdict()])
    if assessment.gaps or assessment.short or not assessment.fits:
        raise typer.Exit(1)


def _row(gap: "Gap") -> list[Any]:
    """Return the values of a gap, with those inside it as mappings."""
    return [*gap[:-1], [inside._asdict() for inside in gap.gaps]]


def _show_statistics(given: MeasuredLevels, asked: float | None, output: Output, db: Path) -> None:
    """Show the statistics of the levels of each parity, and of random matrices and random numbers."""
    with snapshot_at(db, asked) as (catalogue, at):
        found = catalogue.level_statistics(given.by_parity(), window=given.window, parity=given.parity, a=at)
    output.write([*found.columns], found.rows())
    notes(found.notes)
