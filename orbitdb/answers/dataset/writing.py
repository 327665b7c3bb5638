"""Write a dataset: tables, ``datapackage.json``, README and licence.

The same catalogue always gives the same bytes.
"""

import json
import os
import re
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from orbitdb import __version__
from orbitdb.answers.dataset.checking import PACKAGE, read_package, sha256
from orbitdb.answers.dataset.tables import Table, orbits, others
from orbitdb.column_files import write_parquet
from orbitdb.errors import ExportError, StoreError
from orbitdb.export import write_csv
from orbitdb.progress import Tell, nobody
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import run
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.rows import Chosen

Resource = dict[str, Any]
"""The description of a file, with the keys that the standard prescribes."""

_LICENCE = {
    "name": "CC-BY-4.0",
    "title": "Creative Commons Attribution 4.0",
    "path": "https://creativecommons.org/licenses/by/4.0/",
}
_TYPES = {"text": "string", "numbers": "any"}
"""The standard's types where they differ from our kinds of columns; its own type "array" means JSON."""

_OF_FILE, _OF_WORD, _OF_BOUNCE = 8_000, 20, 4
"""Maximum number of bytes for a file, for each word in it, and for each bounce of a word."""


def write_dataset(
    moment: Moment, folder: Path, chosen: Sequence[Selection], force: bool = False, tell: Tell = nobody
) -> str:
    """Write a dataset; return a description of its orbits, or '' if no word of a complete period is chosen.

    Parameters
    ----------
    moment : Moment
    folder : Path
        The folder to create; it appears only when it is complete.
    chosen : sequence of Selection
        One for each a; they differ only in a. They choose the periods, and the words in the tables of orbits;
        the other tables do not depend on which words are chosen.
    force : bool, optional
        Replace an existing dataset.
    tell : callable, optional
        Called with the progress.

    Raises
    ------
    ExportError
        If the folder exists, unless it is a dataset and `force` is true.
    StoreError
        If the disk has too little space, or the folder cannot be written.
    """
    whole = [(each, fill) for each in chosen for fill in moment.fills(each.a) if fill.whole]
    whole = [(each, fill) for each, fill in whole if each.includes(fill.p)]
    subsets = [moment.choose(replace(each, periods=((fill.p, fill.p),))) for each, fill in whole]
    if not (total := sum(map(len, subsets))):
        return ""
    _check(folder, force, subsets)
    selection = chosen[0].describe(sorted({each.a for each, _ in whole}), total)
    wanted = [orbits(moment, subset, fill.words) for subset, (_, fill) in zip(subsets, whole, strict=True)]
    with _replacing(folder.resolve()) as draft:
        found, done = list[Resource](), 0
        (draft / "orbits").mkdir()
        for made in chain(wanted, others(moment, chosen, {fill.p for _, fill in whole})):
            tell(done, total, made.path)
            rows = _write(draft / made.path, made)
            if rows or made.words:
                found.append(_described(draft, made, rows))
            else:
                (draft / made.path).unlink()
            done += rows if made.words else 0
        found += _texts(draft, selection)
        described = json.dumps(_package(moment, selection, found), indent=1) + "\n"
        (draft / PACKAGE).write_text(described, encoding="utf-8")
    return selection


def _write(path: Path, made: Table) -> int:
    """Write a table, and return its number of rows."""
    names = [column.name for column in made.columns]
    if path.suffix == ".parquet":
        with open(path, "wb") as binary:
            return write_parquet(binary, names, made.rows, {}, "zstd")
    with open(path, "w", encoding="utf-8", newline="") as text:
        return write_csv(text, names, made.rows)


def _texts(draft: Path, selection: str) -> Iterator[Resource]:
    """Write the README and the licence, and yield their descriptions."""
    for name in ("README.md", "LICENSE.txt"):
        text = (files(__package__) / name).read_text(encoding="utf-8")
        for mark, value in (("SELECTION", selection), ("VERSION", __version__)):
            text = text.replace(f"@{mark}@", value)
        (draft / name).write_text(text, encoding="utf-8")
        yield _file(draft, name)


def _file(draft: Path, path: str) -> Resource:
    name, _, form = path.lower().rpartition(".")
    of_file = {"name": re.sub("[/=_]", "-", name), "path": path, "format": form}
    return of_file | {"hash": f"sha256:{sha256(draft / path)}"}


def _described(draft: Path, made: Table, rows: int) -> Resource:
    """Return the description of a written table, with the meaning, unit and error bound of each column."""
    columns = []
    for each in made.columns:
        told = {"description": each.means, "unit": each.unit, "bound": each.bound}
        told["empty"] = each.empty if each.empty != "never" else ""
        kind = {"name": each.name, "type": _TYPES.get(each.kind, each.kind)}
        columns.append(kind | {key: text for key, text in told.items() if text})
    known = {"title": made.title, "rows": rows, "schema": {"fields": columns}}
    return _file(draft, made.path) | known | ({"complete": rows == made.words} if made.words else {})


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


def _check(folder: Path, force: bool, subsets: Sequence[Chosen]) -> None:
    """Raise if the folder exists, unless it is a dataset to replace, or if the disk has too little space."""
    parent = folder.resolve().parent
    if not parent.is_dir():
        raise StoreError(f"there is no folder {parent}: make it first")
    if folder.exists() and not force:
        raise ExportError(f"{folder} already exists: --force replaces a dataset")
    if folder.exists():
        read_package(folder)
    periods = [(len(subset), subset.selection.periods[0][0]) for subset in subsets]
    need = sum(_OF_FILE + words * (_OF_WORD + _OF_BOUNCE * p) for words, p in periods)
    if (free := shutil.disk_usage(parent).free) < need:
        raise StoreError(
            f"no room for {folder}: it takes up to {need / 1e6:.1f} MB, but only {free / 1e6:.1f} MB is free"
        )


@contextmanager
def _replacing(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder; move it into place at the end, or remove it after a failure."""
    draft, before = (folder.with_name(f".{folder.name}.{os.getpid()}.{end}") for end in ("part", "old"))
    try:
        draft.mkdir()
        yield draft
        if folder.exists():
            os.rename(folder, before)
        os.rename(draft, folder)
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be written ({error.strerror or error}); nothing was saved"
        ) from error
    finally:
        if before.exists() and not folder.exists():
            os.rename(before, folder)
        for rest in (draft, before):
            shutil.rmtree(rest, ignore_errors=True)
