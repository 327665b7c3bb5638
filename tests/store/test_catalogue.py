"""The database file: its schema, what is refused, and what survives."""

import re
import sqlite3

import pytest
import sqlalchemy as sa
from contents import alter
from older import empty

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.errors import StoreError
from orbitdb.store.asking.conditions import COLUMNS
from orbitdb.store.asking.expressions import names_in
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.engines import writing_engine
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.schema import APPLICATION_ID, SCHEMA_VERSION
from orbitdb.store.file.tables import metadata


def plainly(statement: str | None) -> str:
    """SQL without the blanks that mean nothing."""
    return re.sub(r"\s*([(),])\s*", r"\1", " ".join((statement or "").split()))


def schema_of(connection: sa.Connection) -> dict[str, str]:
    found = connection.exec_driver_sql("SELECT name, sql FROM sqlite_master")
    return {name: plainly(statement) for name, statement in found}


def test_a_new_file_is_what_migrations_make_of_an_older_one(tmp_path):
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    path = tmp_path / "new.db"
    assert migrate(path) == (0, SCHEMA_VERSION, None)
    assert migrate(path) == (SCHEMA_VERSION, SCHEMA_VERSION, None)
    with writing_engine(path).begin() as connection:
        context = MigrationContext.configure(connection)
        differing = [each for each in compare_metadata(context, metadata) if each[0] != "remove_constraint"]
        assert differing == []  # which texts are unique, SQLAlchemy need not know
        made, revision = schema_of(connection), context.get_current_revision()
    empty(tmp_path / "migrated.db").close()
    assert migrate(tmp_path / "migrated.db").after == SCHEMA_VERSION
    with writing_engine(tmp_path / "migrated.db").begin() as connection:
        assert schema_of(connection) == made
        assert MigrationContext.configure(connection).get_current_revision() == revision
    with sqlite3.connect(path) as plain:
        assert plain.execute("PRAGMA application_id").fetchone() == (APPLICATION_ID,)
        assert plain.execute("PRAGMA journal_mode").fetchone() == ("wal",)
        names = [row[1] for row in plain.execute("PRAGMA table_info(catalogue)")]
        assert sorted(names) == sorted(COLUMNS)
        tables = dict(plain.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'"))
    plain.close()
    assert all("STRICT" in tables[name] for name in metadata.tables)


def test_other_databases_folders_and_nothing_are_refused(tmp_path):
    other = tmp_path / "other.db"
    alter(other, "CREATE TABLE somebody (elses INTEGER)")
    with pytest.raises(StoreError, match="another program"):
        Catalogue.create(other)
    with pytest.raises(StoreError, match="folder"):
        Catalogue(tmp_path)
    with pytest.raises(StoreError, match="orbitdb fill"):
        Catalogue(tmp_path / "missing.db")


def test_newer_schema_is_refused(filled):
    alter(filled, f"PRAGMA user_version = {SCHEMA_VERSION + 1}")
    with pytest.raises(StoreError, match="upgrade orbitdb"):
        Catalogue.create(filled)


def test_reading_never_writes(filled):
    before = filled.read_bytes()
    catalogue = Catalogue(filled)
    with pytest.raises(StoreError, match="cannot be written"), catalogue.reading() as connection:
        connection.exec_driver_sql("DELETE FROM orbit")
    assert filled.read_bytes() == before


@pytest.mark.parametrize("names", [["word", "colour"], ["word; DROP TABLE orbit"]])
def test_unknown_columns_are_named(filled, names):
    with pytest.raises(SelectionError, match="the columns are"):
        list(Catalogue(filled).rows(Selection(), names))
    with pytest.raises(SelectionError, match=r"the columns are|order"):
        list(Catalogue(filled).rows(Selection(), order=names[-1]))


def test_names_that_an_expression_uses():
    assert names_in("p > :least and word <> ':no' and length < :most -- :nor\n") == {"least", "most"}
    assert names_in("p > 2") == set()
