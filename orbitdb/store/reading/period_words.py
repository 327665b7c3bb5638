"""The words of one period in their order, four bytes each: they are expanded from their classes.

A word is told by its class and the first element that carries the class's least word to it. In which
order these stand is found without SQL: the images of all least words are rotated to their least, and
sorted a piece at a time. At p = 16, with 18 million words, that takes 2 s of a processor and 14 bytes a
word while it goes on; NumPy keeps no other thread waiting for longer than a piece takes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.symbols.symmetry import ELEMENTS, packed_images
from orbitdb.symbols.words import BITS, keys, least_rotations, packed

Places = NDArray[np.intp]
Integers = NDArray[np.int64]

_ABOVE = BITS
"""Bits of an entry that hold its element; above them stands its class."""

_BATCH = 1 << 14
"""Classes that are expanded at a time: what is in work fits into the processor's cache."""

_PIECE = 1 << 20
"""Words that are sorted at a time, about."""

_HEAD = 6
"""First symbols of words that are sorted together."""

HEAD = 8
"""First symbols by which words of all periods are found in the order of their texts: `_HEAD` or more."""

_EXTENT = 43
"""Bits of the differences of words that are sorted together, at most: 20 bits more say which word it is."""


def _first_elements() -> NDArray[np.bool_]:
    """Tell, for each stabiliser, which elements are the first ones to lead to their image."""
    first = np.zeros((256, len(ELEMENTS)), dtype=np.bool_)
    for mask in range(1, 256):
        kept = [s for s in ELEMENTS if mask >> s & 1]
        first[mask] = [g == min(g ^ s for s in kept) for g in ELEMENTS]
    return first


FIRST = _first_elements()
"""For each stabiliser, which elements are the first ones to lead to their image."""


@dataclass(frozen=True, eq=False)
class PeriodWords(ByValue):
    """All words of the known classes of one period, in their order.

    Attributes
    ----------
    p : int
        The period.
    offset : int
        The number, in the index, of the first class.
    least : ndarray of int64, shape (C,)
        The keys of the classes' least words, rising.
    entries : ndarray of uint32, shape (N,)
        Of each word the class, counted from 0 among the C, times 8, and the element.
    heads, head_starts : ndarray of int64, shape (H,)
        The first symbols of the words as `head_of` has them, each once, and where they begin.
    """

    p: int
    offset: int
    least: Integers
    entries: NDArray[np.uint32]
    heads: Integers
    head_starts: Integers

    def __len__(self) -> int:
        return len(self.entries)

    def told(self, places: Places | slice) -> tuple[NDArray[np.integer], NDArray[np.integer]]:
        """Return by what some words are told: their classes, counted from 0 among the C, and elements."""
        entries = self.entries[places]
        return entries >> _ABOVE, entries & 7

    def classes(self, places: Places | slice) -> NDArray[np.int64]:
        """Return the numbers, in the index, of the classes of some words."""
        return (self.entries[places] >> _ABOVE) + np.int64(self.offset)

    def keys(self, places: Places | slice) -> Integers:
        """Return the keys of some words."""
        classes, elements = self.told(places)
        return keys_of_images(self.least[classes], elements, self.p)

    def lower(self, key: int) -> int:
        """Return how many words stand before a key."""
        low, high = 0, len(self)
        while low < high:
            middle = (low + high) // 2
            if self.keys(slice(middle, middle + 1))[0] < key:
                low = middle + 1
            else:
                high = middle
        return low


@dataclass(frozen=True, eq=False)
class ListedWords(ByValue):
    """Words of one period, or long ones, that are read one by one: not all words of their classes are there.

    Attributes
    ----------
    p : int
        The period; 0 for long words, of any.
    offset : int
        The number, in the index, of the first class.
    listed : ndarray of int64, shape (N,)
        Their keys, rising.
    numbers : ndarray of int64, shape (N,)
        Of each word the class, counted from 0 among those of the period.
    """

    p: int
    offset: int
    listed: Integers
    numbers: Integers

    def __len__(self) -> int:
        return len(self.listed)

    def classes(self, places: Places | slice) -> Integers:
        """Return the numbers, in the index, of the classes of some words."""
        return self.numbers[places] + self.offset

    def keys(self, places: Places | slice) -> Integers:
        """Return the keys of some words."""
        return self.listed[places]

    def lower(self, key: int) -> int:
        """Return how many words stand before a key."""
        return int(np.searchsorted(self.listed, key))


Words = PeriodWords | ListedWords


def heads_of(words: Integers, p: int) -> Integers:
    """Return the first `HEAD` symbols of packed words of order p, as if zeros followed shorter ones."""
    spare = BITS * (p - HEAD)
    return words >> spare if spare >= 0 else words << -spare


def new_heads(heads: Integers) -> Places:
    """Return where heads, which rise, are others than those before."""
    return np.flatnonzero(np.diff(heads, prepend=-1))


def keys_of_images(least: Integers, elements: NDArray[np.integer], p: int) -> Integers:
    """Return the keys of the images of classes, by the keys of their least words and an element each."""
    found = np.empty(len(least), dtype=np.int64)
    for g in ELEMENTS:
        chosen = np.flatnonzero(elements == g)
        if len(chosen):
            images = packed_images(packed(least[chosen], p), p)[g]
            found[chosen] = keys(least_rotations(images, p), p)
    return found


def all_images(least: Integers, p: int) -> tuple[Integers, NDArray[np.uint8]]:
    """Return all words of some classes as packed words, shape (8, C), and the stabilisers, shape (C,)."""
    codes = packed(least, p)
    images = np.stack([codes, *(least_rotations(image, p) for image in packed_images(codes, p)[1:])])
    stabilisers = np.zeros(len(codes), dtype=np.uint8)
    for g in ELEMENTS:
        stabilisers |= (images[g] == codes).astype(np.uint8) << np.uint8(g)
    return images, stabilisers


def keys_of_classes(least: Integers, p: int) -> tuple[Integers, Places]:
    """Return the keys of all words of some classes of one period, in no order, and whose each of them is."""
    found, which = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.intp)]
    for start in range(0, len(least), _BATCH):
        images, stabilisers = all_images(least[start : start + _BATCH], p)
        new = FIRST[stabilisers].T
        found.append(keys(images[new], p))
        which.append(start + np.nonzero(new)[1])
    return np.concatenate(found), np.concatenate(which)


def expand(least: Integers, p: int) -> PeriodWords:
    """Put all words of some classes of one period into their order.

    Parameters
    ----------
    least : ndarray of int64, shape (C,)
        The keys of the classes' least words, rising.
    p : int
        The period.
    """
    planes = _Planes(p, len(least))
    for start in range(0, len(least), _BATCH):
        planes.add(start, *all_images(least[start : start + _BATCH], p))
    entries = np.empty(int(planes.heads.sum()), dtype=np.uint32)
    heads, starts = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    done = 0
    for places, words in planes.pieces():
        order = _argsort(words)
        found = heads_of(words[order], p)
        new = new_heads(found)  # none of them goes on in the next piece
        heads.append(found[new])
        starts.append(new + done)
        elements, classes = np.divmod(places[order], max(len(least), 1))
        entries[done : done + len(places)] = classes << _ABOVE | elements
        done += len(places)
    return PeriodWords(p, 0, least, entries, np.concatenate(heads), np.concatenate(starts))


def _argsort(words: Integers) -> NDArray[np.int64]:
    """Return the order of packed words near each other; NumPy sorts values faster than it finds an order."""
    bits = max(len(words) - 1, 1).bit_length()
    low = words.min() if len(words) else np.int64(0)
    marked = (words - low).astype(np.uint64) << np.uint64(bits) | np.arange(len(words), dtype=np.uint64)
    marked.sort()
    return (marked & np.uint64((1 << bits) - 1)).astype(np.int64)


class _Planes:
    """Packed words of one period, element by element, the upper 32 bits apart: six bytes each.

    Parameters
    ----------
    p : int
        The period.
    count : int
        How many classes there are.
    """

    def __init__(self, p: int, count: int) -> None:
        self.low_bits = max(BITS * p - 32, 0)
        self.head_bits = BITS * max(p - _HEAD, 0)
        self.upper = np.full((len(ELEMENTS), count), np.uint32(0xFFFFFFFF))
        self.lower = np.zeros_like(self.upper, dtype=np.uint16 if self.low_bits <= 16 else np.uint32)
        self.heads = np.zeros(1 << BITS * min(p, _HEAD), dtype=np.int64)

    def add(self, start: int, images: Integers, stabilisers: NDArray[np.uint8]) -> None:
        """Add the words of some classes; an image that an element before has led to is left out."""
        new = FIRST[stabilisers].T
        here = np.s_[:, start : start + len(stabilisers)]
        self.upper[here] = np.where(new, images >> self.low_bits, 0xFFFFFFFF)
        self.lower[here] = images & ((1 << self.low_bits) - 1)
        self.heads += np.bincount(images[new] >> self.head_bits, minlength=len(self.heads))

    def pieces(self) -> Iterator[tuple[Places, Integers]]:
        """Yield the words in pieces, one behind the other: their places, and what they are."""
        upper, lower = self.upper.ravel(), self.lower.ravel()
        shift = self.head_bits - self.low_bits
        for first, last in self._spans():
            low, high = (np.uint64(end) << np.uint64(max(shift, 0)) for end in (first, last))
            places = np.flatnonzero((upper >= low) & (upper < high))
            words = upper[places].astype(np.int64) << self.low_bits
            yield places, words | lower[places].astype(np.int64)

    def _spans(self) -> Iterator[tuple[int, int]]:
        """Yield spans of heads of about `_PIECE` words, or of a single head."""
        widest = 1 << max(_EXTENT - self.head_bits, 0)
        first = head = count = 0
        for head in np.flatnonzero(self.heads).tolist():
            words = int(self.heads[head])
            if count and (count + words > _PIECE or head - first >= widest):
                yield first, head
                count = 0
            first = first if count else head
            count += words
        if count:
            yield first, head + 1  # below what stands for images left out
