"""What SQLAlchemy knows of a database file: its tables and views, and engines for reading or writing."""

import sqlite3
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import event

from orbitdb.columns import IN_CATALOGUE, kind_of
from orbitdb.store.file.database import to_read, to_write, waiting
from orbitdb.store.file.schema import LIFE, OF_CLASS, SHARED, TABLES

_KINDS: dict[str, type[sa.types.TypeEngine[Any]]] = {
    "text": sa.Text, "integers": sa.Text, "integer": sa.Integer, "number": sa.REAL, "numbers": sa.LargeBinary,
}  # fmt: skip

metadata = sa.MetaData()


with sa.create_engine("sqlite://").begin() as _empty:  # SQLite, which has made them, says what they are
    for _statement in TABLES.values():
        _empty.exec_driver_sql(_statement)
    metadata.reflect(_empty)


def view(name: str, columns: Iterable[str]) -> sa.TableClause:
    """Return a view with some columns."""
    return sa.table(name, *(sa.column(each, _KINDS[kind_of(each)]) for each in columns))


(
    stadium, run, cycle, element, pruned, orbit, fill, certificate, change, birth_fill, trajectory,
    entropy_bound, level_fill, level, sweep, sweep_block,
) = map(metadata.tables.__getitem__, TABLES)  # fmt: skip

classes = view("class", SHARED | OF_CLASS)
"""The view of the classes: one row a class and a."""

catalogue = view("catalogue", [each.name for each in IN_CATALOGUE])
"""The view of the words: one row a word and a."""

ENDS = ("born", "dies")
"""The first birth and the first death of a word, as the views have them.

No `born` for a word that is an orbit from a = 0 on, as for one of which no births are stored."""

life = view("life", LIFE)
"""The view of the lives of classes."""


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
