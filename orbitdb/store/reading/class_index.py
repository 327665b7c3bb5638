"""The index of a catalogue at one a: its symmetry classes, an eighth of the words, and where the words stand.

Both are found without a look at the words of a period that holds all words of its classes and no others:
these are expanded from the classes (`orbitdb.store.reading.period_words`). Words of other periods are listed
as they are stored.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.orbits.orbit import Status
from orbitdb.store.reading.period_words import Integers, Places, Words
from orbitdb.symbols.words import BITS, MAX_KEYED, key, keys_of_period, word_of

LONG = 1 << 62
"""The key of the first word of more than `MAX_KEYED` symbols; the others follow."""

STATUSES = tuple(Status)

_FEW = 64
_PIECE = 1 << 20


@dataclass(frozen=True, eq=False)
class Part(ByValue):
    """The classes and words of one period, or all long ones.

    Attributes
    ----------
    numbers : ndarray of int64, shape (C,)
        The numbers of the classes, rising. Words that are geometrically pruned have none; those of a period
        count as one class more, whose number is that of no word: the last one of the period, or, for long
        words, how long they are.
    sizes : ndarray of uint32, shape (C,)
        How many words each of them has here.
    statuses : ndarray of uint8, shape (C,)
        The places of their statuses in `STATUSES`.
    words : Words
        The words in their order.
    """

    numbers: Integers
    sizes: NDArray[np.uint32]
    statuses: NDArray[np.uint8]
    words: Words


@dataclass(frozen=True, eq=False)
class Index(ByValue):
    """The symbol sequences that a catalogue knows at one a, in the order of period and word.

    Attributes
    ----------
    a : float
        The stadium.
    parts : tuple of Part
        By rising period; the long words last.
    long_words : tuple of str
        The words of more than `MAX_KEYED` symbols, in their order.
    numbers, sizes, statuses : ndarray, shape (C,)
        Those of the parts, one behind the other.
    starts, class_starts : ndarray of int64, shape (len(parts) + 1,)
        Where the words and the classes of each part begin, and where they end.
    """

    a: float
    parts: tuple[Part, ...]
    long_words: tuple[str, ...] = ()
    numbers: Integers = field(init=False)
    sizes: NDArray[np.uint32] = field(init=False)
    statuses: NDArray[np.uint8] = field(init=False)
    starts: Integers = field(init=False)
    class_starts: Integers = field(init=False)

    def __post_init__(self) -> None:
        class_starts = _ends([len(part.numbers) for part in self.parts])
        found = {
            "parts": tuple(
                replace(part, words=replace(part.words, offset=start))
                for part, start in zip(self.parts, class_starts.tolist(), strict=False)
            ),
            "numbers": _joined([part.numbers for part in self.parts], np.int64),
            "sizes": _joined([part.sizes for part in self.parts], np.uint32),
            "statuses": _joined([part.statuses for part in self.parts], np.uint8),
            "starts": _ends([len(part.words) for part in self.parts]),
            "class_starts": class_starts,
        }
        for name, value in found.items():
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return int(self.starts[-1])

    @cached_property
    def last_values(self) -> dict[str, NDArray[np.float64]]:
        """The values of the column that was sorted by last (`orbitdb.store.reading.class_values`)."""
        return {}

    def word(self, key: int) -> str:
        """Return the word, as a least rotation, that has a key."""
        return self.long_words[key - LONG] if key >= LONG else word_of(key)

    def key(self, word: str) -> int | None:
        """Return the key of a least rotation, None for a long word that is not here."""
        if len(word) <= MAX_KEYED:
            return key(word)
        return LONG + self.long_words.index(word) if word in self.long_words else None

    def keys_at(self, places: NDArray[np.integer]) -> Integers:
        """Return the keys of the words at some places, in any order."""
        order = np.argsort(places)
        found = np.empty(len(places), dtype=np.int64)
        found[order] = self.keys(places[order].astype(np.int64))
        return found

    def keys(self, places: Places) -> Integers:
        """Return the keys of the words at some places, which rise."""
        return _joined([words.keys(here) for words, here in self._by_part(places)], np.int64)

    def classes(self, places: Places) -> Integers:
        """Return the numbers, from 0 on, of the classes of the words at some places, which rise."""
        return _joined([words.classes(here) for words, here in self._by_part(places)], np.int64)

    def _by_part(self, places: Places) -> Iterator[tuple[Words, Places]]:
        ends = np.searchsorted(places, self.starts)
        for number in np.flatnonzero(np.diff(ends)):
            yield self.parts[number].words, places[ends[number] : ends[number + 1]] - self.starts[number]

    def pieces(self, first: int, last: int, size: int) -> Iterator[tuple[int, Integers]]:
        """Yield the classes of the words between two places in pieces, and where each of these begins."""
        for part, start in zip(self.parts, self.starts.tolist(), strict=False):
            begin, end = max(first - start, 0), min(last - start, len(part.words))
            for at in range(begin, end, size):
                yield start + at, part.words.classes(slice(at, min(at + size, end)))

    def place(self, word: str) -> int | None:
        """Return where a least rotation stands among all words, or None if it is not there."""
        wanted = self.key(word)
        found = len(self) if wanted is None else self.lower(wanted)
        there = found < len(self) and int(self.keys(np.array([found]))[0]) == wanted
        return found if there else None

    def class_of(self, word: str) -> int | None:
        """Return the number, from 0 on, of the class of a least rotation, or None if it is not here."""
        place = self.place(word)
        return None if place is None else int(self.classes(np.array([place]))[0])

    def places(self, keys: Integers) -> Places:
        """Return where the words with some keys, which rise, stand; those that are not here are left out."""
        found = []
        for part, start in zip(self.parts, self.starts.tolist(), strict=False):
            low, high = keys_of_period(part.words.p) if part.words.p else (LONG, 2 * LONG - 1)
            here = keys[np.searchsorted(keys, low) : np.searchsorted(keys, high)]
            found += [start + places for places in _places(part.words, here)]
        return _joined(found, np.int64)

    def lower(self, key: int) -> int:
        """Return how many words stand before a key."""
        p = (key.bit_length() - 1) // BITS if key < LONG else 0
        for part, start in zip(self.parts, self.starts.tolist(), strict=False):
            if part.words.p == p or not part.words.p:
                return int(start) + part.words.lower(key)
            if part.words.p > p > 0:
                return int(start)
        return len(self)

    def by_period(self, value: Callable[[int], float]) -> NDArray[np.float64]:
        """Return a number a class that depends on its period alone, shape (C,)."""
        found = np.empty(len(self.numbers), dtype=np.float64)
        for part, first, last in zip(self.parts, self.class_starts, self.class_starts[1:], strict=False):
            found[first:last] = value(part.words.p) if part.words.p else np.nan
        if self.parts and not self.parts[-1].words.p:
            long = self.parts[-1].words
            found[long.classes(slice(None))] = [value(len(word)) for word in self.long_words]
        return found


def _places(words: Words, keys: Integers) -> Iterator[Places]:
    """Yield where those words of a part stand that have some keys, which rise."""
    if len(keys) < _FEW:
        places = np.array([words.lower(key) for key in keys.tolist()], dtype=np.intp)
        places = places[places < len(words)]
        yield places[np.isin(words.keys(places), keys)]
        return
    for begin in range(0, len(words), _PIECE):
        yield begin + np.flatnonzero(np.isin(words.keys(slice(begin, begin + _PIECE)), keys))


def _ends(lengths: Sequence[int]) -> Integers:
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(lengths, dtype=np.int64)])


def _joined(arrays: Sequence[NDArray[Any]], kind: type[np.generic]) -> NDArray[Any]:
    return np.concatenate([np.zeros(0, kind), *arrays], dtype=kind)
