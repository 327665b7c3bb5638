"""Open the database file safely for reading or writing."""

import os
import sqlite3
import stat
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from orbitdb.errors import StoreError
from orbitdb.store.file.guard import (
    Place,
    beside,
    own_views,
    place,
    plain_errors,
    refuse_foreign,
    refuse_tampered,
    remedy,
)
from orbitdb.store.file.schema import APPLICATION_ID, OLDEST_VERSION, PAGE_SIZE, SCHEMA_VERSION

if TYPE_CHECKING:
    import sqlalchemy as sa

BUSY_TIMEOUT = 5.0
"""Seconds that SQLite waits for a lock."""

_TURNS = 12
"""Number of these waits before a writer gives up; parallel fills hold the lock most of the time."""

_STEPS_BETWEEN_LOOKS = 1_000_000

_CACHE = 8 << 10
"""Page cache of a reader in kilobytes; small, because rows are read in the order of storage."""


def default_path() -> Path:
    """Return the default path of the catalogue: ORBITDB_DB, or a file in the user's data folder."""
    named = os.environ.get("ORBITDB_DB")
    return Path(named) if named else data_folder() / "orbits.db"


def data_folder() -> Path:
    """Return the user's data folder, the only folder that orbitdb creates."""
    from platformdirs import user_data_path

    return user_data_path("orbitdb", appauthor=False)


def check_file(path: Path) -> int | None:
    """Return the schema version of a file; None if it is missing or empty.

    Raises
    ------
    StoreError
        If it is not a catalogue, comes from a newer orbitdb, or has a schema older than 6.
    """
    try:
        try:
            found = path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return None
        if stat.S_ISDIR(found.st_mode):
            raise StoreError(f"{path} is a folder: name a file with --db")
        if not stat.S_ISREG(found.st_mode):
            raise StoreError(f"{path} is not an ordinary file: name another with --db")
        if found.st_size == 0:
            return None
    except OSError as error:
        raise StoreError(f"{path} cannot be read ({error.strerror}): check its permissions") from error
    pages, version, application = _marks(path)
    if not application and not version and pages <= 1:
        return None  # a database without tables: its creation was killed
    if application != APPLICATION_ID:
        raise StoreError(f"{path} is another program's SQLite database: name another file with --db")
    if version > SCHEMA_VERSION:
        raise StoreError(
            f"{path} has schema {version}, newer than this orbitdb's {SCHEMA_VERSION}: upgrade orbitdb"
        )
    if version < OLDEST_VERSION:
        raise StoreError(
            f"{path} has schema {version}, too old for this orbitdb: move it away, and fill a new one"
        )
    return version


def need_newest(path: Path) -> None:
    """Raise `StoreError`, with a remedy, unless the file is a catalogue of the newest schema."""
    version = check_file(path)
    if version is None:
        raise StoreError(f"no catalogue at {path}: make one with 'orbitdb fill --p 11'")
    if version < SCHEMA_VERSION:
        raise StoreError(f"{path} has the older schema {version}: run 'orbitdb migrate' first")


def _marks(path: Path) -> tuple[int, ...]:
    """Return page count, schema version and application id, with the changes in the journal if there is one.

    Only SQLite opens the file. A process that closes a file loses all its locks on it (POSIX), including
    those of SQLite's connections, and other processes could then remove the journal in use.
    """
    if not path.with_name(path.name + "-wal").exists():
        with suppress(sqlite3.Error, UnicodeDecodeError):  # damage, or a writer at this moment
            return _pragmas(_uri(path) + "&immutable=1")
    _refuse_foreign_journal(path)
    with plain_errors(path):
        return _pragmas(_uri(path))


def _refuse_foreign_journal(path: Path) -> None:
    refuse_foreign(path, lambda: _open(_uri(path) + "&immutable=1"), lambda: _open(_uri(path)))


def _pragmas(uri: str) -> tuple[int, ...]:
    with closing(_open(uri)) as connection:
        names = ("page_count", "user_version", "application_id")
        return tuple(int(connection.execute(f"PRAGMA {name}").fetchone()[0]) for name in names)


def _uri(path: Path, mode: str = "ro") -> str:
    """Return the absolute path as a URI; the name need not be UTF-8."""
    return f"file:{quote(os.fsencode(os.path.realpath(path)))}?mode={mode}"


def to_read(path: Path) -> Callable[[], sqlite3.Connection]:
    """Return a function that opens a catalogue for reading, in any folder and while others write.

    It refuses an older schema and active contents (`orbitdb.store.file.guard`).
    """
    uri = _uri(path, "rw")  # whoever closes the file last removes the journal and needs write access

    def connect() -> sqlite3.Connection:
        connection = _connect(uri + ("&immutable=1" if read_alone(path) else ""), path, newest=True)
        own_views(connection)
        connection.execute("PRAGMA query_only = ON")
        connection.execute(f"PRAGMA cache_size = -{_CACHE}")
        # in expressions, no function may make a text longer; set here, because SQLite changes no function
        # while a query runs
        connection.create_function("replace", 3, _shortened, deterministic=True)
        return connection

    return connect


def read_alone(path: Path) -> bool:
    """Tell whether to read a file without locks, because SQLite could not write or remove its journal.

    A journal left by another user would keep the owner from writing.
    """
    writable = all(os.access(each, os.W_OK) for each in (path, path.parent))
    return not writable and not path.with_name(path.name + "-wal").exists()


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Raise `StoreError` if a file that is read without locks is written meanwhile."""
    before = _stamp(path) if read_alone(path) else None
    try:
        yield
    finally:
        if before and before != _stamp(path):
            raise StoreError(f"{path} was written while it was read: ask again")


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def to_write(path: Path, references: bool) -> Callable[[], sqlite3.Connection]:
    """Return a function that opens a file for writing, which may be new or have an older schema.

    It refuses active contents. With `references`, SQLite checks every foreign key that is written.
    """
    newest = check_file(path) == SCHEMA_VERSION
    uri = _uri(path, "rw" if newest else "rwc")
    if path.exists() and not os.access(path, os.W_OK):
        raise StoreError(remedy(path, "readonly"))  # SQLite would say so, but leave an empty journal

    def connect() -> sqlite3.Connection:
        connection = _connect(uri, path, newest)
        connection.execute(f"PRAGMA page_size = {PAGE_SIZE}")  # for a new file; others keep theirs
        waiting(lambda: connection.execute("PRAGMA journal_mode = WAL"))
        connection.remember_place(path)  # a new file has a journal from here on
        connection.execute("PRAGMA synchronous = NORMAL")
        connection.execute(f"PRAGMA foreign_keys = {'ON' if references else 'OFF'}")
        return connection

    return connect


def reading_engine(path: Path) -> "sa.Engine":
    """Return an engine that cannot write (`to_read`)."""
    return _engine(to_read(path), "BEGIN", kept=not read_alone(path))


def writing_engine(path: Path, references: bool = True) -> "sa.Engine":
    """Return an engine whose transactions take the write lock at once (`to_write`).

    A fill does without the check of references, because its random lookups would take a third of the time.
    """
    return _engine(to_write(path, references), "BEGIN IMMEDIATE")


def _engine(connect: Callable[[], sqlite3.Connection], begin: str, kept: bool = True) -> "sa.Engine":
    import sqlalchemy as sa  # single words are asked for without it

    # without locks, a connection would keep pages of a file that has changed since
    pool = sa.pool.QueuePool if kept else sa.pool.NullPool
    engine = sa.create_engine("sqlite+pysqlite://", creator=connect, poolclass=pool)

    @sa.event.listens_for(engine, "begin")
    def take_lock(connection: "sa.Connection") -> None:
        waiting(lambda: driver(connection).execute(begin))

    return engine


def driver(connection: "sa.Connection") -> sqlite3.Connection:
    """Return the sqlite3 connection of SQLAlchemy, for direct queries."""
    own = connection.connection.driver_connection
    assert isinstance(own, sqlite3.Connection)
    return own


def waiting(ask: Callable[[], object]) -> None:
    """Ask for a lock until it is granted or time is up; Ctrl-C works between attempts."""
    deadline = time.monotonic() + _TURNS * BUSY_TIMEOUT
    while True:
        try:
            ask()
            return
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() >= deadline:
                raise
        time.sleep(0.01)  # SQLite itself does not wait to change the journal mode


_connections: "weakref.WeakSet[_Connection]" = weakref.WeakSet()


class _Connection(sqlite3.Connection):
    """A connection whose `close` ends its queries first; an interrupted one would keep the journal in use.

    It also removes the journal of a file that is no longer in its place, which SQLite leaves there and would
    take for that of the next file with this name.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._cursors: weakref.WeakSet[sqlite3.Cursor] = weakref.WeakSet()
        self._file: tuple[Path, Place | None] | None = None
        self._journal: dict[Path, Place | None] = {}
        _connections.add(self)

    def remember_place(self, path: Path) -> None:
        """Note which file is open, and which journal; SQLite keeps that until `close`."""
        self._file = path, place(path)
        self._journal = {part: place(part) for part in beside(path)}

    def cursor(self, factory: Any = sqlite3.Cursor) -> Any:
        cursor = super().cursor(factory)
        self._cursors.add(cursor)
        return cursor

    def execute(self, *arguments: Any) -> sqlite3.Cursor:
        cursor: sqlite3.Cursor = self.cursor().execute(*arguments)
        return cursor

    def close(self) -> None:
        for cursor in list(self._cursors):
            cursor.close()
        super().close()
        if self._file is not None and (now := place(self._file[0])) != self._file[1]:
            for part, was in self._journal.items():
                if now is None or place(part) == was:
                    part.unlink(missing_ok=True)


def close_connections() -> None:
    """Close every connection that an interrupted command has lost, so that no journal remains.

    While other threads run, a connection can be in use, and closing it would wait for its query.
    """
    if threading.active_count() == 1:
        for connection in list(_connections):
            with suppress(sqlite3.Error):
                connection.close()


def _open(uri: str) -> _Connection:
    """Connect to a database; Ctrl-C interrupts long queries."""
    connection = sqlite3.connect(
        uri, BUSY_TIMEOUT, uri=True, isolation_level=None, check_same_thread=False, factory=_Connection
    )
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.set_progress_handler(lambda: 0, _STEPS_BETWEEN_LOOKS)  # lets Python handle signals
    return connection


def _connect(uri: str, path: Path, newest: bool) -> _Connection:
    """Connect so that SQLite runs nothing in the file; refuse active contents or another file's journal."""
    _refuse_foreign_journal(path)
    connection = _open(uri)
    try:
        connection.remember_place(path)
        connection.execute("PRAGMA cell_size_check = ON")
        if sys.version_info >= (3, 12):
            connection.setconfig(sqlite3.SQLITE_DBCONFIG_DEFENSIVE)
        refuse_tampered(connection, path, newest)
        connection.remember_place(path)  # with the journal, which reading makes
    except BaseException:
        connection.close()
        raise
    return connection


@contextmanager
def asking(path: Path) -> Iterator[sqlite3.Connection]:
    """Give a connection in a read transaction, without importing SQLAlchemy."""
    need_newest(path)
    with unchanged(path), plain_errors(path), closing(to_read(path)()) as connection:
        waiting(lambda: connection.execute("BEGIN"))
        yield connection


def _shortened(text: object, part: object, by: object) -> str | None:
    """Replace like SQLite, but fail if the text would grow."""
    if text is None or part is None or by is None:
        return None
    if any(isinstance(value, bytes) for value in (text, part, by)) or len(str(by)) > len(str(part)):
        raise ValueError
    return str(text).replace(str(part), str(by)) if part != "" else str(text)
