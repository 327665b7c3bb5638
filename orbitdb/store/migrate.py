"""Bringing a database file to the newest schema."""

from importlib import resources
from pathlib import Path

import sqlalchemy as sa

from orbitdb.store.database import check_file, plain_errors, writing_engine
from orbitdb.store.schema import APPLICATION_ID, SCHEMA_VERSION


def migrate(path: Path) -> tuple[int, int]:
    """Create a catalogue, or bring an older one to the newest schema, in one transaction.

    Returns
    -------
    tuple of int
        The schema's version before (0: there was none) and after.

    Raises
    ------
    StoreError
        If the file is not a catalogue or cannot be written.
    """
    before = check_file(path) or 0
    if before == SCHEMA_VERSION:
        return before, before
    with plain_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        engine = writing_engine(path)
        with engine.begin() as connection:
            _upgrade(connection)
            connection.exec_driver_sql(f"PRAGMA application_id = {APPLICATION_ID}")
            connection.exec_driver_sql(f"PRAGMA user_version = {SCHEMA_VERSION}")
        engine.dispose()
    return before, SCHEMA_VERSION


def _upgrade(connection: sa.Connection) -> None:
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(resources.files("orbitdb.migrations")))
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
