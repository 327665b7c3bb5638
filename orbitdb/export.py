"""Write rows for other tools, with all digits, as csv, jsonl, parquet or npz.

A file appears under its name only when it is complete. Parquet and npz files contain their provenance. csv
and jsonl files are pure data, which every tool can read; their provenance is in a second file, named as in
the W3C's "CSV on the Web": ``orbits.csv-metadata.json``.
"""

import contextlib
import csv
import json
import math
import os
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

from orbitdb.column import Row
from orbitdb.columns import kind_of
from orbitdb.errors import ExportError, StoreError
from orbitdb.plaintext import cell

Metadata = Mapping[str, Any]


def write_csv(file: TextIO, columns: Sequence[str], rows: Iterable[Any], delimiter: str = ",") -> int:
    """Write a line with the names of the columns, then one line per row; return the number of rows.

    The items of a list are separated by blanks, None is empty, and no text is a formula (`cell`).
    """
    writer = csv.writer(file, delimiter=delimiter, lineterminator="\n")
    writer.writerow(columns)
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


def json_object(columns: Sequence[str], row: Row) -> str:
    """Return a row as a JSON object in ASCII, with null for NaN and infinities."""
    values = (None if isinstance(value, float) and not math.isfinite(value) else value for value in row)
    return json.dumps(dict(zip(columns, values, strict=True)))


TEXT_WRITERS: dict[str, Callable[[TextIO, Sequence[str], Iterable[Row]], int]] = {
    "csv": write_csv,
    "jsonl": write_jsonl,
}
FORMATS = (*TEXT_WRITERS, "parquet", "npz")
"""The formats in which rows can be written."""

FIGURES = ("png", "svg", "pdf")
"""The formats in which figures can be written."""

STDOUT = Path("-")
"""The path that means standard output."""


def form_of(path: Path, form: str | None = None, known: Sequence[str] = FORMATS) -> str:
    """Return the format of a file: the given one, or the one that its extension names.

    Raises
    ------
    ExportError
        If the format is unknown, or contradicts the extension.
    """
    ending = path.suffix.lstrip(".").lower()
    found = form or ending
    if found not in known:
        raise ExportError(
            f"format {found!r} of {path}: end the name in .{', .'.join(known)}, or use --format"
        )
    if ending in known and ending != found:
        raise ExportError(f"{path} ends in .{ending}, but --format says {form}: leave one of them out")
    return found


def write_file(
    path: Path, form: str, columns: Sequence[str], rows: Iterable[Any], metadata: Metadata
) -> None:
    """Write rows to a file that appears only when it is complete.

    Parameters
    ----------
    path : Path
    form : str
        One of `FORMATS`.
    columns : sequence of str
        Names from `orbitdb.columns`.
    rows : iterable of sequences
        Plain Python values; None for a missing value.
    metadata : mapping
        Provenance, as values that JSON can represent.

    Raises
    ------
    ExportError
        If the path is a folder or a device, or if the rows do not fit into the format.
    StoreError
        If the system refuses to write the file.
    """
    if form in TEXT_WRITERS:
        described = dict(metadata) | {"columns": {name: kind_of(name) for name in columns}}
        with complete(path) as data, complete(metadata_path(path), path) as beside:
            with open(data, "w", encoding="utf-8", newline="") as file:
                TEXT_WRITERS[form](file, columns, rows)
            beside.write_text(json.dumps(described, indent=2) + "\n", encoding="utf-8")
        return
    from orbitdb.column_files import write_npz, write_parquet

    with complete(path) as data, open(data, "wb") as binary:
        (write_parquet if form == "parquet" else write_npz)(binary, columns, rows, metadata)


def check_target(path: Path, replace: bool = True) -> None:
    """Raise an error unless a path is a new or, if `replace` is true, an existing ordinary file.

    Raises
    ------
    ExportError
        If there is a folder or a device at the path, or a file that is not to be replaced.
    StoreError
        If the folder does not exist, or the path cannot be examined.
    """
    try:
        mode = path.stat().st_mode
    except FileNotFoundError as error:
        if not path.parent.is_dir():
            raise StoreError(f"there is no folder {path.parent}: make it first") from error
        return
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror})") from error
    if not stat.S_ISREG(mode):
        raise ExportError(f"{path} is a folder or a device: name a file")
    if not replace:
        raise ExportError(f"{path} already exists: --force replaces it")


def metadata_path(path: Path) -> Path:
    """Return the path of the file with the provenance of a csv or jsonl file."""
    return path.with_name(path.name + "-metadata.json")


@contextmanager
def complete(path: Path, wanted: Path | None = None) -> Iterator[Path]:
    """Yield a temporary path in the same folder, and rename the file to `path` once it is complete.

    A path that cannot be written is refused at once. Errors name `wanted`, if it is given, instead of `path`.

    Raises
    ------
    ExportError
        If the path is a folder or a device.
    StoreError
        If the system refuses to write the file.
    """
    check_target(path)
    draft = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        try:
            draft.touch()
            yield draft
            with open(draft, "rb") as file:
                os.fsync(file.fileno())
            os.replace(draft, path)
        except OSError as error:
            raise StoreError(
                f"{wanted or path} cannot be written ({error.strerror or error}); nothing was saved"
            ) from error
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()
