"""All words of symmetry classes, from their representatives.

The words of a class are in the order of the first elements that lead to them, beginning with the
representative (the identity). Word n, counted from 0, belongs to element `ELEMENT_OF[stabiliser, n]`;
elements that lead to an earlier word are skipped.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Integers, Masks
from orbitdb.symbols.symmetry import ELEMENTS, GROUPS, SIZES, all_images, label, members
from orbitdb.symbols.words import unpack

_BATCH = 1 << 14
"""Classes at a time; they fit into the processor's cache."""


def _elements() -> NDArray[np.uint8]:
    found = np.zeros((256, len(ELEMENTS)), dtype=np.uint8)
    for mask in GROUPS:
        kept = [s for s in ELEMENTS if mask >> s & 1]
        found[mask, : SIZES[mask]] = [g for g in ELEMENTS if g == min(g ^ s for s in kept)]
    return found


ELEMENT_OF = _elements()
"""For each stabiliser, the elements that lead to the words of its class in order, shape (256, 8)."""

STABILISER_OF = {label(mask): mask for mask in GROUPS}
"""The stabiliser of each symmetry label."""

ELEMENT_ROWS = [
    (label(mask), n, int(ELEMENT_OF[mask, n])) for mask in GROUPS for n in range(int(SIZES[mask]))
]
"""Symmetry label, n, and the element that leads to word n: the rows of the table ``element``."""

BITS_OF = np.arange(256, dtype=np.uint8)[:, None] >> np.arange(8, dtype=np.uint8) & 1
"""The bits of each byte, the lowest first, shape (256, 8)."""


def places_of_elements(elements: Masks, stabilisers: Masks) -> Masks:
    """Turn sets of elements, shape (C,), into sets of places in the classes.

    Bit g stands for the word of element g, and bit n of the result for word n. Bits beyond the size of the
    class mean nothing.
    """
    places = np.zeros_like(elements)
    for n in ELEMENTS:
        places |= (elements >> ELEMENT_OF[stabilisers, n] & 1) << np.uint8(n)
    return places


def joined_words(codes: Integers, stabilisers: Masks, p: int) -> list[str]:
    """Return all words of each class as one text, p symbols each.

    The codes are the packed representatives, of period p <= 20, with their stabilisers, shape (C,) each.
    """
    sizes = SIZES[stabilisers]
    every = packed_members(codes, p, ((1 << sizes) - 1).astype(np.uint8), stabilisers)
    text = b"".join((unpack(words, p) + np.uint8(ord("0"))).tobytes() for words in every).decode("ascii")
    ends = [0, *(p * sizes.cumsum()).tolist()]
    return [text[start:end] for start, end in pairwise(ends)]


def joined_members(word: str) -> str:
    """Return all words of the class of a representative of any period as one text."""
    return "".join(members(word))


def packed_members(codes: Integers, p: int, masks: Masks, stabilisers: Masks) -> Iterator[Integers]:
    """Yield chosen words of classes as packed words, class by class in the order of their places.

    Parameters
    ----------
    codes : ndarray of int64, shape (C,)
        The packed representatives, of period p <= 20.
    masks : ndarray of uint8, shape (C,)
        Bit n is set if word n of the class is chosen.
    stabilisers : ndarray of uint8, shape (C,)
    """
    for start in range(0, len(codes), _BATCH):
        batch = slice(start, start + _BATCH)
        images = all_images(codes[batch], p)
        words = np.take_along_axis(images, ELEMENT_OF.T[:, stabilisers[batch]].astype(np.intp), axis=0)
        yield words.T[BITS_OF[masks[batch]].astype(np.bool_)]
