"""Check a dataset: the checksum and row count of each file, and that there are no other files."""

import csv
import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from orbitdb.errors import ExportError
from orbitdb.extras import load

PACKAGE = "datapackage.json"

Counts = Mapping[tuple[float, int], tuple[str, str]]
"""N_t and N_c, as written in the file, for each pair of a and p."""


def sha256(path: Path) -> str:
    """Return the SHA-256 checksum of a file in hexadecimal digits."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_package(folder: Path) -> list[dict[str, Any]]:
    """Return the descriptions of the files that a dataset lists.

    Raises
    ------
    ExportError
        If the folder is not a dataset written by orbitdb.
    """
    try:
        package = json.loads((folder / PACKAGE).read_text(encoding="utf-8"))
        found: list[dict[str, Any]] = package["resources"]
        if package["name"] == "stadium-orbits" and all({"path", "hash"} <= each.keys() for each in found):
            return found
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    raise ExportError(
        f"{folder} is not a dataset of orbitdb: it has no valid {PACKAGE} (--db names a catalogue)"
    )


def wrong_files(folder: Path) -> Iterator[tuple[str, str | None]]:
    """Yield the name of each file of a dataset, and a message that says what is wrong with it, or None.

    Raises
    ------
    ExportError
        If the folder is not a dataset.
    """
    found = {str(each["path"]): each for each in read_package(folder)}
    counts: Counts = {}
    for name in sorted(found, key=lambda name: name != "counts.csv"):
        fault = _fault(folder, name, found[name], counts)
        if name == "counts.csv" and fault is None:
            counts = _counts(folder / name)
        yield name, fault
    for path in sorted(folder.rglob("[!.]*")):
        if path.is_file() and (name := path.relative_to(folder).as_posix()) not in (*found, PACKAGE):
            yield name, "does not belong to the dataset"


def _fault(folder: Path, name: str, stated: Mapping[str, Any], counts: Counts) -> str | None:
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()) or not path.is_file():
        return "is missing"
    if stated["hash"] != f"sha256:{sha256(path)}":
        return "does not match its sha256 sum"
    if "rows" not in stated:
        return None
    try:
        rows = _rows_of_csv(path) if path.suffix == ".csv" else _parquet(path).metadata.num_rows
        if rows != stated["rows"]:
            return f"has {rows} rows, not {stated['rows']}"
        return _miscounted(path, counts) if stated.get("complete") and counts else None
    except (OSError, ValueError, KeyError):
        return "cannot be read as a table"


def _rows_of_csv(path: Path) -> int:
    with open(path, encoding="utf-8", newline="") as file:
        return sum(1 for _ in csv.reader(file)) - 1


def _parquet(path: Path) -> Any:
    return load("pyarrow.parquet", "a dataset", "parquet").ParquetFile(path)


def _counts(path: Path) -> Counts:
    with open(path, encoding="utf-8", newline="") as file:
        return {(float(row["a"]), int(row["p"])): (row["N_t"], row["N_c"]) for row in csv.DictReader(file)}


def _miscounted(path: Path, counts: Counts) -> str | None:
    """Return how the rows of a complete period disagree with ``counts.csv``, or None if they agree."""
    a, p, status = (column.to_pylist() for column in _parquet(path).read(["a", "p", "status"]).columns)
    found = str(len(status)), str(status.count("orbit"))
    if set(zip(a, p, strict=True)) == {(a[0], p[0])} and counts.get((a[0], p[0])) == found:
        return None
    return f"has {found[0]} words and {found[1]} orbits; counts.csv has other numbers"
