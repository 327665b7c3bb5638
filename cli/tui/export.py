"""Taking away what is shown: the rows as csv, tsv, json or jsonl, the orbit as SVG or PNG."""

from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import code_text
from orbitdb.cli.rows import KEYS, with_rules
from orbitdb.cli.tui.source import Ordering
from orbitdb.errors import InputError
from orbitdb.export import complete, json_object, write_csv, write_jsonl
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.svg import orbit_svg
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.fills import describe_partial

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue

ROWS = {".csv": ",", ".tsv": "\t", ".json": "", ".jsonl": ""}
PICTURES = (".svg", ".png")
_WIDTH = 800


def kind_of(path: Path) -> str:
    """Say what a file of this name will hold.

    Raises
    ------
    InputError
        If its ending is not known.
    """
    if path.suffix in ROWS:
        return "the chosen rows, in full precision"
    if path.suffix in PICTURES:
        return "the orbit in its stadium"
    raise InputError(f"{path.name}: end the name in {', '.join((*ROWS, *PICTURES))}")


def export(
    path: Path,
    catalogue: "Catalogue | None",
    selection: Selection,
    ordering: Ordering,
    orbit: Orbit | None,
) -> str:
    """Write a file, and say what was written.

    Raises
    ------
    InputError
        If its ending is not known, or there is nothing of the kind to write.
    """
    kind_of(path)
    if path.suffix in ROWS:
        if catalogue is None:
            raise InputError("there are no rows to write")
        with (
            catalogue.at_one_moment() as still,
            complete(path) as draft,
            draft.open("w", encoding="utf-8", newline="") as file,
        ):
            count = _write_rows(file, path.suffix, still, selection, ordering)
            partial = still.partial(selection)
        said = f"{count:,} rows written to {path}"
        return f"{said}; {describe_partial(partial, selection.a)}" if partial else said
    if orbit is None or orbit.points is None:
        raise InputError("there is no orbit to draw")
    with complete(path) as draft:
        _draw(
            draft, path.suffix, orbit, orbit.points, f"The orbit {code_text(orbit.code)} at a = {orbit.a:g}"
        )
    return f"{code_text(orbit.code)} drawn in {path}"


def _draw(path: Path, suffix: str, orbit: Orbit, points: NDArray[np.float64], title: str) -> None:
    if suffix == ".svg":
        path.write_text(orbit_svg(Stadium(orbit.a), points, title, _WIDTH) + "\n", encoding="utf-8")
        return
    try:
        from orbitdb.cli import figures
        from orbitdb.plots import style
    except ImportError:
        raise InputError("PNG needs matplotlib: install orbitdb[plot], or write an .svg") from None
    style.save(figures.draw_orbit(orbit), path, "png", title)


def _write_rows(
    file: TextIO, suffix: str, catalogue: "Catalogue", selection: Selection, ordering: Ordering
) -> int:
    order = f"{ordering.column} {'desc' if ordering.descending else 'asc'}"
    rows = with_rules(KEYS, catalogue.rows(selection, KEYS, order))
    if ROWS[suffix]:
        return write_csv(file, KEYS, rows, ROWS[suffix])
    if suffix == ".jsonl":
        return write_jsonl(file, KEYS, rows)
    count = 0
    file.write("[\n")
    for row in rows:
        file.write((",\n" if count else "") + json_object(KEYS, row))
        count += 1
    file.write("\n]\n")
    return count
