"""``orbitdb spectrum`` and ``scars``: what orbits say about levels and their waves."""

from contextlib import suppress
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.given_levels import OF_FILE, GivenLevels, Lengths, Parities, read_k, read_range
from orbitdb.cli.notes import is_quiet, not_shown, note, notes, progress
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import given_codes, primitive_words, snapshot_at, solving
from orbitdb.errors import InputError

EXAMPLES = {
    "spectrum": (
        "spectrum --lengths 3:11 --json",
        "spectrum --parity oo --k 0:25 --format csv",
        "spectrum --levels measured.csv --peaks",
        "spectrum --levels window.csv --window --parity oo --k 771:777",
        "spectrum --terms --parity oo --lengths 0:12",
    ),
    "scars": (
        "scars 13 --k 20:22",
        "scars --k 20:20.5 --parity ee",
        "scars 02 --k 20:22 --order 'strength desc'",
        "scars 0123 --k 15.3 --parity oo",
    ),
}
PEAKS = ("length", "height", "code", "repetitions", "total", "strength")


def spectrum(
    *,
    context: typer.Context,
    lengths: Lengths = None,
    resolution: Annotated[int, options.count_option(help="Number of lengths.", least=2)] = 500,
    k: Annotated[
        str | None,
        typer.Option(
            metavar="LOW:HIGH",
            help="Range of wavenumbers k, in units of 1/radius; a single number is its upper end. Only with "
            "--window can it begin above 0 [default: that of the levels, or 0:30].",
        ),
    ] = None,
    given: GivenLevels,
    peaks: Annotated[
        bool, typer.Option("--peaks", help="List the peaks, and the orbits that cause them.")
    ] = False,
    terms: Annotated[
        bool,
        typer.Option("--terms", help="List the terms of the trace formula, by orbit and repetition."),
    ] = False,
    a: options.HalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Show the length spectrum: the Fourier transform of the density of levels, and the orbits' part in it.

    Its peaks lie at the lengths of orbits. Levels count with sin^4 over their range of k, 0 at its ends.
    --terms lists instead each term Re(A exp(i k l)) of the density of levels: with --parity, those of a
    quarter stadium, in which a symmetric orbit closes after half of its length. repetition counts traversals
    of the orbit or half orbit; length, lyapunov and index are those of all of them. A is sign times |A|
    exp(-i pi index / 2).
    """
    if terms:
        options.refuse_idle(context, "with --terms", "resolution", "peaks", "levels")
    if given.levels is None:
        options.refuse_idle(context, "without --levels", *OF_FILE)
    parity = given.of_one()
    read = given.read(parity)
    with progress("summing orbits"), snapshot_at(db, a) as (catalogue, at):
        result = catalogue.spectrum(
            None if lengths is None else read_range("--lengths", lengths),
            resolution=resolution,
            k=None if k is None else read_k(k),
            levels=read,
            window=given.window,
            parity=parity,
            a=at,
        )
        said = result.notes(terms)
        if read is not None and not is_quiet():
            with suppress(InputError):  # without enough orbits
                said += catalogue.assess(read, parity=parity, window=given.window, a=at).lacking()
    if terms:
        from orbitdb.quantum.length_spectrum import TERMS

        output.write(TERMS, result.term_rows())
    elif peaks:
        output.write(PEAKS, result.peaks())
    else:
        from orbitdb.quantum.length_spectrum import SPECTRUM_COLUMNS

        output.write(SPECTRUM_COLUMNS, result.rows())
    notes(said)


def scars(
    *,
    words: options.Words = None,
    code: options.Codes = None,
    k: Annotated[
        str, typer.Option(metavar="LOW:HIGH|K", help="Range of k, or a single k for the nearest level.")
    ],
    parity: Parities = None,
    order: Annotated[
        str | None,
        typer.Option(help="Columns to sort by [default: 'above desc' with WORD, else k]; desc reverses one."),
    ] = None,
    limit: options.Limit = None,
    a: options.HalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Measure how strongly orbits scar quantum levels.

    strength is the mean of psi^2 along the orbit, times the area: 1 on average, but 2 or 0 for an orbit on a
    symmetry axis. For the bouncing balls, 02, it is the mean over the rectangle that they fill. above is the
    difference from the mean strength of the 15 levels of the same parity on each side, in standard
    deviations. With WORD, you see all levels, the most scarred first. Without WORD, you see for each level
    the five orbits that scar it most, out of the bouncing balls and the twenty shortest stored orbits. Most
    of the time goes into the waves: each parity also needs those of 30 neighbours.
    """
    from orbitdb.answers.scars import Scar
    from orbitdb.catalogue import Catalogue

    at_k, named = read_k(k), words or code
    if named:
        with solving(db, a) as (_, (at,)):
            codes = primitive_words(given_codes(words, code))
        if not codes:
            raise InputError("stdin contains no code")
    else:
        with snapshot_at(db, a) as (_, at):
            codes = None  # no snapshot stays open while the waves are computed
    with progress("waves") as tell:
        catalogue = Catalogue(db, missing_ok=bool(named))
        rows = catalogue.scars(at_k, code=codes, parity=parity, order=order, progress=tell, a=at)
    count = output.write(Scar._fields, rows[: output.most(limit)])
    if not rows:
        note(f"no level with k in {k}")
        raise typer.Exit(1)
    if count < len(rows):
        note(f"{len(rows)} rows{not_shown(count, len(rows))}")
