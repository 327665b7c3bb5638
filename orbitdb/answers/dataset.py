"""Export catalogues as datasets, and check them: a folder of tables for any tool, with README and licence.

It is a Data Package, version 2 (https://datapackage.org). The same catalogue always gives the same bytes.
"""

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from orbitdb import __version__
from orbitdb.answers.completeness import Coverage, periods_with_births
from orbitdb.answers.entropy import table
from orbitdb.answers.lyapunov import OF_AVERAGES, lyapunov
from orbitdb.answers.results import Result
from orbitdb.columns import (
    EVERY,
    OF_BOUNDS,
    OF_COUNTS,
    OF_ENSEMBLES,
    OF_ESCAPE,
    OF_LEVELS,
    OF_LIVES,
    WRITTEN,
    Column,
)
from orbitdb.errors import ExportError, StoreError
from orbitdb.open_stadium.escape import AT, RATES, Escape
from orbitdb.output_files import atomic_folder, check_space, write_csv, write_parquet
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.weyl import Parity
from orbitdb.selection import Selection
from orbitdb.store.file import check_replaced
from orbitdb.store.lookup import read_lives
from orbitdb.store.periods import Fill, class_rows, runs
from orbitdb.store.select import COORDINATES, Words, count, rows_of
from orbitdb.store.sqlite import Connection
from orbitdb.store.stored_values import best_reference, stored_escapes, stored_levels, tightest_bounds
from orbitdb.text import format_float

CITE = (
    "The project has no authors' names, address or DOI yet. Until then, cite O. Biham and M. Kvale, Phys. "
    "Rev. A 46, 6334 (1992), and orbitdb with its version, its commit if you have it, and the selection."
)
"""What to cite, and why."""

PACKAGE = "datapackage.json"
_NAME = "stadium-orbits"
_PROFILES = "https://datapackage.org/profiles/2.0/"
_TEXTS = ("README.md", "LICENSE.txt", "CITATION.cff")

Resource = dict[str, Any]
"""The description of a file, with the keys that the standard prescribes."""

_TYPES = {"text": "string", "numbers": "any"}
"""The standard's types where they differ from our kinds of columns; its own type "array" means JSON."""

_OF_FILE, _OF_WORD, _OF_BOUNCE = 8_000, 20, 4
"""Maximum number of bytes for a file, for each word in it, and for each bounce of a word."""

_ORBITS = [EVERY[name] for name in (*WRITTEN, COORDINATES) if name != "rules"]
_OF_CLASS = [EVERY[name] for name in ("representative", "p", "class_size")]
_OF_LIFE = [*_OF_CLASS, *(column for column in OF_LIVES if column.name != "word")]
_CLASSES = [*_OF_CLASS, *(EVERY[name] for name in ("symmetry", "time_reversal", "walls"))]
_LEVELS = [column for column in OF_LEVELS if column.name in ("k", "parity", "number", "error")]
_OF_ESCAPE = {column.name: column for column in OF_ESCAPE}
_OPEN = [_OF_ESCAPE[name] for name in ("opening", "without", "trajectories", "bounces", "seed")]
_RATES = [_OF_ESCAPE[name] for name in RATES]
_SURVIVAL = [_OF_ESCAPE[name] for name in (*AT.values(), "survival", "error", "tail")]
_COUNTS = [EVERY["p"], *OF_COUNTS]
_AVERAGES = [EVERY["p"], *OF_AVERAGES]


@dataclass(frozen=True)
class Dataset:
    """A dataset that was written, or the reasons why there was nothing to write.

    Attributes
    ----------
    folder : Path
    words : int
        Number of words in the tables of orbits.
    description : str
        What these are.
    notes : tuple of str
        What is missing, one line each.
    absent : tuple of str
        The last of the notes if there is nothing to write: a line for each a.
    """

    folder: Path
    words: int
    description: str
    notes: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()

    @staticmethod
    def check(folder: Path | str) -> list[tuple[str, str | None]]:
        """Return the files of a dataset, each with what is wrong with it, or None."""
        return list(wrong_files(Path(folder)))

    def __repr__(self) -> str:
        return f"<{self.description or 'no dataset'}, in {self.folder}>"


class TableFile(NamedTuple):
    """A table of a dataset."""

    path: str  # ends in .parquet or .csv
    title: str
    columns: Sequence[Column]
    rows: Iterable[Sequence[Any]]
    words: int | None = None  # for a table of orbits, the number of words of its period, chosen or not


def write_dataset(
    connection: Connection,
    folder: Path,
    chosen: Sequence[Selection],
    force: bool = False,
    tell: Tell = nobody,
) -> Dataset:
    """Write a dataset, unless no word of a complete period is chosen (`Catalogue.write_dataset`).

    The selections, one for each a, differ only in a. They choose the periods, and the words in the tables of
    orbits; the other tables do not depend on which words are chosen. The folder appears only when it is
    complete. With `force`, it may replace a folder that holds a dataset and nothing else.

    Raises
    ------
    ExportError
        If the folder exists and is not to be replaced.
    StoreError
        If the disk has too little space, or the folder cannot be written.
    """
    covered = [Coverage(connection, subset) for subset in chosen]
    notes = [line for one in covered for line in one.gaps(left_out=True)]
    subsets = [
        (subset := replace(one.chosen, periods=((fill.p, fill.p),)), fill, count(connection, subset))
        for one in covered
        for fill in one.fills
        if fill.p in one.filled
    ]
    if not (total := sum(number for _, _, number in subsets)):
        absent = tuple(filter(None, (one.nothing() for one in covered)))
        return Dataset(folder, 0, "", (*notes, *absent), absent)
    need = sum(_OF_FILE + number * (_OF_WORD + _OF_BOUNCE * fill.p) for _, fill, number in subsets)
    _check(folder, force, need)
    selection = chosen[0].describe(sorted({subset.a for subset, _, _ in subsets}), total)
    orbits = (_orbits(connection, *subset) for subset in subsets)
    filled = {fill.p for _, fill, _ in subsets}
    with atomic_folder(folder) as draft:
        tables = chain(orbits, _others(connection, chosen, filled))
        resources = _write_tables(draft, tables, total, tell)
        version = f"1.0.0+{hashlib.sha256(json.dumps(resources).encode()).hexdigest()[:12]}"
        resources += _write_texts(draft, selection, version)
        package = _package(connection, selection, version, resources)
        (draft / PACKAGE).write_text(json.dumps(package, indent=1) + "\n", encoding="utf-8")
        check_replaced(connection)
    return Dataset(folder, total, selection, tuple(notes))


def _write_tables(draft: Path, tables: Iterable[TableFile], total: int, tell: Tell) -> list[Resource]:
    """Write tables, except empty ones that are not about orbits; return the descriptions of the files."""
    resources, done = list[Resource](), 0
    (draft / "orbits").mkdir()
    for made in tables:
        tell(done, total, made.path)
        rows = _write(draft / made.path, made)
        if rows or made.words:
            resources.append(_described(draft, made, rows))
        else:
            (draft / made.path).unlink()
        done += rows if made.words else 0
    return resources


def _write_texts(draft: Path, selection: str, version: str) -> list[Resource]:
    """Write the README, the licence and the citation; return the descriptions of the files."""
    for name in _TEXTS:
        text = (files(__package__) / "templates" / f"dataset-{name}").read_text(encoding="utf-8")
        marks = {"SELECTION": selection, "VERSION": version, "PROGRAM": __version__, "CITE": CITE}
        for mark, value in marks.items():
            text = text.replace(f"@{mark}@", value)
        (draft / name).write_text(text, encoding="utf-8")
    return [_file(draft, name) for name in _TEXTS]


def _orbits(connection: Connection, chosen: Selection, fill: Fill, number: int) -> TableFile:
    """Return the table of the chosen words of one period at one a, ordered by class and element."""
    rows = rows_of(connection, Words(chosen), [column.name for column in _ORBITS])
    path = f"orbits/a={format_float(chosen.a)}_p={fill.p:02d}.parquet"
    return TableFile(path, chosen.describe(count=number), _ORBITS, rows, fill.words)


def _others(connection: Connection, chosen: Sequence[Selection], filled: set[int]) -> Iterator[TableFile]:
    """Yield all tables except those of orbits; `filled` is the set of periods that have a table of orbits."""
    born = [p for p in periods_with_births(connection) if chosen[0].includes(p)]
    names = ("word", *(column.name for column in _CLASSES[1:]))
    classes = class_rows(connection, names, filled.union(born))
    lives = (astuple(life) for p in born for life in read_lives(connection, p))
    yield TableFile("classes.parquet", "Symmetry classes", _CLASSES, classes)
    yield TableFile("births.parquet", "Births and deaths of all classes", _OF_LIFE, lives)

    counts, averages, ensembles, bounds, levels = (list[tuple[Any, ...]]() for _ in range(5))
    for at_a in chosen:
        every = Selection(at_a.a)
        counts += _by_period(table(connection, every), _COUNTS, at_a)
        averages += _by_period(lyapunov(connection, every), _AVERAGES, at_a)
        if (ensemble := best_reference(connection, at_a.a)) is not None:
            ensembles.append(tuple(ensemble.row().values()))
        if (proved := tightest_bounds(connection, at_a.a)) is not None:
            bounds.append(tuple(proved.row().values()))
        levels += _levels(connection, at_a.a)
    at = [EVERY["a"]]
    yield TableFile("counts.csv", "Counts of all words by period", at + _COUNTS, counts)
    yield TableFile("averages.csv", "Averages over all orbits by period", at + _AVERAGES, averages)
    yield TableFile("trajectories.csv", "Averages over random trajectories", [*at, *OF_ENSEMBLES], ensembles)
    yield TableFile("bounds.csv", "Bounds on the topological entropy", [*at, *OF_BOUNDS], bounds)
    yield TableFile("levels.csv", "Quantum levels", at + _LEVELS, levels)
    opened = [found for at_a in chosen for found in stored_escapes(connection, at_a.a)]
    escapes = ((*_open(found), *found.rates().values()) for found in opened)
    yield TableFile("escapes.csv", "Escape rates and tails of open stadiums", [*at, *_OPEN, *_RATES], escapes)
    yield TableFile("survival.csv", "Survival in open stadiums", [*at, *_OPEN, *_SURVIVAL], _survival(opened))


def _open(found: Escape) -> tuple[Any, ...]:
    """Return the values of the columns that say what is open, and of what sample survival is."""
    texts = (" ".join(map(str, each)) for each in (found.opening, found.without))
    return found.a, *texts, found.trajectories, found.bounces, found.seed


def _survival(opened: Sequence[Escape]) -> Iterator[tuple[Any, ...]]:
    """Yield survival by bounce, time and leg; each row has a value in one of the columns n, t and legs."""
    for found in opened:
        for place, by in enumerate(AT):
            for at, *values in zip(*found.columns(by).values(), strict=True):
                yield *_open(found), *(at if place == own else None for own in range(len(AT))), *values


def _by_period(result: Result, columns: Sequence[Column], chosen: Selection) -> Iterator[tuple[Any, ...]]:
    """Yield the rows of a result for the chosen periods, with a first."""
    for row in result.rows([column.name for column in columns]) if len(result) else ():
        if chosen.includes(row[0]):
            yield (chosen.a, *row)


def _levels(connection: Connection, a: float) -> Iterator[tuple[Any, ...]]:
    for parity in Parity:
        for window in stored_levels(connection, a, parity):
            pairs = zip(window.k.tolist(), window.error.tolist(), strict=True)
            for number, (k, error) in enumerate(pairs, window.below + 1):
                yield a, k, str(parity), number, error


def _write(path: Path, made: TableFile) -> int:
    """Write a table, and return its number of rows."""
    names = [column.name for column in made.columns]
    if path.suffix == ".parquet":
        with open(path, "wb") as binary:
            return write_parquet(binary, names, made.rows, {}, "zstd")
    with open(path, "w", encoding="utf-8", newline="") as text:
        return write_csv(text, names, made.rows)


def _file(draft: Path, path: str) -> Resource:
    name, _, form = path.lower().rpartition(".")
    key = re.sub("[/=_]", "-", name)
    return {"name": key, "path": path, "format": form, "hash": _sha256(draft / path)}


def _sha256(path: Path) -> str:
    with open(path, "rb") as file:
        return f"sha256:{hashlib.file_digest(file, 'sha256').hexdigest()}"


def _described(draft: Path, made: TableFile, rows: int) -> Resource:
    """Return the description of a written table, with the meaning, unit and error bound of each column."""
    columns = []
    for column in made.columns:
        empty = column.empty if column.empty != "never" else ""
        texts = {"description": column.means, "unit": column.unit, "bound": column.bound, "empty": empty}
        kind = {"name": column.name, "type": _TYPES.get(column.kind, column.kind)}
        columns.append(kind | {key: text for key, text in texts.items() if text})
    schema = {"$schema": f"{_PROFILES}tableschema.json", "fields": columns}
    of_table = {"title": made.title, "type": "table", "rows": rows, "schema": schema}
    return _file(draft, made.path) | of_table | ({"complete": rows == made.words} if made.words else {})


def _package(
    connection: Connection, selection: str, version: str, resources: Sequence[Resource]
) -> dict[str, Any]:
    """Return the contents of ``datapackage.json``."""
    licence = "https://creativecommons.org/licenses/by/4.0/"
    return {
        "$schema": f"{_PROFILES}datapackage.json",
        "name": _NAME,
        "title": "Periodic orbits of the stadium billiard",
        "description": selection,
        "version": version,
        "licenses": [{"name": "CC-BY-4.0", "title": "Creative Commons Attribution 4.0", "path": licence}],
        "sources": [{"title": "O. Biham and M. Kvale, Phys. Rev. A 46, 6334 (1992)"}],
        "contributors": [{"title": "The orbitdb founders", "roles": ["creator"]}],
        "cite": CITE,
        "made_by": made_by(connection),
        "resources": resources,
    }


def made_by(connection: Connection) -> list[dict[str, Any]]:
    """Return the runs that made the data of a catalogue, each with its version, command and parameters."""
    return [{"orbitdb": version} | json.loads(parameters) for version, parameters in runs(connection)]


def _check(folder: Path, force: bool, need: int) -> None:
    """Raise if the folder exists, unless it is a dataset to replace, or if the disk has too little space."""
    if not folder.resolve().parent.is_dir():
        raise StoreError(f"there is no folder {folder.resolve().parent}: make it first")
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        if not force:
            raise ExportError(f"{folder} already exists: `force=True` replaces a dataset")
        if others := _other_files(folder, [resource["path"] for resource in read_package(folder)]):
            raise ExportError(f"{folder} also holds {others[0]}, which is no part of a dataset: move it away")
    check_space(folder, need, "it takes up to")


def read_package(folder: Path) -> list[Resource]:
    """Return the descriptions of the files of a dataset; raise `ExportError` if it is not a dataset."""
    try:
        package = json.loads((folder / PACKAGE).read_text(encoding="utf-8"))
        resources: list[Resource] = package["resources"]
        if package["name"] == _NAME and all({"path", "hash"} <= resource.keys() for resource in resources):
            return resources
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    raise ExportError(
        f"{folder} is not a dataset of orbitdb: it has no valid {PACKAGE} (--db names a catalogue)"
    )


def wrong_files(folder: Path) -> Iterator[tuple[str, str | None]]:
    """Yield the name of each file of a dataset, and what is wrong with it, or None.

    Raises `ExportError` if the folder is not a dataset.
    """
    listed = {resource["path"]: resource["hash"] for resource in read_package(folder)}
    for name in sorted(listed):
        same = (folder / name).is_file() and listed[name] == _sha256(folder / name)
        there = "does not match its sha256 sum" if (folder / name).is_file() else "is missing"
        yield name, None if same else there
    for name in _other_files(folder, listed):
        if "/." not in f"/{name}":  # what file managers and git leave there
            yield name, "does not belong to the dataset"


def _other_files(folder: Path, listed: Iterable[str]) -> list[str]:
    """Return the names of the files in a folder that its dataset does not list."""
    names = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir())
    return sorted(set(names) - {*listed, PACKAGE})
