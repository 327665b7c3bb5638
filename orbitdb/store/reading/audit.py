"""Reading a catalogue in order to check it as a whole: file, schema, references and counts."""

import json
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.file.engines import reading_engine
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.schema import certificate, change, cycle, fill, metadata, orbit, sequence, stadium

Row = dict[str, Any]


def file_errors(connection: sa.Connection) -> list[str]:
    """Return what SQLite finds wrong with the file, its indexes and the types of its values."""
    found = connection.exec_driver_sql("PRAGMA integrity_check").scalars().all()
    return [] if found == ["ok"] else [str(message) for message in found]


def dangling(connection: sa.Connection) -> list[str]:
    """Return the references that lead nowhere, as "table -> table"."""
    found = connection.exec_driver_sql("PRAGMA foreign_key_check").all()
    return [f"{child} -> {parent}" for child, _, parent, _ in found]


def row_count(connection: sa.Connection) -> int:
    """Return the number of rows of all tables."""
    return sum(
        connection.scalar(sa.select(sa.func.count()).select_from(t)) or 0 for t in metadata.sorted_tables
    )


def schema_differences(connection: sa.Connection) -> tuple[int, list[str]]:
    """Compare tables and view, with their columns, keys and references, with those of a new catalogue.

    What somebody has added beside them is no difference.

    Returns
    -------
    tuple of int and list of str
        How many there are, and the names of those that differ.
    """
    expected = _new_schema()
    return len(expected), [name for name, parts in expected.items() if _parts(connection, name) != parts]


@cache
def _new_schema() -> dict[str, Any]:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "new.db"
        migrate(path)
        engine = reading_engine(path)
        with engine.begin() as fresh:
            names = fresh.exec_driver_sql(
                "SELECT name FROM sqlite_master WHERE type IN ('table', 'view') ORDER BY name"
            ).scalars()
            schema = {name: _parts(fresh, name) for name in names}
        engine.dispose()
    return schema


def _parts(connection: sa.Connection, name: str) -> list[list[tuple[Any, ...]]]:
    """Return the columns of a table or view, its references, and the indexes that its keys have made."""
    columns, references, indexes = (
        sorted(map(tuple, connection.exec_driver_sql(f'PRAGMA {pragma}("{name}")')), key=repr)
        for pragma in ("table_xinfo", "foreign_key_list", "index_list")
    )
    return [columns, references, [index[1:] for index in indexes if index[3] != "c"]]


def stadium_id(connection: sa.Connection, a: float) -> int | None:
    """Return the number of a stadium, None if it is not known."""
    return connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))


def fills(connection: sa.Connection) -> list[Row]:
    """Return the rows of `fill`, each with its a."""
    query = sa.select(fill, stadium.c.a).join(stadium).order_by(stadium.c.a, fill.c.p)
    return [dict(row) for row in connection.execute(query).mappings()]


def word_counts(connection: sa.Connection) -> dict[int, tuple[int, int, int]]:
    """Return by period the numbers of admissible sequences, of classes, and of words that they claim."""
    words = sa.select(sequence.c.p, sa.func.count(sequence.c.cycle)).group_by(sequence.c.p)
    classes = sa.select(cycle.c.p, sa.func.count(), sa.func.sum(cycle.c.class_size)).group_by(cycle.c.p)
    found = {p: (count, 0, 0) for p, count in connection.execute(words)}
    for p, count, claimed in connection.execute(classes):
        found[p] = (found.get(p, (0, 0, 0))[0], count, claimed)
    return found


def words_without_fill(connection: sa.Connection, p: int) -> int:
    """Return how many words the classes of a period claim that have any of them stored."""
    here = sa.select(sequence.c.cycle).where(sequence.c.p == p, sequence.c.cycle.is_not(None))
    claimed = sa.select(sa.func.sum(cycle.c.class_size)).where(cycle.c.p == p, cycle.c.id.in_(here))
    return connection.scalar(claimed) or 0


def changes(connection: sa.Connection, p: int) -> list[sa.Row[Any]]:
    """Return the changes of all classes of a period, by class and number, each with its class size."""
    query = sa.select(change, cycle.c.class_size, cycle.c.word).join_from(change, cycle).where(cycle.c.p == p)
    return list(connection.execute(query.order_by(change.c.cycle, change.c.number)))


def status_counts(connection: sa.Connection, stadium: int) -> dict[int, dict[str, tuple[int, int]]]:
    """Return by period and status the numbers of words and of classes at one stadium."""
    query = (
        sa.select(cycle.c.p, orbit.c.status, sa.func.sum(cycle.c.class_size), sa.func.count())
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .where(orbit.c.stadium == stadium)
        .group_by(cycle.c.p, orbit.c.status)
    )
    found: dict[int, dict[str, tuple[int, int]]] = {}
    for p, status, words, classes in connection.execute(query):
        found.setdefault(p, {})[status] = (words, classes)
    return found


def runs(connection: sa.Connection) -> dict[int, tuple[str, str | None]]:
    """Return the version of each run, and the arithmetic that it names."""
    found = {}
    for number, version, parameters in connection.exec_driver_sql("SELECT id, version, parameters FROM run"):
        try:
            named = json.loads(parameters).get("arithmetic")
        except (ValueError, AttributeError):
            named = None
        found[number] = (version, named)
    return found


def certified(connection: sa.Connection, stadium_id: int) -> NDArray[np.int64]:
    """Return the numbers of the classes that are certified at one stadium, in order."""
    query = sa.select(certificate.c.cycle).where(certificate.c.stadium == stadium_id)
    return np.array(connection.scalars(query.order_by(certificate.c.cycle)).all(), dtype=np.int64)
