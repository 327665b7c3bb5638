"""Reading the index of a catalogue, a piece of some ten thousand classes at a time.

SQLite joins the texts of a piece into one, which NumPy takes apart: no object a class is made, and the
interpreter is free for other threads.
"""

from collections.abc import Iterator, Mapping

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.orbits.orbit import Status
from orbitdb.store.file.engines import little_kept
from orbitdb.store.file.schema import cycle, orbit, sequence, stadium
from orbitdb.store.reading.class_first import orders
from orbitdb.store.reading.class_index import LONG, STATUSES, Index, Part
from orbitdb.store.reading.joined_texts import digits, one_text, written_keys
from orbitdb.store.reading.period_words import Integers, ListedWords, expand
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import need_words, unsound
from orbitdb.symbols.words import MAX_KEYED, keys_of_period

PIECE = 1 << 15
"""Classes or words that are read at a time."""

_CODES = {status.value: chr(ord("0") + number) for number, status in enumerate(STATUSES)}
_GEOMETRIC = STATUSES.index(Status.GEOMETRIC)


def load_index(reader: Reader, a: float, known: Mapping[int, Part] | None = None) -> Index:
    """Read the classes, and the order of the words, that the catalogue knows at one a.

    Parameters
    ----------
    reader : Reader
    a : float
        The stadium.
    known : mapping of int to Part, optional
        Periods that were read before and are as they were.
    """
    known = known or {}
    with reader.reading() as connection, little_kept(connection):
        here = connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))
        if here is None:
            return Index(a, ())
        periods = [p for p in orders(connection) if p <= MAX_KEYED]
        # the largest period first: while it is sorted it takes more room than when it is done
        parts = {p: known.get(p) or _read_period(connection, here, p) for p in reversed(periods)}
        long_words, long_part = _read_long(connection, here)
    found = [parts[p] for p in periods] + ([long_part] if long_words else [])
    return Index(a, tuple(found), long_words)


def _read_period(connection: sa.Connection, here: int, p: int) -> Part:
    """Read one period: its classes, and its words one by one unless they are all of their classes."""
    pieces = list(_classes(connection, here, p))
    every = sum(int(sizes.sum()) for _, sizes, _ in pieces)
    known = [(numbers[here], sizes[here], found[here]) for numbers, sizes, found in pieces
             for here in [np.flatnonzero(found != len(STATUSES))]]  # fmt: skip
    empty = (np.zeros(0, np.int64), np.zeros(0, np.uint32), np.zeros(0, np.uint8))
    numbers, sizes, statuses = (np.concatenate(column) for column in zip(empty, *known, strict=True))
    del pieces, known
    stored = connection.scalar(sa.select(sa.func.count()).where(sequence.c.p == p))
    if stored != every:
        return _listed(p, numbers, statuses, *_read_words(connection, p))
    words = expand(numbers, p)
    if len(words) != sizes.sum():
        raise unsound("classes of impossible sizes, of period", p)
    return Part(numbers, sizes, statuses, words)


def _classes(
    connection: sa.Connection, here: int, p: int
) -> Iterator[tuple[Integers, NDArray[np.uint32], NDArray[np.uint8]]]:
    """Yield numbers, sizes and statuses of a period's classes; `len(STATUSES)` where there is none here."""
    after, high = keys_of_period(p)
    while True:
        piece = sa.select(cycle.c.word, cycle.c.class_size)
        piece = piece.where(cycle.c.id.between(after + 1, high)).order_by(cycle.c.id).limit(PIECE)
        rows = piece.subquery().c
        words, sizes = connection.execute(sa.select(one_text(rows.word), one_text(rows.class_size))).one()
        if words is None:
            return
        numbers = written_keys(words, len(sizes), p)
        if not (np.diff(numbers, prepend=after) > 0).all():  # the words say the numbers
            raise unsound("impossible numbers or sizes of classes, of period", p)
        after = int(numbers[-1])
        yield numbers, digits(sizes).astype(np.uint32), _statuses(connection, here, numbers, p)


def _statuses(connection: sa.Connection, here: int, numbers: Integers, p: int) -> NDArray[np.uint8]:
    """Return the statuses at one a of classes of a period that come one behind the other."""
    mark = sa.case(*((orbit.c.status == name, code) for name, code in _CODES.items()))
    ends = orbit.c.cycle.between(int(numbers[0]), int(numbers[-1]))
    piece = sa.select(orbit.c.cycle, mark.label("mark")).where(orbit.c.stadium == here, ends)
    rows = piece.order_by(orbit.c.cycle).subquery().c
    marks = connection.scalar(sa.select(one_text(rows.mark))) or ""
    found = np.full(len(numbers), len(STATUSES), dtype=np.uint8)
    if len(marks) == len(numbers):
        return digits(marks)
    solved = np.array(connection.scalars(sa.select(rows.cycle)).all(), dtype=np.int64)
    if len(marks) != len(solved):
        raise unsound("orbits without a status of period", p)
    found[np.isin(numbers, solved)] = digits(marks)[np.isin(solved, numbers)]
    return found


def _read_words(connection: sa.Connection, p: int) -> tuple[Integers, Integers]:
    """Return the keys of all stored words of a period, rising, and the numbers of their classes, or 0."""
    parts = [(np.zeros(0, np.int64), np.zeros(0, np.int64))]
    after = ""
    while True:
        number = sa.func.coalesce(sequence.c.cycle, 0).label("number")
        piece = sa.select(sequence.c.word, number).where(sequence.c.p == p, sequence.c.word > after)
        rows = piece.order_by(sequence.c.word).limit(PIECE).subquery().c
        joined = sa.func.group_concat(rows.number)
        words, numbers, last = connection.execute(
            sa.select(one_text(rows.word), joined, sa.func.max(rows.word))
        ).one()
        if last is None:
            break
        after = last
        found = np.fromstring(numbers, dtype=np.int64, sep=",")
        parts.append((written_keys(words, len(found), p), found))
    listed, of_words = (np.concatenate(column) for column in zip(*parts, strict=True))
    low, high = keys_of_period(p)
    if not (listed[1:] > listed[:-1]).all():
        raise unsound("words that are none, of period", p)
    if ((of_words != 0) & ((of_words < low) | (of_words >= high))).any():
        raise unsound("impossible numbers of classes, of period", p)
    return listed, np.where(of_words == 0, high, of_words)


def _listed(
    p: int, numbers: Integers, statuses: NDArray[np.uint8], listed: Integers, of_words: Integers
) -> Part:
    """Return a part of words that are given one by one: those of a class that is known, or pruned ones."""
    pruned = np.setdiff1d(of_words[_are_pruned(p, of_words)], numbers)
    numbers = np.append(numbers, pruned)
    statuses = np.append(statuses, np.full(len(pruned), _GEOMETRIC, dtype=np.uint8))
    here = np.isin(of_words, numbers)
    places = np.searchsorted(numbers, of_words[here])
    sizes = np.bincount(places, minlength=len(numbers)).astype(np.uint32)
    return Part(numbers, sizes, statuses, ListedWords(p, 0, listed[here], places))


def _are_pruned(p: int, of_words: Integers) -> NDArray[np.bool_]:
    return of_words == keys_of_period(p)[1] if p else of_words > 0


def _read_long(connection: sa.Connection, here: int) -> tuple[tuple[str, ...], Part]:
    """Return the words that are too long for a key, and their classes."""
    number = sa.func.coalesce(sequence.c.cycle, 0)
    listed = sa.select(sequence.c.p, sequence.c.word, number).where(sequence.c.p > MAX_KEYED)
    rows = connection.execute(listed.order_by(sequence.c.p, sequence.c.word)).all()
    need_words([word for _, word, _ in rows], [p for p, _, _ in rows])
    solved = sa.select(orbit.c.cycle, orbit.c.status).where(orbit.c.stadium == here, orbit.c.cycle < 0)
    found = connection.execute(solved.order_by(orbit.c.cycle)).all() if rows else []
    numbers = np.array([number for number, _ in found], dtype=np.int64)
    statuses = np.array([STATUSES.index(Status(status)) for _, status in found], dtype=np.uint8)
    of_words = np.array([number or p for p, _, number in rows], dtype=np.int64)
    here_too = (of_words > 0) | np.isin(of_words, numbers)
    part = _listed(0, numbers, statuses, LONG + np.arange(int(here_too.sum())), of_words[here_too])
    return tuple(row[1] for row, keep in zip(rows, here_too.tolist(), strict=True) if keep), part
