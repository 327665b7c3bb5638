"""A catalogue opened for writing."""

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from orbitdb import __version__
from orbitdb.arithmetic import arithmetic
from orbitdb.store.file.database import plain_errors
from orbitdb.store.file.engines import reading_engine, writing_engine
from orbitdb.store.file.tables import run, stadium


class Writer:
    """A catalogue of the newest schema, opened for writing on behalf of one run of the program.

    The parameters are what the run was asked to do; they are kept as its provenance, with the
    `arithmetic` that computed it. For `references` see `writing_engine`.
    """

    def __init__(self, path: Path, parameters: dict[str, Any], references: bool = True) -> None:
        self.path = path
        self._engine, self._reading = writing_engine(path, references), reading_engine(path)
        self._parameters = parameters
        self._run_ids: dict[str, int] = {}
        self._written = False

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """Give a connection that holds the write lock; all is written, or nothing."""
        noted = dict(self._run_ids)
        try:
            with plain_errors(self.path), self._engine.begin() as connection:
                yield connection
        except BaseException:
            self._run_ids = noted  # what was noted since is gone with the rest
            raise
        self._written = True

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Give a connection that sees one moment and lets others write meanwhile."""
        with plain_errors(self.path), self._reading.begin() as connection:
            yield connection

    def try_to_write(self) -> None:
        """Write nothing, as a check that something could be written: else a `StoreError`."""
        with self.writing() as connection:
            connection.execute(sa.delete(run).where(sa.false()))

    def close(self) -> None:
        """Close the file, with all that was written in it and not in the journal, whoever reads it still."""
        if self._written:
            with (
                suppress(sa.exc.DBAPIError, sqlite3.Error),
                closing(self._engine.raw_connection()) as connection,
            ):
                connection.execute("PRAGMA wal_checkpoint")
        self._reading.dispose()
        self._engine.dispose()

    def run_id(self, connection: sa.Connection, computed: str | None = None) -> int:
        """Return the number of this run, noting it on its first write.

        A run whose workers differ has several, one for each `arithmetic` that computed something; by
        default it is this machine's.
        """
        computed = computed or arithmetic()
        if computed not in self._run_ids:
            provenance = json.dumps(self._parameters | {"arithmetic": computed}, sort_keys=True)
            started = datetime.now(UTC).isoformat(timespec="seconds")
            values = {"started": started, "version": __version__, "parameters": provenance}
            fresh = sa.insert(run).values(**values).returning(run.c.id)
            self._run_ids[computed] = int(connection.execute(fresh).scalar_one())
        return self._run_ids[computed]

    def stadium_id(self, connection: sa.Connection, a: float) -> int:
        """Return the number of a stadium, adding it if it is new."""
        connection.execute(sa.insert(stadium).prefix_with("OR IGNORE").values(a=a))
        return int(connection.execute(sa.select(stadium.c.id).where(stadium.c.a == a)).scalar_one())
