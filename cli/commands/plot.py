"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import sys
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.given_levels import OF_FILE, GivenLevels, Lengths, read_range
from orbitdb.cli.grids import Asked, GivenValues, many_a, named
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import code_text, note, notes, progress
from orbitdb.cli.snapshots import given_codes, primitive, primitive_words, snapshot, solving
from orbitdb.display import load
from orbitdb.errors import InputError
from orbitdb.plots.registry import (
    FIGURES,
    NAMES,
    SUBSET,
    EmptyFigureError,
    Figure,
    figure_of,
    load_function,
    plain_name,
)
from orbitdb.text import format_float, real

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit
    from orbitdb.plots.style import Picture

EXAMPLES = (
    "plot orbit 1232131 --a 1.2 -o orbit.pdf",
    "plot entropy --p 2-11 -o entropy.svg",
    "plot life 010203113 -o life.svg",
    "plot sheet --order length --limit 20 -o shortest.pdf",
    "plot phase-space --p 2-8 --time-reversal self -o phase-space.png",
)

_SHOWN = (
    f"  {figure.name:12} {figure.shows}{f' (needs {figure.needs})' * bool(figure.needs)}"
    for figure in FIGURES
    if figure.shows
)
AFTERWORD = "\n".join(["\n\b\nFigures:", *_SHOWN, ""])
_ALWAYS = ("kind", "output", "form", "size", "dpi", "title")
"""Options that every figure takes."""

_MOST_K = 200.0
"""Largest k of a wave to draw."""
_LEAST, _MOST = 1.0, 100.0
"""Limits on the width and height of a figure in inches."""


def _figure_name(text: str) -> str:
    """Return the name of a figure as the registry writes it; refuse other names."""
    if (name := plain_name(text)) not in NAMES:
        raise typer.BadParameter(f"{text!r:.40} is not one of {', '.join(NAMES)}")
    return name


def plot(
    *,
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="FIGURE",
            parser=_figure_name,
            autocompletion=lambda: list(NAMES),
            help="One of the figures listed below.",
        ),
    ],
    words: options.Words = None,
    output: Annotated[
        Path, options.path_option("--output", "-o", help="Name ending in .png, .svg or .pdf; - for stdout.")
    ],
    code: options.Codes = None,
    a: options.HalfLengths = None,
    choice: SelectionOptions,
    order: options.Order = "p",
    over_a: Annotated[
        bool, typer.Option("--over-a", help="Draw the entropy against a instead of the period.")
    ] = False,
    limit: Annotated[
        int,
        options.count_option("--limit", "-n", least=1, help="Maximum number of orbits to draw on a sheet."),
    ] = 120,
    given: GivenLevels,
    lengths: Lengths = None,
    k: Annotated[
        str | None,
        typer.Option(
            metavar="K or LOW:HIGH", help="Of a wave, the level nearest to K; of a spectrum, its range of k."
        ),
    ] = None,
    kappa: options.Kappa = None,
    size: Annotated[
        str | None,
        typer.Option(
            "--size", metavar="WIDTH[xHEIGHT]", help="Size in inches, such as 6.4x4.8, or only the width."
        ),
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
    orbits or levels; lyapunov, lengths and symbol-plane can compare several a.
    """
    figure = figure_of(kind, [name for name, value in context.params.items() if value])
    ending, inches = _target(context, output, form, force), _size(size)
    _refuse_others(context, figure, given, a)
    if choice.status is None:
        choice = replace(choice, status=figure.status)
    style = load("orbitdb.plots.style", "plot", "plot")  # late, because matplotlib is slow to import
    codes = list(given_codes(words, code)) if "words" in figure.takes else []
    values = {
        "limit": limit,
        "order": order,
        "grid": named(a) or (),
        "lengths": None if lengths is None else read_range("--lengths", lengths),
        "opening": choice.opening or (),
        "kappa": [*chain.from_iterable(kappa or ())],
    }
    try:
        with progress("drawing"), style.sized(inches):
            if figure.source == "catalogue":
                made = _of_catalogue(figure, choice, given, k, values, a, db)
            elif figure.source == "opening":
                made = _of_opening(figure, choice, a, db)
            elif figure.source == "wave":
                made = _of_wave(figure, codes, k, given, a, db)
            else:
                made = _of_words(figure, codes, values, a, db)
    except EmptyFigureError as error:
        notes(error.lines)
        raise typer.Exit(1) from None
    notes(made.notes)
    if title is not None:
        style.entitle(made, title)
    _write(made, output, ending, dpi)


def _target(context: typer.Context, output: Path, form: str | None, force: bool) -> str:
    """Return the format of the figure; refuse a file that must not be written."""
    from orbitdb.output_files import FIGURES, STDOUT, check_target, form_of

    if output == STDOUT:
        options.refuse_idle(context, "on stdout", "force")
    else:
        check_target(output, force)
    return form_of(output, form, FIGURES)


def _refuse_others(
    context: typer.Context, figure: Figure, given: GivenLevels, a: list[GivenValues] | None
) -> None:
    """Refuse the given options that the figure does not take, and several a if it draws one."""
    asked = f"with {_flag(figure.when[0])}" if figure.when else f"in plot {figure.name}"
    options.takes_only(context, asked, *_ALWAYS, *_options_of(figure))
    if "a" not in figure.takes and figure.source == "orbit":
        options.refuse_idle(context, asked, "db")
    if given.levels is None and "levels" in figure.takes:
        options.refuse_idle(context, "without --levels", *OF_FILE)
    if many_a(a) and not figure.several_a:
        *others, last = (each.name for each in FIGURES if each.several_a and not each.when)
        several_a = f"{', '.join(others)} and {last}"
        raise InputError(
            f"--a gives several values: plot {figure.name} draws one a; {several_a} draw several"
        )


def _write(made: "Picture", output: Path, ending: str, dpi: int) -> None:
    from orbitdb.output_files import STDOUT, atomic_file
    from orbitdb.plots import style

    label = str(made.get_label())
    if output == STDOUT:
        sys.stdout.buffer.write(style.as_bytes(made, ending, label, dpi))
        return
    with progress("drawing"), atomic_file(output) as draft:
        style.save(made, draft, ending, label, dpi)
    note(f"{label}, in {output}")


def _flag(name: str) -> str:
    return "words" if name == "words" else f"--{name.replace('_', '-')}"


def _options_of(figure: Figure) -> list[str]:
    """Return the names of the parameters that a figure takes; a subset has all `SelectionOptions`."""
    return [
        each
        for name in figure.takes
        for each in (SelectionOptions.__dataclass_fields__ if name == SUBSET else [name])
    ]


def _size(text: str | None) -> tuple[float, float | None] | None:
    """Return the width and, if it is given, the height from --size, or raise."""
    if text is None:
        return None
    try:
        given = [*map(real, text.split("x"))]
    except ValueError:
        given = []
    if len(given) not in (1, 2) or not all(_LEAST <= inches <= _MOST for inches in given):
        within = f"{_LEAST:g} to {_MOST:g} inches"
        raise InputError(
            f"--size {text!r:.40}: give a width of {within}, and perhaps a height, such as 3.39 or 6.4x4.8"
        )
    return given[0], given[1] if len(given) == 2 else None


def _of_catalogue(
    figure: Figure,
    choice: SelectionOptions,
    given: GivenLevels,
    k: str | None,
    values: dict[str, Any],
    a: Asked,
    db: Path,
) -> "Picture":
    """Draw what a catalogue contains: a chosen subset, or its levels."""
    every_a = "a" not in figure.takes or "grid" in figure.passes
    with snapshot(db, USUAL_A if every_a else a, choice) as (catalogue, chosen):
        if "levels" in figure.passes:
            parity = given.of_one()
            values |= {"parity": parity, "levels": given.read(parity), "window": given.window}
        if "parts" in figure.passes:
            values |= {"parts": given.by_parity(catalogue, chosen[0].a), "window": given.window}
        if "k" in figure.passes:
            values["k"] = None if k is None else read_range("--k", k)
        return _draw(figure, values, catalogue, *chosen)


def _draw(figure: Figure, values: dict[str, Any], *what: Any) -> "Picture":
    """Draw a figure with those of the values that it uses."""
    made: Picture = load_function(figure.whole)(*what, **{name: values[name] for name in figure.passes})
    return made


def _of_wave(
    figure: Figure, codes: Sequence[str], k: str | None, given: GivenLevels, a: Asked, db: Path
) -> "Picture":
    """Draw the wave of the level nearest to k; if a code is given, draw its orbit on top."""
    from orbitdb.quantum.waves import nearest_wave

    try:
        near = 0.0 if k is None else real(k)
    except ValueError:
        near = 0.0
    if not 0 < near < _MOST_K:
        raise InputError(f"give the level, above 0 and below {_MOST_K:g}, such as --k 20.17")
    if (parity := given.of_one()) is None:
        raise InputError("name one parity, such as --parity ee")
    if len(codes) > 1:
        raise InputError("name one orbit at most")
    at, orbits = _orbits(codes, a, db)
    orbit = next(iter(orbits), None)
    return _draw(figure, {}, nearest_wave(at, near, parity), orbit)


def _of_opening(figure: Figure, choice: SelectionOptions, a: Asked, db: Path) -> "Picture":
    """Draw what escapes from an open stadium, as it is stored or computed on the spot."""
    ways = choice.opening or (), choice.without or ()
    with solving(db, a) as (catalogue, (at,)):
        return _draw(figure, {}, catalogue.escape(*ways, a=at, jobs=None, store=False))


def _of_words(figure: Figure, codes: Sequence[str], values: dict[str, Any], a: Asked, db: Path) -> "Picture":
    """Draw the orbit of a single word, or several on a sheet; they are read or solved."""
    if figure.source in ("orbit", "word") and len(codes) != 1:
        raise InputError(f"name one orbit to draw: plot {figure.name} 1232131")
    if figure.source == "word":
        with solving(db, a) as (_, (at,)):
            return _draw(figure, values, primitive(codes[0]), at)
    if "a" not in figure.takes:
        from orbitdb.orbits.solve import solve_word

        return _draw(figure, values, solve_word(primitive(codes[0]), USUAL_A))
    _, orbits = _orbits(codes, a, db)
    return _draw(figure, values, *(orbits if figure.source == "orbit" else [orbits]))


def _orbits(codes: Sequence[str], a: Asked, db: Path) -> "tuple[float, list[Orbit]]":
    """Return the a and the orbits of words at it, except those without a path; raise if all are."""
    with solving(db, a) as (catalogue, (at,)):
        orbits = catalogue.orbit(primitive_words(codes), a=at)
    drawn = [orbit for orbit in orbits if orbit.points is not None]
    for orbit in orbits:
        if orbit.points is None:
            text = (
                f"{code_text(orbit.code)} at a = {format_float(at)} cannot be drawn: {orbit.status.sentence}"
            )
            if not drawn:
                raise InputError(text)
            note(text)
    return at, drawn
