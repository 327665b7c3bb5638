"""The journal beside a catalogue: whether it belongs to the file, and moving it into the file.

SQLite keeps the latest changes in a journal, ``orbits.db-wal``, until it moves them into the file. It finds
the journal by name alone. If a killed process leaves a journal behind, and another file is then copied over
the catalogue, SQLite would apply the journal to that file. To notice this, every transaction that writes
increases a counter in the row of its run. A journal belongs to a file if it contains the file's last run,
with at least the same number of commits, and every commit since then.
"""

import os
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.store import tables as t
from orbitdb.store.paths import FileId, file_id, journal_files, journal_size
from orbitdb.store.sqlite import DATABASE_ERRORS, Driver, Run, open_sqlite, uri_of


def remove_journal_of(
    path: Path, opened: FileId | None, journal: dict[Path, FileId | None], moved: bool = False
) -> None:
    """Remove the journal of an opened file that is no longer at its path; SQLite would leave it there.

    SQLite would take it for the journal of the next file with this name. While there is no such file, the
    user may have moved the opened one and still need its journal, unless all of it was `moved` into the file.
    """
    now = file_id(path)
    gone = moved or not journal_size(path) if now is None else not now.is_same(opened)
    if gone:
        for part, was in journal.items():
            if was is not None and was.is_same(file_id(part)):
                part.unlink(missing_ok=True)


JOURNAL_LIMIT = 16 << 20
"""Size in bytes of a journal from which on a writer moves it into the file."""


def checkpoint(engine: sa.Engine, other: Driver, limit: int = 0) -> None:
    """Move the journal of a file into the file, if it is larger than a limit in bytes.

    Before version 3.51.3, SQLite can lose what one connection commits while another one moves the journal
    (https://sqlite.org/wal.html, section 11). So the engine holds the write lock while `other` moves it.
    """
    if journal_size(other.path) > limit:
        with engine.begin():
            other.execute("PRAGMA wal_checkpoint(PASSIVE)")


def refuse_foreign_journal(path: Path) -> None:
    """Raise `StoreError` if the journal next to a file belongs to another file."""
    if journal_size(path) and not (_has_last_run(path) and _has_every_commit(path)):
        journal, index = (part.name for part in journal_files(path))
        raise StoreError(
            f"{journal} is not the journal of {path}, but of a file that had this name before: move "
            f"{journal} and {index} away, and leave {path.name} where it is"
        )


def count_transaction(connection: sa.Connection, run: int | None = None) -> None:
    """Count a transaction in the row of a run, by default of the last one."""
    own = run or sa.select(sa.func.max(t.run.c.id)).scalar_subquery()
    connection.execute(sa.update(t.run).where(t.run.c.id == own).values(commits=t.run.c.commits + 1))


def last_run(driver: Driver) -> Run | None:
    """Return the last run in a file and its journal, as a connection sees it; None before the first run."""
    found: Run | None = driver.execute(_LAST_RUN).fetchone()
    return found


def has_run(path: Path, run: Run) -> bool:
    """Tell whether the file that is now at a path has a run, with at least as many commits."""
    try:
        refuse_foreign_journal(path)
        return _row_of(uri_of(path) if journal_size(path) else _alone(path), _SAME_RUN, run) is not None
    except sqlite3.OperationalError as error:
        return "no such table" not in str(error)  # locked, for example by a process that moves the journal
    except (StoreError, *DATABASE_ERRORS):
        return False


def _has_last_run(path: Path) -> bool:
    """Tell whether a journal has the last run of the file beside it, with at least as many commits.

    Others may write meanwhile, so the file is read before the journal. No connection can write, because the
    last one to close would move the journal into the file.
    """
    try:
        run = _row_of(_alone(path), _LAST_RUN)
    except DATABASE_ERRORS:
        return True  # nothing to compare: damaged, or the first pages are still in the journal
    try:
        return (_row_of(uri_of(path), _SAME_RUN, run) if run else _row_of(uri_of(path), _COMMITS)) is not None
    except sqlite3.OperationalError as error:
        return "no such table" not in str(error)  # locked, or no permission; opening it will say so
    except DATABASE_ERRORS:
        return False


def _has_every_commit(path: Path) -> bool:
    """Tell whether a journal has all commits that its file lacks.

    An older copy of the file lacks those, too, that were moved into the file before the journal began. Others
    may write meanwhile, so the file is read after the journal.
    """
    try:
        (written,) = _row_of(uri_of(path), _COMMITS)
        in_journal = _transactions_in(journal_files(path)[0])
        (moved,) = _row_of(_alone(path), _COMMITS)
    except (OSError, *DATABASE_ERRORS):
        return True  # another process is moving the journal, or opening the file will say what is wrong
    return int(written) - int(moved) <= in_journal


_LAST_RUN = "SELECT id, started, commits FROM run ORDER BY id DESC LIMIT 1"
_SAME_RUN = "SELECT 1 FROM run WHERE id = ? AND started = ? AND commits >= ?"
_COMMITS = "SELECT coalesce(sum(commits), 0) FROM run"


def _alone(path: Path) -> str:
    """Return the URI of a file without its journal."""
    return uri_of(path) + "&immutable=1"


def _row_of(uri: str, query: str, values: tuple[Any, ...] = ()) -> Any:
    with closing(open_sqlite(uri)) as driver:
        return driver.execute(query, values).fetchone()


def _transactions_in(journal: Path) -> int:
    """Return the number of transactions in a journal, without VACUUM, which no run counts.

    The format is https://sqlite.org/fileformat2.html#walformat. Only VACUUM, and the creation of a file,
    write every page.
    """
    count, pages = 0, set[bytes]()
    with open(journal, "rb") as file:
        header = file.read(32)
        size, salt = int.from_bytes(header[8:12], "big"), header[16:24]
        while (frame := file.read(24))[8:16] == salt and salt:
            pages.add(frame[:4])
            if of_file := int.from_bytes(frame[4:8], "big"):  # only the last page of a transaction has it
                count += len(pages) < of_file - 1  # without the one that SQLite leaves out after 1 GB
                pages.clear()
            file.seek(size, os.SEEK_CUR)
    return count
