"""A catalogue as a dataset: tables for any tool, described by the Frictionless standard.

The folder holds orbits in Parquet, one file for each a and whole period; everything else in csv;
``datapackage.json``, which describes each column and has the sha256 sum of each file; and a README. The same
catalogue gives the same bytes. The folder is written under a temporary name and renamed when complete.
"""

import csv
import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, NamedTuple

import sqlalchemy as sa

from orbitdb import __version__
from orbitdb.answers.entropy import table
from orbitdb.answers.lyapunov import lyapunov
from orbitdb.answers.spectrum import stored_levels
from orbitdb.column_files import write_parquet
from orbitdb.columns import EVERY, WRITTEN, kind_of
from orbitdb.errors import ExportError, StoreError
from orbitdb.numerals import exact
from orbitdb.plaintext import cell
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.amplitudes import Parity
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file import tables
from orbitdb.store.reading.lives import Life
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.rows import COORDINATES

PACKAGE = "datapackage.json"
ORBITS = (*(name for name in WRITTEN if name not in ("a", "rules")), COORDINATES)
"""The columns of orbits."""

_BYTES = 60
"""Rough upper bound on the bytes of a word with coordinates in Parquet; 27 at p = 13."""
_LICENCE = {
    "name": "CC-BY-4.0",
    "title": "Creative Commons Attribution 4.0",
    "path": "https://creativecommons.org/licenses/by/4.0/",
}
_TYPES = {"text": "string", "integer": "integer", "number": "number", "numbers": "any", "integers": "any"}
_README = """\
# Periodic orbits of the stadium billiard

Made by orbitdb {version}. Licence of the data: CC BY 4.0. Please cite orbitdb, and O. Biham and M. Kvale,
Phys. Rev. A 46, 6334 (1992), whose method of symbols and pruning this follows.

* `orbits/`: every word of each whole period, one Parquet file for each half length a and period p.
* `counts.csv`: words and orbits by period, the columns of the paper's Table 1.
* `averages.csv`: Lyapunov averages by period.
* `births.csv`: the a at which each class begins and ceases to be an orbit.
* `bounds.csv`: proved bounds on the topological entropy; `levels.csv`: quantum levels with estimated errors.
* `datapackage.json`: what each column is, its unit, what bounds its error, and the sha256 sum of each file.

Every status is proved. `length_error` and `lyapunov_error` bound the errors of length and lambda, `error`
that of each coordinate. `orbitdb verify FOLDER` checks the sums and counts.

* Python: `pandas.read_parquet("orbits")`
* DuckDB: `SELECT * FROM 'orbits/*.parquet'`
* R: `arrow::open_dataset("orbits")`
* Julia: `using Parquet2, DataFrames; DataFrame(Parquet2.Dataset("orbits"))`
* Mathematica: `Import["orbits/a=1.6_p=05.parquet"]`
"""


class Resource(NamedTuple):
    """A file of a dataset: its name, columns and number of rows."""

    path: str
    columns: tuple[str, ...]
    rows: int


def write_dataset(moment: Moment, folder: Path, values: Sequence[float], tell: Tell = nobody) -> int:
    """Write a dataset of the stadiums with some a; return the number of its files.

    Raises
    ------
    ExportError
        If the folder exists, or there is no whole period to write.
    StoreError
        If the disk has too little room, or the folder cannot be written.
    """
    whole = [(a, fill) for a in values for fill in moment.fills(a) if fill.whole]
    if not whole:
        raise ExportError("no whole period is filled: 'orbitdb fill --p 11' fills some")
    words = sum(fill.words for _, fill in whole)
    _check_room(folder, words)
    with _complete(folder) as draft:
        (draft / "orbits").mkdir()
        found, done = [], 0
        for a, fill in whole:
            tell(done, words, f"orbits at a = {exact(a)}, p = {fill.p}")
            path = f"orbits/a={exact(a)}_p={fill.p:02d}.parquet"
            counted = _Counted(moment.rows(Selection(a, ((fill.p, fill.p),)), ORBITS))
            with open(draft / path, "wb") as file:
                write_parquet(file, ORBITS, counted, {"a": a, "p": fill.p}, compression="zstd")
            found.append(Resource(path, ORBITS, counted.count))
            done += fill.words
        for name, columns, rows in _others(moment, values):
            counted = _Counted(rows)
            with open(draft / name, "w", encoding="utf-8", newline="") as text:
                writer = csv.writer(text, lineterminator="\n")
                writer.writerow(columns)
                writer.writerows(list(map(cell, row)) for row in counted)
            if counted.count:
                found.append(Resource(name, tuple(columns), counted.count))
            else:
                (draft / name).unlink()
        (draft / "README.md").write_text(_README.format(version=__version__), encoding="utf-8")
        described = json.dumps(_package(moment, draft, found), indent=1) + "\n"
        (draft / PACKAGE).write_text(described, encoding="utf-8")
    return len(found) + 2


class _Counted:
    """Counts rows as they are read."""

    def __init__(self, rows: Iterable[Sequence[Any]]) -> None:
        self.rows, self.count = rows, 0

    def __iter__(self) -> Iterator[Sequence[Any]]:
        for row in self.rows:
            self.count += 1
            yield row


def _others(moment: Moment, values: Sequence[float]) -> Iterator[tuple[str, Sequence[str], Iterable[Any]]]:
    """Yield the name, columns and rows of each csv table."""
    for name, ask in (("counts", table), ("averages", lyapunov)):
        found = [(a, ask(moment, Selection(a))) for a in values]
        columns = next((list(each.columns) for _, each in found if len(each)), [])
        rows = [(a, *row) for a, each in found if len(each) for row in each.rows(columns)]
        yield f"{name}.csv", ("a", *columns), rows
    whole = [each.p for each in moment.birth_fills() if each.whole]
    names = [each.name for each in fields(Life)]
    yield "births.csv", names, (astuple(life) for p in whole for life in moment.births(p))
    bounds = [each for each in moment.entropy_curve() if each.a in values]
    yield (
        "bounds.csv",
        ("a", "window", "lower", "upper", "windows", "undecided", "proof"),
        [astuple(each) for each in bounds],
    )
    levels = (
        (a, str(parity), window.below + n, k, error)
        for a in values
        for parity in Parity
        for window in stored_levels(moment.connection, a, parity)
        for n, (k, error) in enumerate(zip(window.k.tolist(), window.error.tolist(), strict=True), 1)
    )
    yield "levels.csv", ("a", "parity", "number", "k", "error"), levels


def _package(moment: Moment, folder: Path, found: Sequence[Resource]) -> dict[str, Any]:
    """Return the contents of `datapackage.json`."""
    runs = sa.select(tables.run.c.version, tables.run.c.parameters).order_by(tables.run.c.id)
    made = [
        {"orbitdb": version, **json.loads(parameters)}
        for version, parameters in moment.connection.execute(runs)
    ]
    for each in made:
        each.pop("commits", None)
    return {
        "profile": "data-package",
        "name": "stadium-orbits",
        "title": "Periodic orbits of the stadium billiard",
        "version": __version__,
        "licenses": [_LICENCE],
        "sources": [{"title": "O. Biham and M. Kvale, Phys. Rev. A 46, 6334 (1992)"}],
        "contributors": [{"title": f"orbitdb {__version__}", "role": "author"}],
        "made_by": made,
        "resources": [_resource(folder, each) for each in found],
    }


def _resource(folder: Path, of: Resource) -> dict[str, Any]:
    path = folder / of.path
    columns = []
    for name in of.columns:
        told = {"name": name, "type": "string" if name == "proof" else _TYPES[kind_of(name)]}
        if name in EVERY:
            told |= {"description": EVERY[name].means, "unit": EVERY[name].unit, "bound": EVERY[name].bound}
        columns.append({key: value for key, value in told.items() if value})
    name = of.path.removeprefix("orbits/").rpartition(".")[0].replace("=", "-").replace("_", "-").lower()
    return {
        "name": f"orbits-{name}" if of.path.startswith("orbits/") else name,
        "path": of.path,
        "format": path.suffix.lstrip("."),
        "rows": of.rows,
        "hash": f"sha256:{_sum(path)}",
        "schema": {"fields": columns},
    }


def _sum(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def wrong_files(folder: Path) -> Iterator[tuple[str, str | None]]:
    """Yield each file of a dataset with its fault, or None.

    Raises
    ------
    ExportError
        If the folder holds no dataset.
    """
    try:
        found = json.loads((folder / PACKAGE).read_text(encoding="utf-8"))
        resources = [(each["path"], each["hash"], each["rows"]) for each in found["resources"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ExportError(f"{folder} holds no dataset of orbitdb: it lacks a sound {PACKAGE}") from error
    for name, stated, rows in resources:
        path = folder / name
        if not path.resolve().is_relative_to(folder.resolve()) or not path.is_file():
            yield name, "is missing"
        elif stated != f"sha256:{_sum(path)}":
            yield name, "differs from its sha256 sum"
        elif (count := _rows_in(path)) is not None and count != rows:
            yield name, f"has {count} rows, not {rows}"
        else:
            yield name, None


def _rows_in(path: Path) -> int | None:
    """Return the number of rows of a csv file; None for others, whose sum is enough."""
    if path.suffix != ".csv":
        return None
    with open(path, encoding="utf-8", newline="") as file:
        return sum(1 for _ in csv.reader(file)) - 1


def _check_room(folder: Path, words: int) -> None:
    parent = folder.resolve().parent
    if not parent.is_dir():
        raise StoreError(f"there is no folder {parent}: make it first")
    if folder.exists():
        raise ExportError(f"{folder} already exists: name a folder that does not")
    if (free := shutil.disk_usage(parent).free) < words * _BYTES:
        need = words * _BYTES / 1e9
        raise StoreError(
            f"no room for {folder}: it takes up to {need:.1f} GB, and {free / 1e9:.1f} GB is free"
        )


@contextmanager
def _complete(folder: Path) -> Iterator[Path]:
    """Give a temporary folder; rename it at the end, or remove it after a failure."""
    draft = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    try:
        draft.mkdir()
        yield draft
        os.rename(draft, folder)
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be written ({error.strerror or error}); nothing was kept"
        ) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)
