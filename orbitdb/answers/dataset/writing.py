"""Write a dataset: the tables, ``datapackage.json``, a README and the licence. Same catalogue, same bytes."""

import json
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from orbitdb import __version__
from orbitdb.answers.dataset.checking import PACKAGE, read_package, sha256
from orbitdb.answers.dataset.tables import ORBITS, Table, tables
from orbitdb.column_files import write_columns, write_parquet
from orbitdb.errors import ExportError, StoreError
from orbitdb.export import write_csv
from orbitdb.numerals import exact
from orbitdb.progress import Tell, nobody
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import run
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.rows import Chosen

Resource = dict[str, Any]
"""A file, described in the words of the standard."""

_LICENCE = {
    "name": "CC-BY-4.0",
    "title": "Creative Commons Attribution 4.0",
    "path": "https://creativecommons.org/licenses/by/4.0/",
}
_TYPES = {"text": "string", "numbers": "any"}
"""The standard's types of the kinds of columns that it names otherwise; its arrays are JSON."""

_OF_FILE, _OF_WORD, _OF_BOUNCE = 8_000, 20, 4
"""Bytes that a file, a word and one of its bounces take at most."""


def write_dataset(
    moment: Moment, folder: Path, chosen: Sequence[Selection], force: bool = False, tell: Tell = nobody
) -> str:
    """Write a dataset; return what it holds in words, or nothing if no word of a whole period is chosen.

    Parameters
    ----------
    moment : Moment
    folder : Path
        It appears when it is complete.
    chosen : sequence of Selection
        One for each a, otherwise alike. They choose periods, and words among the orbits; counts, averages,
        bounds and levels are of all orbits.
    force : bool, optional
        Replace a dataset.
    tell : callable, optional
        Gets progress.

    Raises
    ------
    ExportError
        If the folder exists.
    StoreError
        If the disk has too little room, or the folder cannot be written.
    """
    whole = [(each, fill) for each in chosen for fill in moment.fills(each.a) if fill.whole]
    whole = [(each, fill) for each, fill in whole if each.includes(fill.p)]
    subsets = [moment.choose(replace(each, periods=((fill.p, fill.p),))) for each, fill in whole]
    if not (total := sum(map(len, subsets))):
        return ""
    _check_target(folder, force)
    _check_room(folder, subsets)
    selection = chosen[0].describe(sorted({each.a for each, _ in whole}), total)
    found, done = list[Resource](), 0
    with _replacing(folder.resolve()) as draft:
        for subset, (each, fill) in zip(subsets, whole, strict=True):
            tell(done, total, f"orbits at a = {exact(each.a)}, p = {fill.p}")
            found.append(_orbits(moment, draft, subset) | {"complete": len(subset) == fill.words})
            done += len(subset)
        found += _tables(draft, tables(moment, chosen, {fill.p for _, fill in whole}))
        found += _texts(draft, selection)
        described = json.dumps(_package(moment, selection, found), indent=1) + "\n"
        (draft / PACKAGE).write_text(described, encoding="utf-8")
    return selection


def _orbits(moment: Moment, draft: Path, subset: Chosen) -> Resource:
    """Write the chosen words of one a and period, in the order of class and element."""
    a, ((p, _),) = subset.selection.a, subset.selection.periods
    title = subset.selection.describe(count=len(subset))
    made = Table(f"orbits/a={exact(a)}_p={p:02d}.parquet", title, ORBITS, ())
    path = draft / made.path
    path.parent.mkdir(exist_ok=True)
    with open(path, "wb") as file:
        blocks = (block.columns for block in moment.blocks(subset, made.names))
        rows = write_columns(file, made.names, blocks, {}, "zstd")
    return _described(path, made, rows) | {"name": f"orbits-a-{exact(a).lower()}-p-{p:02d}"}


def _tables(draft: Path, wanted: Sequence[Table]) -> Iterator[Resource]:
    """Write the other tables, except those without rows."""
    for made in wanted:
        path = draft / made.path
        if path.suffix == ".parquet":
            with open(path, "wb") as binary:
                rows = write_parquet(binary, made.names, made.rows, {}, "zstd")
        else:
            with open(path, "w", encoding="utf-8", newline="") as text:
                rows = write_csv(text, made.names, made.rows)
        if rows:
            yield _described(path, made, rows)
        else:
            path.unlink()


def _texts(draft: Path, selection: str) -> Iterator[Resource]:
    """Write the README and the licence."""
    for name in ("README.md", "LICENSE.txt"):
        text = (files(__package__) / name).read_text(encoding="utf-8")
        for mark, value in (("SELECTION", selection), ("VERSION", __version__)):
            text = text.replace(f"@{mark}@", value)
        (draft / name).write_text(text, encoding="utf-8")
        yield _file(draft / name, name) | {"name": name.partition(".")[0].lower()}


def _file(path: Path, name: str) -> Resource:
    return {
        "path": name,
        "format": path.suffix[1:],
        "hash": f"sha256:{sha256(path)}",
    }


def _described(path: Path, made: Table, rows: int) -> Resource:
    """Return a written table with the meaning, unit and error bound of each column."""
    columns = []
    for each in made.columns:
        told = {"description": each.means, "unit": each.unit, "bound": each.bound}
        told["empty"] = each.empty if each.empty != "never" else ""
        kind = {"name": each.name, "type": _TYPES.get(each.kind, each.kind)}
        columns.append(kind | {key: text for key, text in told.items() if text})
    known = {"name": path.stem, "title": made.title, "rows": rows, "schema": {"fields": columns}}
    return _file(path, made.path) | known


def _package(moment: Moment, selection: str, found: Sequence[Resource]) -> dict[str, Any]:
    """Return the contents of ``datapackage.json``."""
    runs = moment.connection.execute(sa.select(run.c.version, run.c.parameters).order_by(run.c.id))
    made = [{"orbitdb": version} | json.loads(parameters) for version, parameters in runs]
    for each in made:
        each.pop("commits", None)
    return {
        "profile": "data-package",
        "name": "stadium-orbits",
        "title": "Periodic orbits of the stadium billiard",
        "description": selection,
        "version": __version__,
        "licenses": [_LICENCE],
        "sources": [{"title": "O. Biham and M. Kvale, Phys. Rev. A 46, 6334 (1992)"}],
        "contributors": [{"title": f"orbitdb {__version__}", "role": "author"}],
        "made_by": made,
        "resources": found,
    }


def _check_target(folder: Path, force: bool) -> None:
    """Refuse a folder that exists, unless it is a dataset that may be replaced."""
    parent = folder.resolve().parent
    if not parent.is_dir():
        raise StoreError(f"there is no folder {parent}: make it first")
    if folder.exists():
        if not force:
            raise ExportError(f"{folder} already exists: --force replaces a dataset")
        read_package(folder)


def _check_room(folder: Path, subsets: Sequence[Chosen]) -> None:
    """Refuse a disk without room for the most that words and files have been seen to take."""
    need = 0
    for subset in subsets:
        ((p, _),) = subset.selection.periods
        need += _OF_FILE + len(subset) * (_OF_WORD + _OF_BOUNCE * p)
    if (free := shutil.disk_usage(folder.resolve().parent).free) < need:
        raise StoreError(
            f"no room for {folder}: it takes up to {need / 1e6:.1f} MB, and {free / 1e6:.1f} MB is free"
        )


@contextmanager
def _replacing(folder: Path) -> Iterator[Path]:
    """Give a temporary folder; put it in place at the end, or remove it after a failure."""
    draft, before = (folder.with_name(f".{folder.name}.{os.getpid()}.{end}") for end in ("part", "old"))
    try:
        draft.mkdir()
        yield draft
        if folder.exists():
            os.rename(folder, before)
        os.rename(draft, folder)
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be written ({error.strerror or error}); nothing was kept"
        ) from error
    finally:
        if before.exists() and not folder.exists():
            os.rename(before, folder)
        for rest in (draft, before):
            shutil.rmtree(rest, ignore_errors=True)
