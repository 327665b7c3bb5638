"""Pages of a chosen subset in any order, without reading the rows that are not shown.

An `Index` holds one integer a symbol sequence of a catalogue, in the order (p, word), and its class.
A subset in some order is then a vector of these integers: conditions and sort keys that belong to a
class are read once a class, a tenth of the words, and the sorting is NumPy's. A page is fetched by the
primary keys of its rows, so it costs the same at the beginning and at the end of a million.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.store.asking.conditions import answering, conditions_of
from orbitdb.store.asking.confinement import Patience, never
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import certificate, cycle, orbit, sequence, stadium
from orbitdb.store.reading.class_first import orders_with_pruned
from orbitdb.store.reading.class_view import class_view, same_for_classes
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import is_written, need_words, unsound
from orbitdb.symbols.words import BITS, MAX_KEYED, from_strings, key, keys_of_period, pack, word_of

Keys = NDArray[np.int64]

_LONG = 1 << 62
_BLOCK = 4096


class CancelledError(Exception):
    """Nobody waits for the result any more."""


@dataclass(frozen=True, eq=False)
class Index(ByValue):
    """The symbol sequences that a catalogue knows at one a.

    Attributes
    ----------
    a : float
        The stadium.
    keys : ndarray of int64, shape (N,)
        One a sequence, rising in the order (p, word).
    cycles : ndarray of int64, shape (N,)
        The number of its class; 0 for a word that is geometrically pruned.
    long_words : tuple of str
        The words of more than `MAX_KEYED` symbols, in their order.
    """

    a: float
    keys: Keys
    cycles: NDArray[np.int64]
    long_words: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.keys)

    def word(self, key: int) -> str:
        """Return the word, as a least rotation, that has a key."""
        if key >= _LONG:
            return self.long_words[key - _LONG]
        return word_of(key)

    def position(self, keys: Keys, word: str) -> int | None:
        """Return where a least rotation stands among some of the keys, or None if it is not there."""
        if len(word) > MAX_KEYED:
            wanted = _LONG + self.long_words.index(word) if word in self.long_words else -1
        else:
            wanted = key(word)
        found = np.flatnonzero(keys == wanted)
        return int(found[0]) if len(found) else None


def load_index(reader: Reader, a: float) -> Index:
    """Read the keys of all sequences that the catalogue knows at one a.

    SQLite joins the words of a period into one text, which NumPy takes apart: no object a word is made,
    and the interpreter is free for other threads.

    Parameters
    ----------
    reader : Reader
    a : float
        The stadium.
    """
    solved = sa.select(orbit.c.cycle).join(stadium).where(stadium.c.a == a)
    number = sa.func.coalesce(sequence.c.cycle, 0)
    words = sa.func.group_concat(sequence.c.word, "")
    packed = sa.select(sequence.c.p, words, sa.func.group_concat(number)).group_by(sequence.c.p)
    listed = sa.select(sequence.c.p, sequence.c.word, number).order_by(sequence.c.p, sequence.c.word)
    with reader.reading() as connection:
        if connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a)) is None:
            return Index(a, np.zeros(0, np.int64), np.zeros(0, np.int64), ())
        known = np.array([0, *connection.scalars(solved)], dtype=np.int64)
        parts = [_parse(*row) for row in connection.execute(packed.where(sequence.c.p <= MAX_KEYED))]
        long_rows = connection.execute(listed.where(sequence.c.p > MAX_KEYED)).all()
    need_words([word for _, word, _ in long_rows], [p for p, _, _ in long_rows])
    long_cycles = np.array([number for *_, number in long_rows], dtype=np.int64)
    parts.append((_LONG + np.arange(len(long_rows)), long_cycles))
    keys, cycles = (np.concatenate(column) for column in zip(*parts, strict=True))
    here = np.isin(cycles, known)
    return Index(a, keys[here], cycles[here], tuple(word for _, word, _ in long_rows))


def _parse(p: int, words: str, cycles: str) -> tuple[Keys, NDArray[np.int64]]:
    """Return the keys of the words of one period, joined, in rising order, and their classes."""
    numbers = np.fromstring(cycles, dtype=np.int64, sep=",")
    if p < 1 or len(words) != p * len(numbers) or not is_written(words, len(words)):
        raise unsound("words that are none, of period", p)
    low, high = keys_of_period(p)
    if ((numbers != 0) & ((numbers < low) | (numbers > high))).any():
        raise unsound("impossible numbers of classes, of period", p)
    symbols = from_strings([words]).reshape(-1, p)
    keys = pack(symbols) + (1 << BITS * p)
    order = np.argsort(keys, kind="stable")
    return keys[order], numbers[order]


def chosen_keys(
    reader: Reader,
    index: Index,
    selection: Selection,
    column: str = "p",
    descending: bool = False,
    cancelled: Callable[[], bool] = never,
) -> Keys:
    """Return the keys of a chosen subset in the order of one column, then of (p, word).

    The order is the same as that of `Catalogue.rows`.

    Parameters
    ----------
    reader : Reader
    index : Index
        Of the same a as the selection.
    selection : Selection
    column : str, optional
        A column of the view ``catalogue``.
    descending : bool, optional
    cancelled : callable, optional
        Asked now and then whether to stop.

    Raises
    ------
    SelectionError
        If ``where`` is refused.
    CancelledError
        If it is told to stop.
    """
    if column not in class_view().c and column not in ("code", "word"):
        return _scanned(reader, index, selection, f"{column} {'desc' if descending else 'asc'}", cancelled)
    rows = _chosen_rows(reader, index, selection, cancelled)
    if cancelled():
        raise CancelledError
    if column == "p" and not descending:
        return index.keys[rows]
    ranks = _word_ranks if column in ("code", "word") else partial(_class_ranks, reader, column)
    sort_by = ranks(index, rows)
    if sort_by is None:
        return _scanned(reader, index, selection, f"{column} {'desc' if descending else 'asc'}", cancelled)
    return index.keys[rows[np.argsort(-sort_by if descending else sort_by, kind="stable")]]


def _chosen_rows(
    reader: Reader, index: Index, selection: Selection, cancelled: Callable[[], bool]
) -> NDArray[np.intp]:
    """Return the places in the index of the sequences of a subset."""
    if selection.contains or not same_for_classes(selection):
        keys = _scanned(reader, index, selection, "p,code", cancelled)
        return np.flatnonzero(np.isin(index.keys, keys, assume_unique=True))
    if replace(selection, a=index.a) == Selection(index.a):
        return np.arange(len(index))
    classes = class_view().c
    chosen = sa.select(classes.cycle).where(*conditions_of(selection, classes))
    with _unless(cancelled), reader.reading() as connection:
        with answering(connection, selection, Patience(cancelled=cancelled)):
            cycles = connection.scalars(chosen).all()
        orders = list(orders_with_pruned(connection, selection))
    mask = np.isin(index.cycles, np.array(cycles, dtype=np.int64))
    return np.flatnonzero(mask | _pruned_of(index, orders))


def _pruned_of(index: Index, orders: Sequence[int]) -> NDArray[np.bool_]:
    """Tell which words are geometrically pruned, and so have no class, and of some orders."""
    pruned = index.cycles == 0
    pruned[pruned] = np.isin([_period(index, key) for key in index.keys[pruned].tolist()], orders)
    return pruned


def _period(index: Index, key: int) -> int:
    return (key.bit_length() - 1) // BITS if key < _LONG else len(index.word(key))


def _class_ranks(
    reader: Reader, column: str, index: Index, rows: NDArray[np.intp]
) -> NDArray[np.float64] | None:
    """Return a number a word that sorts as a column of its class does; None if there is no such number.

    NaN, which NumPy sorts last either way, stands for no value and for words without a class.
    """
    if column in ("p", "status") and (index.cycles == 0).any():
        return None
    classes = class_view().c
    query = sa.select(classes.cycle, classes[column]).where(classes.a == index.a)
    with reader.reading() as connection:
        pairs = connection.execute(query).all()
    values: list[Any] = [value for _, value in pairs]
    if any(isinstance(value, str) for value in values):
        order = {value: rank for rank, value in enumerate(sorted({value for value in values if value}))}
        values = [order.get(value) for value in values]
    numbers = np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    known = np.array([0, *(number for number, _ in pairs)], dtype=np.int64)  # 0: without a class
    rising = np.argsort(known)
    places = np.searchsorted(known, index.cycles[rows], sorter=rising)
    if (places == len(known)).any() or (known[rising[places]] != index.cycles[rows]).any():
        raise unsound("words without their classes, sorted by", column)
    ranks: NDArray[np.float64] = np.append(np.nan, numbers)[rising[places]]
    return ranks


def _word_ranks(index: Index, rows: NDArray[np.intp]) -> NDArray[np.int64] | None:
    """Return a number a word that sorts as its text does; None if some are too long."""
    if index.long_words:
        return None
    keys = index.keys[rows]
    ranks = np.empty_like(keys)
    bounds = np.int64(1) << (BITS * np.arange(MAX_KEYED + 2, dtype=np.int64))
    periods = np.searchsorted(bounds, keys, side="right") - 1
    ranks[:] = (keys - bounds[periods]) << (BITS * (MAX_KEYED - periods))
    return ranks


def _scanned(
    reader: Reader, index: Index, selection: Selection, order: str, cancelled: Callable[[], bool]
) -> Keys:
    """Return the keys of a subset in any order, by a pass over the view."""
    numbers = {word: _LONG + place for place, word in enumerate(index.long_words)}
    found: list[int] = []
    with _unless(cancelled):
        for count, (word,) in enumerate(reader.rows(selection, ("code",), order, cancelled=cancelled)):
            if count % _BLOCK == 0 and cancelled():
                raise CancelledError
            number = key(word) if len(word) <= MAX_KEYED else numbers.get(word)
            if number is not None:
                found.append(number)
    return np.array(found, dtype=np.int64)


@contextmanager
def _unless(cancelled: Callable[[], bool]) -> Iterator[None]:
    """Tell a query that nobody waits for from one that is refused."""
    try:
        yield
    except SelectionError:
        if cancelled():
            raise CancelledError from None
        raise


def fetch(reader: Reader, index: Index, keys: Keys, columns: Sequence[str]) -> list[tuple[Any, ...] | None]:
    """Return the rows that have some keys, in their order; None for a row that is no longer there."""
    words = [index.word(key) for key in keys.tolist()]
    found: dict[str, tuple[Any, ...]] = {}
    wanted = [view.c.code, *(view.c[name] for name in columns)]
    with reader.reading() as connection:
        for p, group in groupby(sorted(words, key=len), key=len):
            here = (view.c.a == index.a, view.c.p == p, view.c.word.in_(list(group)))
            rows = connection.execute(sa.select(*wanted).where(*here))
            found |= {code: tuple(values) for code, *values in rows}
    return [found.get(word) for word in words]


def certificate_of(reader: Reader, representative: str, a: float) -> tuple[float, int] | None:
    """Return the radius and the bits of the proof of a class's orbit, or None if there is none."""
    joined = certificate.join(cycle, cycle.c.id == certificate.c.cycle)
    joined = joined.join(stadium, stadium.c.id == certificate.c.stadium)
    query = sa.select(certificate.c.radius, certificate.c.bits).select_from(joined)
    here = (cycle.c.p == len(representative), cycle.c.word == representative, stadium.c.a == a)
    with reader.reading() as connection:
        row = connection.execute(query.where(*here)).first()
    return None if row is None else (row.radius, row.bits)
