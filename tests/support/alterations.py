"""Make files with rows in every table, and find a row to alter in each of them."""

import sqlite3
from collections.abc import Sequence
from pathlib import Path

from processes import run_here

EVERYTHING = [
    ["fill", "--p", "5"],
    ["fill", "--p", "4", "--a", "0.5"],
    ["fill", "--p", "3", "--a", "2", "--method", "relaxation"],
    ["fill", "--p", "2-3", "--geometric"],
    ["fill", "--code", "1^30 5^29"],
    ["fill", "--code", "0^30 1"],
    ["births", "--p", "7"],
    ["sweep", "--p", "7"],
    ["verify", "--prove", "--p", "2-4", "--a", "1.6"],
    ["simulate", "--bounces", "3000"],
    ["bounds", "--edges", "5"],
    ["escape", "--opening", "top:-0.3:0.3", "--trajectories", "1000", "--bounces", "10"],
]
"""Commands that store rows in every table, except for levels, and blocks of a sweep that is not done."""

LEVELS = [["levels", "--k", "0:4", "--parity", "oo"]]
"""For a file of its own, because checking levels takes a second."""


def make(path: Path, commands: Sequence[Sequence[str]]) -> None:
    """Make a catalogue with commands; fail if one of them does."""
    for command, code, err in run_here(commands, path):
        assert code == 0, (command, err)


def middle_row(plain: sqlite3.Connection, table: str, where: str = "TRUE") -> tuple[str, tuple[object, ...]]:
    """Return a condition that chooses one row in the middle of a table, and the values of its keys."""
    keys = [name for _, name, _, _, _, key in plain.execute(f"PRAGMA table_info({table})") if key]
    rows = f"FROM {table} WHERE {where}"
    offset = f"(SELECT count(*) / 2 {rows})"
    own = plain.execute(f"SELECT {', '.join(keys)} {rows} ORDER BY {', '.join(keys)} LIMIT 1 OFFSET {offset}")
    return " AND ".join(f"{key} = ?" for key in keys), own.fetchone()
