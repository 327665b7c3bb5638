"""Export what is on the screen: rows as csv, tsv, json, jsonl or parquet, pictures and curves as figures."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from textual.message import Message

from orbitdb.answers.completeness import describe_partial, partial_fills
from orbitdb.answers.export import TEXT_WRITERS, complete, write_file
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.output import code_text
from orbitdb.cli.reading import provenance
from orbitdb.cli.tui.dialogs import LineDialog
from orbitdb.cli.tui.screens import Working
from orbitdb.cli.tui.view import Ordering
from orbitdb.columns import WRITTEN
from orbitdb.errors import InputError
from orbitdb.extras import load
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots.svg import orbit_svg
from orbitdb.store.file import Reader
from orbitdb.store.query import choose
from orbitdb.store.rows import rows_of
from orbitdb.store.selection import Selection
from orbitdb.store.where import never
from orbitdb.text import exact

ROWS = (".csv", ".tsv", ".json", ".jsonl", ".parquet")
PICTURES = (".svg", ".png", ".pdf")
_WIDTH = 800

Write = Callable[[Path, Callable[[], bool]], str]
"""Writes a file unless it is cancelled, and returns a message that says what was written."""


@dataclass
class Export(Message):
    """Asks the application to write a file; `write` gets a function that tells whether to stop."""

    path: Path
    write: Callable[[Callable[[], bool]], str]


def path_of(name: str) -> Path:
    """Return the path for a typed file name, in which ~ stands for the home folder."""
    return Path(os.path.expanduser(name))


class Shown(NamedTuple):
    """What the main screen shows: rows in some order, and an orbit, in its stadium or in phase space."""

    catalogue: Reader | None
    selection: Selection
    ordering: Ordering
    orbit: Orbit | None
    in_phase_space: bool = False


def ask_for_shown(screen: Working, shown: Shown, of_rows: bool) -> None:
    """Ask for a file to export to; propose a name for the rows if `of_rows`, otherwise for the orbit."""
    orbit = shown.orbit
    name = "orbits.csv" if orbit is None or of_rows else f"{orbit.code[:40]}.svg"
    figure = "the bounces in phase space" if shown.in_phase_space else "the orbit in its stadium"
    ask_for_file(screen, name, partial(export, shown), figure, rows=True)


def ask_for_file(screen: Working, name: str, write: Write, figure: str, rows: bool = False) -> None:
    """Ask for a file, and have it written by `write`.

    The file shows a figure, which `figure` describes to the user; with `rows`, it can contain rows instead.
    """

    def take(name: str) -> None:
        path = path_of(name).absolute()
        screen.app.post_message(Export(path, partial(write, path)))

    def check(name: str) -> str:
        return describe_file(name, figure, rows)

    example = "orbits.csv, .parquet .." if rows else "figure.png, .svg, .pdf"
    screen.ask(LineDialog("export to a file", name, example, check), take)


def describe_file(name: str, figure: str = "the orbit in its stadium", rows: bool = True) -> str:
    """Return a message that says what a file of this name will contain; raise if its ending is unknown."""
    path, endings = path_of(name), (*(ROWS if rows else ()), *PICTURES)
    if path.suffix not in endings:
        raise InputError(f"{path.name}: end the name in {', '.join(endings)}")
    content = "the chosen rows, in full precision" if path.suffix in ROWS else figure
    return f"{path} exists and will be replaced: {content}" if os.path.exists(path) else content


def export(shown: Shown, path: Path, cancelled: Callable[[], bool] = never) -> str:
    """Write the rows, or a drawing if the file is a picture; return a message that says what was written.

    Once `cancelled` returns True, writing stops and leaves no file.
    """
    describe_file(str(path))
    catalogue, selection, ordering, orbit, in_phase_space = shown
    if path.suffix in PICTURES:
        return _draw(path, orbit, in_phase_space)
    if catalogue is None:
        raise InputError("there are no rows to write")
    with catalogue.moment() as moment:
        chosen = choose(moment.connection, selection, str(ordering), cancelled=cancelled)
        rows = rows_of(moment.connection, chosen, WRITTEN, cancelled=cancelled)
        if path.suffix == ".parquet":
            write_file(path, "parquet", WRITTEN, rows, provenance(moment, [selection], False))
        else:
            with complete(path) as draft, draft.open("w", encoding="utf-8", newline="") as file:
                TEXT_WRITERS[path.suffix[1:]](file, WRITTEN, rows)
        said = f"{len(chosen):,} rows written to {path}"
        partial = partial_fills(moment, selection)
    return f"{said}; {describe_partial(partial, selection.a)}" if partial else said


def _draw(path: Path, orbit: Orbit | None, in_phase_space: bool) -> str:
    """Draw an orbit in phase space or in its stadium; the latter needs no matplotlib for SVG."""
    if orbit is None or orbit.points is None:
        raise InputError("there is no orbit to draw")
    if in_phase_space:
        return save_figure(path, lambda figures: figures.draw_phase([orbit]))
    if path.suffix != ".svg":
        return save_figure(path, lambda figures: figures.draw_orbit(orbit))
    code = code_text(orbit.code)
    title = f"The orbit {code} at a = {exact(orbit.a)}"
    with complete(path) as draft:
        drawn = orbit_svg(Stadium(orbit.a), orbit.points, title, _WIDTH)
        draft.write_text(drawn + "\n", encoding="utf-8")
    return f"{code} drawn in {path}"


def save_figure(path: Path, draw: Callable[[Any], Any]) -> str:
    """Save the figure that `draw` makes with `orbitdb.cli.figures.orbits`; return a message about it."""
    style = load("orbitdb.plots.style", "a figure", "plot")
    made = draw(load("orbitdb.cli.figures.orbits", "a figure", "plot"))
    said = str(made.get_label())
    with complete(path) as draft:
        style.save(made, draft, path.suffix[1:], said)
    return f"{said} drawn in {path}"
