"""Connections to a catalogue, for reading or writing; its journal; SQLite's errors in plain words.

SQLite keeps the latest changes in a journal, ``orbits.db-wal``, until it moves them into the file. It finds
the journal by name alone. If a killed process leaves a journal behind, and another file is then copied over
the catalogue, SQLite would apply the journal to that file. To notice this, every transaction of
`orbitdb.store.writing.Writer` increases a counter in the row of its run. A journal belongs to a file if it
contains the file's last run, with at least the same number of commits.
"""

import os
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from orbitdb.errors import StoreError
from orbitdb.store.schema import PAGE_SIZE, VIEWS
from orbitdb.symbols.words import WordError, least_rotation, parse_primitive

if TYPE_CHECKING:
    import sqlalchemy as sa

BUSY_TIMEOUT = 5.0
"""Seconds that SQLite waits for a lock."""

_TURNS = 12
"""Number of such waits after which a writer gives up; parallel fills hold the lock most of the time."""

_STEPS_BETWEEN_LOOKS = 1_000_000

_CACHE = 8 << 10
"""Page cache of a reader in kilobytes; it is small, because rows are read in the order of storage."""


class Place(NamedTuple):
    """The identity of a file, whatever its name."""

    device: int
    inode: int


def place(path: Path) -> Place | None:
    """Return the identity of the file that is now at a path, or None if there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return Place(status.st_dev, status.st_ino)


def need_place(path: Path, opened: Place | None, message: str) -> None:
    """Raise `StoreError` if the opened file was replaced or deleted; `message` ends the error message."""
    now = place(path)
    if now != opened:
        what = "moved or deleted" if now is None else "replaced by another file"
        raise StoreError(f"{path} was {what} while this command {message}")


# the journal


def beside(path: Path) -> tuple[Path, Path]:
    """Return the paths of a file's journal and of the journal's index."""
    real = Path(os.path.realpath(path))
    return real.with_name(real.name + "-wal"), real.with_name(real.name + "-shm")


def refuse_foreign_journal(path: Path) -> None:
    """Raise `StoreError` if the journal next to a file belongs to another file."""
    journal, index = beside(path)
    with suppress(OSError):
        if journal.stat().st_size and not _continues(path):
            raise StoreError(
                f"{journal.name} is not the journal of {path}, but of a file that had this name before: move "
                f"{journal.name} and {index.name} away, and leave {path.name} where it is"
            )


def _continues(path: Path) -> bool:
    """Tell whether a journal continues its file, that is, contains the last run recorded in the file.

    Neither connection can write, because the last one to close would move the journal into the file. The
    read transaction keeps writers from doing so meanwhile.
    """
    with (
        closing(open_sqlite(uri_of(path))) as whole,
        closing(open_sqlite(uri_of(path) + "&immutable=1")) as alone,
    ):
        try:
            whole.execute("BEGIN")
            with_journal = _runs(whole)
        except sqlite3.OperationalError as error:
            if "no such table" not in str(error):
                return True  # locked, or without permission; opening it will say so
            with_journal = {}
        except (sqlite3.DatabaseError, UnicodeDecodeError):
            with_journal = {}
        try:
            runs = _runs(alone)
        except (sqlite3.Error, UnicodeDecodeError):
            return True  # nothing to compare: damaged, or the first pages are still in the journal
    if not runs:
        return True
    last = max(runs)
    (started, commits), (same, more) = runs[last], with_journal.get(last, ("", 0))
    return started == same and commits <= more


def _runs(connection: sqlite3.Connection) -> dict[int, tuple[str, int]]:
    """Return for each run, by id, when it started and its number of transactions."""
    rows = connection.execute("SELECT id, started, commits FROM run").fetchall()
    return {number: (started, commits) for number, started, commits in rows}


def remove_journal_of(path: Path, opened: Place | None, journal: dict[Path, Place | None]) -> None:
    """Remove the journal of an opened file that is no longer at its path; SQLite would leave it there.

    It would be taken for that of the next file with this name.
    """
    if place(path) != opened:
        for part, was in journal.items():
            if was is not None and place(part) == was:
                part.unlink(missing_ok=True)


def places_beside(path: Path) -> dict[Path, Place | None]:
    """Return the identities of a file's journal and of the journal's index."""
    return {part: place(part) for part in beside(path)}


# connections


def open_sqlite(uri: str) -> sqlite3.Connection:
    """Connect to a database; Ctrl-C interrupts long queries."""
    connection = sqlite3.connect(
        uri, timeout=BUSY_TIMEOUT, uri=True, isolation_level=None, check_same_thread=False
    )
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.execute("PRAGMA cell_size_check = ON")
    connection.set_progress_handler(lambda: 0, _STEPS_BETWEEN_LOOKS)  # so that Python can handle signals
    return connection


def add_code(connection: sqlite3.Connection) -> None:
    """Give a connection the function ``code()``: the least rotation of a word; NULL for anything else."""

    def code(word: object) -> str | None:
        try:
            return least_rotation(parse_primitive(word)) if isinstance(word, str) else None
        except WordError:
            return None

    connection.create_function("code", 1, code, deterministic=True)


def _open_own(path: Path, uri: str) -> sqlite3.Connection:
    """Connect to a file whose journal is its own, also if the file is replaced at this moment."""
    before = place(path)
    refuse_foreign_journal(path)
    connection = open_sqlite(uri)
    try:
        if before:
            need_place(path, before, "opened it")
    except BaseException:
        connection.close()
        raise
    return connection


def uri_of(path: Path, mode: str = "ro") -> str:
    """Return a path as an absolute URI; its name need not be UTF-8."""
    return f"file:{quote(os.fsencode(os.path.realpath(path)))}?mode={mode}"


def waiting(ask: Callable[[], object]) -> None:
    """Call `ask` until it gets a lock or the time is up; Ctrl-C works between attempts."""
    deadline = time.monotonic() + _TURNS * BUSY_TIMEOUT
    while True:
        try:
            ask()
            return
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() >= deadline:
                raise
        time.sleep(0.01)  # because SQLite itself does not wait before it changes the journal mode


def open_to_read(path: Path) -> sqlite3.Connection:
    """Open a catalogue for reading, even in a read-only folder or while others write."""
    mode = "&immutable=1" if read_alone(path) else ""
    connection = _open_own(path, uri_of(path, "rw") + mode)  # the last to close the file removes the journal
    connection.execute("PRAGMA temp_store = MEMORY")
    for text in VIEWS.values():  # this version's views; those in the file are for other programs
        connection.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))
    add_code(connection)
    connection.execute("PRAGMA query_only = ON")
    connection.execute(f"PRAGMA cache_size = -{_CACHE}")
    return connection


def open_to_write(path: Path, references: bool = True, create: bool = False) -> sqlite3.Connection:
    """Open a file for writing; with `references`, SQLite checks every foreign key that is written.

    Only with `create` may the file be new.
    """
    if path.exists() and not os.access(path, os.W_OK):
        raise StoreError(remedy(path, "readonly"))  # SQLite would do so, too, but leave an empty journal
    connection = _open_own(path, uri_of(path, "rwc" if create else "rw"))
    try:
        connection.execute(f"PRAGMA page_size = {PAGE_SIZE}")  # for a new file; others keep their page size
        waiting(lambda: connection.execute("PRAGMA journal_mode = WAL"))
        connection.execute("PRAGMA synchronous = NORMAL")
        connection.execute(f"PRAGMA foreign_keys = {'ON' if references else 'OFF'}")
    except BaseException:
        connection.close()
        raise
    return connection


def read_alone(path: Path) -> bool:
    """Tell whether to read a file without locks, because SQLite could not write or remove its journal.

    A journal that another user left behind would keep the owner from writing.
    """
    writable = all(os.access(part, os.W_OK) for part in (path, path.parent))
    return not writable and not beside(path)[0].exists()


@contextmanager
def unchanged(path: Path) -> Iterator[None]:
    """Raise `StoreError` if a file that is read without locks changes during the block."""
    before = _stamp(path) if read_alone(path) else None
    try:
        yield
    finally:
        if before and before != _stamp(path):
            raise StoreError(f"{path} was written while it was being read: try again")


def _stamp(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def reading_engine(path: Path) -> "sa.Engine":
    """Return an engine for reading.

    Each transaction opens the file that is then at the path. Between transactions the file is closed, so that
    another may take its place.
    """
    import sqlalchemy as sa  # single words are looked up without it

    return _engine(lambda: open_to_read(path), "BEGIN", sa.pool.NullPool)


def writing_engine(path: Path, references: bool = True, create: bool = False) -> "sa.Engine":
    """Return an engine for writing, which keeps the file open; its transactions take the write lock at once.

    A fill does not check references, because the random lookups would take a third of its time.
    """
    import sqlalchemy as sa

    return _engine(lambda: open_to_write(path, references, create), "BEGIN IMMEDIATE", sa.pool.QueuePool)


def _engine(connect: Callable[[], sqlite3.Connection], begin: str, pool: "type[sa.Pool]") -> "sa.Engine":
    import sqlalchemy as sa

    engine = sa.create_engine("sqlite+pysqlite://", creator=connect, poolclass=pool)

    @sa.event.listens_for(engine, "begin")
    def take_lock(connection: "sa.Connection") -> None:
        waiting(lambda: driver(connection).execute(begin))

    return engine


def driver(connection: "sa.Connection") -> sqlite3.Connection:
    """Return the sqlite3 connection of an SQLAlchemy connection, for direct queries."""
    own = connection.connection.driver_connection
    assert isinstance(own, sqlite3.Connection)
    return own


# errors


@contextmanager
def plain_errors(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into a `StoreError` that says what to do."""
    try:
        yield
    except Exception as error:
        cause = getattr(error, "orig", error)  # the error that SQLAlchemy wrapped
        if not isinstance(cause, sqlite3.Error | UnicodeDecodeError):
            raise
        if str(cause) == "interrupted":  # by a signal
            raise KeyboardInterrupt from error
        # a text that is not UTF-8 is damage, too
        message = "malformed" if isinstance(cause, UnicodeDecodeError) else str(cause)
        raise StoreError(remedy(path, message)) from error


def remedy(path: Path, message: str) -> str:
    """Return one line that says what an error of SQLite means and what to do."""
    damaged = f"{path} is damaged: restore a copy, or move it away and fill a new one"
    remedies = {
        "locked": f"{path} is in use by another process that writes: try again when it has finished",
        "readonly": f"{path} cannot be written: check its permissions, or name another file",
        "unable to open": f"{path} cannot be opened: check its permissions, and those of its folder",
        "disk is full": f"no space left for {path}: free some, then run the same command again to continue",
        "malformed": damaged,
        "decode to UTF-8": damaged,
        "no such table": damaged,
        "no such column": damaged,
        "not a database": f"{path} is not an orbitdb catalogue: name another file",
        "disk I/O": f"{path} cannot be read or written (disk I/O error): check that the disk has room",
    }
    return next((line for part, line in remedies.items() if part in message), f"{path}: {message}")
