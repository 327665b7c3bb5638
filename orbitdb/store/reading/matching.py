"""Find words in classes and among the rows of a subset, by pattern, code, period or first symbols.

Words are compared in packed form, which follows from the ids of the classes without reading the file.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa

from orbitdb.arrays import Integers, Marks, Masks
from orbitdb.store.asking.limits import CancelledError, never
from orbitdb.store.file.ids import LONG
from orbitdb.store.file.tables import cycle, pruned
from orbitdb.store.reading.rows import ALL, Chosen, listed, orders_of
from orbitdb.store.reading.soundness import need_words, stabiliser_of
from orbitdb.symbols.patterns import Like, Pattern
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.symmetry import (
    ELEMENT_OF,
    all_images,
    class_of,
    classify,
    members,
    packed_images,
    places_of_elements,
)
from orbitdb.symbols.words import MAX_KEYED, key, packed

if TYPE_CHECKING:
    from orbitdb.store.reading.lives import Standings


BATCH = 1 << 14
"""Number of classes handled at a time; they fit into the processor's cache."""


def fitting(
    connection: sa.Connection,
    ids: Integers,
    patterns: Sequence[Pattern],
    cancelled: Callable[[], bool] = never,
) -> Masks:
    """Return a mask per class, in which bit g is set if the image under element g matches all patterns.

    The ids, shape (C,), are those of classes or of pruned words, for which only bit 0 matters. Only words too
    long for a key are read from the file.
    """
    found = np.zeros(len(ids), dtype=np.uint8)
    orders = orders_of(ids)
    for p in np.unique(orders).tolist():
        here = np.flatnonzero(orders == p)
        if p > MAX_KEYED:
            found[here] = _of_long(connection, ids[here], patterns)
            continue
        for start in range(0, len(here), BATCH):
            if cancelled():
                raise CancelledError
            batch = here[start : start + BATCH]
            found[batch] = _of_short(np.abs(ids[batch]), p, patterns)
    return found


def _of_short(keys: Integers, p: int, patterns: Sequence[Pattern]) -> Masks:
    codes = packed(keys, p)
    as_written = any(not pattern.cyclic for pattern in patterns)
    images = all_images(codes, p) if as_written else packed_images(codes, p)
    found = np.zeros(len(keys), dtype=np.uint8)
    for g, image in enumerate(images):
        fits = np.logical_and.reduce([pattern.fitting(image, p) for pattern in patterns])
        found |= fits.astype(np.uint8) << np.uint8(g)
    return found


def _of_long(connection: sa.Connection, ids: Integers, patterns: Sequence[Pattern]) -> Masks:
    found = np.zeros(len(ids), dtype=np.uint8)
    for row, number in enumerate(ids.tolist()):
        words, stabiliser = long_words(connection, number)
        for word, g in zip(words, ELEMENT_OF[stabiliser].tolist(), strict=False):
            found[row] |= all(pattern.fits(word) for pattern in patterns) << g
    return found


def long_words(connection: sa.Connection, number: int) -> tuple[list[str], int]:
    """Return the words and the stabiliser of a class (or pruned word) whose id is not a key."""
    if number < 0:
        query = sa.select(pruned.c.p, pruned.c.word, sa.literal("1")).where(pruned.c.id == number)
    else:
        query = sa.select(cycle.c.p, cycle.c.words, cycle.c.symmetry).where(cycle.c.id == number)
    p, text, symmetry = connection.execute(query).one()
    words = [text[start : start + p] for start in range(0, len(text), p)]
    need_words(words, [p] * len(words))
    return words, stabiliser_of(symmetry)


def stabilisers_of_classes(connection: sa.Connection, ids: Integers, full: Marks) -> Masks:
    """Return the stabilisers of classes; classes marked `full` have eight words, and so the trivial group."""
    found = np.ones(len(ids), dtype=np.uint8)
    small = np.flatnonzero(~full & (ids > 0))
    orders = orders_of(ids[small])
    for p in np.unique(orders).tolist():
        here = small[orders == p]
        if p <= MAX_KEYED:
            found[here] = classify(packed(ids[here], p), p).stabiliser
            continue
        query = sa.select(cycle.c.id, cycle.c.symmetry).where(cycle.c.id.in_(listed(ids[here])))
        known = {number: stabiliser_of(symmetry) for number, symmetry in connection.execute(query)}
        found[here] = [known[number] for number in ids[here].tolist()]
    return found


def position_of(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    """Return the row number of a code in the subset, or None if it is not there."""
    if len(word) > MAX_KEYED:
        return _position_of_long(connection, chosen, word) if (np.abs(chosen.ids) >= LONG).any() else None
    if rules_of(word):
        return chosen.position(-key(word), 0)
    least = class_of(word).representative
    return chosen.position(key(least), list(members(least)).index(word))


def _position_of_long(connection: sa.Connection, chosen: Chosen, word: str) -> int | None:
    p = len(word)
    known = sa.select(cycle.c.id, cycle.c.words).where(cycle.c.id >= LONG, cycle.c.p == p)
    queries = (
        known.where(sa.func.instr(cycle.c.words, word) > 0),
        sa.select(pruned.c.id, pruned.c.word).where(pruned.c.p == p, pruned.c.word == word),
    )
    for number, words in (row for query in queries for row in connection.execute(query)):
        for place in range(len(words) // p):
            if words.startswith(word, place * p):
                return chosen.position(number, place)
    return None


def periods_of(connection: sa.Connection, ids: Integers) -> Integers:
    """Return the periods of classes and pruned words, shape (C,)."""
    found = orders_of(ids)
    if (found > MAX_KEYED).any():
        rows = connection.execute(
            sa.select(cycle.c.id, cycle.c.p)
            .where(cycle.c.id >= LONG)
            .union_all(sa.select(pruned.c.id, pruned.c.p).where(pruned.c.id <= -LONG))
        )
        known = {row.id: row.p for row in rows}
        for place in np.flatnonzero(found > MAX_KEYED).tolist():
            found[place] = known[int(ids[place])]
    return found


def periods_without(connection: sa.Connection, ids: Integers, standings: "Standings") -> list[int]:
    """Return the distinct periods of the classes for which no births are stored."""
    return np.unique(periods_of(connection, ids[standings.places == len(standings.cycles)])).tolist()


def first_of_period(connection: sa.Connection, chosen: Chosen, p: int) -> int | None:
    """Return the number of the first row with a given period, or None."""
    here = periods_of(connection, chosen.ids) == p
    return chosen.first(np.where(here, 0xFF, 0).astype(np.uint8))


def first_beginning(
    connection: sa.Connection, chosen: Chosen, code: str, cancelled: Callable[[], bool] = never
) -> int | None:
    """Return the number of the first row whose code begins with the given symbols, or None."""
    elements = fitting(connection, chosen.ids, (Like(f"{code}%", True),), cancelled)
    stabilisers = stabilisers_of_classes(connection, chosen.ids, chosen.masks == ALL)
    return chosen.first(places_of_elements(elements, stabilisers))
