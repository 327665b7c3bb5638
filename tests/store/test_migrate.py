"""Revisions upgrade a file in one transaction and lose nothing; a new file is what they lead to."""

import gzip
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from contents import SCHEMA_9, alter, ask, content

from orbitdb import Catalogue
from orbitdb.errors import StoreError
from orbitdb.store import file, tables
from orbitdb.store.file import migrate
from orbitdb.store.file_kind import check_file, need_newest
from orbitdb.store.tables import APPLICATION_ID, SCHEMA_VERSION

NEXT = SCHEMA_VERSION + 1
REVISION = f"""
import sqlalchemy as sa
from alembic import op
revision, down_revision = "{NEXT:04}", "{SCHEMA_VERSION:04}"
branch_labels = depends_on = None

def upgrade():
    with op.batch_alter_table("orbit") as batch:
        batch.add_column(sa.Column("extra", sa.REAL(), nullable=True))
    with op.batch_alter_table("cycle") as batch:
        batch.alter_column("walls", existing_type=sa.Integer(), nullable=True)
"""
ROOT = Path(__file__).parents[2]


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """Unpack the catalogue with schema 9."""
    path = tmp_path / "old.db"
    path.write_bytes(gzip.decompress(SCHEMA_9.read_bytes()))
    return path


@pytest.fixture
def newer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Make this the next version of orbitdb, with changed tables; return its revision."""
    folder = tmp_path / "migrations"
    shutil.copytree(str(file.MIGRATIONS), folder, ignore=shutil.ignore_patterns("__pycache__"))
    revision = folder / "versions" / f"v{NEXT:04}_extra.py"
    revision.write_text(REVISION)
    monkeypatch.setattr(file, "MIGRATIONS", folder)
    monkeypatch.setattr(tables, "SCHEMA_VERSION", NEXT)
    return revision


def schema(path: Path) -> dict[str, list[str]]:
    """Return the lines of each CREATE statement, in any order: SQLite keeps the foreign keys in another."""
    stored = ask(path, "SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL")
    return {name: sorted(line.strip(" ,\t") for line in sql.split("\n")) for name, sql in stored}


def columns(path: Path) -> dict[str, str]:
    """Return the columns of every table.

    The number of transactions, which an upgrade increases, and the moments, which it drops, are left out.
    """
    named = ask(
        path,
        "SELECT m.name, group_concat(c.name) FROM sqlite_master AS m, pragma_table_info(m.name) AS c "
        "WHERE m.type = 'table' AND m.name NOT IN ('sqlite_sequence', 'alembic_version') "
        "AND c.name NOT IN ('commits', 'moments') GROUP BY m.name",
    )
    return dict(named)


def rows(path: Path, of: dict[str, str] | None = None) -> dict[str, list[tuple[object, ...]]]:
    """Return the rows of every table, or those columns that are given."""
    wanted = of or columns(path)
    return {table: ask(path, f"SELECT {names} FROM {table}") for table, names in wanted.items()}


def alembic(path: Path, *command: str) -> subprocess.CompletedProcess[str]:
    """Run the command ``alembic`` on a file, as a developer does."""
    words = [sys.executable, "-m", "alembic", "-x", f"db={path}", *command]
    return subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_new_file_has_the_schema_to_which_the_revisions_lead(tmp_path):
    made, upgraded = tmp_path / "made.db", tmp_path / "upgraded.db"
    Catalogue.create(made)
    assert alembic(upgraded, "upgrade", "head").returncode == 0
    ours, theirs = schema(made), schema(upgraded)
    assert ours.keys() == theirs.keys()
    differing = [name for name in ours if "".join(ours[name]).split() != "".join(theirs[name]).split()]
    assert [name for name in differing if name != "stadium"] == []  # rebuilt, with its name in quotes
    assert rows(made) == rows(upgraded)
    for path in (made, upgraded):
        assert "No new upgrade operations" in (done := alembic(path, "check")).stdout, done.stderr
        assert ask(path, "PRAGMA user_version") == [(SCHEMA_VERSION,)]


@pytest.mark.slow
def test_a_file_of_schema_9_is_read_as_it_is_and_upgraded_without_loss(old, cli):
    known, before, content_before = columns(old), rows(old), old.read_bytes()
    assert ask(old, "PRAGMA user_version") == [(9,)]
    answers = [
        cli(*command, "--db", str(old)).out for command in (["table"], ["query", "--p", "2-5", "--json"])
    ]
    assert Catalogue(old).rows(p=3, status="geometric").notes  # nobody knows whether they are complete
    assert old.read_bytes() == content_before
    assert cli("verify", "--db", str(old)).code == 0
    done = cli("migrate", "--db", str(old))
    assert (done.code, done.err) == (0, f"{old}: schema 9 -> {SCHEMA_VERSION}\n")
    assert rows(old, known) == before
    assert "AUTOINCREMENT" in ask(old, "SELECT sql FROM sqlite_master WHERE name = 'stadium'")[0][0]
    again = [
        cli(*command, "--db", str(old)).out for command in (["table"], ["query", "--p", "2-5", "--json"])
    ]
    assert again == answers
    assert cli("verify", "--db", str(old)).code == 0


def test_a_file_of_schema_9_is_upgraded_before_it_is_written(old, cli):
    assert cli("fill", "--p", "6", "--a", "0.3", "--db", str(old)).code == 0
    assert check_file(old) == SCHEMA_VERSION
    assert ask(old, "SELECT count(*) FROM fill WHERE stadium = 2") == [(5,)]


def test_a_revision_upgrades_a_filled_file_and_loses_nothing(old, newer):
    known, before, tables_before = columns(old), rows(old), schema(old)
    migrate(old)
    assert rows(old, known) == before
    assert ask(old, "PRAGMA table_info(cycle)")[4][3] == 0
    assert ask(old, "SELECT version_num FROM alembic_version") == [(f"{NEXT:04}",)]
    for name in tables_before.keys() & tables.TABLES.keys():
        created = ask(old, f"SELECT sql FROM sqlite_master WHERE name = '{name}'")[0][0]
        assert "STRICT" in created
        assert ("WITHOUT ROWID" in created) == ("WITHOUT ROWID" in " ".join(tables_before[name]))
    assert ask(old, "PRAGMA foreign_key_check") == []
    assert ask(old, "SELECT count(*) FROM catalogue")[0][0] > 100


def test_a_failed_upgrade_leaves_the_file_unchanged(filled, newer):
    newer.write_text(REVISION + "    op.execute('SELECT * FROM nowhere')\n")
    before = ask(filled, "SELECT type, name, sql FROM sqlite_master")
    with pytest.raises(StoreError):
        migrate(filled)
    assert ask(filled, "SELECT type, name, sql FROM sqlite_master") == before
    assert check_file(filled) == SCHEMA_VERSION


def test_a_file_that_must_be_upgraded_to_be_read_says_so(filled, newer, monkeypatch, cli):
    monkeypatch.setattr(tables, "OLDEST_READABLE", NEXT)
    assert cli("query", "13", "--db", str(filled)).says(3, "older schema", "orbitdb migrate")
    assert cli("migrate", "--db", str(filled)).err == f"{filled}: schema {SCHEMA_VERSION} -> {NEXT}\n"
    assert cli("query", "13", "--db", str(filled)).code == 0


@pytest.mark.parametrize("version", [1, 6, 8])
def test_files_of_development_versions_are_refused(filled, version):
    alter(filled, f"PRAGMA user_version = {version}")
    before = filled.read_bytes()
    for use in (check_file, migrate, need_newest):
        with pytest.raises(StoreError, match=rf"development version .*schema {version}\): fill a new one"):
            use(filled)
    assert filled.read_bytes() == before
    assert [each.name for each in filled.parent.iterdir()] == [filled.name]


def test_a_restored_dump_is_told_which_marks_it_lacks(filled, tmp_path, cli):
    restored = tmp_path / "restored.db"
    with closing(sqlite3.connect(filled)) as plain, closing(sqlite3.connect(restored)) as copy:
        copy.executescript("\n".join(plain.iterdump()))
    pragmas = f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {SCHEMA_VERSION}"
    for command in ("info", "migrate"):
        assert cli(command, "--db", str(restored)).says(3, f'"{pragmas}" in sqlite3')
    alter(restored, *pragmas.split("; "))
    assert content(restored) == content(filled)
    assert cli("verify", "--db", str(restored)).code == 0
