"""Where the words that fit patterns stand in an index: told from the least words of their classes."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from orbitdb.store.asking.confinement import never
from orbitdb.store.reading.class_index import Index, Part
from orbitdb.store.reading.class_values import CancelledError
from orbitdb.store.reading.fitting_words import fitting_images
from orbitdb.store.reading.period_words import Integers, PeriodWords
from orbitdb.symbols.patterns import Pattern
from orbitdb.symbols.words import packed

_PIECE = 1 << 18
"""Words or classes that are looked at at a time."""

Chosen = NDArray[np.bool_]
Places = Iterator[Integers]


def fitting_places(
    index: Index, patterns: Sequence[Pattern], chosen: Chosen, cancelled: Callable[[], bool] = never
) -> NDArray[np.uint32]:
    """Return the places of the words of some classes that fit all patterns.

    Parameters
    ----------
    index : Index
    patterns : sequence of Pattern
    chosen : ndarray of bool
        The classes.
    cancelled : callable, optional
        Asked now and then whether to stop.

    Returns
    -------
    ndarray of uint32
        Rising.

    Raises
    ------
    CancelledError
        If it is told to stop.
    """
    found = [np.zeros(0, dtype=np.uint32)]
    ends = zip(index.starts.tolist(), index.class_starts.tolist(), strict=True)
    for part, (start, of_class) in zip(index.parts, ends, strict=False):
        here = chosen[of_class : of_class + len(part.numbers)]
        if here.any():
            places = _places(part, index.long_words, patterns, here, cancelled)
            found += [(start + piece).astype(np.uint32) for piece in places]
    return np.concatenate(found)


def _places(
    part: Part,
    long_words: Sequence[str],
    patterns: Sequence[Pattern],
    chosen: Chosen,
    cancelled: Callable[[], bool],
) -> Places:
    """Yield the places of fitting words of one part."""
    words = part.words
    if isinstance(words, PeriodWords):
        yield from _expanded(words, patterns, chosen, cancelled)
    elif words.p:
        fits = [pattern.fitting(packed(words.listed, words.p), words.p) for pattern in patterns]
        yield np.flatnonzero(np.logical_and.reduce([*fits, chosen[words.numbers]]))
    else:
        fits = [np.array([pattern.fits(word) for word in long_words]) for pattern in patterns]
        yield np.flatnonzero(np.logical_and.reduce([*fits, chosen[words.numbers]]))


def _expanded(
    words: PeriodWords, patterns: Sequence[Pattern], chosen: Chosen, cancelled: Callable[[], bool]
) -> Places:
    masks = np.zeros(len(words.least), dtype=np.uint8)
    classes = np.flatnonzero(chosen)
    for begin in range(0, len(classes), _PIECE):
        if cancelled():
            raise CancelledError
        piece = classes[begin : begin + _PIECE]
        masks[piece] = fitting_images(words.least[piece], words.p, patterns)
    for begin in range(0, len(words), _PIECE):
        if cancelled():
            raise CancelledError
        of_classes, elements = words.told(slice(begin, begin + _PIECE))
        yield begin + np.flatnonzero(masks[of_classes] >> elements & 1)
