"""A chosen subset as two arrays: its symmetry classes in the order asked for, and which of their words.

Its size is a sum over bits, and a page is a slice of their cumulative count. Averages weight a class with
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
"""How many bits are set in each byte."""

_NTH = np.argsort(1 - BITS_OF, axis=1, kind="stable").astype(np.uint8)
"""Which bit of each byte is its first one that is set, its second one, and so on."""

ALL = 0xFF
"""The mask of a class of eight words that are all chosen."""

_LEAST = 1 << 2 * BITS
"""The key of 00: no word has fewer symbols."""


class Words(NamedTuple):
    """Words, each by the id of its class and its place among the words of the class.

    Negative ids are those of words that are geometrically pruned, whose place is 0.
    """

    ids: Integers
    places: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Chosen(ByValue):
    """A chosen subset of the words that are stored at one a.

    Attributes
    ----------
    selection : Selection
        What was chosen.
    ids : ndarray of int64, shape (C,)
        The classes with chosen words, in the order of the rows; of pruned words minus their keys.
    masks : ndarray of uint8, shape (C,)
        Bit n is set where the n-th word of the class is chosen.
    rows : ndarray of uint32, shape (N,), or None
        The order of the words if it is not that of the classes: their numbers in that order.
    values : mapping of str to ndarray, shape (C,)
        Columns of the classes that were asked for, too.
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
        """How many words of each class are chosen, shape (C,)."""
        return COUNTS[self.masks]

    @cached_property
    def ends(self) -> Integers:
        """How many words there are up to each class and with it, shape (C,)."""
        return np.cumsum(self.counts, dtype=np.int64)

    def words(self, first: int = 0, last: int | None = None) -> Words:
        """Return the words of rows from one on and below another."""
        numbers = self._numbers(first, last)
        classes = np.searchsorted(self.ends, numbers, side="right")
        masks = self.masks[classes]
        before = numbers - (self.ends[classes] - COUNTS[masks])
        return Words(self.ids[classes], _NTH[masks, before])

    def classes(self, first: int = 0, last: int | None = None) -> NDArray[np.intp]:
        """Return the places among all classes of the classes of the words of such rows."""
        return np.searchsorted(self.ends, self._numbers(first, last), side="right")

    def _numbers(self, first: int, last: int | None) -> Integers:
        last = len(self) if last is None else min(last, len(self))
        if self.rows is None:
            return np.arange(first, max(first, last))
        return self.rows[first:last].astype(np.int64)

    def position(self, number: int, place: int) -> int | None:
        """Return in which row a word stands, by the id of its class and its place there; None if in none."""
        for found in np.flatnonzero(self.ids == number).tolist():
            mask = int(self.masks[found])
            if mask >> place & 1:
                row = int(self.ends[found]) - (mask >> place).bit_count()
                return row if self.rows is None else int(np.flatnonzero(self.rows == row)[0])
        return None

    def first(self, masks: Masks) -> int | None:
        """Return the first row of some words, which are given as those of the subset are; None if in none."""
        wanted = self.masks & masks
        if not wanted.any():
            return None
        if self.rows is None:
            found = int(np.argmax(wanted > 0))
            return self.position(int(self.ids[found]), int(_NTH[wanted[found], 0]))
        inside, chosen = (BITS_OF[each].astype(np.bool_) for each in (wanted, self.masks))
        return int(np.argmax(inside[chosen][self.rows]))


def listed(ids: Integers) -> sa.Select[tuple[int]]:
    """Return many ids as a subquery, in one parameter."""
    return sa.select(sa.column("value")).select_from(sa.func.json_each(json.dumps(ids.tolist())))


def orders_of(ids: Integers, sound: bool = True) -> NDArray[np.int64]:
    """Return the orders of the words that ids, or minus the ids, are keys of; `MAX_KEYED` + 1 for others.

    Ids below every key are refused, unless they need not be sound; their order is then 0.
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
