"""A new revision upgrades a file in one transaction; files of development versions are refused."""

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from contents import alter, ask, content

from orbitdb.errors import StoreError
from orbitdb.store import file
from orbitdb.store.file import check_file, migrate, need_newest
from orbitdb.store.tables import APPLICATION_ID, SCHEMA_VERSION

NEXT = SCHEMA_VERSION + 1
REVISION = f"""
from alembic import op
revision, down_revision = "{NEXT:04}", "{SCHEMA_VERSION:04}"
branch_labels = depends_on = None

def upgrade():
    op.execute("CREATE TABLE extra (id INTEGER PRIMARY KEY, name TEXT NOT NULL) STRICT")
    op.execute("INSERT INTO extra VALUES (1, 'new')")
"""


@pytest.fixture
def newer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Make this the next version of orbitdb, whose schema has one more table; return its revision."""
    folder = tmp_path / "migrations"
    shutil.copytree(file.MIGRATIONS, folder, ignore=shutil.ignore_patterns("__pycache__"))
    revision = folder / "versions" / f"v{NEXT:04}_extra.py"
    revision.write_text(REVISION)
    monkeypatch.setattr(file, "MIGRATIONS", str(folder))
    monkeypatch.setattr(file, "SCHEMA_VERSION", NEXT)
    return revision


def test_a_revision_upgrades_a_file_and_loses_nothing(filled, newer, cli):
    before = content(filled)
    assert cli("query", "13", "--db", str(filled)).says(3, "older schema", "orbitdb migrate")
    done = cli("migrate", "--db", str(filled))
    assert done.code == 0
    assert done.err == f"{filled}: schema {SCHEMA_VERSION} -> {NEXT}\n"
    assert ask(filled, "SELECT name FROM extra") == [("new",)]
    assert ask(filled, "SELECT version_num FROM alembic_version") == [(f"{NEXT:04}",)]
    assert content(filled) == before
    assert cli("query", "13", "--db", str(filled)).code == 0


def test_a_failed_upgrade_leaves_the_file_unchanged(filled, newer):
    newer.write_text(REVISION + "    op.execute('SELECT * FROM nowhere')\n")
    before = ask(filled, "SELECT type, name, sql FROM sqlite_master")
    with pytest.raises(StoreError):
        migrate(filled)
    assert ask(filled, "SELECT type, name, sql FROM sqlite_master") == before
    assert check_file(filled) == SCHEMA_VERSION


@pytest.mark.parametrize("version", [1, 6, SCHEMA_VERSION - 1])
def test_files_of_development_versions_are_refused(filled, version):
    alter(filled, f"PRAGMA user_version = {version}")
    before = filled.read_bytes()
    for use in (check_file, migrate, need_newest):
        with pytest.raises(StoreError, match=rf"development version .*schema {version}\): .*fill a new one$"):
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
