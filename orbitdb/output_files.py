"""Write files for other tools, with all digits: rows as csv, tsv, json, jsonl or parquet.

A file appears under its name only when it is complete, and no catalogue is ever replaced. Parquet files
contain their provenance. The others are pure data, which every tool can read; their provenance is in a second
file, named as in the W3C's "CSV on the Web": ``orbits.csv-metadata.json``.
"""

import contextlib
import csv
import errno
import glob
import json
import math
import os
import shutil
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, TextIO
from urllib.parse import quote

from orbitdb.columns import Row, kind_of
from orbitdb.display import load
from orbitdb.errors import ExportError, StoreError
from orbitdb.text import cell, gigabytes

if TYPE_CHECKING:
    import pyarrow as pa

    from orbitdb.arrays import Values

Metadata = Mapping[str, Any]

_ROWS = 20_000
"""Number of rows that are written to a parquet file at a time."""


def write_csv(file: TextIO, columns: Sequence[str], rows: Iterable[Any], delimiter: str = ",") -> int:
    """Write a line with the names of the columns, then one line per row; return the number of rows.

    The items of a list are separated by blanks, None is empty, and no text is a formula (`cell`).
    """
    writer = csv.writer(file, delimiter=delimiter, lineterminator="\n")
    writer.writerow(map(cell, columns))
    count = 0
    for row in rows:
        writer.writerow(map(cell, row))
        count += 1
    return count


def write_jsonl(file: TextIO, columns: Sequence[str], rows: Iterable[Row]) -> int:
    """Write one JSON object per row; return the number of rows."""
    count = 0
    for row in rows:
        file.write(json_object(columns, row) + "\n")
        count += 1
    return count


def write_json(file: TextIO, columns: Sequence[str], rows: Iterable[Row]) -> int:
    """Write one JSON array of objects, one per row; return the number of rows."""
    count = 0
    for count, row in enumerate(rows, 1):
        file.write(("[\n" if count == 1 else ",\n") + json_object(columns, row))
    file.write("\n]\n" if count else "[]\n")
    return count


def json_object(columns: Sequence[str], row: Row) -> str:
    """Return a row as a JSON object in ASCII, with null for NaN and infinities."""
    values = (None if isinstance(value, float) and not math.isfinite(value) else value for value in row)
    return json.dumps(dict(zip(columns, values, strict=True)))


TEXT_WRITERS: dict[str, Callable[[TextIO, Sequence[str], Iterable[Row]], int]] = {
    "csv": write_csv,
    "tsv": partial(write_csv, delimiter="\t"),
    "json": write_json,
    "jsonl": write_jsonl,
}
"""The formats that are written row by row, and thus to stdout, too."""

FORMATS = (*TEXT_WRITERS, "parquet")
"""The formats in which rows can be written."""

FIGURES = ("png", "svg", "pdf")
"""The formats in which figures can be written."""

STDOUT = Path("-")
"""The path that means standard output."""


def form_of(
    path: Path, form: str | None = None, forms: Sequence[str] = FORMATS, also: Sequence[str] = ()
) -> str:
    """Return the format of a file: the given one, or the one that its extension names.

    Raises `ExportError`, which names the extensions in `also`, too, if the format is unknown, or contradicts
    the extension.
    """
    ending = path.suffix.lstrip(".").lower()
    chosen = form or ending
    if chosen not in forms:
        raise ExportError(
            f"format {chosen!r} of {path}: end the name in .{', .'.join((*forms, *also))}, or use --format"
        )
    if ending in forms and ending != chosen:
        raise ExportError(f"{path} ends in .{ending}, but --format says {form}: leave one of them out")
    return chosen


def check_rows(path: Path, form: str | None, replace: bool, also: Sequence[str] = ()) -> str:
    """Return the format of a file of rows; raise `ExportError` if the file, or its provenance, is there.

    See `form_of` and `check_target` for the errors.
    """
    kind = form_of(path, form, also=also)
    for target in (path, metadata_path(path)) if kind in TEXT_WRITERS else (path,):
        check_target(target, replace)
    return kind


def write_file(path: Path, form: str, columns: Sequence[str], rows: Iterable[Any], metadata: Metadata) -> int:
    """Write rows to a file that appears only when it is complete (`complete`); return their number.

    The format is one of `FORMATS`, and the columns are named as in `orbitdb.columns`. The values are plain,
    with None for a missing one. The metadata is the provenance, as values that JSON can represent.
    """
    if form in TEXT_WRITERS:
        described = dict(metadata) | {"columns": {name: kind_of(name) for name in columns}}
        with atomic_file(path) as data, atomic_file(metadata_path(path), path) as beside:
            with open(data, "w", encoding="utf-8", newline="") as file:
                count = TEXT_WRITERS[form](file, columns, rows)
            beside.write_text(json.dumps(described, indent=2) + "\n", encoding="utf-8")
        return count
    with atomic_file(path) as data, open(data, "wb") as binary:
        return write_parquet(binary, columns, rows, metadata)


def write_parquet(
    file: IO[bytes],
    columns: Sequence[str],
    rows: Iterable[Row],
    metadata: Mapping[str, Any],
    compression: str = "snappy",
) -> int:
    """Write typed columns, with the metadata in the schema (`arrow_schema`); return the number of rows."""
    parquet = load("pyarrow.parquet", "a parquet file", "parquet")
    schema, count = arrow_schema(columns, metadata), 0
    rows = iter(rows)
    with parquet.ParquetWriter(file, schema, compression=compression) as writer:
        while block := list(islice(rows, _ROWS)):
            writer.write_batch(arrow_batch(list(zip(*block, strict=True)), schema))
            count += len(block)
    return count


def arrow_schema(columns: Sequence[str], metadata: Mapping[str, Any]) -> "pa.Schema":
    """Return the Arrow schema of the named columns, with each part of the metadata as JSON."""
    import pyarrow as pa

    types = {
        "number": pa.float64(),
        "integer": pa.int64(),
        "text": pa.string(),
        "numbers": pa.list_(pa.float64()),
        "integers": pa.list_(pa.int64()),
    }
    notes = {name: json.dumps(value) for name, value in metadata.items()}
    return pa.schema([(name, types[kind_of(name)]) for name in columns], metadata=notes)


def arrow_batch(block: "Sequence[Values]", schema: "pa.Schema") -> "pa.RecordBatch":
    """Return columns as an Arrow record batch."""
    import pyarrow as pa

    arrays = [
        pa.array(values, type=field.type, from_pandas=hasattr(values, "dtype"))  # NaN becomes null
        for values, field in zip(block, schema, strict=True)
    ]
    return pa.record_batch(arrays, schema=schema)


def check_target(path: Path, replace: bool = True) -> None:
    """Raise `ExportError` unless a path is a new or, if `replace` is true, an existing ordinary file.

    A catalogue or another SQLite file is never replaced. Raises `StoreError` if there is no such folder.
    """
    try:
        if not path.exists():
            folder = Path(os.path.realpath(path)).parent if path.is_symlink() else path.parent
            if not folder.is_dir():
                raise StoreError(f"there is no folder {folder}: make it first")
            return
        if not path.is_file():
            raise ExportError(f"{path} is a folder or a device: name a file")
        belongs_to_sqlite = _is_database(path) or _begins_like_sqlite(path)
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror})") from error
    if belongs_to_sqlite:
        raise ExportError(
            f"{path} is an SQLite file, such as a catalogue, and is never replaced: name another"
        )
    if not replace:
        raise ExportError(f"{path} already exists: `force=True` replaces it")


def _is_database(path: Path) -> bool:
    """Tell whether a file is an SQLite database.

    Only SQLite may open it: a process that closes a file loses all its locks on it (POSIX), those of open
    catalogues, too, and other processes could then write where they must not.
    """
    uri = f"file:{quote(os.fsencode(path.absolute()))}?mode=ro&immutable=1"
    try:
        with contextlib.closing(sqlite3.connect(uri, uri=True)) as database:
            return database.execute("PRAGMA page_count").fetchone() != (0,)
    except sqlite3.DatabaseError as error:
        if error.sqlite_errorcode == sqlite3.SQLITE_CANTOPEN:
            path.stat()
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES)) from error
        return error.sqlite_errorcode != sqlite3.SQLITE_NOTADB


def _begins_like_sqlite(path: Path) -> bool:
    """Tell whether a file that SQLite cannot read is a journal, a write-ahead log or a damaged database."""
    with open(path, "rb") as file:
        return file.read(len(_BEGINNINGS[0])).startswith(_BEGINNINGS)


_JOURNALS = ("d9d505f920a163d7", "377f0682", "377f0683")
_BEGINNINGS = (b"SQLite format 3\0", *map(bytes.fromhex, _JOURNALS))
"""What an SQLite file, its journal or its write-ahead log begins with."""


def check_space(path: Path, need: float, what: str) -> None:
    """Raise `StoreError` if a disk has fewer than `need` bytes free for a file or a folder.

    `what` begins the reason, such as "100 words take".
    """
    folder = next(parent for parent in path.resolve().parents if parent.exists())
    if (free := shutil.disk_usage(folder).free) < need:
        raise StoreError(
            f"no room for {path}: {what} about {gigabytes(need)}, but only {gigabytes(free)} is free: "
            "make room, or name a place on another disk"
        )


def metadata_path(path: Path) -> Path:
    """Return the path of the file with the provenance of a file of rows other than parquet."""
    return path.with_name(path.name + "-metadata.json")


@contextmanager
def _saving(path: Path) -> Iterator[None]:
    """Turn errors of the system into a `StoreError` that says that nothing was saved."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise StoreError(f"{path} cannot be written ({reason}); nothing was saved") from error


def _clear_remains(target: Path) -> None:
    """Delete the drafts of a file or folder that were left by processes that have been killed.

    If one was killed just before it put a new folder in the place of an old one, the old one comes back.
    """
    for rest in target.parent.glob(f".{glob.escape(target.name)}.*.*"):
        owner, ending = rest.name.removeprefix(f".{target.name}.").split(".", 1)
        if ending in ("part", "old") and owner.isdigit() and not _runs(int(owner)):
            with contextlib.suppress(OSError):
                if ending == "old" and not target.exists():
                    rest.rename(target)
                else:
                    shutil.rmtree(rest) if rest.is_dir() else rest.unlink()


def _runs(process: int) -> bool:
    """Tell whether a process still runs; on Windows, where a look would end it, it is taken to run."""
    try:
        if os.name == "posix":
            os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        pass
    return True


@contextmanager
def atomic_file(path: Path, wanted: Path | None = None) -> Iterator[Path]:
    """Yield a temporary path in the same folder, and rename the file to `path` once it is complete.

    A path that cannot be written is refused at once (`check_target`). A link stays: the file to which it
    leads is replaced and keeps its permissions. If the system refuses to write, a `StoreError` names
    `wanted`, if it is given, instead of `path`.
    """
    check_target(path)
    target = Path(os.path.realpath(path))
    _clear_remains(target)
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with _saving(wanted or path):
            draft.touch()
            yield draft
            with open(draft, "rb") as file:
                os.fsync(file.fileno())
            if target.exists():
                shutil.copymode(target, draft)
            os.replace(draft, target)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


@contextmanager
def atomic_folder(path: Path) -> Iterator[Path]:
    """Yield a temporary folder; move it to `path` at the end, or remove it after a failure.

    A folder that it replaces is deleted last, so that one of the two is always whole. Raises `StoreError` if
    the system refuses to write.
    """
    folder = path.resolve()
    _clear_remains(folder)
    draft, replaced = (folder.with_name(f".{folder.name}.{os.getpid()}.{end}") for end in ("part", "old"))
    try:
        with _saving(folder):
            draft.mkdir()
            yield draft
            if folder.exists():
                os.rename(folder, replaced)
            os.rename(draft, folder)
    finally:
        if replaced.exists() and not folder.exists():
            os.rename(replaced, folder)
        try:
            _remove(draft, replaced)
        except BaseException:  # a signal, after which no other one disturbs
            _remove(draft, replaced)
            raise


def _remove(*folders: Path) -> None:
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
