"""``orbitdb assess``: find missing levels with the orbits, and the statistics of levels."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.choice import Choice
from orbitdb.cli.given_levels import MeasuredLevels, read_parities
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import reading
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import exact, with_error

if TYPE_CHECKING:
    from orbitdb.store.reading.moment import Moment

EXAMPLES = (
    "assess levels.csv --parity oo",
    "assess measured.txt --parity oo --frequency GHz --radius 0.2 --fit-radius",
    "assess --statistics",
)
COLUMNS = ("after", "before", "missing")


def assess(
    *,
    context: typer.Context,
    given: MeasuredLevels,
    fit_radius: Annotated[
        bool, typer.Option("--fit-radius", help="Fit the radius, which you know to half a per cent.")
    ] = False,
    statistics: Annotated[
        bool, typer.Option("--statistics", help="Show the statistics of the levels of each parity instead.")
    ] = False,
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Find the levels that are missing from a list.

    The stored orbits count the levels below each k. Give all levels from the lowest one on, in units of the
    radius. Each row is a place between two levels; missing says how many levels are missing there, and a
    negative number how many are spurious or double. The exit code is 1 if there is such a place. --statistics
    shows gap ratios, the variance of spacings, Delta_3 and the number variance, first of the levels as they
    are (balls: in), then with the bouncing balls taken out of the staircase.
    """
    if given.levels is None:
        options.refuse_idle(context, "without FILE", "energies", "frequency", "radius", "fit_radius")
    parity = None if statistics else given.of_one()
    if statistics:
        options.refuse_idle(context, "with --statistics", "fit_radius")
        with reading(db, a, Choice()) as (moment, (chosen,)):
            rows = _statistics(moment, chosen.a, given)
        from orbitdb.quantum.statistics import Statistics

        output.write(Statistics._fields, rows)
        return
    from orbitdb.answers.judging import assess_levels

    read = given.read(parity)
    with progress("summing orbits"), reading(db, a, Choice()) as (moment, (chosen,)):
        found, told = assess_levels(moment, chosen.a, read, parity, fit_radius)
    output.write(COLUMNS, found.gaps)
    for said in told:
        note(said)
    if fit_radius:
        unit = given.radius or 1.0
        scaled = with_error(found.scale * unit, found.scale_error * unit)
        note(f"radius {scaled} {'m' if given.radius else 'times the one you used'}; the k above use it")
    note(found.verdict())
    if found.gaps:
        raise typer.Exit(1)


def _statistics(moment: "Moment", a: float, given: MeasuredLevels) -> list[tuple[object, ...]]:
    """Return the statistics of each parity, of random matrices and of random numbers."""
    import numpy as np

    from orbitdb.answers.spectrum import levels_from_zero
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.quantum.spectrum import check_levels
    from orbitdb.quantum.statistics import expected, statistics

    path, parities = given.levels, read_parities(given.parity)
    if path is not None and len(parities) != 1 and not _has_parities(path):
        raise InputError(
            f"statistics need one parity: name it with --parity, or add a column parity to {path}"
        )
    rows: list[tuple[object, ...]] = []
    for parity in parities:
        read = given.read(parity)
        k = levels_from_zero(moment, a, parity).k if read is None else np.sort(read)
        check_levels(k, Stadium(a), parity)
        rows += [tuple(statistics(k, Stadium(a), parity, balls)) for balls in (False, True)]
        if read is None:
            note(f"{parity}: {len(k)} levels at a = {exact(a)}, k below {k[-1]:.4g}")
    return rows + [tuple(each) for each in expected()]


def _has_parities(path: Path) -> bool:
    return "parity" in path.read_text(encoding="utf-8-sig").partition("\n")[0]
