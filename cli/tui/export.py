"""Export what is on the screen: rows as csv, tsv, json, jsonl or parquet, pictures and curves as figures."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from textual.message import Message

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue import Catalogue
from orbitdb.cli.output import code_text
from orbitdb.cli.tui.dialogs import LineDialog
from orbitdb.cli.tui.panels.filter_bar import View
from orbitdb.cli.tui.screens import Working
from orbitdb.columns import WRITTEN
from orbitdb.display import load
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit
from orbitdb.output_files import FIGURES, FORMATS, atomic_file
from orbitdb.plots.registry import load_function
from orbitdb.svg import orbit_svg
from orbitdb.text import format_float

_WIDTH = 800

Write = Callable[[Path, Callable[[], bool]], str]
"""Writes a file unless it is cancelled, and returns a message that says what was written."""


@dataclass
class Export(Message):
    """Asks the application to write a file; `write` gets a function that tells whether to stop."""

    path: Path
    write: Callable[[Callable[[], bool]], str]


def ask_for_file(
    screen: Working, name: str, figure: str, draw: Callable[[Path], str], rows: Write | None = None
) -> None:
    """Ask for a file, proposing a name, and have it written: a figure by `draw`, or rows by `rows` if given.

    `figure` describes the figure to the user.
    """
    endings = (*(FORMATS if rows else ()), *FIGURES)

    def path_of(name: str) -> Path:
        path = Path(os.path.expanduser(name))
        if path.suffix[1:] not in endings:
            raise InputError(f"{path.name}: end the name in .{', .'.join(endings)}")
        return path

    def check(name: str) -> str:
        path = path_of(name)
        content = figure if path.suffix[1:] in FIGURES else "the chosen rows, in full precision"
        return f"{path} exists and will be replaced: {content}" if path.exists() else content

    def take(name: str) -> None:
        path = path_of(name).absolute()
        if rows is None or path.suffix[1:] in FIGURES:
            screen.app.post_message(Export(path, lambda _: draw(path)))
        else:
            screen.app.post_message(Export(path, partial(rows, path)))

    example = "orbits.csv, .parquet .." if rows else "figure.png, .svg, .pdf"
    screen.ask(LineDialog("export to a file", name, example, check), take)


def write_rows(catalogue: Catalogue, view: View, path: Path, cancelled: Callable[[], bool]) -> str:
    """Write the rows of a view; once `cancelled` returns True, writing stops and leaves no file."""
    if catalogue.missing:
        raise InputError("there are no rows to write")
    columns = (*WRITTEN, *["words"] * view.by_class)
    with catalogue.snapshot(cancelled) as then:
        listing = then.rows(view.selection, columns=columns, order=str(view.ordering), classes=view.by_class)
        count = listing.write(path, force=True)
        return "; ".join([f"{count:,} rows written to {path}", *listing.gaps])


def save_orbit(orbit: Orbit | None, in_phase_space: bool, path: Path) -> str:
    """Draw an orbit in phase space or in its stadium; the latter needs no matplotlib for SVG."""
    if orbit is None or orbit.points is None:
        raise InputError("there is no orbit to draw")
    if in_phase_space:
        return save_figure("phase_space.phase_space_of", [orbit], path)
    if path.suffix != ".svg":
        return save_figure("orbits.orbit", [orbit], path)
    code = code_text(orbit.code)
    title = f"The orbit {code} at a = {format_float(orbit.a)}"
    with atomic_file(path) as draft:
        drawn = orbit_svg(Stadium(orbit.a), orbit.points, orbit.code, title, _WIDTH)
        draft.write_text(drawn + "\n", encoding="utf-8")
    return f"{code} drawn in {path}"


def save_figure(name: str, arguments: Sequence[Any], path: Path) -> str:
    """Save the figure that a function of `orbitdb.plots` draws, ``module.function``; return a message."""
    style = load("orbitdb.plots.style", "a figure", "plot")
    figure = load_function(name)(*arguments)
    title = str(figure.get_label())
    with atomic_file(path) as draft:
        style.save(figure, draft, path.suffix[1:], title)
    return f"{title} drawn in {path}"
