"""Reading a catalogue in order to check it as a whole: file, references and counts."""

from typing import Any

import sqlalchemy as sa

from orbitdb.store.file.schema import DONE
from orbitdb.store.file.tables import birth_fill, change, cycle, element, fill, metadata, orbit, stadium
from orbitdb.symbols.words import key, keys_of_period

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


def elements(connection: sa.Connection) -> set[tuple[str, int, int]]:
    """Return the rows of `element`."""
    return {(symmetry, n, g) for symmetry, n, g in connection.execute(sa.select(element))}


def stadium_id(connection: sa.Connection, a: float) -> int | None:
    """Return the number of a stadium, None if it is not known."""
    return connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))


def fills(connection: sa.Connection) -> list[Row]:
    """Return the rows of `fill`, each with its a."""
    query = sa.select(fill, stadium.c.a).join(stadium).order_by(stadium.c.a, fill.c.p)
    return [dict(row) for row in connection.execute(query).mappings()]


def partial_births(connection: sa.Connection) -> list[Row]:
    """Return the rows of `birth_fill` that are not complete."""
    query = sa.select(birth_fill).where(birth_fill.c.state != DONE).order_by(birth_fill.c.p)
    return [dict(row) for row in connection.execute(query).mappings()]


def word_counts(connection: sa.Connection) -> dict[int, tuple[int, int]]:
    """Return by period the numbers of classes, and of words that they say they have."""
    query = sa.select(cycle.c.p, sa.func.count(), sa.func.sum(cycle.c.class_size)).group_by(cycle.c.p)
    return {p: (classes, words) for p, classes, words in connection.execute(query)}


def words_up_to(connection: sa.Connection, stadium: int | None, p: int, last: str) -> int:
    """Return how many words the classes of a period have whose least words are not behind some text.

    They are those with a row at one stadium; without any, those with births.
    """
    size = sa.select(sa.func.sum(cycle.c.class_size))
    if stadium is None:
        rows = size.join_from(change, cycle).where(change.c.number == 1)
    else:
        rows = size.join_from(orbit, cycle).where(orbit.c.stadium == stadium)
    return connection.scalar(rows.where(cycle.c.id.between(keys_of_period(p)[0], key(last)))) or 0


def changes(connection: sa.Connection, p: int) -> list[sa.Row[Any]]:
    """Return the changes of all classes of a period, by class and number, each with its class size."""
    query = sa.select(change, cycle.c.class_size, cycle.c.word).join_from(change, cycle).where(cycle.c.p == p)
    return list(connection.execute(query.order_by(change.c.cycle, change.c.number)))


def periods_without_births(connection: sa.Connection) -> list[int]:
    """Return the periods that have changes, but no row that says how far these are stored."""
    known = sa.select(birth_fill.c.p)
    query = sa.select(cycle.c.p).join_from(change, cycle).where(cycle.c.p.not_in(known)).distinct()
    return list(connection.scalars(query.order_by(cycle.c.p)))


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
