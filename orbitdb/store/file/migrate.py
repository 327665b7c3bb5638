"""Create a database file, or upgrade one to the latest schema."""

from importlib import resources
from pathlib import Path
from typing import NamedTuple

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.store.file.database import check_file, data_folder, plain_errors, writing_engine
from orbitdb.store.file.schema import APPLICATION_ID, REVISIONS, SCHEMA_VERSION, TABLES, VIEWS
from orbitdb.symbols.symmetry import ELEMENT_ROWS

MIGRATIONS = str(resources.files("orbitdb.migrations"))


class Migration(NamedTuple):
    """The schema versions before (0 for a new file) and after."""

    before: int
    after: int


def migrate(path: Path) -> Migration:
    """Create a catalogue, or upgrade an older one, in a single transaction."""
    before = check_file(path) or 0
    if before == SCHEMA_VERSION:
        return Migration(before, before)
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
    with plain_errors(path):
        engine = writing_engine(path, references=False, create=True)
        with engine.begin() as connection:
            before = int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())
            if before != SCHEMA_VERSION:  # another process may have upgraded it meanwhile
                if before:
                    upgrade_tables(connection)
                else:
                    _create(connection)
                connection.exec_driver_sql(f"PRAGMA application_id = {APPLICATION_ID}")
                connection.exec_driver_sql(f"PRAGMA user_version = {SCHEMA_VERSION}")
        engine.dispose()
    return Migration(before, SCHEMA_VERSION)


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
    config.set_main_option("script_location", MIGRATIONS)
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
