"""Engines for a catalogue, for reading or writing; SQLite's errors in plain words."""

import logging
import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.sqlite import dialect
from sqlalchemy.pool import Pool
from sqlalchemy.schema import CreateTable

from orbitdb.errors import DamagedError, StoreError
from orbitdb.store.connection import (
    DATABASE_ERRORS,
    Driver,
    driver_of,
    open_sqlite,
    original,
    uri_of,
    waiting,
)
from orbitdb.store.journal import journal_files, journal_size, refuse_foreign_journal
from orbitdb.store.paths import check_same_file, file_id
from orbitdb.store.tables import PAGE_SIZE, SCHEMA_VERSION, TABLES
from orbitdb.store.views import view_texts

_CACHE = 8 << 10
"""Page cache of a reader in kilobytes; it is small, because rows are read in the order of storage."""

# otherwise a Ctrl-C while a connection is being closed would be logged with a traceback, and then raised
logging.getLogger("sqlalchemy.pool").addHandler(logging.NullHandler())


def open_to_read(path: Path) -> Driver:
    """Open a catalogue for reading, even in a read-only folder, on a full disk, or while others write."""
    alone = read_alone(path)
    try:
        return _reader(path, alone)
    except sqlite3.OperationalError as error:
        if alone or error.sqlite_errorcode & 0xFF not in _NO_ROOM or journal_size(path):
            raise
    return _reader(path, True)  # there is no room for the index of the journal


_NO_ROOM = (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_CANTOPEN)


def _reader(path: Path, alone: bool) -> Driver:
    mode = "&immutable=1" if alone else ""
    # the last to close the file removes the journal, and needs "rw" for it
    with _opening(path, uri_of(path, "rw") + mode) as driver:
        driver.alone = alone
        driver.execute("PRAGMA temp_store = MEMORY")
        stored = dict(driver.execute("SELECT name, sql FROM sqlite_master"))
        ((version,),) = driver.execute("PRAGMA user_version")
        for name in TABLES.keys() - stored.keys() if version < SCHEMA_VERSION else ():
            text = str(CreateTable(TABLES[name]).compile(dialect=dialect()))
            driver.execute(text.replace("CREATE TABLE", "CREATE TEMP TABLE", 1))
        for text in set(view_texts().values()) - set(stored.values()):  # others are for other programs
            driver.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))
        driver.add_functions()
        driver.execute("PRAGMA query_only = ON")
        driver.execute(f"PRAGMA cache_size = -{_CACHE}")
    return driver


def open_to_write(path: Path, references: bool = True, create: bool = False) -> Driver:
    """Open a file for writing; with `references`, SQLite checks every foreign key that is written.

    A fill does not check references, because the random lookups would take a third of its time. Only with
    `create` may the file be new. SQLite itself moves no journal into the file (`checkpoint` does).
    """
    if path.exists() and not os.access(path, os.W_OK):
        raise StoreError(remedy(path, "readonly"))  # SQLite would do so, too, but leave an empty journal
    with _opening(path, uri_of(path, "rwc" if create else "rw")) as driver:
        driver.execute(f"PRAGMA page_size = {PAGE_SIZE}")  # for a new file; others keep their page size
        waiting(lambda: driver.execute("PRAGMA journal_mode = WAL"), path)
        driver.execute("PRAGMA synchronous = NORMAL")
        driver.execute("PRAGMA wal_autocheckpoint = 0")
        driver.execute("PRAGMA journal_size_limit = 0")  # a journal is then as large as its content
        driver.execute(f"PRAGMA foreign_keys = {'ON' if references else 'OFF'}")
    return driver


@contextmanager
def _opening(path: Path, uri: str) -> Iterator[Driver]:
    """Connect to a file whose journal belongs to it; close it again if the block fails.

    Raises `StoreError` if the journal belongs to another file, or if the file is replaced at this moment.
    """
    before = file_id(path)
    refuse_foreign_journal(path)
    driver = open_sqlite(uri)
    driver.path, driver.opened = path, before
    try:
        if before:
            check_same_file(path, before, "opened it")
        yield driver
    except BaseException:
        driver.close()
        raise


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


def read_alone(path: Path) -> bool:
    """Tell whether to read a file without locks, because SQLite could not write or remove its journal.

    A journal that another user left behind would keep the owner from writing.
    """
    writable = all(os.access(part, os.W_OK) for part in (path, path.parent))
    return not writable and not journal_files(path)[0].exists()


# errors


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
        line = remedy(path, message)
        raise (DamagedError if " is damaged: " in line else StoreError)(line) from error
    except AssertionError as error:  # SQLAlchemy's own, in place of a signal while it ends a transaction
        if isinstance(signalled := error.__context__, KeyboardInterrupt | SystemExit):
            raise signalled from None
        raise


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
