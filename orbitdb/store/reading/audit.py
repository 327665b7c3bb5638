"""Read a catalogue for verification, by class and exactly as it is stored."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.arrays import Integers, Marks
from orbitdb.orbits.status import NUMBERS, Orbits
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import certificate, change, cycle, fill, orbit, stadium
from orbitdb.store.reading import question
from orbitdb.store.reading.rows import listed, orders_of
from orbitdb.store.reading.soundness import StoredColumns, are_whole, sound_words
from orbitdb.symbols.words import MAX_KEYED, from_strings

Ids = dict[int, Integers]
"""Ids of classes, in order, for each period."""

_BLOCK = 4096


def sampled_classes(
    connection: sa.Connection, selection: Selection, sample: int | None, rng: np.random.Generator
) -> Ids:
    """Return the ids of the chosen classes, or of a random sample of them, by period."""
    ids = question.choose(connection, selection).ids
    return by_period(connection, sampled(np.sort(ids[ids > 0]), sample, rng))


def sampled(ids: Integers, sample: int | None, rng: np.random.Generator) -> Integers:
    """Return a random sample of ids, in order, or all ids if there are no more than `sample`."""
    if sample is None or sample >= len(ids):
        return ids
    return np.sort(rng.choice(ids, sample, replace=False))


def ids_in(connection: sa.Connection, column: sa.Column[int], *where: sa.ColumnElement[bool]) -> Integers:
    """Return the distinct ids in a column, in order."""
    found = connection.execute(sa.select(column).where(*where)).yield_per(_BLOCK).scalars()
    return np.unique(np.fromiter(found, np.int64))


def by_period(connection: sa.Connection, ids: Integers, table: sa.Table = cycle) -> Ids:
    """Group the ids of classes or pruned words by period, which follows from the key or is in the table.

    An id that is not a key is taken for that of a word too long for a key.
    """
    orders = orders_of(ids, sound=False)
    long = ids[no_key := (orders > MAX_KEYED) | (orders == 0)]
    if len(long):
        query = sa.select(table.c.id, table.c.p).where(table.c.id.in_(listed(long)))
        known = {number: max(p, MAX_KEYED + 1) for number, p in connection.execute(query)}
        orders[no_key] = [known.get(number, MAX_KEYED + 1) for number in long.tolist()]
    return {p: ids[orders == p] for p in np.unique(orders).tolist()}


def load_rows(connection: sa.Connection, table: sa.Table, ids: Integers) -> list[tuple[Any, ...]]:
    """Return the rows of `cycle` or `pruned` with the given ids."""
    query = sa.select(table).where(table.c.id.in_(listed(ids)))
    return list(connection.execute(query).cursor.fetchall())


@dataclass(frozen=True)
class StoredBlock:
    """Rows of `orbit` with the same period and stadium, as columns.

    Besides the columns of `orbit`, there are `word`, the representative, and `radius`, from the certificate
    (None if there is no certificate).
    """

    columns: StoredColumns

    @property
    def words(self) -> Sequence[str]:
        """The representatives, as stored."""
        return self.columns["word"]

    def some(self, name: str, chosen: Iterable[int]) -> list[Any]:
        """Return a column for some of the rows, given by their indices."""
        values = self.columns[name]
        return [values[i] for i in chosen]

    def whole(self, p: int) -> Marks:
        """Tell which rows have the values that their statuses require."""
        return are_whole(self.columns, p)

    def orbits(self, chosen: Sequence[int]) -> Orbits:
        """Return some of the rows as arrays, with NaN for NULL; their words and BLOBs must be sound."""
        words = from_strings(self.some("word", chosen))
        blank = np.full(words.shape[1], np.nan, dtype="<f8").tobytes()
        places = b"".join(blob or blank for blob in self.some("coordinates", chosen))
        return Orbits(
            words=words,
            status=np.array(self.some("status", chosen), dtype=str),
            coordinates=np.frombuffer(places, dtype="<f8").astype(float).reshape(words.shape),
            iterations=np.array(self.some("iterations", chosen), dtype=np.int64),
            **{name: np.array(self.some(name, chosen), dtype=float) for name in NUMBERS},
        )


def load_orbits(connection: sa.Connection, stadium: int, ids: Integers) -> StoredBlock:
    """Return the stored orbits of the classes with the given ids, at a stadium."""
    proof = (certificate.c.stadium == orbit.c.stadium) & (certificate.c.cycle == orbit.c.cycle)
    query = (
        sa.select(cycle.c.word, certificate.c.radius, orbit)
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .outerjoin(certificate, proof)
        .where(orbit.c.stadium == stadium, orbit.c.cycle.in_(listed(ids)))
        .order_by(orbit.c.cycle)
    )
    names = [column.name for column in query.selected_columns]
    rows = connection.execute(query).cursor.fetchall()
    return StoredBlock(dict(zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True)))


def whole_rows(stored: StoredBlock, p: int, whole: Marks) -> list[int]:
    """Return the indices of the rows that are whole and have sound words."""
    sound = sound_words(stored.words, p)
    places: list[int] = sound[whole[sound]].tolist()
    return places


def stadium_id(connection: sa.Connection, a: float) -> int | None:
    """Return the id of the stadium with a given a, or None."""
    return connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))


def fill_rows(connection: sa.Connection) -> list[dict[str, Any]]:
    """Return the rows of `fill`, each with its value of a."""
    query = sa.select(fill, stadium.c.a).join(stadium).order_by(stadium.c.a, fill.c.p)
    return [dict(row) for row in connection.execute(query).mappings()]


def change_rows(connection: sa.Connection, p: int) -> list[sa.Row[Any]]:
    """Return the births and deaths of a period, sorted by class and number, with class sizes and words."""
    query = sa.select(change, cycle.c.class_size, cycle.c.word).join_from(change, cycle).where(cycle.c.p == p)
    return list(connection.execute(query.order_by(change.c.cycle, change.c.number)))
