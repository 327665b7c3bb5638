"""Taking away what is shown: the rows as csv, tsv, json or jsonl, the orbit as SVG or PNG."""

from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from orbitdb.cli.query import KEYS, with_rules
from orbitdb.cli.tui.pictures import path_of
from orbitdb.cli.tui.source import Ordering
from orbitdb.errors import InputError
from orbitdb.export import complete, json_object, write_csv, write_jsonl
from orbitdb.orbits import Orbit
from orbitdb.selection import Selection
from orbitdb.stadium import Stadium

if TYPE_CHECKING:
    from orbitdb.store.catalogue import Catalogue

ROWS = {".csv": ",", ".tsv": "\t", ".json": "", ".jsonl": ""}
PICTURES = (".svg", ".png")


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
        with complete(path) as draft, draft.open("w", encoding="utf-8", newline="") as file:
            count = _write_rows(file, path.suffix, catalogue, selection, ordering)
        return f"{count:,} rows written to {path}"
    if orbit is None or orbit.coordinates is None:
        raise InputError("there is no orbit to draw")
    with complete(path) as draft:
        if path.suffix == ".svg":
            draft.write_text(as_svg(orbit), encoding="utf-8")
        else:
            _write_png(draft, orbit)
    return f"{orbit.code} drawn in {path}"


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


def as_svg(orbit: Orbit, width: int = 800) -> str:
    """Return an orbit in its stadium as an SVG picture."""
    a = Stadium(orbit.a).a
    scale = width / (2 * a + 2.2)
    height = round(2.2 * scale)
    wall = f"M {-a} 1 L {a} 1 A 1 1 0 0 0 {a} -1 L {-a} -1 A 1 1 0 0 0 {-a} 1 Z"
    points = " ".join(f"{x:.6f},{-y:.6f}" for x, y in path_of(orbit))
    start = path_of(orbit)[0]
    line = 1.5 / scale
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
        f' viewBox="{-a - 1.1} -1.1 {2 * a + 2.2} 2.2" fill="none" stroke-width="{line:.6f}">\n'
        f"  <title>{orbit.code} at a = {orbit.a:g}</title>\n"
        f'  <path d="{wall}" stroke="#334155"/>\n'
        f'  <polyline points="{points}" stroke="#c2410c"/>\n'
        f'  <circle cx="{start[0]:.6f}" cy="{-start[1]:.6f}" r="{3 * line:.6f}" fill="#15803d"/>\n'
        "</svg>\n"
    )


def _write_png(path: Path, orbit: Orbit) -> None:
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("PNG needs matplotlib: install orbitdb[plot], or write an .svg") from None
    a = orbit.a
    figure = Figure(figsize=(8, 8 * 2.2 / (2 * a + 2.2)))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.plot(*Stadium(a).outline(200).T, color="#334155", linewidth=1.2)
    axes.plot(*path_of(orbit).T, color="#c2410c", linewidth=1.2)
    figure.savefig(path, format="png", dpi=200)
