"""Files from elsewhere are only read: active content is refused, and altered rows are shown or refused."""

import contextlib
import json
import re
import sqlite3
from pathlib import Path

import pytest
from contents import alter, ask
from quick import slow_but

from orbitdb.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.store.file.guard import TamperedError
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.schema import SCHEMA_VERSION, TABLES, VIEWS
from orbitdb.store.file.tables import metadata
from orbitdb.store.reading.moment import reading

NAMES = re.findall(r" AS (\w+)[,\n]", VIEWS["catalogue"].partition("AS\n")[2])

LOOP = "WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)"


def rewritten(table: str, before: str, after: str) -> str:
    """Return a statement that edits the SQL text of a table."""
    return f"UPDATE sqlite_master SET sql = replace(sql, '{before}', '{after}') WHERE name = '{table}'"


HOSTILE = {
    "a trigger": ["CREATE TRIGGER t AFTER INSERT ON run BEGIN DELETE FROM orbit; END"],
    "a trigger on the view": [
        "CREATE TRIGGER t INSTEAD OF INSERT ON catalogue BEGIN DELETE FROM orbit; END"
    ],
    "a view for a table": [
        "ALTER TABLE fill RENAME TO old", f"CREATE VIEW fill AS {LOOP} SELECT old.* FROM old, n"
    ],
    "a virtual table": ["CREATE VIRTUAL TABLE mine USING fts5(x)"],
    "a virtual table for a table": [
        "DROP TABLE trajectory", "CREATE VIRTUAL TABLE trajectory USING fts5(x)"
    ],
    "a generated column": ["ALTER TABLE run ADD COLUMN more INTEGER AS (abs(id))"],
    "a check": [rewritten("run", "PRIMARY KEY", "CHECK (abs(id) > 0), PRIMARY KEY")],
    "a check in a table beside": ["CREATE TABLE mine (x CHECK (abs(x) > 0))"],
    "a default that is computed": [rewritten("run", "version TEXT", "version TEXT DEFAULT (random())")],
    "an index of an expression": ["CREATE INDEX i ON run (abs(id))"],
    "a table that takes anything": [rewritten("run", "STRICT", "")],
    "a table less": ["DROP TABLE certificate"],
    "a table in capitals": ["ALTER TABLE fill RENAME TO other", "ALTER TABLE other RENAME TO FILL"],
}  # fmt: skip

QUICK = ["a trigger", "a table less", "a virtual table for a table",
         "a default that is computed", "a table in capitals"]  # fmt: skip

BROKEN = {
    "a text that is no SQL": ["UPDATE sqlite_master SET sql = 'CREATE TABLE' WHERE name = 'run'"],
    "a trigger called a table": [
        *HOSTILE["a trigger"], "UPDATE sqlite_master SET type = 'table' WHERE name = 't'"
    ],
    "a trigger called otherwise": [
        *HOSTILE["a trigger"], "UPDATE sqlite_master SET name = 'u' WHERE name = 't'"
    ],
    "a table within itself": ["UPDATE sqlite_master SET rootpage = 1 WHERE name = 'run'"],
}  # fmt: skip

USES = [
    ["query"], ["query", "--code", "13"], ["query", "--where", "p = 3"], ["table"], ["info"], ["entropy"],
    ["lyapunov"], ["export", "--format", "csv"], ["plot", "orbit", "--code", "013", "-o", "o.svg"],
    ["plot", "lengths", "-o", "o.svg"], ["fill", "--p", "3"], ["fill", "--code", "0133"],
    ["simulate", "--bounces", "1000"],
]  # fmt: skip


VIEWED = {
    "an endless view": [
        "DROP VIEW catalogue",
        f"CREATE VIEW catalogue AS {LOOP} SELECT {', '.join(f'x AS {name}' for name in NAMES)} FROM n",
    ],
    "a view with a row more": [
        "DROP VIEW catalogue",
        VIEWS["catalogue"].replace("cycle AS cycle", "cycle AS cycle, random() AS more"),
    ],
    "another view of lives": ["DROP VIEW life", VIEWS["life"].replace("'born'", "'died'")],
    "a view that asks for another text": ["DROP VIEW life", VIEWS["life"].replace("'born'", "'bo rn'")],
    "no view of lives": ["DROP VIEW life"],
    "a table for the view": ["DROP VIEW catalogue", f"CREATE TABLE catalogue ({', '.join(NAMES)})"],
}  # fmt: skip
"""Changes to the views of a file, which only other programs use."""


def hostile(path: Path, statements: list[str]) -> None:
    try:
        alter(path, *statements)
    except sqlite3.OperationalError as error:  # this SQLite has no fts5, or cannot drop columns
        pytest.skip(str(error))


@pytest.mark.parametrize("name", slow_but([*QUICK, *[*BROKEN][:1]], [*HOSTILE, *BROKEN]))
def test_a_file_with_active_content_is_refused(own, cli, monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    hostile(own, (HOSTILE | BROKEN)[name])
    before = own.read_bytes()
    for arguments in USES if name == "a trigger" else USES[:: len(USES) - 2]:
        outcome = cli(*arguments)
        assert (outcome.code, outcome.out) == (3, ""), (arguments, outcome)
        assert len(outcome.err.splitlines()) == 1
        assert "is not as orbitdb made it" in outcome.err or "is damaged" in outcome.err
    assert own.read_bytes() == before
    with pytest.raises(StoreError):
        Catalogue(own)


@pytest.mark.parametrize("name", slow_but(QUICK, HOSTILE))
def test_verify_names_active_content_and_runs_none_of_it(own, cli, name):
    hostile(own, HOSTILE[name])
    outcome = cli("verify", "--json")
    assert outcome.code == 1
    (row,) = json.loads(outcome.out)
    assert row["check"] == "schema"
    assert row["failures"] >= 1
    assert row["first"]
    assert "nothing in it was run" in outcome.err


def test_a_file_with_a_trigger_is_not_migrated(own, cli):
    alter(own, *HOSTILE["a trigger"], f"PRAGMA user_version = {SCHEMA_VERSION - 1}")
    before = own.read_bytes()
    for arguments in (["migrate"], ["fill", "--p", "3"]):
        outcome = cli(*arguments)
        assert outcome.code == 3
        assert "trigger t" in outcome.err
    assert own.read_bytes() == before


def test_brackets_in_a_comment_are_not_taken_for_an_expression(own):
    alter(own, "CREATE INDEX quick /* (of periods) */ ON fill (p)")
    assert Catalogue(own).count() > 0


@pytest.mark.slow
def test_harmless_additions_by_users_are_allowed(own, cli):
    """A view with an unknown name is never run, however long it would take."""
    alter(
        own,
        "CREATE TABLE mine (word TEXT DEFAULT 'a', \"check (x)\" REAL, at TEXT DEFAULT CURRENT_TIMESTAMP)",
        'CREATE TABLE "my notes" (id INTEGER PRIMARY KEY, size DECIMAL(10, 2)) -- CHECK (1)',
        "CREATE INDEX fast ON orbit (length)",
        "CREATE UNIQUE INDEX mine_word ON mine (word COLLATE nocase, at DESC)",
        f"CREATE VIEW pragma_table_list AS {LOOP} SELECT x FROM n",
        "ANALYZE",
    )
    assert cli("query").code == 0
    assert cli("fill", "--p", "7").code == 0
    assert cli("verify").code == 0


def test_a_new_catalogue_is_accepted_and_opened_safely(tmp_path):
    path = tmp_path / "new.db"
    Catalogue.create(path)
    with reading(path) as moment:
        connection = moment.connection
        texts = connection.exec_driver_sql("SELECT sql FROM sqlite_master WHERE type = 'view'").scalars()
        assert sorted(text.split() for text in texts) == sorted(text.split() for text in VIEWS.values())
        assert connection.exec_driver_sql("PRAGMA trusted_schema").scalar() == 0
        assert connection.exec_driver_sql("PRAGMA cell_size_check").scalar() == 1
        assert connection.exec_driver_sql("PRAGMA query_only").scalar() == 1
    assert set(NAMES) >= {"code", "a", "length"}


def test_a_change_to_any_table_is_found(tmp_path):
    migrate(new := tmp_path / "new.db")
    for name in TABLES:
        path = tmp_path / f"{name}.db"
        path.write_bytes(new.read_bytes())
        alter(path, f"ALTER TABLE {name} ADD COLUMN more TEXT")
        with pytest.raises(TamperedError, match=f"table {name}") as caught:
            Catalogue(path)
        assert caught.value.faults == [f"table {name}"]


VALUES = ["''", "'x'", "NULL", "0", "-1", "9223372036854775807", "9e999", "1e308", "5e-324", "x'00'", "'1,9'",
          "printf('%.*c', 3000, '1')", "cast(x'ff80' AS TEXT)", "char(27) || '[31m'", "'=1+1'"]  # fmt: skip

DELETIONS = ["cycle WHERE id % 5 = 2", "pruned", "element WHERE n = 1", "stadium WHERE id = 1", "fill", "run",
             "orbit WHERE cycle % 5 = 1"]  # fmt: skip

READING = [
    ["births"], ["table", "--a", "0.7"], ["entropy", "--a", "0.7"],
    ["query"], ["query", "--json"], ["query", "--format", "csv"], ["query", "--code", "013"], ["table"],
    ["info"], ["entropy"], ["lyapunov"], ["export", "--format", "csv", "--coordinates"],
    ["verify", "--p", "2-4"], ["export", "--format", "jsonl"], ["plot", "sheet", "--p", "3", "-o", "o.svg"],
]  # fmt: skip


def alterations() -> list[str]:
    columns = [(table.name, column.name) for table in metadata.sorted_tables for column in table.columns]
    updates = [
        f"UPDATE OR IGNORE {table} SET {name} = {value}" for table, name in columns for value in VALUES
    ]
    return updates + [f"DELETE FROM {which}" for which in DELETIONS]


def try_altered(own: Path, cli, statements: list[str], sound: bytes) -> None:
    for number, statement in enumerate(statements):
        path = own.with_name(f"{number}.db")  # a new one, because the last may still be open
        path.write_bytes(sound)
        with contextlib.suppress(sqlite3.IntegrityError):
            alter(path, statement)
        for arguments in READING[number % len(READING) :: 6]:
            code, out, err = cli(*arguments, "--db", str(path))
            assert code in (0, 1, 2, 3), (statement, arguments)
            assert code == 0 or err, (statement, arguments)
            assert all(symbol.isprintable() or symbol in "\t\n" for symbol in out + err), (
                statement,
                arguments,
            )


@pytest.mark.parametrize("share", [300, pytest.param(60, marks=pytest.mark.fuzz)])
@pytest.mark.slow
def test_altered_rows_are_shown_or_refused(own, cli, monkeypatch, tmp_path, share):
    monkeypatch.chdir(tmp_path)
    try_altered(own, cli, alterations()[::share], own.read_bytes())


@pytest.mark.parametrize("name", slow_but(["an endless view", "a table for the view"], VIEWED))
def test_the_views_of_a_file_are_never_run_but_renewed(own, cli, name):
    rows = cli("query", "--limit", "9").out
    hostile(own, VIEWED[name])
    assert cli("query", "--limit", "9").out == rows
    assert cli("sql", "SELECT count(*) AS n FROM catalogue").code == 0
    assert cli("sql", "SELECT p FROM main.catalogue").says(2, "may read")
    found = json.loads(cli("verify", "--json").out)
    (row,) = (each for each in found if each["failures"])
    assert row["check"] == "schema"
    assert row["first"].startswith("view ")
    assert cli("simulate", "--bounces", "1000").code == 0
    if name != "a table for the view":  # a user's table with this name is left alone
        assert cli("verify").code == 0
        assert {text for (text,) in ask(own, "SELECT sql FROM sqlite_master WHERE type = 'view'")} >= {
            *VIEWS.values()
        }
