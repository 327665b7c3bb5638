"""Engines for a catalogue, for reading or writing; SQLite's errors in plain words.

SQLite keeps the latest changes in a journal, ``orbits.db-wal``, until it moves them into the file. It finds
the journal by name alone. If a killed process leaves a journal behind, and another file is then copied over
the catalogue, SQLite would apply the journal to that file. To notice this, every transaction of
`orbitdb.store.writing.Writer` increases a counter in the row of its run. A journal belongs to a file if it
contains the file's last run, with at least the same number of commits, and every commit since then.
"""

import logging
import os
import sqlite3
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import cache, lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

import sqlalchemy as sa
from sqlalchemy import Connection
from sqlalchemy.exc import ResourceClosedError as ClosedError
from sqlalchemy.exc import StatementError
from sqlalchemy.pool import Pool

from orbitdb.errors import StoreError
from orbitdb.store.paths import check_same_file, file_id, journal_files
from orbitdb.store.tables import PAGE_SIZE
from orbitdb.store.views import view_texts
from orbitdb.symbols.words import WordError, contains_cyclic, least_rotation, parse, parse_primitive

__all__ = ["ClosedError", "Connection"]  # of SQLAlchemy, for all that ask the store

BUSY_TIMEOUT = 2.0
"""Seconds that SQLite waits for a lock; a writer that waits for longer says so."""

_TURNS = 30
"""Number of such waits after which a writer gives up; parallel fills hold the lock most of the time."""

STEPS_BETWEEN_SIGNALS = 1_000_000
"""SQLite steps after which Python can handle a signal such as Ctrl-C."""

_CACHE = 8 << 10
"""Page cache of a reader in kilobytes; it is small, because rows are read in the order of storage."""

OLDEST_SQLITE = (3, 37, 0)
"""The first version of SQLite that knows STRICT tables."""

DATABASE_ERRORS = (sqlite3.Error, StatementError, UnicodeDecodeError)
"""What reading or writing a file can raise; SQLAlchemy wraps the errors of the driver."""


FUNCTIONS = ("code", "contains")
"""The SQL functions of words (`Driver.add_functions`)."""

_CACHED = 64
"""Number of words or patterns whose symbols such a function keeps."""


def never() -> bool:
    """Return False: the query is never cancelled."""
    return False


class Driver(sqlite3.Connection):
    """A connection of Python's `sqlite3` to a catalogue.

    Attributes
    ----------
    path : Path
        The path of the file; ``:memory:`` if there is none.
    refusal : str
        Why ``code()`` or ``contains()`` last failed; SQLite does not pass this on.
    alone : bool
        Whether it reads the file without locks and journal (`read_alone`).
    used : bool
        Whether it has answered a question.
    cancelled : callable
        Called now and then during long queries; if it returns True, `CancelledError` is raised.
    """

    path = Path(":memory:")
    refusal = ""
    alone = False
    used = False
    cancelled: Callable[[], bool] = staticmethod(never)

    def add_functions(self, strict: bool = False) -> None:
        """Add the SQL functions `FUNCTIONS` of words; they are NULL for anything that is no word.

        ``code(word)`` is the least rotation of a word. ``contains(word, pattern)`` is 1 if the pattern occurs
        in the cyclic word, else 0. With `strict`, for a catalogue of one empty row, they fail
        for texts and numbers that are no words, and for arguments in the wrong order.
        """
        primitive, symbols = lru_cache(_CACHED)(parse_primitive), lru_cache(_CACHED)(parse)

        def read(value: object, parsed: Callable[[str], str], call: str) -> str | None:
            try:
                if not isinstance(value, str):
                    raise WordError(f"codes are texts, so write '{value}', in quotes")
                return parsed(value)
            except WordError as error:
                if strict and value is not None:
                    self.refusal = f"{call.format(f'{value!r:.40}')}: {error}"
                    raise
            return None

        def code(word: object) -> str | None:
            found = read(word, primitive, "code({})")
            return None if found is None else least_rotation(found)

        def contains(word: object, pattern: object) -> bool | None:
            found = read(pattern, symbols, "contains(..., {})")
            if strict and pattern is None and word is not None:  # all columns are NULL there
                self.refusal = "contains() takes the word first: write contains(code, '0202')"
                raise WordError(self.refusal)
            if found is None or not (isinstance(word, str) and word):
                return None
            return contains_cyclic(word, found)

        self.create_function("code", 1, code, deterministic=True)
        self.create_function("contains", 2, contains, deterministic=True)


def driver_of(connection: sa.Connection) -> Driver:
    """Return the driver's connection under a connection of SQLAlchemy."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, Driver)
    return driver


def path_of(connection: sa.Connection) -> Path:
    """Return the path of the catalogue that a connection reads or writes."""
    return driver_of(connection).path


def open_sqlite(uri: str) -> Driver:
    """Connect to a database; Ctrl-C interrupts long queries."""
    if sqlite3.sqlite_version_info < OLDEST_SQLITE:
        needed = ".".join(map(str, OLDEST_SQLITE))
        raise StoreError(
            f"this Python has SQLite {sqlite3.sqlite_version}, but orbitdb needs {needed} or newer: "
            "use a newer Python"
        )
    driver = sqlite3.connect(
        uri, timeout=BUSY_TIMEOUT, uri=True, isolation_level=None, check_same_thread=False, factory=Driver
    )
    driver.execute("PRAGMA trusted_schema = OFF")
    driver.execute("PRAGMA cell_size_check = ON")
    driver.set_progress_handler(lambda: 0, STEPS_BETWEEN_SIGNALS)
    return driver


def open_to_read(path: Path) -> Driver:
    """Open a catalogue for reading, even in a read-only folder, on a full disk, or while others write."""
    alone = read_alone(path)
    try:
        return _reader(path, alone)
    except sqlite3.OperationalError as error:
        if alone or error.sqlite_errorcode & 0xFF not in _NO_ROOM or _journal_size(path):
            raise
    return _reader(path, True)  # there is no room for the index of the journal


_NO_ROOM = (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_CANTOPEN)


def _reader(path: Path, alone: bool) -> Driver:
    mode = "&immutable=1" if alone else ""
    driver = _open_own(path, uri_of(path, "rw") + mode)  # the last to close the file removes the journal
    try:
        driver.alone = alone
        driver.execute("PRAGMA temp_store = MEMORY")
        views = {text for (text,) in driver.execute("SELECT sql FROM sqlite_master WHERE type = 'view'")}
        for text in set(view_texts().values()) - views:  # those of another version are for other programs
            driver.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))
        driver.add_functions()
        driver.execute("PRAGMA query_only = ON")
        driver.execute(f"PRAGMA cache_size = -{_CACHE}")
    except BaseException:
        driver.close()
        raise
    return driver


def open_to_write(path: Path, references: bool = True, create: bool = False) -> Driver:
    """Open a file for writing; with `references`, SQLite checks every foreign key that is written.

    A fill does not check references, because the random lookups would take a third of its time. Only with
    `create` may the file be new. SQLite itself moves no journal into the file (`checkpoint` does).
    """
    if path.exists() and not os.access(path, os.W_OK):
        raise StoreError(remedy(path, "readonly"))  # SQLite would do so, too, but leave an empty journal
    driver = _open_own(path, uri_of(path, "rwc" if create else "rw"))
    try:
        driver.execute(f"PRAGMA page_size = {PAGE_SIZE}")  # for a new file; others keep their page size
        waiting(lambda: driver.execute("PRAGMA journal_mode = WAL"), path)
        driver.execute("PRAGMA synchronous = NORMAL")
        driver.execute("PRAGMA wal_autocheckpoint = 0")
        driver.execute(
            "PRAGMA journal_size_limit = 0"
        )  # so that the size of the journal is that of its content
        driver.execute(f"PRAGMA foreign_keys = {'ON' if references else 'OFF'}")
    except BaseException:
        driver.close()
        raise
    return driver


def _open_own(path: Path, uri: str) -> Driver:
    """Connect to a file, after checking that the journal beside it belongs to it.

    Raises `StoreError` if it does not, or if the file is replaced at this moment.
    """
    before = file_id(path)
    refuse_foreign_journal(path)
    driver = open_sqlite(uri)
    driver.path = path
    try:
        if before:
            check_same_file(path, before, "opened it")
    except BaseException:
        driver.close()
        raise
    return driver


def uri_of(path: Path, mode: str = "ro") -> str:
    """Return a path as an absolute URI; its name need not be UTF-8."""
    return f"file:{quote(os.fsencode(os.path.realpath(path)))}?mode={mode}"


# engines and transactions


def make_engine(creator: Callable[[], Driver], begin: str, pool: type[Pool], **options: Any) -> sa.Engine:
    """Return an engine whose transactions start with a given statement, such as BEGIN IMMEDIATE.

    Parameters
    ----------
    creator : callable
        Opens a connection, as `open_to_read` does.
    begin : str
    pool : type
        Class of the pool that keeps the connections.
    **options
        Further options of `sqlalchemy.create_engine`.
    """
    # without hide_parameters, the message of a failed insert would show pages of rows
    engine = sa.create_engine("sqlite://", creator=creator, poolclass=pool, hide_parameters=True, **options)

    def start(connection: sa.Connection) -> None:
        driver = driver_of(connection)
        waiting(lambda: driver.execute(begin), driver.path)

    sa.event.listen(engine, "begin", start)
    return engine


def waiting(ask: Callable[[], object], path: Path) -> None:
    """Call `ask` until it gets a lock or the time is up; Ctrl-C works between attempts."""
    deadline = time.monotonic() + _TURNS * BUSY_TIMEOUT
    while True:
        try:
            ask()
            return
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_BUSY or time.monotonic() >= deadline:
                raise
        if time.monotonic() >= deadline - (_TURNS - 1) * BUSY_TIMEOUT:
            _say_waiting(path)
        time.sleep(0.01)  # because SQLite itself does not wait before it changes the journal mode


@cache
def _say_waiting(path: Path) -> None:
    """Log, once for each file, that another process keeps this one waiting."""
    logging.getLogger("orbitdb").warning("waiting for another process that writes to %s", path)


JOURNAL_LIMIT = 16 << 20
"""Size in bytes of a journal from which on a writer moves it into the file."""


def checkpoint(engine: sa.Engine, other: Driver, limit: int = 0) -> None:
    """Move the journal of a file into the file, if it is larger than a limit in bytes.

    Before version 3.51.3, SQLite can lose what one connection commits while another one moves the journal
    (https://sqlite.org/wal.html, section 11). So the engine holds the write lock while `other` moves it.
    """
    if _journal_size(other.path) > limit:
        with engine.begin():
            other.execute("PRAGMA wal_checkpoint(PASSIVE)")


# what others may do to the file meanwhile


def refuse_foreign_journal(path: Path) -> None:
    """Raise `StoreError` if the journal next to a file belongs to another file."""
    if _journal_size(path) and not _continues(path):
        journal, index = (part.name for part in journal_files(path))
        raise StoreError(
            f"{journal} is not the journal of {path}, but of a file that had this name before: move "
            f"{journal} and {index} away, and leave {path.name} where it is"
        )


def _journal_size(path: Path) -> int:
    journal = file_id(journal_files(path)[0])
    return journal.size if journal else 0


def _continues(path: Path) -> bool:
    """Tell whether a journal continues its file: it has the file's last run, and all transactions since then.

    An older copy of the file has this run, too, but lacks transactions that were moved into the file before
    the journal began. Others may write meanwhile, so the file is read once before the journal and once after
    it. No connection can write, because the last one to close would move the journal into the file.
    """
    alone = uri_of(path) + "&immutable=1"
    last = "SELECT id, started, commits FROM run ORDER BY id DESC LIMIT 1"
    same = "SELECT 1 FROM run WHERE id = ? AND started = ? AND commits >= ?"
    every = "SELECT coalesce(sum(commits), 0) FROM run"
    try:
        known = _row_of(alone, last)
    except _UNREADABLE:
        return True  # nothing to compare: damaged, or the first pages are still in the journal
    try:
        if known and not _row_of(uri_of(path), same, known):
            return False
        (written,) = _row_of(uri_of(path), every)
    except sqlite3.OperationalError as error:
        return "no such table" not in str(error)  # locked, or no permission; opening it will say so
    except _UNREADABLE:
        return False
    try:
        in_journal = _transactions_in(journal_files(path)[0])
        (moved,) = _row_of(alone, every)
    except (OSError, *_UNREADABLE):
        return True  # another process is moving the journal
    return int(written) - int(moved) <= in_journal


_UNREADABLE = (sqlite3.Error, UnicodeDecodeError)


def _row_of(uri: str, query: str, values: tuple[Any, ...] = ()) -> Any:
    with closing(open_sqlite(uri)) as driver:
        return driver.execute(query, values).fetchone()


def _transactions_in(journal: Path) -> int:
    """Return the number of transactions in a journal, whose format is https://sqlite.org/fileformat2.html#walformat."""
    count = 0
    with open(journal, "rb") as file:
        header = file.read(32)
        page, salt = int.from_bytes(header[8:12], "big"), header[16:24]
        while (frame := file.read(24))[8:16] == salt and salt:
            count += any(frame[4:8])  # the last page of a transaction has the size of the file there
            file.seek(page, os.SEEK_CUR)
    return count


def read_alone(path: Path) -> bool:
    """Tell whether to read a file without locks, because SQLite could not write or remove its journal.

    A journal that another user left behind would keep the owner from writing.
    """
    writable = all(os.access(part, os.W_OK) for part in (path, path.parent))
    return not writable and not journal_files(path)[0].exists()


# errors


def original(error: BaseException) -> BaseException:
    """Return the error that SQLAlchemy has wrapped, or the error itself."""
    return (error.orig or error) if isinstance(error, StatementError) else error


@contextmanager
def plain_errors(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into a `StoreError` that says what to do."""
    try:
        yield
    except DATABASE_ERRORS as wrapped:
        error = original(wrapped)
        if not isinstance(error, sqlite3.Error | UnicodeDecodeError):
            raise error from wrapped
        if str(error) == "interrupted":  # by a signal
            raise KeyboardInterrupt from error
        # a text that is not UTF-8 is damage, too
        message = "malformed" if isinstance(error, UnicodeDecodeError) else str(error)
        raise StoreError(remedy(path, message)) from error


def remedy(path: Path, message: str) -> str:
    """Return one line that says what an error of SQLite means and what to do."""
    journal = journal_files(path)[0]
    away = f"; remove {journal} before you copy" if journal.exists() else ""
    damaged = f"{path} is damaged: restore a copy, or move it away and fill a new one{away}"
    room = "delete other files (deleting from a catalogue needs room, too)"
    remedies = {
        "locked": f"{path} is in use by another process that writes: try again when it has finished",
        "readonly": f"{path} cannot be written: check its permissions, or name another file",
        "unable to open": f"{path} cannot be opened: check its permissions, and those of its folder",
        "disk is full": f"no space left for {path}: {room}, then run the same command again to continue",
        "malformed": damaged,
        "decode to UTF-8": damaged,
        "no such table": damaged,
        "no such column": damaged,
        "not a database": f"{path} is not an orbitdb catalogue: name another file",
        "disk I/O": f"{path} cannot be read or written (disk I/O error): check that the disk has room; "
        f"if not, {room}",
    }
    return next((line for part, line in remedies.items() if part in message), f"{path}: {message}")
