"""A damaged value of any column gives a line of `verify`, never a traceback, and hides no other check.

SQLite would refuse such values; a flipped bit on the disk makes them.
"""

import re
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from alterations import make, middle_row
from quick import fuzz_but

from orbitdb.verification.verify import PROMISES

COMMANDS = [
    ["fill", "--p", "4"],
    ["fill", "--p", "2", "--geometric"],
    ["births", "--p", "5"],
    ["sweep", "--p", "4"],
    ["verify", "--prove", "--p", "2-3"],
    ["simulate", "--bounces", "1000"],
    ["bounds", "--edges", "3"],
]
COLUMNS = {
    "stadium": "id a",
    "run": "id started version parameters commits",
    "cycle": "id p word class_size walls time_reversal symmetry words",
    "element": "symmetry n element",
    "pruned": "id p word rules",
    "orbit": "stadium cycle status coordinates length lyapunov margin residual error length_error"
    " lyapunov_error area area_error iterations solver run",
    "fill": "stadium p state cursor seconds primitive rule_1 n_t n_c classes boundary unresolved",
    "certificate": "stadium cycle radius bits version run",
    "change": "cycle number a error kind bounce joint event slope run",
    "birth_fill": "p state cursor seconds words classes births deaths always least largest",
    "trajectory": "id stadium bounces groups seed lambda_d lambda_c mean_free_path run",
    "entropy_bound": "a proof edges lower upper windows undecided run",
    "sweep": "stadium p state cursor blocks seconds processor words n_c classes boundary sums run",
}
VALUES = {
    "NULL": "NULL",
    "text that is not UTF-8": "CAST(x'3031ff' AS TEXT)",
    "another text": "'0139x'",
    "a huge number": "4611686018427387904",
    "infinity": "-9e999",
    "bytes": "x'00ff'",
}
FIRST = [
    ("pruned", "word", "another text"),
    ("pruned", "p", "a huge number"),
    ("change", "a", "infinity"),
    ("sweep", "state", "text that is not UTF-8"),
]
ALL = [(table, name, value) for table, names in COLUMNS.items() for name in names.split() for value in VALUES]


@pytest.fixture(scope="module")
def whole(made_once) -> Path:
    return made_once("damaged-values", lambda path: make(path, COMMANDS))


def put(path: Path, table: str, column: str, value: str) -> None:
    """Put a value in a row in the middle of a table, although it has the wrong type."""
    with closing(sqlite3.connect(path, isolation_level=None)) as plain:
        ((sql,),) = plain.execute("SELECT sql FROM sqlite_schema WHERE name = ?", (table,)).fetchall()
        ((version,),) = plain.execute("PRAGMA schema_version").fetchall()
        plain.execute("PRAGMA writable_schema = ON")
        loose = re.sub(r",?\s*STRICT", "", sql)
        for kind in ("INTEGER", "REAL", "TEXT", "BLOB"):
            loose = loose.replace(f" {kind} NOT NULL", "").replace(f" {kind},", ",")
        loose = loose.replace("    id,", "    id INTEGER NOT NULL,")  # SQLite's number of the row
        plain.execute("UPDATE sqlite_schema SET sql = ? WHERE name = ?", (loose, table))
        plain.execute(f"PRAGMA schema_version = {version + 1}")
    with closing(sqlite3.connect(path, isolation_level=None)) as plain:
        plain.execute("PRAGMA foreign_keys = OFF")
        this, own = middle_row(plain, table)
        try:
            plain.execute(f"UPDATE {table} SET {column} = {value} WHERE {this}", own)
        except sqlite3.Error as error:
            pytest.skip(f"SQLite cannot store it: {error}")
        plain.execute("PRAGMA writable_schema = ON")
        plain.execute("UPDATE sqlite_schema SET sql = ? WHERE name = ?", (sql, table))
        plain.execute(f"PRAGMA schema_version = {version + 2}")


@pytest.mark.slow
@pytest.mark.parametrize(("table", "column", "value"), fuzz_but(FIRST, ALL))
def test_a_damaged_value_is_a_line_of_the_report(whole, tmp_path, cli, table, column, value):
    path = Path(shutil.copy(whole, tmp_path / "orbits.db"))
    put(path, table, column, VALUES[value])
    outcome = cli("verify", "--births", "--format", "csv")
    assert (outcome.code, "Traceback" in outcome.err) == (1, False), outcome.err
    assert {line.split(",")[0] for line in outcome.out.splitlines()[1:]} <= set(PROMISES)
    assert len(outcome.out.splitlines()) > 8, outcome.out
