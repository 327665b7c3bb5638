"""Create a database file, or upgrade one to the latest schema."""

import shutil
import sqlite3
from contextlib import closing, suppress
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.store.file.database import check_file, data_folder, to_write, writing_engine
from orbitdb.store.file.guard import plain_errors
from orbitdb.store.file.schema import APPLICATION_ID, REVISIONS, SCHEMA_VERSION, TABLES, VIEWS
from orbitdb.symbols.symmetry import ELEMENT_ROWS


class Migration(NamedTuple):
    """The schema versions before (0 for a new file) and after, and the path of a backup of the older file."""

    before: int
    after: int
    backup: Path | None


def migrate(path: Path) -> Migration:
    """Create a catalogue, or back up an older one and upgrade it, in a single transaction."""
    before = check_file(path) or 0
    if before == SCHEMA_VERSION:
        return Migration(before, before, None)
    folder = path.parent
    try:
        if folder == data_folder():
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be created ({error.strerror}): name a file in another folder with --db"
        ) from error
    if not folder.is_dir():
        raise StoreError(f"there is no folder {folder}: create it first, or name another file with --db")
    backup = None
    with plain_errors(path):
        engine = writing_engine(path, references=False)  # all referenced rows are rewritten
        with engine.begin() as connection:
            before = int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())
            if before != SCHEMA_VERSION:  # another process may have upgraded it meanwhile
                if before:
                    _check_room(path)
                    backup = _back_up(path, before)  # no other process can write now
                    upgrade_tables(connection)
                else:
                    _create(connection)
                connection.exec_driver_sql(f"PRAGMA application_id = {APPLICATION_ID}")
                connection.exec_driver_sql(f"PRAGMA user_version = {SCHEMA_VERSION}")
        engine.dispose()
    if backup:  # free unused pages, unless the disk is full or another process writes
        with suppress(StoreError), plain_errors(path), closing(to_write(path, references=False)()) as own:
            own.execute("VACUUM")
    return Migration(before, SCHEMA_VERSION, backup)


def _check_room(path: Path) -> None:
    """Raise `StoreError` if the disk has no room for a backup and a journal of the same size."""
    parts = (path, path.with_name(path.name + "-wal"))
    needed = 2 * sum(part.stat().st_size for part in parts if part.exists())
    free = shutil.disk_usage(path.resolve().parent).free
    if needed > free:
        raise StoreError(
            f"no room to upgrade {path} to schema {SCHEMA_VERSION}: this needs {needed / 1e6:.1f} MB, but "
            f"{free / 1e6:.1f} MB are free: free some space, or copy it to another disk and name it with --db"
        )


def _back_up(path: Path, version: int) -> Path:
    """Copy a database, including its journal; the copy gets its name when it is complete."""
    backup = path.with_name(f"{path.name}.schema-{version}")
    draft = backup.with_name(backup.name + ".part")
    parts = (draft, draft.with_name(draft.name + "-journal"))
    try:
        for part in parts:
            part.unlink(missing_ok=True)  # left by a killed migration
        with closing(sqlite3.connect(path)) as old, closing(sqlite3.connect(draft)) as copy:
            old.backup(copy)
        draft.replace(backup)
    except OSError as error:
        raise StoreError(f"{backup} cannot be written ({error.strerror}); nothing was changed") from error
    finally:
        for part in parts:
            part.unlink(missing_ok=True)
    return backup


def _create(connection: sa.Connection) -> None:
    """Create the latest schema directly, and record its version for Alembic."""
    for statement in (*TABLES.values(), *VIEWS.values(), REVISIONS):
        connection.exec_driver_sql(statement)
    connection.exec_driver_sql("INSERT INTO element VALUES (?, ?, ?)", ELEMENT_ROWS)
    connection.exec_driver_sql("INSERT INTO alembic_version VALUES (?)", (f"{SCHEMA_VERSION:04}",))


def upgrade_tables(connection: sa.Connection) -> None:
    """Run the missing migrations on an open database."""
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(resources.files("orbitdb.migrations")))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
