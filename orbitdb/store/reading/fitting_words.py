"""The words of classes that fit patterns, told from the classes' least words: no word is read."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from orbitdb.store.reading.period_words import FIRST, Integers, all_images
from orbitdb.symbols.patterns import Pattern
from orbitdb.symbols.symmetry import ELEMENTS, packed_images
from orbitdb.symbols.words import BITS, packed

Masks = NDArray[np.uint8]

_BATCH = 1 << 14
"""Classes that are looked at at a time: what is in work fits into the processor's cache."""

_HEAD = 5
"""First symbols of words by which those between two rows are found."""

_ELEMENTS_IN = np.array([mask.bit_count() for mask in range(256)], dtype=np.int64)


def fitting_images(least: Integers, p: int, patterns: Sequence[Pattern]) -> Masks:
    """Return which images of classes fit all patterns: bit g is set where that under element g does.

    Parameters
    ----------
    least : ndarray of int64, shape (C,)
        The keys of the classes' least words.
    p : int
        Their period.
    patterns : sequence of Pattern

    Returns
    -------
    ndarray of uint8, shape (C,)
    """
    found = np.full(len(least), 0xFF, dtype=np.uint8)
    rotated = any(not pattern.cyclic for pattern in patterns)
    for start in range(0, len(least) if patterns else 0, _BATCH):
        batch = least[start : start + _BATCH]
        images = all_images(batch, p)[0] if rotated else packed_images(packed(batch, p), p)
        for g, image in enumerate(images):
            fits = np.logical_and.reduce([pattern.fitting(image, p) for pattern in patterns])
            found[start : start + _BATCH] ^= np.uint8(1 << g) * ~fits
    return found


def count_images(masks: Masks, sizes: NDArray[np.integer]) -> int:
    """Return how many words classes of some sizes have, if some of their eight images count."""
    return int((_ELEMENTS_IN[masks] * sizes).sum()) // len(ELEMENTS)


def words_between(least: Integers, p: int, masks: Masks, first: int, last: int) -> Integers:
    """Return the words of classes of one period from one place on and below another, in their order.

    Parameters
    ----------
    least : ndarray of int64, shape (C,)
        The keys of the classes' least words.
    p : int
    masks : ndarray of uint8, shape (C,)
        Which of their images count.
    first, last : int
        Places among all words that count.

    Returns
    -------
    ndarray of int64
        Packed words.
    """
    below = BITS * max(p - _HEAD, 0)
    counts = np.zeros(1 << BITS * min(p, _HEAD), dtype=np.int64)
    for words in _batches(least, p, masks):
        counts += np.bincount(words >> below, minlength=len(counts))
    ends = np.cumsum(counts)
    head, end = np.searchsorted(ends, [first, last - 1], side="right")
    low, high = head << below, end + 1 << below
    inside = [words[(words >= low) & (words < high)] for words in _batches(least, p, masks)]
    found = np.sort(np.concatenate([np.zeros(0, np.int64), *inside]))
    before = int(ends[head - 1]) if head else 0
    return found[first - before : last - before]


def _batches(least: Integers, p: int, masks: Masks) -> Iterator[Integers]:
    """Yield the words that count, as packed words in no order, some thousand classes at a time."""
    for start in range(0, len(least), _BATCH):
        batch = slice(start, start + _BATCH)
        images, stabilisers = all_images(least[batch], p)
        fits = masks[batch] >> np.arange(len(ELEMENTS), dtype=np.uint8)[:, None] & 1
        yield images[FIRST[stabilisers].T & (fits == 1)]
