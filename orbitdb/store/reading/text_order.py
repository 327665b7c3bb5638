"""The order of the words' texts, whatever their periods: these are merged where rows are shown.

Words with the same first symbols stand together in each period. How many of a subset there are is counted
for each of these heads; the words of a head, from all periods, are sorted when they are shown.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from orbitdb.store.reading.class_index import LONG, Index
from orbitdb.store.reading.period_words import (
    Integers,
    PeriodWords,
    Words,
    heads_of,
    new_heads,
)
from orbitdb.symbols.words import BITS, MAX_KEYED, packed

_PIECE = 1 << 20


@dataclass(eq=False)
class ByText:
    """All words of some classes, by their texts.

    Attributes
    ----------
    index : Index
        Without long words.
    chosen : ndarray of bool, shape (C,)
        The classes.
    descending : bool
    """

    index: Index
    chosen: NDArray[np.bool_]
    descending: bool

    def prepare(self) -> None:
        """Count now what is needed before rows can be found."""
        _ = self._starts

    def __len__(self) -> int:
        return int(self.index.sizes[self.chosen].sum(dtype=np.int64))

    @cached_property
    def _heads(self) -> Integers:
        """All heads of words, rising."""
        heads = [np.zeros(0, np.int64), *(_heads(part.words)[0] for part in self.index.parts)]
        found = np.sort(np.concatenate(heads))  # np.unique keeps other threads waiting
        return found[new_heads(found)]

    @cached_property
    def _edges(self) -> Integers:
        """Where the words with each head begin in each part, and end, shape (parts, heads + 1)."""
        found = np.empty((len(self.index.parts), len(self._heads) + 1), dtype=np.int64)
        for row, part in zip(found, self.index.parts, strict=True):
            heads, starts = _heads(part.words)
            row[:-1] = np.append(starts, len(part.words))[np.searchsorted(heads, self._heads)]
            row[-1] = len(part.words)
        return found

    @cached_property
    def _starts(self) -> Integers:
        """In which row, rising, the words with each head begin; at last the number of rows."""
        before = np.zeros_like(self._edges)
        for row, edges, part, start in zip(
            before, self._edges, self.index.parts, self.index.starts.tolist(), strict=False
        ):
            passed = 0
            for begin, classes in self.index.pieces(start, start + len(part.words), _PIECE):
                counted = np.cumsum(self.chosen[classes])
                here = np.flatnonzero((edges > begin - start) & (edges <= begin - start + len(classes)))
                row[here] = passed + counted[edges[here] - (begin - start) - 1]
                passed += int(counted[-1])
        return before.sum(axis=0)

    def __getitem__(self, rows: slice) -> Integers:
        low, high, _ = rows.indices(len(self))
        if low >= high:
            return np.zeros(0, dtype=np.int64)
        if self.descending:
            return self._rising(len(self) - high, len(self) - low)[::-1]
        return self._rising(low, high)

    def _rising(self, low: int, high: int) -> Integers:
        first = int(np.searchsorted(self._starts, low, side="right")) - 1
        last = int(np.searchsorted(self._starts, high, side="left"))
        parts = [self._of_head(head) for head in range(first, last)]
        start = int(self._starts[first])
        return np.concatenate(parts)[low - start : high - start]

    def _of_head(self, head: int) -> Integers:
        """Return the keys of the chosen words with one head in the order of their texts."""
        found = [keys[self.chosen[classes]] for keys, classes in self._slices(head)]
        keys = np.concatenate([np.zeros(0, np.int64), *found])
        return keys[np.argsort(texts_of(keys), kind="stable")]

    def _slices(self, head: int) -> Iterator[tuple[Integers, Integers]]:
        for part, (begin, end) in zip(
            self.index.parts, self._edges[:, head : head + 2].tolist(), strict=True
        ):
            if begin < end:
                yield part.words.keys(slice(begin, end)), part.words.classes(slice(begin, end))

    def position(self, word: str) -> int | None:
        """Return in which row a least rotation is, or None."""
        key = self.index.key(word)
        if key is None or key >= LONG or not len(self):
            return None
        head = int(np.searchsorted(self._heads, heads_of(packed(np.array([key]), len(word)), len(word))[0]))
        if head == len(self._heads):
            return None
        found = np.flatnonzero(self._of_head(head) == key)
        return self._turned(int(self._starts[head] + found[0])) if len(found) else None

    def _turned(self, row: int) -> int:
        return len(self) - 1 - row if self.descending else row

    def first_within(self, spans: Sequence[tuple[int, int]]) -> int | None:
        """Return the first row whose key is from one number on and below another, of some spans of these."""
        best: int | None = None
        for low, high in spans:
            begin, end = self.index.lower(low), self.index.lower(high)
            places = [
                start + np.flatnonzero(self.chosen[classes])[[0, -1]]
                for start, classes in self.index.pieces(begin, end, _PIECE)
                if self.chosen[classes].any()
            ]
            if places:  # texts rise within a period
                place = places[-1][1] if self.descending else places[0][0]
                row = self.position(self.index.word(int(self.index.keys(np.array([place]))[0])))
                best = row if best is None or (row is not None and row < best) else best
        return best

    def words_of_classes(self) -> Integers:
        """Return how many words of each class there are, shape (C,)."""
        return np.where(self.chosen, self.index.sizes, 0).astype(np.int64)


def texts_of(keys: Integers) -> Integers:
    """Return numbers that sort as the texts of the words with some keys do."""
    bounds = np.int64(1) << (BITS * np.arange(MAX_KEYED + 2, dtype=np.int64))
    periods = np.searchsorted(bounds, keys, side="right") - 1
    found: Integers = (keys - bounds[periods]) << (BITS * (MAX_KEYED - periods))
    return found


def _heads(words: Words) -> tuple[Integers, Integers]:
    """Return the heads of the words of a part, and where they begin."""
    if isinstance(words, PeriodWords):
        return words.heads, words.head_starts
    heads = heads_of(packed(words.listed, words.p), words.p)
    starts = new_heads(heads)
    return heads[starts], starts
