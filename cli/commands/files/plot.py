"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.arguments import given_codes, lengths, primitive
from orbitdb.cli.choice import Choice
from orbitdb.cli.measured import LEVELS_FILE, Measured
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, known_catalogue, meant, reading
from orbitdb.cli.render import code_text, note
from orbitdb.errors import InputError
from orbitdb.extras import load
from orbitdb.numerals import exact, real
from orbitdb.plaintext import several

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.moment import Moment

EXAMPLES = (
    "plot orbit 1232131 --a 1.2 -o orbit.pdf",
    "plot entropy --p 2-11 -o entropy.svg",
    "plot life 010203113 -o life.svg",
    "plot sheet --order length --limit 20 -o shortest.pdf",
    "plot phase-space --p 2-8 --reversal self -o phase-space.png",
)
AFTERWORD = """
\b
Figures:
  orbit       the path of WORD in the stadium (Fig. 1 of the paper)
  reverse     WORD above its time reverse (Fig. 4)
  life        WORD at its birth, its length and its lambda for every a
  entropy     by period (Fig. 5); with --over-a the proved bounds for every a
  lyapunov    by period (Fig. 6)
  sheet       the classes of a subset, or words (- reads stdin), each by itself
  phase-space the bounces in phase space
  lengths     how many orbits are no longer than L, and their density
  births      how many words are orbits at each a (run 'orbitdb births' first)
  spectrum    the length spectrum of levels beside that of the orbits
  staircase   levels below k, and what the orbits give ('orbitdb levels' first)
  assess      where levels are missing, by the orbits
  spacings    the spacings of levels, in their mean
  rigidity    Delta_3 of levels, beside that of random matrices
  wave        psi^2 of the level nearest to --k, with the orbit of WORD if named
  husimi      its Husimi function on the boundary, with the bounces of WORD
"""

Kind = Literal[
    "orbit", "reverse", "entropy", "lyapunov", "sheet", "phase-space", "lengths", "births", "life",
    "spectrum", "staircase", "assess", "spacings", "rigidity",
    "wave", "husimi",
]  # fmt: skip
_LEVELS = ("spectrum", "staircase", "assess", "spacings", "rigidity")
_OF_WAVES = ("wave", "husimi")
_MOST_K = 200.0
"""Largest k of a wave to draw."""
_LEAST, _MOST = 1.0, 100.0
"""Limits on the width and height of a figure in inches."""

_OF_WORD = ("words", "code", "a")
_OF_WORDS = ("orbit", "reverse", "life")
_OF_CLASSES = ("entropy", "lyapunov", "lengths")
"""Figures of averages, and of lengths."""

_TAKES = {
    "orbit": ("words", "code", "a"),
    "reverse": ("words", "code", "a"),
    "life": ("words", "code"),
    "births": ("p",),
    **dict.fromkeys(_LEVELS, ("a", "levels", "parity", "energies", "frequency", "radius")),
    **dict.fromkeys(_OF_WAVES, ("words", "code", "a", "k", "parity")),
}
"""Options of figures without a chosen subset."""


def plot(
    *,
    context: typer.Context,
    kind: Annotated[Kind, typer.Argument(metavar="FIGURE", help="One of those below.")],
    words: options.Words = None,
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="FILE", help="A name ending in .png, .svg or .pdf; - writes to stdout."
        ),
    ],
    code: options.Codes = None,
    a: Annotated[
        str | None,
        typer.Option(
            "--a",
            metavar="NUMBER",
            help="Half length of a straight wall [default: the only one stored, else 1.6]; with --over-a "
            "a grid FROM:TO:COUNT, too.",
            autocompletion=options.offered_half_lengths,
        ),
    ] = None,
    choice: Choice,
    order: options.Order = "p",
    over_a: Annotated[
        bool, typer.Option("--over-a", help="Draw the entropy against a, not against the period.")
    ] = False,
    limit: Annotated[int, options.count_option(least=1, help="Most orbits to draw on a sheet.")] = 120,
    levels: Annotated[Path | None, typer.Option(metavar="FILE", help=LEVELS_FILE)] = None,
    measured: Measured,
    k: Annotated[
        float | None, options.number_option(help="Draw the wave of the level nearest to this k.")
    ] = None,
    size: Annotated[
        str | None, typer.Option("--size", metavar="WIDTHxHEIGHT", help="Size in inches, such as 6.4x4.8.")
    ] = None,
    dpi: Annotated[
        int, options.count_option("--dpi", least=10, most=2000, help="Dots per inch of a png.")
    ] = 200,
    title: Annotated[str | None, typer.Option("--title", help="A title of your own.")] = None,
    form: Annotated[
        str | None, typer.Option("--format", help="png, svg or pdf, if the name does not end in it.")
    ] = None,
    force: options.Force = False,
    db: options.Database,
) -> None:
    """Draw an orbit, or a figure of the chosen subset, into a file.

    orbit, reverse and life draw the orbit of one WORD, a sheet draws several; the others draw a subset.
    """
    from orbitdb.export import FIGURES, STDOUT, check_target, complete, form_of

    to_stdout = output == STDOUT
    if to_stdout:
        options.refuse_idle(context, "on stdout", "force")
    else:
        check_target(output, force)
    ending = form_of(output, form, FIGURES)
    if over_a and kind != "entropy":
        raise InputError(f"--over-a does nothing in plot {kind}: leave it out")
    values = () if a is None else lengths(a)
    if len(values) > 1 and not over_a:
        raise InputError(f"--a {a}: plot {kind} draws one a; a grid goes with --over-a")
    at, inches = values[0] if len(values) == 1 else None, _size(size)
    takes = ("p", "over_a", "a") if over_a else _TAKES.get(kind)
    if takes is not None:
        asked = "with --over-a" if over_a else f"in plot {kind}"
        options.takes_only(context, asked, "kind", "output", "size", "dpi", "title", *takes)
    else:
        options.refuse_idle(
            context, f"in plot {kind}", "levels", "parity", "energies", "frequency", "radius", "k"
        )
        if kind != "sheet":
            options.refuse_idle(context, f"in plot {kind}", "words", "code", "limit", "order")
        elif words or code:
            options.takes_only(context, "with words", "kind", "output", "size", "dpi", "title", *_OF_WORD)
        choice = averaged(choice) if kind in _OF_CLASSES else choice
        choice = replace(choice, status="orbit" if choice.status is None else choice.status)
    style = load("orbitdb.plots.style", "plot", "plot")  # late, because matplotlib is slow to import

    if kind in _OF_WAVES:
        with progress("waves"):
            made = _of_wave(kind, list(given_codes(words, code)), k, measured, at, db)
    elif kind in _OF_WORDS:
        if kind == "life":
            options.refuse_idle(context, f"in plot {kind}", "db")
        made = _of_word(kind, list(given_codes(words, code)), at, db)
    elif words or code:
        if words and code:
            raise InputError("plot sheet: give WORD or --code, not both")
        made = _sheet_of_words(list(given_codes(words, code)), at, db)
    else:
        with progress("drawing"):
            if kind in _LEVELS:
                made = _of_levels(context, kind, levels, measured, at, db)
            else:
                made = _of_subset("over a" if over_a else kind, choice, values, (limit, order), db)
    style.adjust(made, inches, title)
    said = str(made.get_label())
    if to_stdout:
        sys.stdout.buffer.write(style.as_bytes(made, ending, said, dpi))
        return
    with progress("drawing"), complete(output) as draft:
        style.save(made, draft, ending, said, dpi)
    note(f"{said}, in {output}")


def _size(text: str | None) -> tuple[float, float] | None:
    """Return width and height from --size, or raise."""
    if text is None:
        return None
    try:
        width, height = (real(each) for each in text.split("x"))
    except ValueError:
        width = height = 0.0
    if not (_LEAST <= width <= _MOST and _LEAST <= height <= _MOST):
        within = f"{_LEAST:g} to {_MOST:g} inches"
        raise InputError(f"--size {text!r:.40}: give a width and a height of {within}, such as 6.4x4.8")
    return width, height


def _of_subset(
    kind: str, choice: Choice, values: Sequence[float], shown: tuple[int, str], db: Path
) -> "Figure":
    """Draw a figure from the catalogue; `sheet` has limit and order."""
    from orbitdb.cli.figures import averages, over_a, subsets

    draw: dict[str, Callable[[Moment, Selection], Figure]] = {
        "entropy": averages.draw_entropy,
        "over a": partial(over_a.draw_over_a, grid=values),
        "lyapunov": averages.draw_lyapunov,
        "sheet": partial(subsets.draw_sheet, limit=shown[0], order=shown[1]),
        "phase-space": subsets.draw_phase_space,
        "lengths": subsets.draw_lengths,
        "births": over_a.draw_births,
    }
    a = values[0] if values else None
    with reading(db, USUAL_A if kind in ("over a", "births") else a, choice) as (moment, (chosen,)):
        return draw[kind](moment, chosen)


def _of_levels(
    context: typer.Context, kind: str, path: Path | None, measured: Measured, a: float | None, db: Path
) -> "Figure":
    """Draw a figure of levels: those in a file, or in the catalogue."""
    from orbitdb.cli.figures import levels as figures

    with reading(db, a, Choice()) as (moment, (chosen,)):
        if kind in ("spacings", "rigidity"):
            parts = measured.by_parity(context, moment, chosen.a, path)
            return (figures.draw_spacings if kind == "spacings" else figures.draw_rigidity)(chosen.a, parts)
        draw = {
            "spectrum": figures.draw_length_spectrum,
            "staircase": figures.draw_levels,
            "assess": figures.draw_assessment,
        }
        return draw[kind](moment, chosen, measured.levels(context, path), measured.one_parity())


def _of_wave(
    kind: str, codes: list[str], k: float | None, measured: Measured, a: float | None, db: Path
) -> "Figure":
    """Draw the wave of the level nearest to some k, with any orbit over it."""
    from orbitdb.cli.figures.levels import draw_husimi, draw_wave
    from orbitdb.store.reading.lookup import find_or_solve

    if k is None or not 0 < k < _MOST_K:
        raise InputError(f"plot {kind} --k: give the level, above 0 and below {_MOST_K:g}, such as --k 20.17")
    if (parity := measured.one_parity()) is None:
        raise InputError(f"plot {kind}: name one parity, such as --parity ee")
    if len(codes) > 1:
        raise InputError(f"plot {kind}: name one orbit at most")
    (at,) = meant(db, a)
    orbit = find_or_solve(known_catalogue(db), primitive(codes[0]), at) if codes else None
    if orbit is not None and orbit.points is None:
        raise InputError(
            f"{code_text(orbit.code)} at a = {exact(at)} cannot be drawn: {orbit.status.sentence}"
        )
    return (draw_wave if kind == "wave" else draw_husimi)(at, k, parity, orbit)


def _sheet_of_words(codes: list[str], a: float | None, db: Path) -> "Figure":
    """Draw the orbits of some words, stored or solved now; write a note for words without one."""
    from orbitdb.cli.figures.subsets import sheet_of
    from orbitdb.store.reading.lookup import find_or_solve

    (at,), known = meant(db, a), known_catalogue(db)
    orbits = [find_or_solve(known, primitive(code), at) for code in codes]
    for found in orbits:
        if found.points is None:
            note(f"{code_text(found.code)} is left out: {found.status.sentence}")
    drawn = [found for found in orbits if found.points is not None]
    if not drawn:
        raise InputError("none of these words is an orbit that can be drawn")
    return sheet_of(drawn, f"{several(len(drawn), 'orbit')} at a = {exact(at)}")


def _of_word(kind: str, codes: list[str], a: float | None, db: Path) -> "Figure":
    """Draw the orbit of a single word, stored or solved now."""
    from orbitdb.cli.figures import orbits
    from orbitdb.orbits.single_word import solve_word
    from orbitdb.store.reading.lookup import find_or_solve, with_existence

    if len(codes) != 1:
        raise InputError(f"name one orbit to draw: plot {kind} 1232131")
    if kind != "life":
        (at,) = meant(db, a)
        found = find_or_solve(known_catalogue(db), primitive(codes[0]), at)
        if found.coordinates is None:
            raise InputError(
                f"{code_text(found.code)} at a = {exact(at)} cannot be drawn: {found.status.sentence}"
            )
        return orbits.draw_orbit(found) if kind == "orbit" else orbits.draw_reverse(found)
    with progress("following"):
        found = with_existence(solve_word(primitive(codes[0]), USUAL_A))
        if found.exists is None:
            raise InputError(f"{code_text(found.code)} is too long to be followed as a changes")
        if not found.exists:
            raise InputError(f"{code_text(found.code)} has no life: {found.status.sentence}")
        return orbits.draw_life(found)
