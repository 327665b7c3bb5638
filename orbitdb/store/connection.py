"""The connection of SQLite's driver to a catalogue, with the SQL functions of words."""

import logging
import os
import sqlite3
import time
import weakref
from collections.abc import Callable
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

from sqlalchemy import CompoundSelect, Connection, Select
from sqlalchemy.exc import ResourceClosedError as ClosedError
from sqlalchemy.exc import StatementError

from orbitdb.errors import StoreError
from orbitdb.store.paths import FileId
from orbitdb.symbols.words import (
    SYMBOLS,
    WordError,
    contains_cyclic,
    least_rotation,
    parse,
    parse_primitive,
)

__all__ = ["ClosedError", "Connection"]  # of SQLAlchemy, for all that ask the store

BUSY_TIMEOUT = 2.0
"""Seconds that SQLite waits for a lock; a writer that waits for longer says so."""

_TURNS = 30
"""Number of such waits after which a writer gives up; parallel fills hold the lock most of the time."""

STEPS_BETWEEN_SIGNALS = 1_000_000
"""SQLite steps after which Python can handle a signal such as Ctrl-C."""

OLDEST_SQLITE = (3, 37, 0)
"""The first version of SQLite that knows STRICT tables."""

DATABASE_ERRORS = (sqlite3.Error, StatementError, UnicodeDecodeError)
"""What reading or writing a file can raise; SQLAlchemy wraps the errors of the driver."""

_CACHED = 64
"""Number of words or patterns whose symbols such a function keeps."""


def never() -> bool:
    """Return False: the query is never cancelled."""
    return False


Run = tuple[int, str, int]
"""The id of a run, when it started, and the number of its commits."""


class Seen(NamedTuple):
    """What a transaction reads: the file, and the last run in it and its journal."""

    file: FileId
    run: Run | None


class Driver(sqlite3.Connection):
    """A connection of Python's `sqlite3` to a catalogue.

    Attributes
    ----------
    path : Path
        The path of the file; ``:memory:`` if there is none.
    opened : FileId or None
        The file that was opened; None if there is none.
    seen : Seen or None
        What its transaction reads; None if there is no file.
    refusal : str
        Why ``code()`` or ``contains()`` last failed; SQLite does not pass this on.
    alone : bool
        Whether it reads the file without locks and journal (`read_alone`).
    statements : WeakSet of sqlite3.Cursor
        Cursors of the statements that users wrote. The end of a snapshot closes them, because rows that
        nobody reads would keep the transaction open.
    cancelled : callable
        Called now and then during long queries; if it returns True, `CancelledError` is raised.
    """

    path = Path(":memory:")
    opened: FileId | None = None
    seen: Seen | None = None
    refusal = ""
    alone = False
    statements: weakref.WeakSet[sqlite3.Cursor]
    cancelled: Callable[[], bool] = staticmethod(never)

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.statements = weakref.WeakSet()

    def add_functions(self, strict: bool = False) -> None:
        """Add the SQL functions of words.

        ``code(word)`` is the least rotation of a word. ``contains(word, pattern)`` is 1 if the pattern occurs
        in the cyclic word, else 0. Both are NULL for NULL, and for symbols that are not a word, as a part of
        a word may be; they fail for other texts and for numbers. With `strict`, for a catalogue of one empty
        row, they fail for all texts and numbers that are not words, and for arguments in the wrong order.
        """
        primitive, symbols = lru_cache(_CACHED)(parse_primitive), lru_cache(_CACHED)(parse)

        def read(value: object, parsed: Callable[[str], str], call: str) -> str | None:
            if value is None:
                return None
            try:
                if not isinstance(value, str):
                    raise WordError(f"codes are texts, so write '{value}', in quotes")
                return parsed(value)
            except WordError as error:
                if not strict and isinstance(value, str) and not value.strip(SYMBOLS):
                    return None
                self.refusal = f"{call.format(f'{value!r:.40}')}: {error}"
                raise

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


def driver_of(connection: Connection) -> Driver:
    """Return the driver's connection under a connection of SQLAlchemy."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, Driver)
    return driver


def cursor_of(connection: Connection, query: Select[Any] | CompoundSelect[Any]) -> Any:
    """Run a query and return the driver's cursor, because rows of SQLAlchemy take longer to read."""
    cursor = connection.execute(query).cursor
    assert cursor is not None
    return cursor


def path_of(connection: Connection) -> Path:
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
    driver.execute("PRAGMA cell_size_check = ON")
    driver.set_progress_handler(lambda: 0, STEPS_BETWEEN_SIGNALS)
    return driver


def uri_of(path: Path, mode: str = "ro") -> str:
    """Return a path as an absolute URI; its name need not be UTF-8."""
    return f"file:{quote(os.fsencode(os.path.realpath(path)))}?mode={mode}"


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


def original(error: BaseException) -> BaseException:
    """Return the error that SQLAlchemy has wrapped, or the error itself."""
    return (error.orig or error) if isinstance(error, StatementError) else error
