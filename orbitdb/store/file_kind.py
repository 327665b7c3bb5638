"""What kind of file is at a path: whether it is a catalogue, and of which schema version."""

import sqlite3
import stat
from contextlib import closing, suppress
from pathlib import Path

from orbitdb.errors import StoreError
from orbitdb.store import tables as t
from orbitdb.store.journal import refuse_foreign_journal
from orbitdb.store.paths import absolute_path, journal_size
from orbitdb.store.sqlite import Driver, open_sqlite, plain_errors, uri_of


def check_file(path: Path) -> int | None:
    """Return the schema version of a file, or None if the file is missing or empty.

    Raises
    ------
    StoreError
        If the file is not a catalogue, or its schema is newer or older than this version can read.
    """
    try:
        status = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise StoreError(f"{path} cannot be read ({error.strerror}): check its permissions") from error
    if stat.S_ISDIR(status.st_mode):
        raise StoreError(f"{path} is a folder: name a file")
    if not stat.S_ISREG(status.st_mode):
        raise StoreError(f"{path} is not an ordinary file: name another")
    if status.st_size == 0:
        return None
    if status.st_size == 1:  # SQLite would take it for an empty file
        raise StoreError(f"{path} is not an orbitdb catalogue: name another file")
    version, application, empty = _marks(path)
    if empty:
        return None  # a database without tables, because its creation was interrupted
    if application != t.APPLICATION_ID:
        pragmas = f"PRAGMA application_id = {t.APPLICATION_ID}; PRAGMA user_version = {t.SCHEMA_VERSION}"
        raise StoreError(
            f"{path} is another program's SQLite database: name another file "
            f'(a catalogue restored from .dump needs "{pragmas}" in sqlite3)'
        )
    check_version(path, version)
    return version


def check_version(path: Path, version: int) -> None:
    """Raise `StoreError` if this version of the program knows no schema with that number."""
    if version > t.SCHEMA_VERSION:
        raise StoreError(
            f"{path} has schema {version}, newer than this orbitdb's {t.SCHEMA_VERSION}: upgrade orbitdb"
        )
    if version < t.OLDEST_VERSION:
        raise StoreError(
            f"{path} was made by a development version of orbitdb (schema {version}): "
            "fill a new one under another name"
        )


def need_readable(path: Path, missing_ok: bool = False) -> bool:
    """Raise `StoreError`, which says what to do, unless there is a catalogue that this version can read.

    Return False if it is missing, which is an error unless `missing_ok`.
    """
    return _need(path, t.OLDEST_READABLE, missing_ok)


def need_newest(path: Path) -> None:
    """Raise `StoreError`, which says what to do, unless the file is a catalogue with the latest schema."""
    _need(path, t.SCHEMA_VERSION)


def _need(path: Path, least: int, missing_ok: bool = False) -> bool:
    version = check_file(path)
    if version is None and missing_ok:
        return False
    if version is None:
        raise StoreError(
            f"no catalogue at {path}: make one with `Catalogue.create({_named(path)}).fill(p=11)`"
        )
    if version < least:
        raise StoreError(
            f"{path} has the older schema {version}: run `Catalogue.migrate({_named(path)})` first"
        )
    return True


def _named(path: Path) -> str:
    """Return a path as an argument, '' for the default catalogue."""
    return "" if path.absolute() == absolute_path(None) else repr(str(path))


def _marks(path: Path) -> tuple[int, int, bool]:
    """Return the schema's version and the application of a file and its journal, and whether it is empty.

    Only SQLite may open the file. A process that closes a file loses all its locks on it (POSIX), including
    those of SQLite's connections, and other processes could then remove the journal while it is in use.
    """
    mode = "ro"
    if not journal_size(path):
        with suppress(sqlite3.Error):  # damaged, or being written at this moment
            return _read_marks(uri_of(path) + "&immutable=1")
        mode = "rw"  # so that closing the file removes the empty journal that opening it makes
    refuse_foreign_journal(path)
    with plain_errors(path):
        return _read_marks(uri_of(path, mode))


def _read_marks(uri: str) -> tuple[int, int, bool]:
    with closing(open_sqlite(uri)) as driver:
        version, application = (pragma(driver, name) for name in ("user_version", "application_id"))
        # the number of pages is looked up last, because that reads the schema
        return version, application, not (version or application) and pragma(driver, "page_count") <= 1


def pragma(driver: Driver, name: str) -> int:
    """Return the value of a pragma that is a whole number."""
    (value,) = driver.execute(f"PRAGMA {name}").fetchone()
    return int(value)
