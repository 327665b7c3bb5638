"""A damaged or altered file gives a one-line error, never a traceback, and `verify` finds the damage."""

import random
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from contents import alter, ask
from processes import run_several, seeded
from quick import fuzz_but, slow_but

from orbitdb.store.tables import PAGE_SIZE

COMMANDS = (
    ["query", "--p", "5", "--json"],
    ["query", "--code", "1232131"],
    ["table"],
    ["info"],
    ["fill", "--p", "8"],
    ["fill", "--p", "5", "--a", "1"],
    ["export", "--format", "csv", "-c", "+coordinates", "--p", "6"],
    ["verify"],
)
UNCHECKED = {
    "fill": {"seconds", "enumerating", "solving", "storing", "cursor", "words"},
    "run": {"started", "version", "parameters"},
    "orbit": {"iterations", "run"},
    "stadium": set(),
}
"""Columns that cannot be recomputed: times and provenance."""


def judge(found: list[tuple[list[str], int, str]]) -> int:
    """Check exit codes and messages of commands; return the exit code of ``verify``."""
    for arguments, code, err in found:
        allowed = {0, 1, 3} if arguments[0] == "verify" else {0, 3}
        assert code in allowed, (arguments, code, err)
        assert "Traceback" not in err
        assert code != 3 or len(err.splitlines()) == 1, (arguments, err)
    return found[-1][1]


def checked_rows(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    """Return everything that ``verify`` checks."""
    tables = {}
    with closing(sqlite3.connect(path)) as plain:
        plain.text_factory = bytes
        for table in ("cycle", "element", "pruned", "orbit", "fill", "stadium"):
            names = [row[1].decode() for row in plain.execute(f"PRAGMA table_info({table})")]
            wanted = ", ".join(name for name in names if name not in UNCHECKED.get(table, set()))
            tables[table] = plain.execute(f"SELECT {wanted} FROM {table} NOT INDEXED").fetchall()
    return tables


def put(path: Path, data: bytes) -> None:
    """Write a file without a journal."""
    for part in path.parent.glob(f"{path.name}-*"):
        part.unlink()
    path.write_bytes(data)


def truncated(data: bytes, moments: random.Random) -> bytes:
    return data[: moments.randrange(100, len(data))]


def noisy_page(data: bytes, moments: random.Random) -> bytes:
    start = PAGE_SIZE * moments.randrange(len(data) // PAGE_SIZE)
    return data[:start] + moments.randbytes(PAGE_SIZE) + data[start + PAGE_SIZE :]


def empty_page(data: bytes, moments: random.Random) -> bytes:
    start = PAGE_SIZE * moments.randrange(len(data) // PAGE_SIZE)
    return data[:start] + bytes(PAGE_SIZE) + data[start + PAGE_SIZE :]


def flipped_bit(data: bytes, moments: random.Random) -> bytes:
    place, bit = moments.randrange(len(data)), moments.randrange(8)
    return data[:place] + bytes([data[place] ^ 1 << bit]) + data[place + 1 :]


@pytest.mark.parametrize("harm", slow_but(1, [noisy_page, truncated, empty_page, flipped_bit]))
def test_damage_is_reported_in_one_line(filled, cli, harm):
    broken = filled.with_name("broken.db")
    broken.write_bytes(harm(filled.read_bytes(), seeded(1)))
    ends = [(each, cli(*each, "--db", str(broken))) for each in COMMANDS]
    judge([(arguments, end.code, end.err) for arguments, end in ends])


def test_a_file_that_was_cut_short_gets_no_journal(filled, cli):
    with filled.open("r+b") as file:
        file.truncate(filled.stat().st_size // 3)
    before = sorted(filled.parent.iterdir())
    assert cli("info").says(3, f"{filled} is damaged: restore a copy, or move it away and fill a new one")
    assert sorted(filled.parent.iterdir()) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("harm", "times"),
    fuzz_but([(noisy_page, 1)], [(truncated, 1), (noisy_page, 1), (empty_page, 1), (flipped_bit, 8)]),
)
def test_verify_finds_all_damage_to_checked_rows(filled, harm, times):
    moments, data, sound = seeded(2026), filled.read_bytes(), checked_rows(filled)
    broken = filled.with_name("broken.db")
    for _ in range(times):
        harmed = harm(data, moments)
        put(broken, harmed)
        if judge(run_several([["verify"]], broken)) == 0:
            assert checked_rows(broken) == sound
        put(broken, harmed)
        judge(run_several(COMMANDS, broken))


def test_a_period_that_became_null_is_reported(filled, cli):
    """A flipped bit can make NULL of any value."""
    rule, none = "p INTEGER NOT NULL", "p INTEGER"
    for change in (
        f"UPDATE sqlite_schema SET sql = replace(sql, '{rule}', '{none}') WHERE name = 'cycle'",
        "UPDATE cycle SET p = NULL WHERE word = '0113'",
        f"UPDATE sqlite_schema SET sql = replace(sql, '{none}', '{rule}') WHERE name = 'cycle'",
    ):
        alter(filled, change)
    assert ask(filled, "SELECT count(*) FROM cycle WHERE p + 0 IS NULL") == [(1,)]
    outcome = cli("verify", "--db", str(filled))
    assert outcome.code == 1
    assert "NULL value in cycle.p" in outcome.out + outcome.err
