"""``orbitdb spectrum``: the length spectra of orbits and levels."""

import csv
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.choice import Choice
from orbitdb.cli.commands.make.levels import read_parities, read_range
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import reading
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import real

if TYPE_CHECKING:
    from orbitdb.store.reading.moment import Moment

EXAMPLES = (
    "spectrum --range 3:11 --json",
    "spectrum --parity oo --k-max 25 --format csv",
    "spectrum --levels measured.csv --peaks",
)
_SHOWN = 3
"""Number of places with missing levels to name in one line."""

PEAKS = ("length", "height", "code", "repetitions", "total", "strength")


def spectrum(
    *,
    context: typer.Context,
    lengths: Annotated[
        str, typer.Option("--range", metavar="FROM:TO", help="Range of lengths, in units of the radius.")
    ] = "1:12",
    points: Annotated[int, options.count_option(help="Number of lengths.", least=2)] = 500,
    parity: Annotated[str | None, typer.Option(help="ee, eo, oe or oo [default: all].")] = None,
    k_max: Annotated[
        float | None, options.number_option(help="End of the window [default: where the levels end, or 30].")
    ] = None,
    levels: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="File of levels k, one a line, or csv with a column k [default: those of the catalogue].",
        ),
    ] = None,
    energies: Annotated[
        bool, typer.Option("--energies", help="The file holds energies k^2 (in csv, a column energy).")
    ] = False,
    peaks: Annotated[
        bool, typer.Option("--peaks", help="List the peaks and the orbits behind them.")
    ] = False,
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Show the length spectrum: the Fourier transform of the density of levels, and the orbits' share in it.

    Peaks lie at the lengths of orbits. The window is sin^4(pi k / k_max).
    """
    from orbitdb.answers.spectrum import read_spectrum

    low, high = read_range("--range", lengths)
    if energies and levels is None:
        options.refuse_idle(context, "without --levels", "energies")
    if parity is not None:
        if len(named := read_parities(parity)) != 1:
            raise InputError(f"--parity {parity}: give one, or leave it out for all")
        parity = str(named[0])
    given = None if levels is None else read_file(levels, energies, parity)
    with progress("summing orbits"), reading(db, a, Choice()) as (moment, (chosen,)):
        found = read_spectrum(moment, chosen.a, (low, high), points, k_max, given, parity)
        judged = _judged(moment, chosen.a, given, parity)
    if peaks:
        output.write(PEAKS, found.peaks())
    else:
        from orbitdb.quantum.spectrum import COLUMNS

        output.write(COLUMNS, found.rows())
    for said in [*found.notes(), *judged]:
        note(said)


def _judged(moment: "Moment", a: float, given: "list[float] | None", parity: str | None) -> list[str]:
    """Name the missing levels of a file, if the orbits can find them."""
    from orbitdb.answers.judging import assess_levels
    from orbitdb.quantum.amplitudes import Parity

    if given is None:
        return []
    try:
        found, _ = assess_levels(moment, a, given, None if parity is None else Parity(parity))
    except InputError:
        return []
    if not found.gaps:
        return []
    places = ", ".join(f"{gap.after or 0:.4g} and {gap.before or 0:.4g}" for gap in found.gaps[:_SHOWN])
    more = f" and {len(found.gaps) - _SHOWN} more" if len(found.gaps) > _SHOWN else ""
    return [f"{found.verdict()}: between {places}{more}; 'orbitdb assess FILE' lists them"]


def read_file(path: Path, energies: bool, parity: str | None, column: str = "k") -> list[float]:
    """Return the levels k, or another column, in a file; from a csv with parities only the named parity.

    Refuses unreadable files and impossible levels.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "no text"
        raise InputError(f"{path}: {why}; give a file with one level a line") from None
    lines, name = [line for line in text.splitlines() if line.strip()], "energy" if energies else column
    bare = not lines or _level(lines[0].split(",")[0]) is not None
    table = csv.DictReader(lines, [name] if bare else None, skipinitialspace=True)
    if name not in (table.fieldnames or ()):
        raise InputError(f"{path}: its heading has no column {name}: rename one, or leave out the heading")
    found = []
    for number, row in enumerate(table, 1):
        if parity not in (None, row.get("parity", parity)):
            continue
        level = _level(row[name] or "")
        if level is None:
            raise InputError(f"{path}: row {number} has no level: {row[name]!r:.40}; give one number a line")
        if level <= 0:
            raise InputError(f"{path}: row {number} is {level:g}: levels are above 0")
        found.append(math.sqrt(level) if energies else level)
    return found


def _level(text: str) -> float | None:
    try:
        return real(text)
    except ValueError:
        return None
