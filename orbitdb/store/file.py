"""The file of a catalogue: its path, what kind of file it is, reading it, and creating or upgrading it."""

import os
import sqlite3
import stat
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from orbitdb.errors import StoreError
from orbitdb.store.connection import (
    beside,
    open_sqlite,
    open_to_read,
    place,
    places_beside,
    plain_errors,
    reading_engine,
    refuse_foreign_journal,
    remove_journal_of,
    unchanged,
    uri_of,
    waiting,
    writing_engine,
)
from orbitdb.store.schema import (
    APPLICATION_ID,
    OLDEST_VERSION,
    REVISIONS,
    SCHEMA_VERSION,
    TABLES,
    VIEWS,
)
from orbitdb.symbols.symmetry import ELEMENT_ROWS

if TYPE_CHECKING:
    import sqlalchemy as sa

# the path


def default_path() -> Path:
    """Return the path of the default catalogue: ORBITDB_DB, or ``orbits.db`` in the user's data folder."""
    named = os.environ.get("ORBITDB_DB")
    return home_expanded(named) if named else data_folder() / "orbits.db"


def home_expanded(path: Path | str) -> Path:
    """Return a path with the home folder in place of ``~``, which shells leave as it is within quotes."""
    return Path(os.path.expanduser(path))


def absolute_path(path: Path | str | None) -> Path:
    """Return the absolute path of a catalogue, so that it does not follow `os.chdir`; None is the default."""
    return (default_path() if path is None else home_expanded(path)).absolute()


def data_folder() -> Path:
    """Return the user's data folder for orbitdb."""
    from platformdirs import user_data_path

    return user_data_path("orbitdb", appauthor=False)


# what kind of file it is


def check_file(path: Path) -> int | None:
    """Return the schema version of a file, or None if the file is missing or empty.

    Raises
    ------
    StoreError
        If the file is not a catalogue, or its schema is newer or older than this version can read.
    """
    try:
        try:
            status = path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return None
        if stat.S_ISDIR(status.st_mode):
            raise StoreError(f"{path} is a folder: name a file")
        if not stat.S_ISREG(status.st_mode):
            raise StoreError(f"{path} is not an ordinary file: name another")
        if status.st_size == 0:
            return None
    except OSError as error:
        raise StoreError(f"{path} cannot be read ({error.strerror}): check its permissions") from error
    marks = _marks(path)
    if not marks.application and not marks.version and marks.pages <= 1:
        return None  # a database without tables, because its creation was interrupted
    if marks.application != APPLICATION_ID:
        if marks.ours:
            pragmas = f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {SCHEMA_VERSION}"
            raise StoreError(
                f"{path} lacks two marks of a catalogue, which .dump leaves out: "
                f'"{pragmas}" in sqlite3 adds them'
            )
        raise StoreError(f"{path} is another program's SQLite database: name another file")
    if marks.version > SCHEMA_VERSION:
        raise StoreError(
            f"{path} has schema {marks.version}, newer than this orbitdb's {SCHEMA_VERSION}: upgrade orbitdb"
        )
    if marks.version < OLDEST_VERSION:
        raise StoreError(
            f"{path} was made by a development version of orbitdb (schema {marks.version}): "
            "move it away, and fill a new one"
        )
    return marks.version


def need_newest(path: Path) -> None:
    """Raise `StoreError`, which says what to do, unless the file is a catalogue with the latest schema."""
    version = check_file(path)
    if version is None:
        there = "" if path.absolute() == absolute_path(None) else f" --db {path}"
        raise StoreError(f"no catalogue at {path}: make one with 'orbitdb fill --p 11{there}'")
    if version < SCHEMA_VERSION:
        raise StoreError(f"{path} has the older schema {version}: run 'orbitdb migrate' first")


class _Marks(NamedTuple):
    """What tells a catalogue from other SQLite files; `ours` if Alembic's table names the latest schema."""

    pages: int
    version: int
    application: int
    ours: bool


def _marks(path: Path) -> _Marks:
    """Return what kind of database a file is, including changes that are still in the journal.

    Only SQLite may open the file. A process that closes a file loses all its locks on it (POSIX), including
    those of SQLite's connections, and other processes could then remove the journal while it is in use.
    """
    if not beside(path)[0].exists():
        with suppress(sqlite3.Error, UnicodeDecodeError):  # damaged, or being written at this moment
            return _read_marks(uri_of(path) + "&immutable=1")
    refuse_foreign_journal(path)
    with plain_errors(path):
        return _read_marks(uri_of(path))


def _read_marks(uri: str) -> _Marks:
    with closing(open_sqlite(uri)) as connection:
        names = ("page_count", "user_version", "application_id")
        pages, version, application = (connection.execute(f"PRAGMA {name}").fetchone()[0] for name in names)
        ours = False
        with suppress(sqlite3.OperationalError):
            (revision,) = connection.execute("SELECT version_num FROM alembic_version").fetchone() or ("",)
            ours = revision == f"{SCHEMA_VERSION:04}"
        return _Marks(pages, version, application, ours)


# reading


@dataclass(frozen=True)
class Moment:
    """A read transaction on a catalogue; all answers taken from it are consistent with one another.

    Attributes
    ----------
    connection : sqlalchemy.Connection
        A connection that sees the file as it was when the transaction began.
    path : Path
        The path of the file.
    """

    connection: "sa.Connection"
    path: Path


class Reader:
    """A catalogue file to read; each call of `moment` starts a `Moment` of the file then at the path.

    Between moments the file is closed.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.

    Raises
    ------
    StoreError
        If there is no catalogue at the path, or this version cannot read it.
    """

    def __init__(self, path: Path | str | None = None) -> None:
        need_newest(default_path() if path is None else home_expanded(path))
        self.path = absolute_path(path)
        self._place = place(self.path)
        self._engine = reading_engine(self.path)

    @contextmanager
    def moment(self) -> Iterator[Moment]:
        """Yield a read transaction; changes made meanwhile appear in the next one."""
        if place(self.path) != self._place:  # another file has taken its place
            need_newest(self.path)
            self._place = place(self.path)
        with unchanged(self.path), plain_errors(self.path), self._engine.begin() as connection:
            journal = places_beside(self.path)
            try:
                yield Moment(connection, self.path)
            finally:
                remove_journal_of(self.path, self._place, journal)


@contextmanager
def reading(path: Path | str | None = None) -> Iterator[Moment]:
    """Open a catalogue for a single moment, and close it afterwards."""
    with Reader(path).moment() as moment:
        yield moment


@contextmanager
def asking(path: Path) -> Iterator[sqlite3.Connection]:
    """Yield a connection in a read transaction, without importing SQLAlchemy."""
    need_newest(path)
    with unchanged(path), plain_errors(path), closing(open_to_read(path)) as connection:
        waiting(lambda: connection.execute("BEGIN"))
        yield connection


# creating and upgrading


MIGRATIONS = str(resources.files("orbitdb.migrations"))
"""The folder of the Alembic revisions."""


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
            f"{folder} cannot be created ({error.strerror}): name a file in another folder"
        ) from error
    if not folder.is_dir():
        raise StoreError(f"there is no folder {folder}: create it first, or name another file")
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


def _create(connection: "sa.Connection") -> None:
    """Create the latest schema directly, and record its version for Alembic."""
    for statement in (*TABLES.values(), *VIEWS.values(), REVISIONS):
        connection.exec_driver_sql(statement)
    connection.exec_driver_sql("INSERT INTO element VALUES (?, ?, ?)", ELEMENT_ROWS)
    connection.exec_driver_sql("INSERT INTO alembic_version VALUES (?)", (f"{SCHEMA_VERSION:04}",))


def upgrade_tables(connection: "sa.Connection") -> None:
    """Run the missing migrations on an open database."""
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", MIGRATIONS)
    config.attributes["connection"] = connection
    command.upgrade(config, "head")
