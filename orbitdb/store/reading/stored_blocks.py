"""Reading chosen classes block by block: their words and orbits as they are stored, right or wrong."""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.orbits.orbit import NUMBERS, Orbits
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import certificate, cycle, orbit, sequence, stadium
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import Columns, Marks, Row, are_whole, sound_words
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.words import from_strings, to_strings, unpack

Ids = dict[int, NDArray[np.int64]]
"""The numbers of classes, by period."""

SYMBOLS_A_BLOCK = 1 << 17

_BLOCK = 4096


def choose(reader: Reader, selection: Selection, sample: int | None, rng: np.random.Generator) -> Ids:
    """Return by period the numbers of the chosen classes, or of a random sample of them."""
    if replace(selection, periods=()) == Selection(a=selection.a):
        with reader.reading() as connection:
            ids = _class_ids(connection, selection.a)
        ids = {p: those for p, those in ids.items() if selection.includes(p)}
    else:
        rows = reader.rows(selection, ("p", "cycle"))
        ids = by_period([row for row in rows if row[1] is not None])
    if sample is None or sample >= (total := sum(map(len, ids.values()))):
        return ids
    pairs = np.concatenate([np.stack([np.full(len(those), p), those], axis=1) for p, those in ids.items()])
    return by_period(pairs[rng.choice(total, sample, replace=False)].tolist())


def blocks(ids: Ids, size: int = _BLOCK) -> Iterator[tuple[int, NDArray[np.int64], int]]:
    """Cut the numbers of classes into blocks; give period, block and how many classes came before."""
    before = 0
    for p, those in ids.items():
        step = max(1, min(size, SYMBOLS_A_BLOCK // p))
        for start in range(0, len(those), step):
            block = those[start : start + step]
            yield p, block, before
            before += len(block)


def _class_ids(connection: sa.Connection, a: float) -> Ids:
    """Return the classes that have a row at one a."""
    query = (
        sa.select(sa.func.group_concat(cycle.c.p), sa.func.group_concat(cycle.c.id))
        .join(orbit, orbit.c.cycle == cycle.c.id)
        .join(stadium, stadium.c.id == orbit.c.stadium)
        .where(stadium.c.a == a)
    )
    periods, numbers = map(_integers, connection.execute(query).one())
    return {int(p): np.unique(numbers[periods == p]) for p in np.unique(periods)}


def _integers(text: str | None) -> NDArray[np.int64]:
    """Return the integers of a column that SQLite has joined: tuples cost ten times the time and room."""
    return np.fromstring(text, dtype=np.int64, sep=",") if text else np.zeros(0, np.int64)


def by_period(pairs: Sequence[Any]) -> dict[int, NDArray[np.int64]]:
    """Return pairs of period and number as the sorted numbers of each period."""
    table = np.array([tuple(pair) for pair in pairs], dtype=np.int64).reshape(-1, 2)
    return {int(p): np.unique(table[table[:, 0] == p, 1]) for p in np.unique(table[:, 0])}


def load_classes(connection: sa.Connection, ids: NDArray[np.int64]) -> Sequence[Row]:
    """Return some rows of `cycle`."""
    query = sa.select(cycle).where(cycle.c.id.in_(_listed(ids))).order_by(cycle.c.id)
    return _dicts(connection, query)


def _dicts(connection: sa.Connection, query: sa.Select[Any]) -> list[dict[str, Any]]:
    """Return rows by the names of their columns, as SQLite's own driver gives them: these are many."""
    names = [column.name for column in query.selected_columns]
    return [dict(zip(names, row, strict=True)) for row in connection.execute(query).cursor.fetchall()]


def load_class_rows(connection: sa.Connection, ids: NDArray[np.int64]) -> list[tuple[Any, ...]]:
    """Return all rows of `cycle` from one class to another, as tuples, in the order of their numbers."""
    if not len(ids):
        return []
    query = sa.select(cycle).where(cycle.c.id.between(int(ids[0]), int(ids[-1]))).order_by(cycle.c.id)
    return list(connection.execute(query).cursor.fetchall())


class StoredSpan(NamedTuple):
    """The words of a span that are stored, but for those that are kept as pruned.

    Attributes
    ----------
    total : int
        How many there are.
    longest : int
        The number of symbols of the longest.
    words : str
        One behind the other, in the order of the table's key, in which SQLite reads them.
    cycles : ndarray of int64
        The numbers of their classes; without those that have none.
    elements : str
        The numbers of the elements, one behind the other, and a mark where there is none: else a number of
        two digits could stand in for it.
    """

    total: int
    longest: int
    words: str
    cycles: NDArray[np.int64]
    elements: str


def load_span(connection: sa.Connection, span: Span) -> StoredSpan:
    """Return the stored words of a span, joined by SQLite: rows would take several times as long."""
    after, upto = (to_strings(unpack(np.array([end]), span.p))[0] for end in (max(span.after, 0), span.upto))
    each = sequence.c
    joined = sa.select(
        sa.func.count(),
        sa.func.max(sa.func.length(each.word)),
        sa.func.group_concat(each.word, ""),
        sa.func.group_concat(each.cycle),
        sa.func.group_concat(sa.func.coalesce(each.element, "?"), ""),
    )
    here = (each.p == span.p, each.word > (after if span.after >= 0 else ""), each.word <= upto)
    total, longest, words, cycles, elements = connection.execute(
        joined.where(*here, each.rules.is_(None))
    ).one()
    return StoredSpan(total, longest or 0, words or "", _integers(cycles), elements or "")


def load_sequences(connection: sa.Connection, p: int, words: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """Return those of some words that are stored, each with class, element and rules."""
    query = sa.select(sequence.c.word, sequence.c.cycle, sequence.c.element, sequence.c.rules)
    chosen = query.where(sequence.c.p == p, sequence.c.word.in_(_listed(words)))
    return {
        word: (number, element, rules)
        for word, number, element, rules in connection.execute(chosen).cursor.fetchall()
    }


def _listed(values: Any) -> sa.Select[Any]:
    """Return many values as a subquery, in one parameter."""
    array = json.dumps(values.tolist() if isinstance(values, np.ndarray) else list(values))
    return sa.select(sa.column("value")).select_from(sa.func.json_each(array))


@dataclass(frozen=True)
class StoredBlock:
    """Rows of `orbit` of one period and stadium, with their words.

    Attributes
    ----------
    columns : dict of str to sequences
        The columns of `orbit`; `word`, the classes' least words; and `radius` of the certificate if there
        is one.
    """

    columns: Columns

    @property
    def words(self) -> Sequence[str]:
        """The classes' least words, as stored."""
        return self.columns["word"]

    def some(self, name: str, chosen: Iterable[int]) -> list[Any]:
        """Return the values of some rows in one column."""
        values = self.columns[name]
        return [values[i] for i in chosen]

    def whole(self, p: int) -> Marks:
        """Tell of each row whether it has what its status demands."""
        return are_whole(self.columns, p)

    def orbits(self, chosen: Sequence[int]) -> Orbits:
        """Return some of the rows as arrays, NaN for NULL; their words and BLOBs must be sound."""
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


def load_orbits(connection: sa.Connection, stadium: int, ids: NDArray[np.int64]) -> StoredBlock:
    """Return what is stored of some classes at one stadium."""
    proof = (certificate.c.stadium == orbit.c.stadium) & (certificate.c.cycle == orbit.c.cycle)
    query = (
        sa.select(cycle.c.word, certificate.c.radius, orbit)
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .outerjoin(certificate, proof)
        .where(orbit.c.stadium == stadium, orbit.c.cycle.in_(_listed(ids)))
        .order_by(orbit.c.cycle)
    )
    names = [column.name for column in query.selected_columns]
    rows = connection.execute(query).cursor.fetchall()
    return StoredBlock(dict(zip(names, zip(*rows, strict=True) if rows else [()] * len(names), strict=True)))


def whole_rows(stored: StoredBlock, p: int, whole: Marks) -> list[int]:
    """Return the places of rows of sound words that are whole (`StoredBlock.whole`)."""
    sound = sound_words(stored.words, p)
    places: list[int] = sound[whole[sound]].tolist()
    return places
