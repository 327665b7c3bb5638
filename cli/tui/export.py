"""Taking away what is shown: the rows as csv, tsv, json, jsonl or parquet, the orbit as SVG or PNG."""

from collections.abc import Callable, Iterable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np
from numpy.typing import NDArray

from orbitdb import __version__
from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.gaps import describe_partial
from orbitdb.cli.render import code_text
from orbitdb.cli.rows import KEYS
from orbitdb.cli.tui.table.source import Ordering
from orbitdb.errors import InputError
from orbitdb.export import complete, json_object, write_csv, write_file, write_jsonl
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.svg import orbit_svg
from orbitdb.store.asking.confinement import never
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue

_DELIMITERS = {".csv": ",", ".tsv": "\t"}
ROWS = (*_DELIMITERS, ".json", ".jsonl", ".parquet")
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
    cancelled: Callable[[], bool] = never,
) -> str:
    """Write a file, and say what was written.

    Parameters
    ----------
    path : Path
    catalogue : Catalogue or None
    selection : Selection
    ordering : Ordering
    orbit : Orbit or None
        What is drawn, if the file is a picture.
    cancelled : callable, optional
        Asked now and then whether to stop, so that nothing is left of the file.

    Raises
    ------
    InputError
        If its ending is not known, or there is nothing of the kind to write.
    """
    kind_of(path)
    if path.suffix in ROWS:
        if catalogue is None:
            raise InputError("there are no rows to write")
        with catalogue.at_one_moment() as still:
            partial = still.partial(selection)
            count = _write(path, still, selection, ordering, cancelled)
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
        from orbitdb.cli.figures.orbits import draw_orbit
        from orbitdb.plots import style
    except ImportError:
        raise InputError("PNG needs matplotlib: install orbitdb[plot], or write an .svg") from None
    style.save(draw_orbit(orbit), path, "png", title)


def _write(
    path: Path,
    catalogue: "Catalogue",
    selection: Selection,
    ordering: Ordering,
    cancelled: Callable[[], bool],
) -> int:
    """Write the rows in their order to a file, and return how many they are."""
    rows = catalogue.rows(selection, KEYS, str(ordering), cancelled=cancelled)
    if path.suffix == ".parquet":
        return _write_parquet(path, catalogue, selection, rows)
    with complete(path) as draft, draft.open("w", encoding="utf-8", newline="") as file:
        if path.suffix in _DELIMITERS:
            return write_csv(file, KEYS, rows, _DELIMITERS[path.suffix])
        return (write_jsonl if path.suffix == ".jsonl" else _write_json)(file, KEYS, rows)


def _write_parquet(
    path: Path, catalogue: "Catalogue", selection: Selection, rows: Iterable[tuple[Any, ...]]
) -> int:
    """Write rows with where they come from, as `orbitdb export` does, and return how many they are."""
    count = 0

    def counted() -> Iterator[tuple[Any, ...]]:
        nonlocal count
        for row in rows:
            count += 1
            yield row

    provenance = {
        "orbitdb": __version__,
        "selection": selection.describe(),
        "a": selection.a,
        "database": str(catalogue.path.resolve()),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "partial": [fill.p for fill in catalogue.partial(selection)],
    }
    try:
        write_file(path, "parquet", KEYS, counted(), provenance)
    except ModuleNotFoundError:
        raise InputError("parquet needs pyarrow: install orbitdb[parquet], or write a .csv") from None
    return count


def _write_json(file: TextIO, names: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> int:
    count = 0
    file.write("[\n")
    for row in rows:
        file.write((",\n" if count else "") + json_object(names, row))
        count += 1
    file.write("\n]\n")
    return count
