"""`verify` finds an alteration of any column of any table, apart from those that docs/faults.md names."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from alterations import middle_row

from orbitdb.selection import Selection
from orbitdb.store.file import reading
from orbitdb.verification.verify import verifiable, verify

pytestmark = pytest.mark.slow

CANNOT = {
    "run": {"started", "version", "parameters", "commits"},
    "orbit": {"iterations", "length_error", "lyapunov_error", "area_error", "error", "residual"},
    "fill": {"seconds", "enumerating", "solving", "storing"},
    "certificate": {"stadium", "radius", "bits", "version"},
    "change": {"error"},
    "birth_fill": {"seconds", "words"},
    "pruned_fill": {"seconds"},
    "trajectory": {
        "id", "bounces", "groups", "seed", "lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error",
        "mean_free_path", "mean_free_path_error",
    },
    "entropy_bound": {"a", "edges", "lower", "upper", "windows", "undecided"},
    "open_stadium": {
        "a", "opening", "without", "trajectories", "bounces", "seed", "survival",
        *(f"rate_{each}{error}" for each in ("leg", "time", "bounce") for error in ("", "_error")),
    },
    "level": {"error"},
    "level_fill": {"low", "high", "seconds"},
    "sweep": {"seconds", "processor", "blocks"},
    "sweep_block": {"number", "sums"},
}  # fmt: skip
"""Columns in which a small change goes unnoticed: docs/faults.md says so. Impossible values are found."""


SMALL = {
    "INTEGER": lambda value: value + 1,
    "REAL": lambda value: value * (1 + 1e-5) if value else 1e-5,
    "TEXT": lambda value: value[:-1] + chr(ord(value[-1]) + 1),
    "BLOB": lambda value: value[:-1] + bytes([value[-1] ^ 64]) if value else bytes(8),
}
WILD = {"INTEGER": -7, "REAL": -1e9, "TEXT": "\N{SNOWMAN}", "BLOB": b"\0"}
TYPICAL = {
    "orbit": "status = 'orbit' AND solver = 'newton' AND area != 0",
    "change": "a > 0",
    "cycle": "p = 6",
}
"""The rows from which one is taken."""


def is_sound(path: Path) -> bool:
    """Verify a file, up to the first check that fails."""
    with reading(path) as connection:
        everywhere = [Selection(a) for a in verifiable(connection)]
        with closing(verify(connection, everywhere)) as steps:
            return not any(check.failures for step in steps for check in step.checks)


def altered(source: Path, path: Path, table: str, column: str, value: Any) -> bool:
    """Copy a file and put a value in one row; return False if this changes nothing."""
    for part in (path, *path.parent.glob(f"{path.name}-*")):
        part.unlink(missing_ok=True)
    shutil.copy(source, path)
    with closing(sqlite3.connect(path)) as plain, plain:
        plain.execute("PRAGMA foreign_keys = OFF")
        this, own = middle_row(plain, table, TYPICAL.get(table, "TRUE"))
        ((before,),) = plain.execute(f"SELECT {column} FROM {table} WHERE {this}", own)
        after = value(before) if callable(value) else value
        if before is None or after == before:
            return False
        try:
            plain.execute(f"UPDATE {table} SET {column} = ? WHERE {this}", (after, *own))
        except sqlite3.IntegrityError:  # such a row exists
            return False
    return True


def tables(path: Path) -> dict[str, dict[str, tuple[str, bool]]]:
    """Return the type of each column of each table, and whether it may be NULL."""
    found: dict[str, dict[str, tuple[str, bool]]] = {}
    with closing(sqlite3.connect(path)) as plain:
        for (table,) in plain.execute(
            "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'"
        ).fetchall():
            if table != "alembic_version":
                described = plain.execute(f"PRAGMA table_info({table})").fetchall()
                found[table] = {
                    name: (kind, not (key or needed)) for _, name, kind, needed, _, key in described
                }
    return found


TABLES = [
    "stadium", "run", "cycle", "element", "pruned", "pruned_fill", "orbit", "fill", "certificate", "change",
    "birth_fill", "trajectory", "entropy_bound", "level_fill", "level", "sweep", "sweep_block",
    "open_stadium",
]  # fmt: skip


def test_the_files_have_these_tables_and_are_sound(files):
    assert sorted(tables(files["whole"])) == sorted(TABLES)
    assert is_sound(files["whole"])
    assert is_sound(files["levels"])


@pytest.mark.parametrize("table", TABLES)
def test_an_alteration_of_any_column_is_found(files, tmp_path, table):
    source, path = files["levels" if table.startswith("level") else "whole"], tmp_path / "altered.db"
    missed = []
    for column, (kind, nullable) in tables(source)[table].items():
        cannot = column in CANNOT.get(table, ()) or column == "run"
        if not cannot and altered(source, path, table, column, SMALL[kind]) and is_sound(path):
            missed.append((column, "small"))
        if column != "id" and altered(source, path, table, column, WILD[kind]) and is_sound(path):
            missed.append((column, "wild"))
        if nullable and altered(source, path, table, column, None) and is_sound(path):
            missed.append((column, "NULL"))
    assert missed == []
