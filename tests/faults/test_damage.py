"""A damaged or altered file gives a one-line error, never a traceback, and `verify` finds the damage."""

import gzip
import random
import re
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from contents import SCHEMA_9, alter, ask
from processes import run_several, seeded
from quick import fuzz_but, slow_but

from orbitdb import Catalogue, StoreError
from orbitdb.cli import output
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


def altered_value(path, table, column, value):
    """Put a value into a column that does not allow it, as a flipped bit can."""
    ((sql,),) = ask(path, f"SELECT sql FROM sqlite_schema WHERE name = '{table}'")
    loose = re.sub(r",?\s*STRICT", "", sql.replace(" NOT NULL", ""))
    with closing(sqlite3.connect(path)) as plain:
        for text, change in ((loose, f"UPDATE {table} SET {column} = {value}"), (sql, None)):
            plain.execute("PRAGMA writable_schema = ON")
            plain.execute("UPDATE sqlite_schema SET sql = ? WHERE name = ?", (text, table))
            plain.execute("PRAGMA writable_schema = RESET")
            if change:
                plain.execute("PRAGMA ignore_check_constraints = ON")
                plain.execute(change)
            plain.commit()


VALUES = {
    ("sweep", "sums", "zeroblob(24)"): ["lyapunov"],
    ("sweep", "words", "NULL"): ["table"],
    ("sweep", "sums", "'x'"): ["lyapunov"],
    ("fill", "n_c", "NULL"): ["table"],
    ("fill", "words", "'x'"): ["table"],
    ("entropy_bound", "lower", "NULL"): ["entropy"],
    ("orbit", "length", "NULL"): ["lyapunov", "--p", "2-8"],
    ("orbit", "lyapunov", "-1.0"): ["lyapunov", "--p", "2-8"],
    ("orbit", "lyapunov", "1e-320"): ["lyapunov", "--p", "2-8"],
    ("orbit", "length", "1e308"): ["lyapunov", "--p", "2-8"],
}


@pytest.fixture(scope="module")
def with_values(made_once):
    def make(path: Path) -> None:
        catalogue = Catalogue.create(path, a=1.6)
        catalogue.fill("2-4")
        catalogue.sweep([5])
        catalogue.prove_bounds(3)

    return made_once("values", make)


@pytest.mark.parametrize(("change", "command"), VALUES.items(), ids=".".join)
def test_values_that_cannot_be_read_give_one_line(with_values, tmp_path, cli, change, command):
    path = tmp_path / "orbits.db"
    path.write_bytes(with_values.read_bytes())
    altered_value(path, *change)
    assert cli(*command, "--a", "1.6", "--db", str(path)).says(3, "the catalogue was altered: ")


def test_a_table_that_was_emptied_is_not_an_empty_answer(filled, cli):
    alter(filled, "DELETE FROM orbit")
    assert cli("query", "--p", "7", "--status", "orbit,dynamical").code == 1
    assert cli("query", "--p", "7", "--status", "orbit").says(
        3, "period 7 is filled, but the rows of its 376 words are gone; 'orbitdb verify' shows what is wrong"
    )


def damaged_orbits(path: Path) -> None:
    """Overwrite a page with orbits."""
    ((root,),) = ask(path, "SELECT max(pageno) FROM dbstat WHERE name = 'orbit'")
    with path.open("r+b") as file:
        file.seek((root - 1) * PAGE_SIZE)
        file.write(b"\x55" * PAGE_SIZE)


@pytest.mark.parametrize(
    "question",
    [
        ("query", "--where", "length > 3"),
        ("query", "--order", "length"),
        ("sql", "SELECT sum(length) FROM orbit"),
        ("lyapunov",),
    ],
    ids=" ".join,
)
def test_damage_is_not_the_fault_of_an_expression(filled, cli, question):
    damaged_orbits(filled)
    assert cli(*question, "--format", "json").says(3, f"{filled} is damaged: restore a copy, or move it away")
    assert "remove" not in cli(*question).err  # the journal is this reader's own, and empty


def test_damaged_text_of_the_schema_is_told_like_any_other(filled, cli):
    """The driver's own errors, of texts that are no UTF-8, have no code of SQLite."""
    data = bytearray(filled.read_bytes())
    data[data.index(b"'1,1,-1,-1'") + len("'1,1,")] ^= 0x80
    filled.write_bytes(data)
    for command in ("table", "fill --p 3"):
        assert cli(*command.split()).says(3, f"{filled} is damaged: restore a copy, or move it away")


def test_a_damaged_name_of_a_column_is_not_the_fault_of_the_sql(filled, cli):
    with closing(sqlite3.connect(filled)) as plain:
        plain.execute("PRAGMA writable_schema = ON")
        plain.execute(
            "UPDATE sqlite_schema SET sql = replace(sql, 'lyapunov', 'lyapunow') WHERE name = 'orbit'"
        )
        plain.commit()
    for question in (("sql", "SELECT max(lyapunov) FROM class"), ("query", "--where", "lyapunov < 4")):
        assert cli(*question).says(3, f"{filled} is damaged: restore a copy, or move it away")
    assert cli("sql", "SELECT lyapunow FROM class").says(
        2, "no such column: lyapunow; did you mean lyapunov?"
    )


def test_damage_in_a_snapshot_is_told_like_any_other(filled):
    damaged_orbits(filled)
    with Catalogue(filled, a=1.6).snapshot() as then:
        assert then.fills()
        with pytest.raises(StoreError, match="is damaged: restore a copy"):
            then.sql("SELECT sum(length) FROM orbit").to_pandas()
        with pytest.raises(StoreError, match="is damaged: restore a copy"):
            list(then.rows(order="length"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("INSERT INTO alembic_version VALUES ('0010')", "says '0009', '0010'"),
        ("UPDATE alembic_version SET version_num = 'abcd'", "says 'abcd'"),
        ("DELETE FROM alembic_version", "says nothing"),
    ],
)
def test_a_file_with_an_unknown_revision_is_not_migrated(tmp_path, cli, change, said):
    old = tmp_path / "old.db"
    old.write_bytes(gzip.decompress(SCHEMA_9.read_bytes()))
    alter(old, change)
    before = old.read_bytes()
    assert cli("migrate", "--db", str(old)).says(3, f"has schema 9, but its table alembic_version {said}")
    assert old.read_bytes() == before


def test_a_file_of_one_byte_is_not_an_empty_one(tmp_path, cli):
    one = tmp_path / "one.db"
    one.write_bytes(b"1")
    for command in (("fill", "--p", "3"), ("query", "--p", "3"), ("migrate",)):
        assert cli(*command, "--db", str(one)).says(
            3, "one.db is not an orbitdb catalogue: name another file"
        )
    assert one.read_bytes() == b"1"


@pytest.mark.parametrize("form", ["table", "csv", "markdown", "json"])
def test_names_of_columns_are_written_like_values(filled, cli, form):
    outcome = cli("sql", 'SELECT 1 AS "\x1b[31m", 2 AS "=cmd"', "--format", form)
    assert outcome.code == 0
    assert "\x1b" not in outcome.out
    if form == "csv":
        assert outcome.out.splitlines()[0] == "\\x1b[31m,'=cmd"


def test_endless_rows_are_no_table(filled, cli, monkeypatch):
    monkeypatch.setattr(output, "_MOST_IN_TABLE", 1000)
    endless = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i FROM n"
    for form in ("table", "markdown", "latex"):
        said = "more than 1,000 rows make no table: use --format csv, or a limit"
        assert cli("sql", endless, "--format", form).says(2, said)


def test_many_expressions_are_not_kept(filled):
    catalogue = Catalogue(filled, a=1.6)
    with catalogue.snapshot() as then:
        for number in range(120):
            then.count(where=f"length > {number}.5", p=3)
    engine: Any = catalogue._store
    assert len(engine._engine._compiled_cache) < 100
