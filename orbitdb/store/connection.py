"""Connections to a catalogue, for reading or writing; SQLite's errors in plain words.

SQLite keeps the latest changes in a journal, ``orbits.db-wal``, until it moves them into the file. It finds
the journal by name alone. If a killed process leaves a journal behind, and another file is then copied over
the catalogue, SQLite would apply the journal to that file. To notice this, every transaction of
`orbitdb.store.writing.Writer` increases a counter in the row of its run. A journal belongs to a file if it
contains the file's last run, with at least the same number of commits.
"""

import os
import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import quote

from orbitdb.errors import StoreError
from orbitdb.store.paths import beside, need_place, place
from orbitdb.store.schema import PAGE_SIZE, VIEWS
from orbitdb.symbols.words import WordError, contains_cyclic, least_rotation, parse, parse_primitive

BUSY_TIMEOUT = 5.0
"""Seconds that SQLite waits for a lock."""

_TURNS = 12
"""Number of such waits after which a writer gives up; parallel fills hold the lock most of the time."""

_STEPS_BETWEEN_LOOKS = 1_000_000

_CACHE = 8 << 10
"""Page cache of a reader in kilobytes; it is small, because rows are read in the order of storage."""

Values = Sequence[Any] | Mapping[str, Any]


class Connection(sqlite3.Connection):
    """A connection to a catalogue."""

    def scalar(self, query: str, values: Values = ()) -> Any:
        """Return the first value of the first row, or None if there is no row."""
        return next(self.execute(query, values), (None,))[0]

    def records(self, query: str, values: Values = ()) -> Iterator[dict[str, Any]]:
        """Yield the rows as dicts, with the names of the columns."""
        cursor = self.execute(query, values)
        names = [name for name, *_ in cursor.description]
        return (dict(zip(names, row, strict=True)) for row in cursor)


class Moment(Connection):
    """A connection in a read transaction; all answers taken from it are consistent with one another.

    Attributes
    ----------
    path : Path
        The path of the file.
    """

    path: Path


_Opened = TypeVar("_Opened", bound=sqlite3.Connection)


def open_sqlite(uri: str, kind: type[_Opened]) -> _Opened:
    """Connect to a database; Ctrl-C interrupts long queries."""
    connection = sqlite3.connect(
        uri, timeout=BUSY_TIMEOUT, uri=True, isolation_level=None, check_same_thread=False, factory=kind
    )
    connection.execute("PRAGMA trusted_schema = OFF")
    connection.execute("PRAGMA cell_size_check = ON")
    connection.set_progress_handler(lambda: 0, _STEPS_BETWEEN_LOOKS)  # so that Python can handle signals
    return connection


def open_to_read(path: Path) -> Moment:
    """Open a catalogue for reading, even in a read-only folder or while others write."""
    mode = "&immutable=1" if read_alone(path) else ""
    uri = uri_of(path, "rw") + mode  # the last to close the file removes the journal
    connection = _open_own(path, uri, Moment)
    connection.path = path
    connection.execute("PRAGMA temp_store = MEMORY")
    views = {text for (text,) in connection.execute("SELECT sql FROM sqlite_master WHERE type = 'view'")}
    for text in set(VIEWS.values()) - views:  # those of another version are for other programs
        connection.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))
    add_code(connection)
    connection.execute("PRAGMA query_only = ON")
    connection.execute(f"PRAGMA cache_size = -{_CACHE}")
    return connection


def open_to_write(path: Path, references: bool = True, create: bool = False) -> Connection:
    """Open a file for writing; with `references`, SQLite checks every foreign key that is written.

    A fill does not check references, because the random lookups would take a third of its time. Only with
    `create` may the file be new.
    """
    if path.exists() and not os.access(path, os.W_OK):
        raise StoreError(remedy(path, "readonly"))  # SQLite would do so, too, but leave an empty journal
    connection = _open_own(path, uri_of(path, "rwc" if create else "rw"), Connection)
    try:
        connection.execute(f"PRAGMA page_size = {PAGE_SIZE}")  # for a new file; others keep their page size
        waiting(lambda: connection.execute("PRAGMA journal_mode = WAL"))
        connection.execute("PRAGMA synchronous = NORMAL")
        connection.execute(f"PRAGMA foreign_keys = {'ON' if references else 'OFF'}")
    except BaseException:
        connection.close()
        raise
    return connection


def _open_own(path: Path, uri: str, kind: type[_Opened]) -> _Opened:
    """Connect to a file whose journal is its own, also if the file is replaced at this moment."""
    before = place(path)
    refuse_foreign_journal(path)
    connection = open_sqlite(uri, kind)
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


def add_code(connection: Connection) -> None:
    """Give a connection the functions ``code()`` and ``contains()``.

    ``code(word)`` is the least rotation of a word, and ``contains(word, pattern)`` 1 if the pattern occurs in
    the cyclic word, else 0. Both are NULL for anything that is not a word.
    """

    def code(word: object) -> str | None:
        try:
            return least_rotation(parse_primitive(word)) if isinstance(word, str) else None
        except WordError:
            return None

    @lru_cache(maxsize=64)
    def symbols_of(pattern: str) -> str | None:
        try:
            return parse(pattern)
        except WordError:
            return None

    def contains(word: object, pattern: object) -> bool | None:
        symbols = symbols_of(pattern) if isinstance(pattern, str) else None
        if not (isinstance(word, str) and word and symbols):
            return None
        return contains_cyclic(word, symbols)

    connection.create_function("code", 1, code, deterministic=True)
    connection.create_function("contains", 2, contains, deterministic=True)


# transactions


@contextmanager
def transaction(connection: sqlite3.Connection, begin: str = "BEGIN") -> Iterator[None]:
    """Commit what the block writes, or roll it back if the block fails."""
    waiting(lambda: connection.execute(begin))
    with connection:
        yield


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


# what others may do to the file meanwhile


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

    Neither connection can write, because the last one to close would move the journal into the file.
    """
    with (
        closing(open_sqlite(uri_of(path) + "&immutable=1", sqlite3.Connection)) as alone,
        closing(open_sqlite(uri_of(path), sqlite3.Connection)) as whole,
    ):
        try:
            query = "SELECT id, started, commits FROM run ORDER BY id DESC LIMIT 1"
            last = alone.execute(query).fetchone()
        except (sqlite3.Error, UnicodeDecodeError):
            return True  # nothing to compare: damaged, or the first pages are still in the journal
        same = "SELECT 1 FROM run WHERE id = ? AND started = ? AND commits >= ?"
        try:
            return not last or whole.execute(same, last).fetchone() is not None
        except sqlite3.OperationalError as error:
            return "no such table" not in str(error)  # locked, or no permission; opening it will say so
        except (sqlite3.DatabaseError, UnicodeDecodeError):
            return False


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


# errors


@contextmanager
def plain_errors(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into a `StoreError` that says what to do."""
    try:
        yield
    except (sqlite3.Error, UnicodeDecodeError) as error:
        if str(error) == "interrupted":  # by a signal
            raise KeyboardInterrupt from error
        # a text that is not UTF-8 is damage, too
        message = "malformed" if isinstance(error, UnicodeDecodeError) else str(error)
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
