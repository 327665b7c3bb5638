"""``orbitdb spectrum``: compare the length spectra of orbits and levels."""

from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.given_levels import OF_FILE, GivenLevels, read_range
from orbitdb.cli.options import Choice
from orbitdb.cli.output import Output, note
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import reading

EXAMPLES = (
    "spectrum --range 3:11 --json",
    "spectrum --parity oo --k-max 25 --format csv",
    "spectrum --levels measured.csv --peaks",
    "spectrum --terms --parity oo --range 0:12",
)
PEAKS = ("length", "height", "code", "repetitions", "total", "strength")


def spectrum(
    *,
    context: typer.Context,
    lengths: Annotated[
        str, typer.Option("--range", metavar="FROM:TO", help="Range of lengths, in units of the radius.")
    ] = "1:12",
    points: Annotated[int, options.count_option(help="Number of lengths.", least=2)] = 500,
    k_max: Annotated[
        float | None,
        options.number_option(help="Upper end of the window in k [default: where the levels end, or 30]."),
    ] = None,
    given: GivenLevels,
    peaks: Annotated[
        bool, typer.Option("--peaks", help="List the peaks, and the orbits that cause them.")
    ] = False,
    terms: Annotated[
        bool,
        typer.Option("--terms", help="List the terms of the trace formula, by orbit and repetition."),
    ] = False,
    a: options.StoredHalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Show the length spectrum: the Fourier transform of the density of levels, and the orbits' part in it.

    Its peaks lie at the lengths of orbits. The window function is sin^4(pi k / k_max). --terms lists instead
    each term Re(A exp(i k l)) of the density of levels: with --parity, those of a quarter stadium, in which
    half of a symmetric orbit is closed. repetition counts traversals of the orbit or half orbit, and length
    is that of all of them. A is sign times |A| exp(-i pi index / 2).
    """
    from orbitdb.answers.levels import notes_on_missing_levels, read_spectrum

    low, high = read_range("--range", lengths.removeprefix("length="))
    if terms:
        options.refuse_idle(context, "with --terms", "points", "peaks", "levels")
    if given.levels is None:
        options.refuse_idle(context, "without --levels", *OF_FILE)
    parity = given.of_one()
    read = given.read(parity)
    with progress("summing orbits"), reading(db, a, Choice()) as (moment, (chosen,)):
        found = read_spectrum(moment, chosen.a, (low, high), points, k_max, read, parity)
        judged = [] if read is None else notes_on_missing_levels(moment, chosen.a, read, parity)
    if terms:
        from orbitdb.quantum.length_spectrum import TERMS

        output.write(TERMS, found.term_rows())
    elif peaks:
        output.write(PEAKS, found.peaks())
    else:
        from orbitdb.quantum.length_spectrum import COLUMNS

        output.write(COLUMNS, found.rows())
    for said in [*found.notes()[: 1 if terms else None], *judged]:
        note(said)
