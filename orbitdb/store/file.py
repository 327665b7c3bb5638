"""The file of a catalogue: what kind of file it is, reading it, and creating or upgrading it."""

import sqlite3
import stat
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from importlib import resources
from pathlib import Path
from typing import NamedTuple

from orbitdb.errors import StoreError
from orbitdb.store.connection import (
    Connection,
    Moment,
    add_code,
    never,
    open_sqlite,
    open_to_read,
    open_to_write,
    plain_errors,
    refuse_foreign_journal,
    transaction,
    unchanged,
    uri_of,
)
from orbitdb.store.paths import (
    absolute_path,
    beside,
    data_folder,
    default_path,
    home_expanded,
    place,
    places_beside,
    remove_journal_of,
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
    version, application, empty = _marks(path)
    if empty:
        return None  # a database without tables, because its creation was interrupted
    if application != APPLICATION_ID:
        pragmas = f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {SCHEMA_VERSION}"
        raise StoreError(
            f"{path} is another program's SQLite database: name another file "
            f'(a catalogue restored from .dump needs "{pragmas}" in sqlite3)'
        )
    if version > SCHEMA_VERSION:
        raise StoreError(
            f"{path} has schema {version}, newer than this orbitdb's {SCHEMA_VERSION}: upgrade orbitdb"
        )
    if version < OLDEST_VERSION:
        raise StoreError(
            f"{path} was made by a development version of orbitdb (schema {version}): "
            "move it away, and fill a new one"
        )
    return version


def need_newest(path: Path, missing_ok: bool = False) -> bool:
    """Raise `StoreError`, which says what to do, unless the file is a catalogue with the latest schema.

    Return False if it is missing, which is an error unless `missing_ok`.
    """
    version = check_file(path)
    if version is None and missing_ok:
        return False
    if version is None:
        there = "" if path.absolute() == absolute_path(None) else f" --db {path}"
        raise StoreError(f"no catalogue at {path}: make one with 'orbitdb fill --p 11{there}'")
    if version < SCHEMA_VERSION:
        raise StoreError(f"{path} has the older schema {version}: run 'orbitdb migrate' first")
    return True


def _marks(path: Path) -> tuple[int, int, bool]:
    """Return the schema's version and the application of a file and its journal, and whether it is empty.

    Only SQLite may open the file. A process that closes a file loses all its locks on it (POSIX), including
    those of SQLite's connections, and other processes could then remove the journal while it is in use.
    """
    if not beside(path)[0].exists():
        with suppress(sqlite3.Error):  # damaged, or being written at this moment
            return _read_marks(uri_of(path) + "&immutable=1")
    refuse_foreign_journal(path)
    with plain_errors(path):
        return _read_marks(uri_of(path))


def _read_marks(uri: str) -> tuple[int, int, bool]:
    with closing(open_sqlite(uri, Connection)) as connection:
        version, application = (
            connection.scalar(f"PRAGMA {name}") for name in ("user_version", "application_id")
        )
        empty = (
            not (version or application) and connection.scalar("PRAGMA page_count") <= 1
        )  # reads the schema
        return version, application, empty


# reading


class Reader:
    """A catalogue file to read; each call of `moment` starts a `Moment` of the file then at the path.

    Between moments the file is closed, so that another may take its place.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.
    missing_ok : bool, optional
        Whether a missing file is an empty catalogue.

    Raises
    ------
    StoreError
        If there is no catalogue at the path, unless `missing_ok`, or this version cannot read it.
    """

    def __init__(self, path: Path | str | None = None, missing_ok: bool = False) -> None:
        self._missing_ok = missing_ok
        self._there = need_newest(default_path() if path is None else home_expanded(path), missing_ok)
        self.path = absolute_path(path)
        self._place = place(self.path)

    def there(self) -> bool:
        """Tell whether there is a catalogue at the path now; raise `StoreError` if it cannot be read."""
        if not self._there or place(self.path) != self._place:  # another file has taken its place
            self._there = need_newest(self.path, self._missing_ok)
            self._place = place(self.path)
        return self._there

    def connect(self) -> Moment:
        """Return a connection to the file that is now at the path, or to an empty catalogue in memory."""
        return open_to_read(self.path) if self.there() else _open_empty(self.path)

    @contextmanager
    def moment(self, cancelled: Callable[[], bool] = never) -> Iterator[Moment]:
        """Yield a read transaction; changes made meanwhile appear in the next one.

        Long queries call `cancelled` now and then, and raise `CancelledError` if it returns True.
        """
        with (
            unchanged(self.path),
            plain_errors(self.path),
            closing(self.connect()) as moment,
            transaction(moment),
        ):
            moment.cancelled = cancelled
            journal = places_beside(self.path)
            try:
                yield moment
            finally:
                remove_journal_of(self.path, self._place, journal)


def _open_empty(path: Path) -> Moment:
    """Return an empty catalogue in memory, for a path without a file."""
    moment = open_sqlite("file::memory:", Moment)
    moment.path = path
    add_code(moment)
    _create(moment)
    return moment


@contextmanager
def reading(path: Path | str | None = None) -> Iterator[Moment]:
    """Open a catalogue for a single moment, and close it afterwards."""
    with Reader(path).moment() as moment:
        yield moment


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
    with plain_errors(path), closing(open_to_write(path, references=False, create=True)) as connection:
        if before:
            upgrade_tables(connection)
        else:
            with transaction(connection, "BEGIN IMMEDIATE"):
                if not connection.scalar("PRAGMA user_version"):  # nobody else has created it meanwhile
                    _create(connection)
    return Migration(before, SCHEMA_VERSION)


def _create(connection: Connection) -> None:
    """Create the latest schema directly, and record its version for Alembic."""
    for statement in (*TABLES.values(), *VIEWS.values(), REVISIONS):
        connection.execute(statement)
    connection.executemany("INSERT INTO element VALUES (?, ?, ?)", ELEMENT_ROWS)
    connection.execute("INSERT INTO alembic_version VALUES (?)", (f"{SCHEMA_VERSION:04}",))
    _mark(connection)


def _mark(connection: Connection) -> None:
    connection.execute(f"PRAGMA application_id = {APPLICATION_ID}")
    connection.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def upgrade_tables(connection: Connection) -> None:
    """Run the missing migrations of an older catalogue in one transaction."""
    import sqlalchemy as sa
    from alembic import command
    from alembic.config import Config

    engine = sa.create_engine("sqlite://", creator=lambda: connection, poolclass=sa.pool.StaticPool)
    sa.event.listen(engine, "begin", lambda _: connection.execute("BEGIN IMMEDIATE"))
    config = Config()
    config.set_main_option("script_location", MIGRATIONS)
    try:
        with engine.begin() as own:
            config.attributes["connection"] = own
            command.upgrade(config, "head")
            _mark(connection)
    except sa.exc.DBAPIError as error:
        raise error.orig or error from error
