"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.figures import DRAWINGS, ENTROPY_OVER_A, ORBIT_IN_FIELD, SHEET_OF_WORDS, Drawing, Kind
from orbitdb.cli.given_levels import OF_FILE, GivenLevels
from orbitdb.cli.options import Asked, Choice, many_a, named
from orbitdb.cli.output import code_text, note, progress
from orbitdb.cli.reading import given_codes, known_catalogue, meant, primitive, reading
from orbitdb.errors import InputError
from orbitdb.extras import load
from orbitdb.text import exact, real, several

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orbitdb.orbits.orbit import Orbit

EXAMPLES = (
    "plot orbit 1232131 --a 1.2 -o orbit.pdf",
    "plot entropy --p 2-11 -o entropy.svg",
    "plot life 010203113 -o life.svg",
    "plot sheet --order length --limit 20 -o shortest.pdf",
    "plot phase-space --p 2-8 --reversal self -o phase-space.png",
)

_SHOWN = (f"  {name:11} {drawing.shows}" for name, drawing in DRAWINGS.items())
AFTERWORD = "\n".join(["\n\b\nFigures:", *_SHOWN, ""])
_ALWAYS = ("kind", "output", "size", "dpi", "title")
"""Options that every figure takes."""

_MOST_K = 200.0
"""Largest k of a wave to draw."""
_LEAST, _MOST = 1.0, 100.0
"""Limits on the width and height of a figure in inches."""


def plot(
    *,
    context: typer.Context,
    kind: Annotated[Kind, typer.Argument(metavar="FIGURE", help="One of the figures listed below.")],
    words: options.Words = None,
    output: Annotated[
        Path, options.path_option("-o", "--output", help="Name ending in .png, .svg or .pdf; - for stdout.")
    ],
    code: options.Codes = None,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    order: options.Order = "p",
    over_a: Annotated[
        bool, typer.Option("--over-a", help="Draw the entropy against a instead of the period.")
    ] = False,
    limit: Annotated[
        int, options.count_option(least=1, help="Maximum number of orbits to draw on a sheet.")
    ] = 120,
    given: GivenLevels,
    k: Annotated[float | None, options.number_option(help="Draw the level nearest to this k.")] = None,
    kappa: options.Kappa = None,
    size: Annotated[
        str | None, typer.Option("--size", metavar="WIDTHxHEIGHT", help="Size in inches, such as 6.4x4.8.")
    ] = None,
    dpi: Annotated[
        int, options.count_option("--dpi", least=10, most=2000, help="Resolution of a png, in dots per inch.")
    ] = 200,
    title: Annotated[str | None, typer.Option("--title", help="Title to replace that of the figure.")] = None,
    form: Annotated[
        str | None, typer.Option("--format", help="png, svg or pdf, if the file name does not say which.")
    ] = None,
    force: options.Force = False,
    db: options.Database,
) -> None:
    """Draw an orbit, or a figure of a chosen subset, and save it to a file.

    orbit, reverse and life draw the orbit of one WORD, and sheet can draw several; with --kappa, orbit draws
    it in a magnetic field. wave and husimi draw one quantum level. The other figures show a subset of the
    orbits or levels; lyapunov and lengths can compare several a.
    """
    from orbitdb.answers.export import FIGURES, STDOUT, check_target, complete, form_of

    to_stdout = output == STDOUT
    if to_stdout:
        options.refuse_idle(context, "on stdout", "force")
    else:
        check_target(output, force)
    ending, inches = form_of(output, form, FIGURES), _size(size)
    drawing, asked = DRAWINGS[kind], f"in plot {kind}"
    if over_a and kind == "entropy":
        drawing, asked = ENTROPY_OVER_A, "with --over-a"
    elif kappa and kind == "orbit":
        drawing, asked = ORBIT_IN_FIELD, "with --kappa"
    elif kind == "sheet" and (words or code):
        drawing, asked = SHEET_OF_WORDS, "with words"
    takes = drawing.takes
    options.takes_only(context, asked, *_ALWAYS, *takes)
    if kind == "life":
        options.refuse_idle(context, asked, "db")
    if given.levels is None and "levels" in takes:
        options.refuse_idle(context, "without --levels", *OF_FILE)
    if many_a(a) and not drawing.several_a:
        several_a = " and ".join(name for name in DRAWINGS if DRAWINGS[name].several_a)
        raise InputError(f"--a gives several values: plot {kind} draws one a; {several_a} draw several")
    if choice.status is None:
        choice = replace(choice, status="orbit")
    style = load("orbitdb.plots.style", "plot", "plot")  # late, because matplotlib is slow to import

    codes = list(given_codes(words, code)) if "words" in takes else []
    if "k" in takes:
        made = _of_wave(drawing, codes, k, given, a, db)
    elif "kappa" in takes:
        made = _in_field(kind, drawing, codes, [*chain.from_iterable(kappa or ())], a, db)
    elif "words" in takes:
        made = _of_words(kind, drawing, codes, a, db, inches)
    else:
        values = {"limit": limit, "order": order, "size": inches, "given": given, "grid": named(a) or ()}
        further = {name: values[name] for name in drawing.further}
        at = USUAL_A if over_a or kind == "births" else a  # these figures are about every a
        with progress("drawing"), reading(db, at, choice) as (moment, chosen):
            made = _draw(drawing, moment, *chosen, **further)
    style.adjust(made, inches, title)
    label = str(made.get_label())
    if to_stdout:
        sys.stdout.buffer.write(style.as_bytes(made, ending, label, dpi))
        return
    with progress("drawing"), complete(output) as draft:
        style.save(made, draft, ending, label, dpi)
    note(f"{label}, in {output}")


def _size(text: str | None) -> tuple[float, float] | None:
    """Return width and height from --size, or raise."""
    if text is None:
        return None
    try:
        width, height = map(real, text.split("x"))
    except ValueError:
        width = height = 0.0
    if not (_LEAST <= width <= _MOST and _LEAST <= height <= _MOST):
        within = f"{_LEAST:g} to {_MOST:g} inches"
        raise InputError(f"--size {text!r:.40}: give a width and a height of {within}, such as 6.4x4.8")
    return width, height


def _draw(drawing: Drawing, *what: Any, **further: Any) -> "Figure":
    """Call a drawing function; its module imports matplotlib."""
    module, name = drawing.draw.split(".")
    made: Figure = getattr(import_module(f"orbitdb.cli.figures.{module}"), name)(*what, **further)
    return made


def _of_wave(
    drawing: Drawing, codes: Sequence[str], k: float | None, given: GivenLevels, a: Asked, db: Path
) -> "Figure":
    """Draw the wave of the level nearest to k; if a code is given, draw its orbit on top."""
    if k is None or not 0 < k < _MOST_K:
        raise InputError(f"give the level, above 0 and below {_MOST_K:g}, such as --k 20.17")
    if (parity := given.of_one()) is None:
        raise InputError("name one parity, such as --parity ee")
    if len(codes) > 1:
        raise InputError("name one orbit at most")
    (at,) = meant(db, a)
    with progress("waves"):
        return _draw(drawing, at, k, parity, next(iter(_orbits(codes, at, db)), None))


def _in_field(
    kind: Kind, drawing: Drawing, codes: Sequence[str], kappa: Sequence[float], a: Asked, db: Path
) -> "Figure":
    """Draw the orbit of a single word in a magnetic field, or its action against the field."""
    if len(codes) != 1:
        raise InputError(f"name one orbit to draw: plot {kind} 1232131")
    (at,) = meant(db, a)
    return _draw(drawing, primitive(codes[0]), at, kappa)


def _of_words(
    kind: Kind, drawing: Drawing, codes: Sequence[str], a: Asked, db: Path, size: tuple[float, float] | None
) -> "Figure":
    """Draw the orbit of a single word, or several on a sheet; they are read or solved."""
    if kind == "sheet":
        (at,) = meant(db, a)
        orbits = _orbits(codes, at, db)
        return _draw(drawing, orbits, f"{several(len(orbits), 'orbit')} at a = {exact(at)}", size)
    if len(codes) != 1:
        raise InputError(f"name one orbit to draw: plot {kind} 1232131")
    if kind == "life":
        with progress("following"):
            return _draw(drawing, _followed(codes[0]))
    (at,) = meant(db, a)
    return _draw(drawing, *_orbits(codes, at, db))


def _orbits(codes: Sequence[str], a: float, db: Path) -> "list[Orbit]":
    """Return the orbits of words, stored or solved now, except those without a path; raise if all are."""
    from orbitdb.store.lookup import find_or_solve

    catalogue = known_catalogue(db)
    orbits = [find_or_solve(catalogue, primitive(code), a) for code in codes]
    drawn = [orbit for orbit in orbits if orbit.points is not None]
    for orbit in orbits:
        if orbit.points is None:
            text = f"{code_text(orbit.code)} at a = {exact(a)} cannot be drawn: {orbit.status.sentence}"
            if not drawn:
                raise InputError(text)
            note(text)
    return drawn


def _followed(code: str) -> "Orbit":
    """Return the orbit of a word and the ranges of a in which it exists; refuse a word that never does."""
    from orbitdb.orbits.solve import solve_word
    from orbitdb.store.lookup import with_existence

    orbit = with_existence(solve_word(primitive(code), USUAL_A))
    if orbit.exists is None:
        raise InputError(f"{code_text(orbit.code)} is too long to be followed as a changes")
    if not orbit.exists:
        raise InputError(f"{code_text(orbit.code)} is not an orbit at any a: {orbit.status.sentence}")
    return orbit
