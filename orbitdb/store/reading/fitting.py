"""Decide which words of classes fit patterns, from the packed words in the ids of the classes."""

from collections.abc import Callable, Sequence

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Integers
from orbitdb.store.asking.confinement import CancelledError, never
from orbitdb.store.file.tables import cycle, pruned
from orbitdb.store.reading.chosen import Masks, listed, orders_of
from orbitdb.store.reading.soundness import need_words, unsound
from orbitdb.symbols.members import ELEMENT_OF, STABILISER_OF
from orbitdb.symbols.patterns import Pattern
from orbitdb.symbols.symmetry import all_images, classify, packed_images
from orbitdb.symbols.words import MAX_KEYED, packed

BATCH = 1 << 14
"""Classes at a time; they fit into the processor's cache."""


def fitting(
    connection: sa.Connection,
    ids: Integers,
    patterns: Sequence[Pattern],
    cancelled: Callable[[], bool] = never,
) -> Masks:
    """Return which words of classes fit all patterns: bit g is set if the image under element g does.

    The ids, shape (C,), belong to classes, or to pruned words, which use bit 0. Words too long for a key are
    read from the connection.
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
    """Return the words of a class, or a pruned word, whose id is not a key, and their stabiliser."""
    if number < 0:
        query = sa.select(pruned.c.p, pruned.c.word, sa.literal("1")).where(pruned.c.id == number)
    else:
        query = sa.select(cycle.c.p, cycle.c.words, cycle.c.symmetry).where(cycle.c.id == number)
    p, text, symmetry = connection.execute(query).one()
    words = [text[start : start + p] for start in range(0, len(text), p)]
    need_words(words, [p] * len(words))
    return words, stabiliser_of(symmetry)


def stabilisers_of_classes(connection: sa.Connection, ids: Integers, full: NDArray[np.bool_]) -> Masks:
    """Return the stabilisers of classes; that of a class with eight words is the identity."""
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


def stabiliser_of(symmetry: str) -> int:
    """Return the stabiliser for a symmetry label."""
    if symmetry not in STABILISER_OF:
        raise unsound("not a symmetry:", symmetry)
    return STABILISER_OF[symmetry]
