"""`Writer`, a catalogue open for writing; functions that store certificates, bounds, averages and levels."""

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa
from sqlalchemy.dialects.sqlite import insert

from orbitdb import __version__
from orbitdb.arithmetic import arithmetic
from orbitdb.store.file.database import (
    Place,
    absolute_path,
    need_newest,
    need_place,
    place,
    places_beside,
    plain_errors,
    reading_engine,
    remove_journal_of,
    writing_engine,
)
from orbitdb.store.file.tables import entropy_bound, level, level_fill, run, stadium, trajectory

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.quantum.levels import LevelWindow
    from orbitdb.trajectories.ensemble import Reference


class Writer:
    """A catalogue with the latest schema, open for writing by one run of the program.

    The parameters of the run and its `arithmetic` are stored as provenance. `writing_engine` explains
    `references`. A writer never creates a file (`orbitdb.store.file.migrate` does).
    """

    def __init__(self, path: Path, parameters: dict[str, Any], references: bool = True) -> None:
        need_newest(path)
        self.path = absolute_path(path)
        self._engine, self._reading = writing_engine(self.path, references), reading_engine(self.path)
        self._parameters = parameters
        self._run_ids: dict[str, int] = {}
        self._written = False
        self._place = place(self.path)
        self._journal: dict[Path, Place | None] = {}

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """Yield a connection that has the write lock, in a single transaction.

        Raises
        ------
        StoreError
            If the file cannot be written, or is no longer at its path.
        """
        noted = dict(self._run_ids)
        try:
            self._need_place()
            with plain_errors(self.path), self._engine.begin() as connection:
                yield connection
                if self._run_ids:
                    own = run.c.id == next(iter(self._run_ids.values()))
                    connection.execute(sa.update(run).where(own).values(commits=run.c.commits + 1))
                self._need_place()
                self._journal = places_beside(self.path)
        except BaseException:
            self._run_ids = noted  # the runs recorded since then were rolled back
            raise
        self._written = True

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Yield a connection that sees the file as it is now, even while others write."""
        self._need_place()
        with plain_errors(self.path), self._reading.begin() as connection:
            yield connection

    def try_to_write(self) -> None:
        """Check that the file is writable without writing to it; raise `StoreError` if not."""
        with self.writing() as connection:
            connection.execute(sa.delete(run).where(sa.false()))

    def close(self) -> None:
        """Move the journal into the file and close it, even while others read it.

        Raises
        ------
        StoreError
            If the file is no longer at its path.
        """
        if self._written:
            with (
                suppress(sa.exc.DBAPIError, sqlite3.Error),
                closing(self._engine.raw_connection()) as connection,
            ):
                connection.execute("PRAGMA wal_checkpoint")
        self._engine.dispose()
        remove_journal_of(self.path, self._place, self._journal)
        self._need_place()

    def _need_place(self) -> None:
        """Raise `StoreError` if the file was replaced, moved or deleted since it was opened."""
        need_place(
            self.path,
            self._place,
            "was writing to it: what it stored is in the old file; run the same command again to write to "
            "the file that you mean",
        )

    def run_id(self, connection: sa.Connection, computed: str | None = None) -> int:
        """Return the id of this run; the first call stores the run.

        A run has a separate id for each arithmetic that its workers use, by default that of this machine.
        """
        computed = computed or arithmetic()
        if computed not in self._run_ids:
            provenance = json.dumps(self._parameters | {"arithmetic": computed}, sort_keys=True)
            started = datetime.now(UTC).isoformat()  # to the microsecond, to distinguish runs
            values = {"started": started, "version": __version__, "parameters": provenance}
            fresh = sa.insert(run).values(**values).returning(run.c.id)
            self._run_ids[computed] = int(connection.execute(fresh).scalar_one())
        return self._run_ids[computed]

    def stadium_id(self, connection: sa.Connection, a: float) -> int:
        """Return the id of the stadium with a given a, after storing it if it is new."""
        connection.execute(insert(stadium).values(a=a).on_conflict_do_nothing())
        return int(connection.execute(sa.select(stadium.c.id).where(stadium.c.a == a)).scalar_one())


def replace_certificates(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    tried: Sequence[int],
    proved: Sequence[tuple[int, float, int]],
    version: str,
) -> None:
    """Delete the certificates of all classes that were tried, and store those of the proved classes.

    A proof consists of the id of a class, the radius, and the number of bits of the arithmetic.
    """
    keys = [(stadium_id, cycle) for cycle in tried]
    connection.exec_driver_sql("DELETE FROM certificate WHERE stadium = ? AND cycle = ?", keys)
    if proved:
        number = writer.run_id(connection)
        rows = [(stadium_id, cycle, radius, bits, version, number) for cycle, radius, bits in proved]
        connection.exec_driver_sql("INSERT INTO certificate VALUES (?, ?, ?, ?, ?, ?)", rows)


def add_reference(writer: Writer, a: float, found: "Reference") -> None:
    """Store averages over random trajectories."""
    values = asdict(found) | {"seed": str(found.seed)}
    with writer.writing() as connection:
        key = {"stadium": writer.stadium_id(connection, a), "run": writer.run_id(connection)}
        connection.execute(sa.insert(trajectory).values(**key, **values))


def keep_bounds(writer: Writer, found: "EntropyBounds", proof: str, computed: str | None = None) -> bool:
    """Store the bounds from windows of a given length; return whether they were new.

    `proof` is `orbitdb.entropy.bounds.DOUBLES` or `BALLS`; `computed` is as in `Writer.run_id`.
    """
    table = entropy_bound.c
    values = {name: getattr(found, name) for name in ("lower", "upper", "windows", "undecided")}
    here = (table.a == found.a) & (table.proof == proof) & (table.edges == found.window)
    with writer.writing() as connection:
        old = connection.execute(sa.select(*(table[name] for name in values)).where(here)).first()
        if old is not None and tuple(old) == tuple(values.values()):
            return False
        key = {
            "a": found.a,
            "proof": proof,
            "edges": found.window,
            "run": writer.run_id(connection, computed),
        }
        connection.execute(sa.insert(entropy_bound).prefix_with("OR REPLACE").values(**key, **values))
    return True


def keep_levels(writer: Writer, found: "LevelWindow") -> bool:
    """Store the levels of a window, unless it overlaps a stored one; return whether they were stored."""
    of, own = level_fill.c, {"a": found.a, "parity": str(found.parity)}
    stored = (of.a == found.a) & (of.parity == own["parity"]) & (of.low < found.high) & (of.high > found.low)
    with writer.writing() as connection:
        if connection.scalar(sa.select(sa.exists().where(stored))):
            return False
        window = {name: getattr(found, name) for name in ("low", "high", "below", "seconds")}
        run = writer.run_id(connection, found.arithmetic)
        connection.execute(sa.insert(level_fill).values(**own, **window, run=run))
        rows = [
            {**own, "number": found.below + n, "k": k, "error": error}
            for n, (k, error) in enumerate(zip(found.k.tolist(), found.error.tolist(), strict=True), 1)
        ]
        if rows:
            connection.execute(sa.insert(level), rows)
    return True
