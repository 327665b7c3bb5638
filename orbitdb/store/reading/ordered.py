"""The rows of a subset in some order, told by their words' keys, which are found when they are asked for.

An order by what belongs to a class is one of groups of classes that have the same value. In a group words
stand by period and word. Most groups are a class or few: their words are expanded and sorted when they are
shown. Of the few large ones (all words without a value, those of one status) it is counted how many
stand in each block of words.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from orbitdb.store.reading.class_index import Index
from orbitdb.store.reading.period_words import Integers, ListedWords, Places, keys_of_classes
from orbitdb.store.reading.text_order import ByText

__all__ = ["ByClass", "ByText", "Listed", "Ordered"]

_BLOCK = 1 << 12
_PIECE = 1 << 20
_LARGE = 1 << 14
"""Words of a group that is not expanded as a whole."""

_MOST_LARGE = 250


@dataclass(eq=False)
class Listed:
    """Rows that are listed by the places of their words.

    Attributes
    ----------
    index : Index
    places : ndarray of uint32, shape (N,)
        Where each of them stands among all words.
    """

    index: Index
    places: NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, rows: slice) -> Integers:
        return self.index.keys_at(self.places[rows])

    def prepare(self) -> None:
        """Do nothing: rows are found at once."""

    def position(self, word: str) -> int | None:
        """Return in which row a least rotation is, or None."""
        place = self.index.place(word)
        rows = np.flatnonzero(self.places == (-1 if place is None else place))
        return int(rows[0]) if len(rows) else None

    def first_within(self, spans: Sequence[tuple[int, int]]) -> int | None:
        """Return the first row whose key is from one number on and below another, of some spans of these."""
        inside = np.zeros(len(self.places), dtype=np.bool_)
        for low, high in spans:
            begin, end = self.index.lower(low), self.index.lower(high)
            inside |= (self.places >= begin) & (self.places < end)
        return int(np.argmax(inside)) if inside.any() else None

    def words_of_classes(self) -> Integers:
        """Return how many words of each class there are, shape (C,)."""
        found = np.zeros(len(self.index.numbers), dtype=np.int64)
        for first in range(0, len(self), _PIECE):
            places = np.sort(self.places[first : first + _PIECE]).astype(np.int64)
            found += np.bincount(self.index.classes(places), minlength=len(found))
        return found


@dataclass(eq=False)
class ByClass:
    """All words of some classes, by a value of the class, then by period and word.

    Attributes
    ----------
    index : Index
    classes : ndarray of uint32, shape (n,)
        The classes in the order of their values.
    firsts : ndarray of int64, shape (G + 1,)
        Where among them each group of one value begins; at last n.
    starts : ndarray of int64, shape (G + 1,)
        In which row each group begins; at last the number of rows.
    """

    index: Index
    classes: NDArray[np.uint32]
    firsts: Integers
    starts: Integers
    _large: dict[int, int] = field(init=False)

    def __post_init__(self) -> None:
        sizes = np.diff(self.starts)
        large = np.flatnonzero(sizes > _LARGE)
        large = large[np.argsort(-sizes[large], kind="stable")][:_MOST_LARGE]
        self._large = {group: mark for mark, group in enumerate(large.tolist(), 1)}

    def __len__(self) -> int:
        return int(self.starts[-1])

    def __getitem__(self, rows: slice) -> Integers:
        low, high, _ = rows.indices(len(self))
        parts = [np.zeros(0, dtype=np.int64)]
        while low < high:
            group = self._group_of_row(low)
            until = group + 1
            if group not in self._large:
                until = self._end_of_small(group, high)
            end = min(high, int(self.starts[until]))
            parts.append(self._keys(group, until, low, end))
            low = end
        return np.concatenate(parts)

    def _group_of_row(self, row: int) -> int:
        return int(np.searchsorted(self.starts, row, side="right")) - 1

    def _end_of_small(self, group: int, row: int) -> int:
        """Return the first large group behind one, or else that behind the one with a row."""
        end = self._group_of_row(row - 1) + 1
        return min((large for large in self._large if group < large < end), default=end)

    def _keys(self, group: int, until: int, low: int, high: int) -> Integers:
        """Return the keys in some rows, all of one large group or of some small ones."""
        start = int(self.starts[group])
        if group in self._large:
            return self.index.keys(self._places(self._large[group], low - start, high - start))
        return self._expanded(group, until)[low - start : high - start]

    def _expanded(self, group: int, until: int) -> Integers:
        """Return the keys of all words of some groups."""
        first, last = int(self.firsts[group]), int(self.firsts[until])
        keys, which = members(self.index, self.classes[first:last].astype(np.int64))
        groups = np.searchsorted(self.firsts, first + which, side="right")
        return keys[np.lexsort((keys, groups))]

    @cached_property
    def _marks(self) -> NDArray[np.uint8]:
        """The mark of the large group that a class is in, 0 for none, shape (C,)."""
        marks = np.zeros(len(self.index.numbers), dtype=np.uint8)
        for group, mark in self._large.items():
            marks[self.classes[self.firsts[group] : self.firsts[group + 1]]] = mark
        return marks

    @cached_property
    def _counts(self) -> NDArray[np.int64]:
        """How many words of each large group stand before a block, shape (blocks + 1, groups + 1)."""
        blocks, width = len(self.index) // _BLOCK + 1, len(self._large) + 1
        counts = np.zeros((blocks + 1, width), dtype=np.int64)
        for start, classes in self.index.pieces(0, len(self.index), _PIECE):
            block = np.arange(start, start + len(classes)) // _BLOCK
            cells = np.bincount((block - block[0]) * width + self._marks[classes])
            cells = np.append(cells, np.zeros(-len(cells) % width, dtype=np.int64)).reshape(-1, width)
            counts[block[0] + 1 : block[0] + 1 + len(cells)] += cells
        return np.cumsum(counts, axis=0)

    def prepare(self) -> None:
        """Count now what is needed before rows of large groups can be found."""
        if self._large:
            _ = self._counts

    def _places(self, mark: int, low: int, high: int) -> Places:
        """Return where some words of a large group stand among all words."""
        before = self._counts[:, mark]
        block = int(np.searchsorted(before, low, side="right")) - 1
        last = int(np.searchsorted(before, high, side="left"))
        places = np.arange(block * _BLOCK, min(last * _BLOCK, len(self.index)))
        found = places[self._marks[self.index.classes(places)] == mark]
        return found[low - before[block] : high - before[block]]

    def position(self, word: str) -> int | None:
        """Return in which row a least rotation is, or None."""
        place = self.index.place(word)
        if place is None:
            return None
        number = int(self.index.classes(np.array([place]))[0])
        found = np.flatnonzero(self.classes == number)
        return self._row(place, int(found[0])) if len(found) else None

    def _row(self, place: int, rank: int) -> int:
        """Return the row of a word, by its place among all words, and that of its class in the order."""
        group = int(np.searchsorted(self.firsts, rank, side="right")) - 1
        if group not in self._large:
            key = self.index.keys(np.array([place]))[0]
            within = np.flatnonzero(self._expanded(group, group + 1) == key)[0]
        else:
            mark, block = self._large[group], place // _BLOCK
            classes = self.index.classes(np.arange(block * _BLOCK, place))
            within = self._counts[block, mark] + np.count_nonzero(self._marks[classes] == mark)
        return int(self.starts[group] + within)

    def first_within(self, spans: Sequence[tuple[int, int]]) -> int | None:
        """Return the first row whose key is from one number on and below another, of some spans of these."""
        ranks = np.full(len(self.index.numbers), len(self.classes), dtype=np.uint32)
        ranks[self.classes] = np.arange(len(self.classes), dtype=np.uint32)
        best = (len(self.firsts), 0)
        for low, high in spans:
            ends = self.index.lower(low), self.index.lower(high)
            for start, classes in self.index.pieces(*ends, _PIECE):
                of_words = ranks[classes]
                first = int(of_words.min())
                if first == len(self.classes):
                    continue
                group = int(np.searchsorted(self.firsts, first, side="right")) - 1
                inside = (of_words >= self.firsts[group]) & (of_words < self.firsts[group + 1])
                best = min(best, (group, start + int(np.argmax(inside))))
        group, place = best
        return None if group == len(self.firsts) else self._row(place, int(self.firsts[group]))

    def words_of_classes(self) -> Integers:
        """Return how many words of each class there are, shape (C,)."""
        found = np.zeros(len(self.index.numbers), dtype=np.int64)
        found[self.classes] = self.index.sizes[self.classes]
        return found


def by_class(
    index: Index, chosen: NDArray[np.bool_], values: NDArray[np.float64] | None, descending: bool = False
) -> ByClass:
    """Order the words of the chosen classes by a value of the class, NaN last; None: by period and word."""
    classes = np.flatnonzero(chosen & (index.sizes > 0)).astype(np.uint32)
    new = np.arange(len(classes)) == 0
    if values is not None:
        order, new = grouped(values[classes], descending)
        classes = classes[order]
        del order  # of millions of classes it takes more room than what is kept
    firsts = np.append(np.flatnonzero(new), len(classes))
    ends = np.concatenate([[0], np.cumsum(index.sizes[classes], dtype=np.int64)])
    return ByClass(index, classes, firsts, ends[firsts])


def grouped(values: NDArray[np.float64], descending: bool) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return numbers' places in their order, NaN last, and where in that another value than before begins."""
    order = np.argsort(-values if descending else values, kind="stable")
    rising = values[order]
    none = np.isnan(rising)
    new = np.ones(len(values), dtype=np.bool_)
    new[1:] = (rising[1:] != rising[:-1]) & ~(none[1:] & none[:-1])
    return order, new


def members(index: Index, classes: Integers) -> tuple[Integers, Integers]:
    """Return the keys of all words of some classes, and which of these each belongs to."""
    keys, which = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    parts = np.searchsorted(index.class_starts, classes, side="right") - 1
    for number in np.unique(parts).tolist():
        here = np.flatnonzero(parts == number)
        words = index.parts[number].words
        if isinstance(words, ListedWords):
            wanted = classes[here] - words.offset
            places = np.flatnonzero(np.isin(words.numbers, wanted))
            order = np.argsort(wanted)
            keys.append(words.keys(places))
            which.append(here[order[np.searchsorted(wanted[order], words.numbers[places])]])
        else:
            found, of_class = keys_of_classes(words.least[classes[here] - words.offset], words.p)
            keys.append(found)
            which.append(here[of_class])
    return np.concatenate(keys), np.concatenate(which)


Ordered = Listed | ByClass | ByText
"""Rows in some order."""
