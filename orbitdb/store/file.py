"""The file of a catalogue: reading it, and creating or upgrading it."""

import os
import sqlite3
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import NamedTuple, TypeVar

import sqlalchemy as sa
from sqlalchemy.dialects.sqlite import dialect
from sqlalchemy.pool import NullPool, StaticPool
from sqlalchemy.schema import CreateTable

from orbitdb.errors import DamagedError, InputError, StoreError
from orbitdb.store import tables as t
from orbitdb.store.file_kind import check_file, check_version, need_readable, pragma
from orbitdb.store.journal import (
    count_transaction,
    has_run,
    last_run,
    refuse_foreign_journal,
    remove_journal_of,
)
from orbitdb.store.paths import (
    FileId,
    absolute_path,
    check_same_file,
    data_folder,
    default_path,
    file_id,
    home_expanded,
    journal_files,
    journal_ids,
    journal_size,
    refuse_links,
)
from orbitdb.store.sqlite import (
    ClosedError,
    Driver,
    Seen,
    add_word_functions,
    driver_of,
    make_engine,
    never,
    open_sqlite,
    path_of,
    plain_errors,
    read_only,
    uri_of,
    waiting,
)
from orbitdb.store.views import create_views, view_texts
from orbitdb.symbols.symmetry import ELEMENT_ROWS

_Row = TypeVar("_Row")

# reading


class Store:
    """A catalogue file to read; each question opens it, so that others can write to it or replace it.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.
    missing_ok : bool, optional
        Whether a missing file is an empty catalogue.

    Attributes
    ----------
    path : Path
        Absolute path of the file.

    Raises
    ------
    StoreError
        If there is no catalogue at the path, unless `missing_ok`, or this version cannot read it.
    """

    def __init__(self, path: Path | str | None = None, missing_ok: bool = False) -> None:
        need_readable(default_path() if path is None else home_expanded(path), missing_ok)
        self.path, self._missing_ok = absolute_path(path), missing_ok
        self._checked: FileId | None = None
        self._engine = self._new_engine()

    def _new_engine(self, wrapped: bool = False) -> sa.Engine:
        engine = make_engine(self._open, "BEGIN", NullPool, wrapped)
        sa.event.listen(engine, "begin", _begun)
        return engine

    @cached_property
    def engine(self) -> sa.Engine:
        """An engine for SQL of your own, whose connections cannot write."""
        return self._new_engine(wrapped=True)

    def there(self) -> bool:
        """Tell whether there is a catalogue at the path now; raise `StoreError` if it cannot be read."""
        now = file_id(self.path)
        if now is None or now != self._checked:  # a file that has not changed need not be opened twice
            self._checked = now if need_readable(self.path, self._missing_ok) else None
        return self._checked is not None

    def _open(self) -> Driver:
        """Open the file that is now at the path, or an empty catalogue in memory."""
        with plain_errors(self.path):
            driver = open_to_read(self.path) if self.there() else open_empty()
            driver.path = self.path
            return driver

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Yield a connection for one question, which sees the file as it is now."""
        with self.snapshot() as moment, moment.reading() as connection:
            yield connection

    @contextmanager
    def snapshot(self, cancelled: Callable[[], bool] = never) -> Iterator["Moment"]:
        """Yield the file as it is now, for several questions; changes made meanwhile are not seen.

        Long queries call `cancelled` now and then, and raise `CancelledError` if it returns True.
        """
        process = os.getpid()
        with plain_errors(self.path):
            connection = self._engine.connect()
        driver, journal = driver_of(connection), dict[Path, FileId | None]()
        try:
            with plain_errors(self.path):
                connection.begin()
            driver.cancelled, journal = cancelled, journal_ids(self.path)
            yield Moment(connection)
            check_replaced(connection)
        finally:
            if process != os.getpid():
                _INHERITED.append(connection)
            else:
                with suppress(sqlite3.ProgrammingError):  # closed already, by SQLAlchemy after Ctrl-C
                    for cursor in [*driver.statements]:
                        cursor.close()
                with plain_errors(self.path):
                    connection.close()
                remove_journal_of(self.path, driver.opened, journal)


_INHERITED: list[sa.Connection] = []
"""Connections that a fork has copied into this process; only the parent may close them."""


class Moment:
    """A catalogue file at one moment, for questions of the thread that opened it.

    Attributes
    ----------
    path : Path
        The path of the file.
    """

    def __init__(self, connection: sa.Connection) -> None:
        self._connection, self._owner = connection, (os.getpid(), threading.get_ident())
        self.path = path_of(connection)

    def there(self) -> bool:
        """Tell whether there was a catalogue at the path."""
        with self.reading() as connection:
            return driver_of(connection).opened is not None

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Yield the connection for one question.

        Raises
        ------
        InputError
            If the snapshot has ended, or belongs to another thread.
        StoreError
            If another file was copied over this one before the question was answered.
        """
        if self._owner != (os.getpid(), threading.get_ident()):
            raise InputError("a snapshot belongs to the thread that opened it: open another one here")
        if self._connection.closed:
            raise InputError(_ENDED)
        try:
            with plain_errors(self.path):
                yield self._connection
        except ClosedError:  # rows that are still read after the end
            raise InputError(_ENDED) from None
        except DamagedError:
            check_replaced(self._connection)
            raise
        check_replaced(self._connection)


_ENDED = "the snapshot has ended: ask, and read the rows, within its with block"


def _begun(connection: sa.Connection) -> None:
    """Note what the transaction sees, which fixes it, as BEGIN alone does not; check the schema again."""
    driver = driver_of(connection)
    check_version(driver.path, pragma(driver, "user_version"))
    driver.seen = Seen(driver.opened, last_run(driver)) if driver.opened else None


def read_whole(connection: sa.Connection, rows: Iterable[_Row]) -> Iterator[_Row]:
    """Yield rows, and raise `StoreError` after the last one if the file was replaced meanwhile."""
    yield from rows
    check_replaced(connection)


def check_replaced(connection: sa.Connection) -> None:
    """Raise `StoreError` if the file that a connection reads has been replaced since the transaction began.

    A file that others have written meanwhile still has the run that was the last one then.
    """
    if connection.closed:
        return
    driver = driver_of(connection)
    if driver.seen is None or (now := file_id(driver.path)) in (driver.seen.file, None):
        return  # of a file that was deleted, everything can still be read
    if driver.alone:
        raise StoreError(f"{driver.path} was written while it was being read: try again")
    known = driver.seen.run  # without a run, nothing was seen but an empty catalogue
    assert now is not None
    if not (has_run(driver.path, known) if known else now.is_same(driver.opened)):
        raise StoreError(f"{driver.path} was replaced by another file while it was being read: ask again")
    driver.seen = Seen(now, driver.seen.run)


_CACHE = 8 << 10
"""Page cache of a reader in kilobytes; it is small, because rows are read in the order of storage."""


def open_to_read(path: Path) -> Driver:
    """Open a catalogue for reading, even in a read-only folder, on a full disk, or while others write."""
    alone = read_alone(path)
    try:
        return _reader(path, alone)
    except sqlite3.OperationalError as error:
        if alone or getattr(error, "sqlite_errorcode", 0) & 0xFF not in _NO_ROOM or journal_size(path):
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
        version = pragma(driver, "user_version")
        for name in t.TABLES.keys() - stored.keys() if version < t.SCHEMA_VERSION else ():
            text = str(CreateTable(t.TABLES[name]).compile(dialect=dialect()))
            driver.execute(text.replace("CREATE TABLE", "CREATE TEMP TABLE", 1))
        for text in set(view_texts().values()) - set(stored.values()):  # others are for other programs
            driver.execute(text.replace("CREATE VIEW", "CREATE TEMP VIEW", 1))
        add_word_functions(driver)
        driver.execute("PRAGMA query_only = ON")
        driver.execute(f"PRAGMA cache_size = -{_CACHE}")
    return driver


def open_to_write(path: Path, references: bool = True, create: bool = False) -> Driver:
    """Open a file for writing; with `references`, SQLite checks every foreign key that is written.

    A fill does not check references, because the random lookups would take a third of its time. Only with
    `create` may the file be new. SQLite itself moves no journal into the file (`checkpoint` does).
    """
    if path.exists() and not os.access(path, os.W_OK):
        raise read_only(path)  # SQLite would do so, too, but leave an empty journal
    refuse_links(path)
    with _opening(path, uri_of(path, "rwc" if create else "rw")) as driver:
        driver.execute(f"PRAGMA page_size = {t.PAGE_SIZE}")  # for a new file; others keep their page size
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


def read_alone(path: Path) -> bool:
    """Tell whether to read a file without locks, because SQLite could not write or remove its journal.

    A journal that another user left behind would keep the owner from writing.
    """
    writable = all(os.access(part, os.W_OK) for part in (path, path.parent))
    return not writable and not journal_files(path)[0].exists()


def open_empty() -> Driver:
    """Return an empty catalogue in memory."""
    driver = open_sqlite("file::memory:")
    add_word_functions(driver)
    with make_engine(lambda: driver, "BEGIN", StaticPool).begin() as connection:
        _create(connection)
    return driver


@contextmanager
def reading(path: Path | str | None = None) -> Iterator[sa.Connection]:
    """Open a catalogue for a single snapshot, and close it afterwards."""
    with Store(path).reading() as connection:
        yield connection


def copy_into(connection: sa.Connection, path: Path) -> None:
    """Copy the catalogue that a snapshot sees into a new file, which gets no journal."""
    driver = driver_of(connection)
    with plain_errors(path), closing(open_sqlite(uri_of(path, "rwc"))) as whole:
        whole.execute("PRAGMA journal_mode = OFF")
        whole.execute("PRAGMA synchronous = OFF")
        driver.backup(whole, pages=_PAGES_A_STEP, progress=lambda *_: None, sleep=0)
    check_replaced(connection)


_PAGES_A_STEP = 1000
"""Pages that are copied before Python can handle a signal; all are those of the same snapshot."""


def size_of(connection: sa.Connection) -> int:
    """Return the size in bytes of the file that a snapshot sees, with what is still in its journal."""
    driver = driver_of(connection)
    return pragma(driver, "page_count") * pragma(driver, "page_size")


# creating and upgrading


MIGRATIONS = resources.files("orbitdb.migrations")
"""The folder of the Alembic revisions."""


class Migration(NamedTuple):
    """The schema versions before (0 for a new file) and after."""

    before: int
    after: int


def migrate(path: Path) -> Migration:
    """Create a catalogue, or upgrade an older one, in a single transaction."""
    before = check_file(path) or 0
    if before == t.SCHEMA_VERSION:
        return Migration(before, before)
    folder, own = path.parent, None
    with suppress(StoreError):  # no home folder
        own = data_folder()
    try:
        if folder == own:
            folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(
            f"{folder} cannot be created ({error.strerror}): name a file in another folder"
        ) from error
    if not folder.is_dir():
        raise StoreError(f"there is no folder {folder}: create it first, or name another file")
    with plain_errors(path), upgrading(path) as connection:
        if before:
            upgrade(connection)
        elif not pragma(driver_of(connection), "user_version"):  # nobody else has created it meanwhile
            _create(connection)
    return Migration(before, t.SCHEMA_VERSION)


@contextmanager
def upgrading(path: Path) -> Iterator[sa.Connection]:
    """Yield a connection that may create a file and change its tables, in a single transaction."""
    driver = open_to_write(path, references=False, create=True)
    engine, opened, journal = make_engine(lambda: driver, "BEGIN IMMEDIATE", StaticPool), file_id(path), {}
    try:
        with engine.begin() as connection:
            journal = journal_ids(path)
            yield connection
    finally:
        engine.dispose()
        remove_journal_of(path, opened, journal)
    check_same_file(path, opened, "was changing its schema: run it again")


def _create(connection: sa.Connection) -> None:
    """Create the latest schema directly, and record its revision for Alembic."""
    t.metadata.create_all(connection, checkfirst=False)
    t.revision.create(connection, checkfirst=False)
    connection.execute(sa.insert(t.revision).values(version_num=f"{t.SCHEMA_VERSION:04}"))
    names = [column.name for column in t.element.c]
    connection.execute(sa.insert(t.element), [dict(zip(names, row, strict=True)) for row in ELEMENT_ROWS])
    finish(connection, t.SCHEMA_VERSION)


def finish(connection: sa.Connection, version: int) -> None:
    """Give a file with the tables of a version the views, and mark it as a catalogue of that version."""
    create_views(connection)
    driver = driver_of(connection)
    driver.execute(f"PRAGMA application_id = {t.APPLICATION_ID}")
    driver.execute(f"PRAGMA user_version = {version}")
    count_transaction(connection)


def upgrade(connection: sa.Connection) -> None:
    """Run the missing revisions of an older catalogue.

    Raises `StoreError` if the file does not have the one revision that its schema version says.
    """
    version = pragma(driver_of(connection), "user_version")
    revisions = connection.scalars(sa.select(t.revision.c.version_num)).all()
    if revisions != [f"{version:04}"]:
        raise StoreError(
            f"{path_of(connection)} has schema {version}, but its table alembic_version says "
            f"{', '.join(map(repr, revisions)) or 'nothing'}: restore a copy"
        )
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.attributes["connection"] = connection
    with resources.as_file(MIGRATIONS) as folder:  # a copy, if Python imports this package from an archive
        config.set_main_option("script_location", str(folder))
        command.upgrade(config, "head")
