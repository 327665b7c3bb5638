"""A chosen subset as two arrays: its symmetry classes in the wanted order, and a bit mask of their words.

The size is the number of bits, and a page is a slice of their cumulative count. Averages weight a class by
its bits. Only an order of single words needs a third array.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Integers
from orbitdb.equality import ByValue
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import LONG
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.members import BITS_OF
from orbitdb.symbols.words import BITS, MAX_KEYED

Masks = NDArray[np.uint8]

COUNTS = BITS_OF.sum(axis=1, dtype=np.uint8)
"""Number of set bits in each byte."""

_NTH = np.argsort(1 - BITS_OF, axis=1, kind="stable").astype(np.uint8)
"""Positions of the set bits of each byte, from the lowest."""

ALL = 0xFF
"""The mask of a class with all eight words chosen."""

_LEAST = 1 << 2 * BITS
"""The key of 00, the least key of any word."""


class Words(NamedTuple):
    """Words, each by the id of its class and its place in the class.

    Geometrically pruned words have negative ids and place 0.
    """

    ids: Integers
    places: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Chosen(ByValue):
    """A chosen subset of the words stored at one a.

    Attributes
    ----------
    selection : Selection
        What was chosen.
    ids : ndarray of int64, shape (C,)
        The classes with chosen words, in the order of the rows; minus the key for a pruned word.
    masks : ndarray of uint8, shape (C,)
        Bit n is set if word n of the class is chosen.
    rows : ndarray of uint32, shape (N,), or None
        The numbers of the words in order, if the order is not that of the classes.
    values : mapping of str to ndarray, shape (C,)
        Requested columns of the classes.
    """

    selection: Selection
    ids: Integers
    masks: Masks
    rows: NDArray[np.uint32] | None = None
    values: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __len__(self) -> int:
        return int(self.ends[-1]) if len(self.ends) else 0

    @property
    def counts(self) -> NDArray[np.uint8]:
        """Number of chosen words of each class, shape (C,)."""
        return COUNTS[self.masks]

    @cached_property
    def ends(self) -> Integers:
        """Number of words up to and including each class, shape (C,)."""
        return np.cumsum(self.counts, dtype=np.int64)

    def words(self, first: int = 0, last: int | None = None) -> Words:
        """Return the words of rows first .. last - 1."""
        numbers = self._numbers(first, last)
        classes = np.searchsorted(self.ends, numbers, side="right")
        masks = self.masks[classes]
        before = numbers - (self.ends[classes] - COUNTS[masks])
        return Words(self.ids[classes], _NTH[masks, before])

    def classes(self, first: int = 0, last: int | None = None) -> NDArray[np.intp]:
        """Return the places of the classes of these rows among all classes."""
        return np.searchsorted(self.ends, self._numbers(first, last), side="right")

    def _numbers(self, first: int, last: int | None) -> Integers:
        last = len(self) if last is None else min(last, len(self))
        if self.rows is None:
            return np.arange(first, max(first, last))
        return self.rows[first:last].astype(np.int64)

    def position(self, number: int, place: int) -> int | None:
        """Return the row of a word, given by the id of its class and its place there, or None."""
        for found in np.flatnonzero(self.ids == number).tolist():
            mask = int(self.masks[found])
            if mask >> place & 1:
                row = int(self.ends[found]) - (mask >> place).bit_count()
                return row if self.rows is None else int(np.flatnonzero(self.rows == row)[0])
        return None

    def first(self, masks: Masks) -> int | None:
        """Return the first row of some words, given by masks like those of the subset, or None."""
        wanted = self.masks & masks
        if not wanted.any():
            return None
        if self.rows is None:
            found = int(np.argmax(wanted > 0))
            return self.position(int(self.ids[found]), int(_NTH[wanted[found], 0]))
        inside, chosen = (BITS_OF[each].astype(np.bool_) for each in (wanted, self.masks))
        return int(np.argmax(inside[chosen][self.rows]))


def listed(ids: Integers) -> sa.Select[tuple[int]]:
    """Return many ids as a subquery with one parameter."""
    return sa.select(sa.column("value")).select_from(sa.func.json_each(json.dumps(ids.tolist())))


def orders_of(ids: Integers, sound: bool = True) -> NDArray[np.int64]:
    """Return the periods of the words whose keys are the ids or minus the ids; `MAX_KEYED` + 1 for others.

    Ids below every key are refused, or have period 0 if they need not be sound.
    """
    keys = np.abs(ids)
    low = keys < _LEAST
    if sound and low.any():
        raise unsound("a class with the number", ids[low][0])
    ends = np.int64(1) << BITS * np.arange(1, MAX_KEYED + 1, dtype=np.int64)
    found = np.searchsorted(ends, keys, side="right")
    found[keys >= LONG] = MAX_KEYED + 1
    found[low] = 0
    return found
