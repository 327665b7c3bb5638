"""All the words of symmetry classes, found from their representatives.

The words of a class are numbered from 0, starting with the representative (the identity). Each of the other
words belongs to the first element that maps the representative to it, and the words are sorted by these
elements. Word n belongs to element `ELEMENT_OF[stabiliser, n]`.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Integers, Masks
from orbitdb.symbols.symmetry import ELEMENTS, GROUPS, SIZES, all_images, label, members
from orbitdb.symbols.words import unpack

_BATCH = 1 << 14
"""Number of classes treated at once; they fit into the processor's cache."""


def _elements() -> NDArray[np.uint8]:
    found = np.zeros((256, len(ELEMENTS)), dtype=np.uint8)
    for mask in GROUPS:
        kept = [s for s in ELEMENTS if mask >> s & 1]
        found[mask, : SIZES[mask]] = [g for g in ELEMENTS if g == min(g ^ s for s in kept)]
    return found


ELEMENT_OF = _elements()
"""For each stabiliser, the element that maps the representative to each word of its class, shape (256, 8)."""

STABILISER_OF = {label(mask): mask for mask in GROUPS}
"""The stabiliser with each symmetry label."""

ELEMENT_ROWS = [
    (label(mask), n, int(ELEMENT_OF[mask, n])) for mask in GROUPS for n in range(int(SIZES[mask]))
]
"""The rows of the table ``element``: symmetry label, n, and the element that leads to word n."""

BITS_OF = np.arange(256, dtype=np.uint8)[:, None] >> np.arange(8, dtype=np.uint8) & 1
"""The bits of each byte, lowest first, shape (256, 8)."""


def places_of_elements(elements: Masks, stabilisers: Masks) -> Masks:
    """Convert sets of elements, shape (C,), to sets of words of the classes.

    Bit g of the argument stands for the image under element g, bit n of the result for word n. Bits beyond
    the size of the class have no meaning.
    """
    places = np.zeros_like(elements)
    for n in ELEMENTS:
        places |= (elements >> ELEMENT_OF[stabilisers, n] & 1) << np.uint8(n)
    return places


def joined_words(codes: Integers, stabilisers: Masks, p: int) -> list[str]:
    """Return all words of each class as a single string, with p symbols for each word.

    `codes` contains the packed representatives, of period p <= 20, and `stabilisers` their stabilisers, each
    of shape (C,).
    """
    sizes = SIZES[stabilisers]
    every = packed_members(codes, p, ((1 << sizes) - 1).astype(np.uint8), stabilisers)
    text = b"".join((unpack(words, p) + np.uint8(ord("0"))).tobytes() for words in every).decode("ascii")
    ends = [0, *(p * sizes.cumsum()).tolist()]
    return [text[start:end] for start, end in pairwise(ends)]


def joined_members(word: str) -> str:
    """Return all words of a class, concatenated. The representative may be too long to pack."""
    return "".join(members(word))


def packed_members(codes: Integers, p: int, masks: Masks, stabilisers: Masks) -> Iterator[Integers]:
    """Yield the chosen words of classes as packed words, class by class and in order within each class.

    Parameters
    ----------
    codes : ndarray of int64, shape (C,)
        The packed representatives, of period p <= 20.
    masks : ndarray of uint8, shape (C,)
        Bit n is set if word n of the class is chosen.
    stabilisers : ndarray of uint8, shape (C,)
        The stabilisers of the classes.
    """
    for start in range(0, len(codes), _BATCH):
        batch = slice(start, start + _BATCH)
        images = all_images(codes[batch], p)
        words = np.take_along_axis(images, ELEMENT_OF.T[:, stabilisers[batch]].astype(np.intp), axis=0)
        yield words.T[BITS_OF[masks[batch]].astype(np.bool_)]
