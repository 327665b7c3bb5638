"""``orbitdb assess``: find missing levels with the orbits, and the statistics of levels."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.choice import Choice
from orbitdb.cli.commands.average.spectrum import read_file
from orbitdb.cli.commands.make.levels import read_parities
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import reading
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import exact, with_error

if TYPE_CHECKING:
    from orbitdb.quantum.amplitudes import Parity
    from orbitdb.store.reading.moment import Moment

EXAMPLES = (
    "assess levels.csv --parity oo",
    "assess measured.txt --parity oo --frequency GHz --radius 0.2 --fit-radius",
    "assess --statistics",
)
COLUMNS = ("after", "before", "missing")
_LIGHT = 299_792_458.0
"""Speed of light in metres per second."""
_UNITS = {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9}

Unit = Literal["Hz", "kHz", "MHz", "GHz"]


def assess(
    *,
    context: typer.Context,
    levels: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="Levels k, one a line, or csv with a column k [default: those of the catalogue].",
        ),
    ] = None,
    parity: Annotated[
        str | None, typer.Option(help="ee, eo, oe or oo, if they are of one [default: all in one list].")
    ] = None,
    energies: Annotated[
        bool, typer.Option("--energies", help="The file holds energies k^2 (in csv, a column energy).")
    ] = False,
    frequency: Annotated[
        Unit | None,
        typer.Option(help="The file holds frequencies in this unit (csv: a column frequency)."),
    ] = None,
    radius: Annotated[
        float | None, options.number_option(help="Radius of the semicircles in metres, with --frequency.")
    ] = None,
    fit_radius: Annotated[
        bool, typer.Option("--fit-radius", help="Find the radius, which is known to half a per cent.")
    ] = False,
    statistics: Annotated[
        bool, typer.Option("--statistics", help="Show the statistics of the levels of each parity instead.")
    ] = False,
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Tell which levels of a list are missing, and where.

    The stored orbits count the levels below each k. Give all levels from the lowest one on, in units of the
    radius. Each row is a place between two levels; missing says how many levels are missing there, and a
    negative number how many are spurious or double. The exit code is 1 if there is such a place. --statistics
    shows gap ratios, the variance of spacings, Delta_3 and the number variance, first of the levels as they
    are (balls: in), then with the bouncing balls taken out of the staircase.
    """
    if levels is None:
        options.refuse_idle(context, "without FILE", "energies", "frequency", "radius", "fit_radius")
    if (frequency is None) != (radius is None):
        raise InputError("frequencies need --frequency with their unit and --radius in metres")
    if frequency is not None and energies:
        raise InputError("--energies and --frequency: the file holds one or the other")
    of = read_parities(parity)
    if parity is not None and len(of) != 1 and not statistics:
        raise InputError(f"--parity {parity}: give one, or leave it out for all")
    if statistics:
        options.refuse_idle(context, "with --statistics", "fit_radius")
        with reading(db, a, Choice()) as (moment, (chosen,)):
            rows = _statistics(moment, chosen.a, levels, of, parity, energies, frequency, radius)
        from orbitdb.quantum.statistics import Statistics

        output.write(Statistics._fields, rows)
        return
    from orbitdb.answers.judging import assess_levels

    given = None if levels is None else _read(levels, energies, frequency, radius, parity)
    with progress("summing orbits"), reading(db, a, Choice()) as (moment, (chosen,)):
        found, told = assess_levels(moment, chosen.a, given, of[0] if parity else None, fit_radius)
    output.write(COLUMNS, found.gaps)
    for said in told:
        note(said)
    if fit_radius:
        scaled = with_error(found.scale * (radius or 1.0), found.scale_error * (radius or 1.0))
        note(f"radius {scaled} {'m' if radius else 'times the one you used'}; the k above use it")
    note(found.verdict())
    if found.gaps:
        raise typer.Exit(1)


def _read(
    path: Path, energies: bool, frequency: Unit | None, radius: float | None, parity: str | None
) -> list[float]:
    """Return the levels k in a file of wavenumbers, energies or frequencies."""
    if frequency is None or radius is None:
        return read_file(path, energies, parity)
    if not 0 < radius < math.inf:
        raise InputError(f"--radius {radius:g}: give metres, such as 0.2")
    wave = 2 * math.pi * _UNITS[frequency] * radius / _LIGHT
    return [wave * each for each in read_file(path, False, parity, "frequency")]


def _statistics(
    moment: "Moment",
    a: float,
    path: Path | None,
    parities: "list[Parity]",
    named: str | None,
    energies: bool,
    frequency: Unit | None,
    radius: float | None,
) -> list[tuple[object, ...]]:
    """Return the statistics of each parity, of random matrices and of random numbers."""
    import numpy as np

    from orbitdb.answers.spectrum import levels_from_zero
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.quantum.spectrum import check_levels
    from orbitdb.quantum.statistics import expected, statistics

    if path is not None and len(parities) != 1 and not _has_parities(path):
        raise InputError(f"statistics are of one parity: name it with --parity, or give a column in {path}")
    rows: list[tuple[object, ...]] = []
    for parity in parities:
        if path is None:
            k = levels_from_zero(moment, a, parity).k
        else:
            k = np.sort(_read(path, energies, frequency, radius, str(parity)))
        check_levels(k, Stadium(a), parity)
        rows += [tuple(statistics(k, Stadium(a), parity, balls)) for balls in (False, True)]
        if path is None:
            note(f"{parity}: {len(k)} levels at a = {exact(a)}, k below {k[-1]:.4g}")
    return rows + [tuple(each) for each in expected()]


def _has_parities(path: Path) -> bool:
    return "parity" in path.read_text(encoding="utf-8-sig").partition("\n")[0]
