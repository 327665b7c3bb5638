"""Read a catalogue for verification, class by class, exactly as it is stored."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.arrays import Integers, Marks
from orbitdb.orbits.batch import NUMBERS, Orbits
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import certificate, change, cycle, fill, orbit, stadium
from orbitdb.store.reading import question
from orbitdb.store.reading.rows import listed, orders_of
from orbitdb.store.reading.soundness import StoredColumns, are_whole, sound_words
from orbitdb.symbols.words import MAX_KEYED, from_strings

Ids = dict[int, Integers]
"""Ids of classes in order, by period."""

_BLOCK = 4096


def sampled_classes(
    connection: sa.Connection, selection: Selection, sample: int | None, rng: np.random.Generator
) -> Ids:
    """Return the ids of the chosen classes, or of a random sample, by period."""
    ids = question.choose(connection, selection).ids
    return by_period(connection, sampled(np.sort(ids[ids > 0]), sample, rng))


def sampled(ids: Integers, sample: int | None, rng: np.random.Generator) -> Integers:
    """Return a random sample of ids in order, or all if there are no more than that."""
    if sample is None or sample >= len(ids):
        return ids
    return np.sort(rng.choice(ids, sample, replace=False))


def ids_in(connection: sa.Connection, column: sa.Column[int], *where: sa.ColumnElement[bool]) -> Integers:
    """Return the distinct ids in a column, in order."""
    found = connection.execute(sa.select(column).where(*where)).yield_per(_BLOCK).scalars()
    return np.unique(np.fromiter(found, np.int64))


def by_period(connection: sa.Connection, ids: Integers, table: sa.Table = cycle) -> Ids:
    """Group ids of classes or pruned words by period, read from the key or from the table.

    An id that is not a key counts as that of a word too long for one.
    """
    orders = orders_of(ids, sound=False)
    long = ids[no_key := (orders > MAX_KEYED) | (orders == 0)]
    if len(long):
        query = sa.select(table.c.id, table.c.p).where(table.c.id.in_(listed(long)))
        known = {number: max(p, MAX_KEYED + 1) for number, p in connection.execute(query)}
        orders[no_key] = [known.get(number, MAX_KEYED + 1) for number in long.tolist()]
    return {p: ids[orders == p] for p in np.unique(orders).tolist()}


def load_rows(connection: sa.Connection, table: sa.Table, ids: Integers) -> list[tuple[Any, ...]]:
    """Return rows of `cycle` or `pruned` by id."""
    query = sa.select(table).where(table.c.id.in_(listed(ids)))
    return list(connection.execute(query).cursor.fetchall())


@dataclass(frozen=True)
class StoredBlock:
    """Rows of `orbit` of one period and stadium.

    Besides the columns of `orbit` there are `word`, the representative, and `radius`, from the certificate if
    there is one.
    """

    columns: StoredColumns

    @property
    def words(self) -> Sequence[str]:
        """The representatives, as stored."""
        return self.columns["word"]

    def some(self, name: str, chosen: Iterable[int]) -> list[Any]:
        """Return one column of some rows."""
        values = self.columns[name]
        return [values[i] for i in chosen]

    def whole(self, p: int) -> Marks:
        """Tell which rows have the values that their status demands."""
        return are_whole(self.columns, p)

    def orbits(self, chosen: Sequence[int]) -> Orbits:
        """Return some rows as arrays, with NaN for NULL; their words and BLOBs must be sound."""
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
    """Return the stored orbits of some classes at one stadium."""
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
    """Return the places of the whole rows that have sound words."""
    sound = sound_words(stored.words, p)
    places: list[int] = sound[whole[sound]].tolist()
    return places


def stadium_id(connection: sa.Connection, a: float) -> int | None:
    """Return the id of a stadium, or None."""
    return connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))


def fill_rows(connection: sa.Connection) -> list[dict[str, Any]]:
    """Return the rows of `fill`, each with its a."""
    query = sa.select(fill, stadium.c.a).join(stadium).order_by(stadium.c.a, fill.c.p)
    return [dict(row) for row in connection.execute(query).mappings()]


def change_rows(connection: sa.Connection, p: int) -> list[sa.Row[Any]]:
    """Return the births and deaths of a period by class and number, each with its class size and word."""
    query = sa.select(change, cycle.c.class_size, cycle.c.word).join_from(change, cycle).where(cycle.c.p == p)
    return list(connection.execute(query.order_by(change.c.cycle, change.c.number)))
