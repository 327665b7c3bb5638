"""Sort single words by their text, their symmetry element, or columns of their classes."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Integers
from orbitdb.store.file.ids import LONG
from orbitdb.store.reading.matching import long_words, stabilisers_of_classes
from orbitdb.store.reading.rows import ALL, Chosen, orders_of
from orbitdb.symbols.symmetry import BITS_OF, ELEMENT_OF, ELEMENTS, packed_members
from orbitdb.symbols.words import BITS, MAX_KEYED, from_strings, pack, packed

_TEXTS = ("code", "word")

STEP = 1 << 17
"""Number of classes or rows handled at a time."""


def in_order_of_words(
    connection: sa.Connection, chosen: Chosen, keys: Mapping[str, bool]
) -> NDArray[np.uint32]:
    """Return the indices that sort the words of a subset by columns, shape (N,).

    The keys map each column to whether its order is descending. The subset must be in its natural order, and
    have the values of those columns that belong to classes. Only words too long for a key are read from the
    file.
    """
    arrays: list[NDArray[Any]] = []
    for name, falls in keys.items():
        if name in _TEXTS:
            texts = _texts(connection, chosen)
            arrays += [np.negative(part, out=part) for part in texts] if falls else texts
            break  # no two words are equal
        if name == "element":
            arrays.append(_elements(connection, chosen, falls))
        else:
            arrays.append(np.repeat(_ranks(chosen.values[name], falls), chosen.counts))
    return np.lexsort(arrays[::-1]).astype(np.uint32)


def _ranks(values: NDArray[np.generic], falling: bool) -> Integers:
    """Return the rank of each value among the distinct values; missing values come last."""
    missing = np.array([value is None or value != value for value in values.tolist()], dtype=np.bool_)
    ranks = np.full(len(values), len(values), dtype=np.int64)
    _, found = np.unique(values[~missing], return_inverse=True)
    ranks[~missing] = -found if falling else found
    return ranks


def _texts(connection: sa.Connection, chosen: Chosen) -> list[Integers]:
    """Return numbers that sort like the texts of words and, if there are long words, ranks to break ties.

    A number contains the first `MAX_KEYED` symbols, each increased by 1, so that a word precedes words that
    begin with it.
    """
    texts, done = np.zeros(len(chosen), dtype=np.int64), 0
    short = len(chosen.ids) - int((np.abs(chosen.ids) >= LONG).sum())  # long words come last
    for start in range(0, short, STEP):
        step = slice(start, min(start + STEP, short))
        ids, masks, orders = chosen.ids[step], chosen.masks[step], orders_of(chosen.ids[step])
        stabilisers = stabilisers_of_classes(connection, ids, masks == ALL)
        for p in np.unique(orders).tolist():  # in the natural order, words of the same period are adjacent
            here = orders == p
            for codes in packed_members(packed(np.abs(ids[here]), p), p, masks[here], stabilisers[here]):
                texts[done : done + len(codes)] = _raised(codes, p)
                done += len(codes)
    if short == len(chosen.ids):
        return [texts]
    words, later = _long_words(connection, chosen.ids[short:], chosen.masks[short:]), np.zeros_like(texts)
    ranks = {word: rank for rank, word in enumerate(sorted(words), 1)}
    texts[done:] = [_text(word) for word in words]
    later[done:] = [ranks[word] for word in words]
    return [texts, later]


def _raised(codes: Integers, p: int) -> Integers:
    return (codes + int("1" * p, 8)) << BITS * (MAX_KEYED - p)


def _text(word: str) -> int:
    return int(_raised(pack(from_strings([word[:MAX_KEYED]])), min(len(word), MAX_KEYED))[0])


def _long_words(connection: sa.Connection, ids: Integers, masks: NDArray[np.uint8]) -> list[str]:
    found = []
    for number, mask in zip(ids.tolist(), masks.tolist(), strict=True):
        words, _ = long_words(connection, number)
        found += [word for n, word in enumerate(words) if mask >> n & 1]
    return found


def _elements(connection: sa.Connection, chosen: Chosen, falling: bool) -> NDArray[np.int8]:
    """Return keys that sort words by symmetry element; pruned words come last."""
    stabilisers = stabilisers_of_classes(connection, chosen.ids, chosen.masks == ALL)
    elements = ELEMENT_OF.astype(np.int8)[stabilisers] * (-1 if falling else 1)
    elements[chosen.ids < 0] = len(ELEMENTS)
    return elements[BITS_OF[chosen.masks].astype(np.bool_)]
