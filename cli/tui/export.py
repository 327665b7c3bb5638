"""Taking away what is shown: the rows as csv, tsv, json, jsonl or parquet, the orbit as SVG or PNG."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from orbitdb.answers.gaps import describe_partial, partial_fills
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.reading import KEYS, provenance
from orbitdb.cli.render import Format, code_text, write_data
from orbitdb.cli.tui.table.pages import Ordering
from orbitdb.errors import InputError
from orbitdb.export import complete, write_file
from orbitdb.extras import load
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.svg import orbit_svg
from orbitdb.store.asking.confinement import never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Reader

ROWS = (".csv", ".tsv", ".json", ".jsonl", ".parquet")
PICTURES = (".svg", ".png")
_WIDTH = 800


def path_of(name: str) -> Path:
    """Return the file of a name that is typed, in which ~ is the home folder."""
    return Path(os.path.expanduser(name))


def kind_told(name: str) -> str:
    """Say what a file of this name will hold, or which endings are known."""
    path = path_of(name)
    if path.suffix not in (*ROWS, *PICTURES):
        raise InputError(f"{path.name}: end the name in {', '.join((*ROWS, *PICTURES))}")
    told = "the chosen rows, in full precision" if path.suffix in ROWS else "the orbit in its stadium"
    return f"{path} exists and will be replaced: {told}" if os.path.exists(path) else told


def export(
    path: Path,
    catalogue: Reader | None,
    selection: Selection,
    ordering: Ordering,
    orbit: Orbit | None,
    cancelled: Callable[[], bool] = never,
) -> str:
    """Write the rows, or the orbit if the file is a picture, and say what was written.

    ``cancelled`` is asked now and then whether to stop, so that nothing is left of the file.
    """
    kind_told(str(path))
    if path.suffix in PICTURES:
        return _draw(path, orbit)
    if catalogue is None:
        raise InputError("there are no rows to write")
    with catalogue.moment() as moment:
        rows = moment.rows(selection, KEYS, str(ordering), cancelled=cancelled)
        if path.suffix == ".parquet":
            with _or_write("a .csv"):
                write_file(path, "parquet", KEYS, rows, provenance(moment, [selection], False))
        else:
            with complete(path) as draft, draft.open("w", encoding="utf-8", newline="") as file:
                write_data(file, KEYS, rows, Format(path.suffix[1:]))
        said = f"{moment.count(selection):,} rows written to {path}"
        partial = partial_fills(moment, selection)
    return f"{said}; {describe_partial(partial, selection.a)}" if partial else said


@contextmanager
def _or_write(other: str) -> Iterator[None]:
    """Name another ending where what is needed for this one is not installed."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise InputError(f"{error}, or write {other}") from None


def _draw(path: Path, orbit: Orbit | None) -> str:
    if orbit is None or orbit.points is None:
        raise InputError("there is no orbit to draw")
    code = code_text(orbit.code)
    title = f"The orbit {code} at a = {exact(orbit.a)}"
    with complete(path) as draft:
        if path.suffix == ".svg":
            drawn = orbit_svg(Stadium(orbit.a), orbit.points, title, _WIDTH)
            draft.write_text(drawn + "\n", encoding="utf-8")
        else:
            with _or_write("an .svg"):
                style = load("orbitdb.plots.style", "PNG", "plot")
            from orbitdb.cli.figures.orbits import draw_orbit

            style.save(draw_orbit(orbit), draft, "png", title)
    return f"{code} drawn in {path}"
