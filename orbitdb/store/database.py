"""The database file: opening it safely, for reading or for writing, and telling what is wrong with it."""

import os
import sqlite3
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from urllib.parse import quote

import sqlalchemy as sa
from sqlalchemy import event

from orbitdb.errors import StoreError
from orbitdb.store.confinement import tame
from orbitdb.store.guard import refuse_tampered
from orbitdb.store.schema import APPLICATION_ID, SCHEMA_VERSION

BUSY_TIMEOUT = 5.0
_MAGIC = b"SQLite format 3\x00"


def default_path() -> Path:
    """Return where a catalogue is kept if nothing else is said: ORBITDB_DB, or the user's data folder."""
    if named := os.environ.get("ORBITDB_DB"):
        return Path(named)
    from platformdirs import user_data_path

    return user_data_path("orbitdb", appauthor=False) / "orbits.db"


def check_file(path: Path) -> int | None:
    """Look at a file before it is opened as a catalogue.

    Returns
    -------
    int or None
        The version of its schema; None if there is no file, or an empty one.

    Raises
    ------
    StoreError
        If it is not a catalogue, or one that a newer orbitdb has written.
    """
    try:
        try:
            found = path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return None
        if stat.S_ISDIR(found.st_mode):
            raise StoreError(f"{path} is a folder: name a file with --db")
        if not stat.S_ISREG(found.st_mode):
            raise StoreError(f"{path} is no ordinary file: name another with --db")
        if found.st_size == 0:
            return None
        with path.open("rb") as file:
            header = file.read(100)
    except OSError as error:
        raise StoreError(f"{path} cannot be read ({error.strerror}): check its permissions") from error
    if len(header) < 100 or not header.startswith(_MAGIC):
        raise StoreError(f"{path} is not an orbitdb catalogue: name another file with --db")
    pages, version, application = (int.from_bytes(header[i : i + 4], "big") for i in (28, 60, 68))
    if path.with_name(path.name + "-wal").exists():
        version, application = _marks(path)  # the newest ones may not have come into the file yet
    if not application and not version and pages <= 1:
        return None  # a database without a table, as a creation that was killed leaves it
    if application != APPLICATION_ID:
        raise StoreError(f"{path} is another program's SQLite database: name another file with --db")
    if version > SCHEMA_VERSION:
        raise StoreError(
            f"{path} has schema {version}, newer than this orbitdb's {SCHEMA_VERSION}: upgrade orbitdb"
        )
    return version


def _marks(path: Path) -> tuple[int, int]:
    """Return the version of the schema and the mark of the program, what is in the journal included."""
    with plain_errors(path), closing(sqlite3.connect(_uri(path, "ro"), uri=True)) as connection:
        marks = [
            int(connection.execute(f"PRAGMA {name}").fetchone()[0])
            for name in ("user_version", "application_id")
        ]
    return marks[0], marks[1]


def _uri(path: Path, mode: str) -> str:
    return f"file:{_quoted(path)}?mode={mode}"


def reading_engine(path: Path) -> sa.Engine:
    """Return an engine that cannot write; it works in a read-only folder and beside a writer.

    What it connects to must be a catalogue of the newest schema and hold nothing that acts
    (`orbitdb.store.guard`).
    """
    uri = _uri(path, "ro")
    frozen = not os.access(path.parent, os.W_OK) and not path.with_name(path.name + "-wal").exists()

    def connect() -> sqlite3.Connection:
        connection = _connect(uri + ("&immutable=1" if frozen else ""), path, newest=True)
        connection.execute("PRAGMA query_only = ON")
        tame(connection)
        return connection

    return _engine(connect, "BEGIN")


def writing_engine(path: Path, references: bool = True) -> sa.Engine:
    """Return an engine whose every transaction takes the write lock at once.

    What it connects to must hold nothing that acts; it may be new, or older than the newest schema.

    Parameters
    ----------
    path : Path
        The database file.
    references : bool, optional
        Whether SQLite looks up every reference that is written. A fill knows that its references are
        right, they being keys of words, and the random lookups would take a third of its time.
    """
    uri = _uri(path, "rwc")
    newest = check_file(path) == SCHEMA_VERSION

    def connect() -> sqlite3.Connection:
        connection = _connect(uri, path, newest)
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA synchronous = NORMAL")
        connection.execute(f"PRAGMA foreign_keys = {'ON' if references else 'OFF'}")
        return connection

    return _engine(connect, "BEGIN IMMEDIATE")


def _quoted(path: Path) -> str:
    """Return the whole path for a URI; a name need not be UTF-8."""
    return quote(os.fsencode(os.path.realpath(path)))


def _connect(uri: str, path: Path, newest: bool) -> sqlite3.Connection:
    """Connect so that nothing in the file acts, and refuse a file in which something would."""
    connection = sqlite3.connect(
        uri, uri=True, timeout=BUSY_TIMEOUT, isolation_level=None, check_same_thread=False
    )
    try:
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA cell_size_check = ON")
        if sys.version_info >= (3, 12):
            connection.setconfig(sqlite3.SQLITE_DBCONFIG_DEFENSIVE)
        refuse_tampered(connection, path, newest)
    except BaseException:
        connection.close()
        raise
    return connection


def _engine(connect: Callable[[], sqlite3.Connection], begin: str) -> sa.Engine:
    engine = sa.create_engine("sqlite+pysqlite://", creator=connect, poolclass=sa.pool.QueuePool)

    @event.listens_for(engine, "begin")
    def take_lock(connection: sa.Connection) -> None:
        connection.exec_driver_sql(begin)

    return engine


@contextmanager
def plain_errors(path: Path) -> Iterator[None]:
    """Turn what SQLite or the file system raises into a `StoreError` with a remedy."""
    try:
        yield
    except (sa.exc.DBAPIError, sqlite3.Error) as error:
        cause = error.orig if isinstance(error, sa.exc.DBAPIError) else error
        raise StoreError(_remedy(path, str(cause))) from error
    except OSError as error:
        raise StoreError(_remedy(path, f"unable to open ({error.strerror})")) from error


def _remedy(path: Path, message: str) -> str:
    remedies = {
        "locked": f"{path} is in use by another process that writes: try again when it has finished",
        "readonly": f"{path} cannot be written: check its permissions, or name another file with --db",
        "unable to open": f"{path} cannot be opened: check that its folder exists and may be written",
        "disk is full": f"no space left for {path}: free some, then run the same command again to go on",
        "malformed": f"{path} is damaged: restore a copy, or move it away and fill anew",
        "not a database": f"{path} is not an orbitdb catalogue: name another file with --db",
        "disk I/O": f"{path} cannot be read or written (disk I/O error): check the disk",
    }
    for part, remedy in remedies.items():
        if part in message:
            return remedy
    return f"{path}: {message}"
