"""`Writer`, a catalogue open for writing by one run of the program."""

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import Connection, Table, select
from sqlalchemy.pool import StaticPool

from orbitdb import __version__
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.store import tables as t
from orbitdb.store.file import open_to_write, read_alone, reading
from orbitdb.store.file_kind import need_newest
from orbitdb.store.journal import JOURNAL_LIMIT, checkpoint, count_transaction, remove_journal_of
from orbitdb.store.paths import FileId, absolute_path, check_same_file, file_id, journal_ids
from orbitdb.store.sqlite import Driver, driver_of, make_engine, plain_errors, uri_of


class Writer:
    """A catalogue with the latest schema, open for writing by one run of the program.

    The parameters of the run and its `arithmetic` are stored as provenance. `open_to_write` explains
    `references`. A writer never creates a file (`orbitdb.store.file` does).
    """

    def __init__(self, path: Path, parameters: dict[str, Any], references: bool = True) -> None:
        need_newest(path)
        self.path = absolute_path(path)
        self._parameters = parameters
        self._run_ids: dict[str, int] = {}
        self.file = file_id(self.path)
        self._journal: dict[Path, FileId | None] = {}
        self._references = references
        self._interrupted = False
        self._drivers: tuple[Driver, ...] = ()  # one that writes, and one that moves the journal
        self._engine = make_engine(self._open, "BEGIN IMMEDIATE", StaticPool)

    def _open(self) -> Driver:
        for _ in range(2):
            self._drivers += (open_to_write(self.path, self._references),)
        return self._drivers[0]

    @contextmanager
    def transaction(self) -> Iterator[Connection]:
        """Yield a connection that has the write lock, in a single transaction.

        Raises
        ------
        StoreError
            If the file cannot be written, or is no longer at its path.
        """
        noted = dict(self._run_ids)
        try:
            with plain_errors(self.path):
                with self._counted() as connection:
                    yield connection
                checkpoint(self._engine, self._drivers[-1], JOURNAL_LIMIT)
        except BaseException as error:
            self._run_ids = noted  # the runs recorded since then were rolled back
            self._interrupted |= not isinstance(error, Exception)
            raise

    @contextmanager
    def _counted(self) -> Iterator[Connection]:
        """Yield a connection in a transaction, which counts if it changes anything."""
        self._check_file()
        with self._engine.begin() as connection:
            driver = driver_of(connection)
            before = driver.total_changes
            yield connection
            if driver.total_changes > before:  # for this run or, until it is stored, for the last one
                count_transaction(connection, next(iter(self._run_ids.values()), None))
            self._check_file()
            self._journal = journal_ids(self.path)

    @contextmanager
    def attached(self, path: Path) -> Iterator[None]:
        """Attach another catalogue as ``part``, for transactions within the block."""
        with plain_errors(self.path):
            self._engine.connect().close()
        with plain_errors(path):
            uri = uri_of(path, "rw") + "&immutable=1" * read_alone(path)
            self._drivers[0].execute("ATTACH ? AS part", (uri,))
        try:
            yield
        finally:
            with suppress(sqlite3.Error):
                self._drivers[0].execute("DETACH part")

    @contextmanager
    def reading(self) -> Iterator[Connection]:
        """Yield a connection that sees the file as it is now, even while others write."""
        self._check_file()
        with reading(self.path) as connection:
            yield connection

    def try_to_write(self) -> None:
        """Check that the file is writable without writing to it; raise `StoreError` if not."""
        with self.transaction() as connection:
            connection.execute(sa.delete(t.run).where(sa.false()))

    def close(self) -> None:
        """Move the journal into the file and close it, even while others read it.

        Raises
        ------
        StoreError
            If the file is no longer at its path.
        """
        moved = self._move_journal()
        self._engine.dispose()
        for driver in self._drivers:
            driver.close()
        remove_journal_of(self.path, self.file, self._journal, moved)
        self._check_file()

    def _move_journal(self) -> bool:
        """Move the journal into the file, if there is one; return whether it was moved."""
        if not self._journal or self._interrupted:  # the interrupted statement may still have the lock
            return False
        try:
            checkpoint(self._engine, self._drivers[-1])
        except sqlite3.Error:
            return False
        return True

    def _check_file(self) -> None:
        """Raise `StoreError` if the file was replaced, moved or deleted since it was opened."""
        check_same_file(
            self.path,
            self.file,
            "was writing to it: what it stored is in the old file; run the same command again to write to "
            "the file that you mean",
        )

    def run_id(self, connection: Connection, computed: str | None = None) -> int:
        """Return the id of this run; the first call stores the run.

        A run has a separate id for each arithmetic that its workers use, by default that of this machine.
        """
        computed = computed or arithmetic()
        if computed not in self._run_ids:
            provenance = json.dumps(self._parameters | {"arithmetic": computed}, sort_keys=True)
            started = datetime.now(UTC).isoformat()  # to the microsecond, to distinguish runs
            values = {"started": started, "version": __version__, "parameters": provenance}
            self._run_ids[computed] = replace_row(connection, t.run, values)
        return self._run_ids[computed]

    def stadium_id(self, connection: Connection, a: float) -> int:
        """Return the id of the stadium with a given a, after storing it if it is new."""
        query = select(t.stadium.c.id).where(t.stadium.c.a == a)
        if (stored := connection.scalar(query)) is not None:
            return int(stored)
        return replace_row(connection, t.stadium, {"a": a})


def check_writable(path: Path) -> FileId:
    """Raise `StoreError` if a catalogue cannot be written, before work whose result it should keep.

    Return which file it is.
    """
    with closing(Writer(path, {})) as writer:
        writer.try_to_write()
        assert writer.file is not None
        return writer.file


def replace_row(connection: Connection, table: Table, values: Mapping[str, Any]) -> int:
    """Store a row, in place of one with the same key, and return its id; 0 if the table has none."""
    made = connection.execute(sa.insert(table).prefix_with("OR REPLACE").values(**values))
    return int(made.lastrowid or 0)
