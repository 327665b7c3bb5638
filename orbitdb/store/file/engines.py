"""SQLAlchemy's engines of a database file, for reading or for writing."""

import sqlite3
from collections.abc import Callable
from pathlib import Path

import sqlalchemy as sa
from sqlalchemy import event

from orbitdb.store.file.database import to_read, to_write, waiting


def reading_engine(path: Path) -> sa.Engine:
    """Return an engine that cannot write (`orbitdb.store.file.database.to_read`)."""
    return _engine(to_read(path), "BEGIN")


def writing_engine(path: Path, references: bool = True) -> sa.Engine:
    """Return an engine whose every transaction takes the write lock at once (`to_write`).

    A fill knows that its references are right, they being keys of words, and to look them up, in random
    places, would take a third of its time.
    """
    return _engine(to_write(path, references), "BEGIN IMMEDIATE")


def driver(connection: sa.Connection) -> sqlite3.Connection:
    """Return what SQLAlchemy asks, for questions that are put to it directly."""
    own = connection.connection.driver_connection
    assert isinstance(own, sqlite3.Connection)
    return own


def _engine(connect: Callable[[], sqlite3.Connection], begin: str) -> sa.Engine:
    engine = sa.create_engine("sqlite+pysqlite://", creator=connect, poolclass=sa.pool.QueuePool)

    @event.listens_for(engine, "begin")
    def take_lock(connection: sa.Connection) -> None:
        waiting(lambda: driver(connection).execute(begin))

    return engine
