"""``orbitdb spectrum``: the length spectra of orbits and levels."""

from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.choice import Choice
from orbitdb.cli.given_levels import GivenLevels, read_range
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import reading
from orbitdb.cli.render import note
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.quantum.amplitudes import Parity
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
    k_max: Annotated[
        float | None, options.number_option(help="End of the window [default: where the levels end, or 30].")
    ] = None,
    given: GivenLevels,
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
    if given.levels is None:
        options.refuse_idle(context, "without --levels", "energies")
    parity = given.of_one()
    read = given.read(parity)
    with progress("summing orbits"), reading(db, a, Choice()) as (moment, (chosen,)):
        found = read_spectrum(moment, chosen.a, (low, high), points, k_max, read, parity)
        judged = _judged(moment, chosen.a, read, parity)
    if peaks:
        output.write(PEAKS, found.peaks())
    else:
        from orbitdb.quantum.spectrum import COLUMNS

        output.write(COLUMNS, found.rows())
    for said in [*found.notes(), *judged]:
        note(said)


def _judged(moment: "Moment", a: float, given: list[float] | None, parity: "Parity | None") -> list[str]:
    """Name the missing levels of a file, if the orbits can find them."""
    from orbitdb.answers.judging import assess_levels

    if given is None:
        return []
    try:
        found, _ = assess_levels(moment, a, given, parity)
    except InputError:
        return []
    if not found.gaps:
        return []
    places = ", ".join(f"{gap.after or 0:.4g} and {gap.before or 0:.4g}" for gap in found.gaps[:_SHOWN])
    more = f" and {len(found.gaps) - _SHOWN} more" if len(found.gaps) > _SHOWN else ""
    return [f"{found.verdict()}: between {places}{more}; 'orbitdb assess FILE' lists them"]
