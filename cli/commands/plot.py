"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.given_levels import OF_FILE, GivenLevels, Lengths, read_k, read_range
from orbitdb.cli.grids import Asked, named
from orbitdb.cli.notes import note, notes, progress
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.snapshots import given_codes, primitive_words, snapshot, solving
from orbitdb.errors import InputError
from orbitdb.plots.registry import FIGURES, NAMES, SIZES, SUBSET, EmptyFigureError, Figure, whole_figure
from orbitdb.text import real

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
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


def plot(
    *,
    context: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            metavar="FIGURE",
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
    figure = whole_figure(kind, [name for name, value in context.params.items() if value])
    ending, inches = _target(context, output, form, force), _size(size)
    _refuse_others(context, figure, given)
    codes = primitive_words(given_codes(words, code)) if "words" in figure.takes else []
    parts = "parts" in figure.passes
    try:
        with progress("drawing"), _opened(figure, a, db) as (catalogue, values):
            made = catalogue.plot(
                figure.name,
                code=codes or None,
                a=values,
                over_a=over_a,
                order=order if "order" in figure.passes else None,
                limit=limit if "limit" in figure.passes else None,
                levels=given.by_parity() if parts else given.read(given.of_one()),
                parity=given.parity,
                window=given.window,
                lengths=None if lengths is None else read_range("--lengths", lengths),
                k=None if k is None else read_k(k),
                kappa=[*chain.from_iterable(kappa)] if kappa else None,
                size=inches,
                title=title,
                **choice.criteria(),
            )
    except EmptyFigureError as error:
        notes(error.lines)
        raise typer.Exit(1) from None
    notes(made.notes)
    _write(made, output, ending, dpi)


@contextmanager
def _opened(figure: Figure, asked: Asked, db: Path) -> "Iterator[tuple[Catalogue, tuple[float, ...] | None]]":
    """Yield the catalogue, which need not exist for words, and the values of a to draw, None if not given."""
    from orbitdb.catalogue import Catalogue

    if "a" not in figure.takes or "grid" in figure.passes:
        yield Catalogue(db, missing_ok=figure.source != "catalogue"), named(asked)
    elif figure.source == "catalogue":
        with snapshot(db, asked, SelectionOptions()) as (catalogue, chosen):
            yield catalogue, tuple(each.a for each in chosen)
    else:
        with solving(db, asked) as opened:
            yield opened


def _target(context: typer.Context, output: Path, form: str | None, force: bool) -> str:
    """Return the format of the figure; refuse a file that must not be written."""
    from orbitdb.output_files import FIGURES, STDOUT, check_target, form_of

    if output == STDOUT:
        options.refuse_idle(context, "on stdout", "force")
    else:
        check_target(output, force)
    return form_of(output, form, FIGURES)


def _refuse_others(context: typer.Context, figure: Figure, given: GivenLevels) -> None:
    """Refuse the given options that the figure does not use."""
    asked = f"with {_flag(figure.when[0])}" if figure.when else f"in plot {figure.name}"
    options.takes_only(context, asked, *_ALWAYS, *_options_of(figure))
    if given.levels is None and "levels" in figure.takes:
        options.refuse_idle(context, "without --levels", *OF_FILE)


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


def _size(text: str | None) -> Sequence[float] | None:
    """Return the width and, if it is given, the height from --size."""
    if text is None:
        return None
    try:
        return [*map(real, text.split("x"))]
    except ValueError:
        raise InputError(f"size {text!r:.40}: give {SIZES}, such as 3.39 or 6.4x4.8") from None
