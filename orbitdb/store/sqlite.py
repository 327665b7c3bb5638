"""SQLite: connections with the SQL functions of words, engines of SQLAlchemy, and errors in plain words."""

import logging
import os
import sqlite3
import sys
import time
import weakref
from array import array
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import sqlalchemy as sa
from sqlalchemy import CompoundSelect, Connection, Select
from sqlalchemy.exc import ResourceClosedError as ClosedError
from sqlalchemy.pool import Pool

from orbitdb.errors import DamagedError, StoreError
from orbitdb.open_stadium.openings import Opening, elements_through, parse_openings
from orbitdb.store.paths import FileId, journal_files, journal_size
from orbitdb.symbols.words import (
    SYMBOLS,
    WordError,
    contains_cyclic,
    least_rotation,
    parse,
    parse_primitive,
)
from orbitdb.text import gigabytes

if sys.platform != "win32":
    import resource  # at once: at its limit, a process can import nothing

__all__ = ["ClosedError", "Connection"]  # of SQLAlchemy, for all that ask the store

BUSY_TIMEOUT = 2.0
"""Seconds that SQLite waits for a lock; a writer that waits for longer says so."""

_TURNS = 30
"""Number of such waits after which a writer gives up; parallel fills hold the lock most of the time."""

STEPS_BETWEEN_SIGNALS = 1_000_000
"""SQLite steps after which Python can handle a signal such as Ctrl-C."""

OLDEST_SQLITE = (3, 37, 0)
"""The first version of SQLite that knows STRICT tables."""

DATABASE_ERRORS = (sqlite3.Error, UnicodeDecodeError)
"""What reading or writing a file can raise; a text that is not UTF-8 is damage, too."""

# otherwise a Ctrl-C while a connection is being closed would be logged with a traceback, and then raised
logging.getLogger("sqlalchemy.pool").addHandler(logging.NullHandler())


def never() -> bool:
    """Return False: the query is never cancelled."""
    return False


# connections


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
    failure : WordError or None
        What ``code()`` or ``contains()`` last raised; SQLite does not pass it on.
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
    failure: WordError | None = None
    alone = False
    statements: weakref.WeakSet[sqlite3.Cursor]
    cancelled: Callable[[], bool] = staticmethod(never)

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.statements = weakref.WeakSet()


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
    return f"file:{quote(os.fsencode(os.path.abspath(path)))}?mode={mode}"


def waiting(ask: Callable[[], object], path: Path) -> None:
    """Call `ask` until it gets a lock or the time is up; Ctrl-C works between attempts."""
    deadline = time.monotonic() + _TURNS * BUSY_TIMEOUT
    while True:
        try:
            ask()
            return
        except sqlite3.OperationalError as error:
            if _code_of(error) != sqlite3.SQLITE_BUSY or time.monotonic() >= deadline:
                raise
        if time.monotonic() >= deadline - (_TURNS - 1) * BUSY_TIMEOUT:
            _say_waiting(path)
        time.sleep(0.01)  # because SQLite itself does not wait before it changes the journal mode


@cache
def _say_waiting(path: Path) -> None:
    """Log, once for each file, that another process keeps this one waiting."""
    logging.getLogger("orbitdb").warning("waiting for another process that writes to %s", path)


# the SQL functions of words


def add_word_functions(driver: Driver, strict: bool = False) -> None:
    """Add the SQL functions of words.

    ``code(word)`` is the least rotation of a word. ``contains(word, pattern)`` is 1 if the pattern occurs in
    the cyclic word, else 0. Both are NULL for NULL, and for symbols that are not a word, as a part of a word
    may be; they fail for other texts and for numbers. With `strict`, for a catalogue of one empty row, they
    fail for all texts and numbers that are not words, and for arguments in the wrong order.
    """
    driver.create_function("code", 1, partial(_code, driver, strict), deterministic=True)
    driver.create_function("contains", 2, partial(_contains, driver, strict), deterministic=True)
    driver.create_function("elements_through", 3, _elements_through, deterministic=True)


def _code(driver: Driver, strict: bool, word: object) -> str | None:
    found = _word(driver, strict, word, _primitive, "code({})")
    return None if found is None else least_rotation(found)


def _contains(driver: Driver, strict: bool, word: object, pattern: object) -> bool | None:
    found = _word(driver, strict, pattern, _symbols, "contains(..., {})")
    if strict and pattern is None and word is not None:  # all columns are NULL there
        driver.failure = WordError("contains() takes the word first: write contains(code, '0202')")
        raise driver.failure
    if found is None or not (isinstance(word, str) and word):
        return None
    return contains_cyclic(word, found)


def _word(driver: Driver, strict: bool, value: object, parsed: Callable[[str], str], call: str) -> str | None:
    """Return the word or pattern that a value of SQL is, or None; keep the error if it cannot be one."""
    if value is None:
        return None
    try:
        if not isinstance(value, str):
            raise WordError(f"codes are texts, so write '{value}', in quotes")
        return parsed(value)
    except WordError as error:
        if not strict and isinstance(value, str) and not value.strip(SYMBOLS):
            return None
        driver.failure = WordError(f"{call.format(f'{value!r:.40}')}: {error}")
        raise driver.failure from error


def _elements_through(word: str, coordinates: bytes | None, openings: str) -> int | None:
    """Return the elements (bits) whose images of an orbit bounce in an opening; NULL without coordinates."""
    return None if coordinates is None else _through(word, coordinates, openings)


_CACHED = 64
"""Number of words and of patterns whose symbols are kept."""

_primitive, _symbols = lru_cache(_CACHED)(parse_primitive), lru_cache(_CACHED)(parse)


@lru_cache(_CACHED)
def _through(word: str, coordinates: bytes, openings: str) -> int:
    """Compute the elements once a class, whose words follow one another."""
    return elements_through(word, array("d", coordinates), _openings(openings))


@lru_cache(_CACHED)
def _openings(texts: str) -> tuple[Opening, ...]:
    return parse_openings(texts.split())


# engines


_STATEMENTS = 50
"""Number of compiled statements that an engine keeps; one with an expression takes 0.2 MB."""


def make_engine(
    creator: Callable[[], Driver], begin: str, pool: type[Pool], wrapped: bool = False
) -> sa.Engine:
    """Return an engine whose transactions start with a given statement, such as BEGIN IMMEDIATE.

    Parameters
    ----------
    creator : callable
        Opens a connection, as `orbitdb.store.file.open_to_read` does.
    begin : str
    pool : type
        Class of the pool that keeps the connections.
    wrapped : bool, optional
        Whether errors are SQLAlchemy's; by default they are the driver's, as where its cursors are read.
    """
    # without hide_parameters, the message of a failed insert would show pages of rows
    engine = sa.create_engine(
        "sqlite://", creator=creator, poolclass=pool, hide_parameters=True, query_cache_size=_STATEMENTS
    )

    def start(connection: sa.Connection) -> None:
        driver = driver_of(connection)
        waiting(lambda: driver.execute(begin), driver.path)

    sa.event.listen(engine, "begin", start)
    if not wrapped:
        sa.event.listen(engine, "handle_error", _unwrap)
    return engine


def _unwrap(context: sa.engine.ExceptionContext) -> None:
    raise context.original_exception


# errors


@contextmanager
def plain_errors(path: Path) -> Iterator[None]:
    """Turn errors of SQLite into a `StoreError` that says what to do."""
    try:
        yield
    except DATABASE_ERRORS as error:
        if _code_of(error) == sqlite3.SQLITE_INTERRUPT:  # by a signal
            raise KeyboardInterrupt from error
        raise store_error(path, error) from error
    except AssertionError as error:
        if (signalled := _lost_signal(error)) is not None:
            raise signalled from None
        raise


def _lost_signal(error: AssertionError) -> KeyboardInterrupt | SystemExit | None:
    """Return the signal in whose place SQLAlchemy raises an error of its own while a transaction ends."""
    lost = error.__context__
    return lost if isinstance(lost, KeyboardInterrupt | SystemExit) else None


def store_error(path: Path, error: Exception) -> StoreError:
    """Return one line that says what an error of SQLite means and what to do."""
    code = _code_of(error)
    undecodable = isinstance(error, UnicodeDecodeError)
    if undecodable or code == sqlite3.SQLITE_CORRUPT or any(sign in str(error) for sign in _SIGNS_OF_DAMAGE):
        journal = journal_files(path)[0]
        away = f"; remove {journal} before you copy" if journal_size(path) else ""
        return DamagedError(f"{path} is damaged: restore a copy, or move it away and fill a new one{away}")
    if (limit := _of_limits(path, code)) is not None:
        return StoreError(limit)
    if code in _REMEDIES:
        return StoreError(_REMEDIES[code].format(path=path))
    return StoreError(f"{path}: {error}")


def of_file(error: BaseException) -> bool:
    """Tell whether an error of SQLite is about the file or the disk, not about a statement."""
    return _code_of(error) in {sqlite3.SQLITE_CORRUPT, *_REMEDIES}


def read_only(path: Path) -> StoreError:
    """Return the error of a file that must not be written."""
    return StoreError(_REMEDIES[sqlite3.SQLITE_READONLY].format(path=path))


def _of_limits(path: Path, code: int | None) -> str | None:
    """Return what else keeps this process from opening or writing a file: a limit of the shell; or None."""
    if sys.platform == "win32":
        return None
    if code == sqlite3.SQLITE_CANTOPEN:
        try:
            with ExitStack() as stack:
                for _ in range(4):  # the file, its journal, the index of that, the folder
                    stack.callback(os.close, os.open(os.devnull, os.O_RDONLY))
        except OSError:
            most, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
            return (
                f"{path} cannot be opened: this process has {most} open files, all that 'ulimit -n' allows: "
                "close some, or raise the limit"
            )
    most, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    if code in (sqlite3.SQLITE_IOERR, sqlite3.SQLITE_FULL) and most != resource.RLIM_INFINITY:
        return (
            f"{path} cannot grow, because 'ulimit -f' allows files of {gigabytes(most)}: raise the limit, "
            "then run the same command again to continue"
        )
    return None


def _code_of(error: BaseException) -> int | None:
    """Return SQLite's primary result code of an error; the driver's own errors have none."""
    code: int | None = getattr(error, "sqlite_errorcode", None)
    return None if code is None else code & 0xFF


_ROOM = "delete other files (deleting from a catalogue needs room, too)"
_REMEDIES = {
    **dict.fromkeys(
        (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED),
        "{path} is in use by another process that writes: try again when it has finished",
    ),
    sqlite3.SQLITE_READONLY: "{path} cannot be written: check its permissions, or name another file",
    sqlite3.SQLITE_CANTOPEN: "{path} cannot be opened: check its permissions, and those of its folder",
    sqlite3.SQLITE_FULL: f"no space left for {{path}}: {_ROOM}, then run the same command again to continue",
    sqlite3.SQLITE_NOTADB: "{path} is not an orbitdb catalogue: name another file",
    sqlite3.SQLITE_IOERR: "{path} cannot be read or written (disk I/O error): check that the disk has room; "
    f"if not, {_ROOM}",
}
"""What each result code means, and what to do."""

_SIGNS_OF_DAMAGE = (
    "decode to UTF-8", "no such table", "no such column", "user-defined function raised exception",
)  # fmt: skip
"""Parts of the messages of other errors that damage causes."""
