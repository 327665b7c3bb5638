"""The symmetries of the stadium: C2v and time reversal, acting on words and on coordinates.

The eight elements are the products of three commuting involutions: the mirror ``x`` -> -x (exchanging left
and right), the mirror ``y`` -> -y (exchanging up and down), and time reversal ``T``. An element is stored as
a bit mask (x = 1, y = 2, T = 4). The product of two elements is then their exclusive or, and each element is
its own inverse.

The words of a class are numbered from 0, starting with the representative (the identity). Each of the other
words belongs to the first element that maps the representative to it, and the words are sorted by these
elements. Word n belongs to element `ELEMENT_OF[stabiliser, n]`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers, Masks, Words
from orbitdb.billiard.stadium import STRAIGHT
from orbitdb.symbols.words import (
    BITS,
    MAX_KEYED,
    SYMBOLS,
    from_strings,
    least_rotation,
    least_rotations,
    symbols_after,
    symbols_before,
    to_strings,
    unpack,
)

MIRROR_X, MIRROR_Y, REVERSE = 1, 2, 4
ELEMENTS = range(8)
NAMES = ("e", "x", "y", "xy", "T", "xT", "yT", "xyT")

GROUPS = tuple(
    mask
    for mask in range(1, 1 << len(ELEMENTS))
    for held in [[g for g in ELEMENTS if mask >> g & 1]]
    if {g ^ h for g in held for h in held} == set(held)
)
"""All possible stabilisers, that is, the masks of all subgroups."""

ODD = tuple(g for g in ELEMENTS if g.bit_count() % 2)
"""The elements that change the sign of an enclosed area: x, y, T and xyT."""

_LONE = np.array([0, 6, 2, 7, 4, 5], dtype=np.uint8)
"""Symbols of single bounces: on the left and right semicircle, 6 and 7 replace 1 and 3."""

_MIRRORED = np.array([0, 3, 2, 1, 5, 4, 7, 6], dtype=np.uint8)
_SWAPPED_WALLS = np.array([2, 1, 0, 3, 4, 5, 6, 7], dtype=np.uint8)
_SWAPPED_SENSE = np.array([0, 4, 2, 5, 1, 3, 6, 7], dtype=np.uint8)
_UNITS = np.int64(int("1" * MAX_KEYED, 8))
"""The lowest bit of each symbol of a packed word."""

_WRITTEN = np.array([0, 1, 2, 3, 4, 5, 1, 3], dtype=np.uint8)


def _table(element: int) -> Words:
    """Return the image of each symbol under one element, with 6 and 7 for single bounces."""
    image = np.arange(8, dtype=np.uint8)
    if bool(element & MIRROR_Y) != bool(element & REVERSE):
        image = _SWAPPED_SENSE[image]
    if element & MIRROR_Y:
        image = _SWAPPED_WALLS[image]
    if element & MIRROR_X:
        image = _MIRRORED[image]
    return _WRITTEN[image]


_TABLES = np.array([_table(element) for element in ELEMENTS])


def act_on_words(element: int, words: Words) -> Words:
    """Return the images of words, shape (N, p), under one element, reversed if it includes time reversal.

    Bounce n of the word becomes bounce n of its image, or bounce p - 1 - n under time reversal. Both the
    mirror ``y`` and time reversal change the sense of a run, 1 <-> 4 and 3 <-> 5, but a single bounce on a
    semicircle is always written as 1 or 3.
    """
    image = _TABLES[element][_lone_apart(words)]
    return image[:, ::-1] if element & REVERSE else image


def _lone_apart(words: Words) -> Words:
    """Return words, shape (N, p), with other symbols for single bounces on a semicircle."""
    same = (words == symbols_before(words)) | (words == symbols_after(words))
    return np.where(same, words, _LONE[words])


def act_on_coordinates(element: int, words: Words, coordinates: Floats) -> Floats:
    """Return the coordinates of the images of orbits under one element, shape (N, p).

    The arguments are the words and coordinates of the original orbits. The coordinates of the images are in
    the order of the symbols of ``act_on_words(element, words)``.
    """
    straight = STRAIGHT[words]
    flips = (straight & bool(element & MIRROR_X)) | (~straight & bool(element & MIRROR_Y))
    image = np.where(flips, -coordinates, coordinates)
    return image[:, ::-1] if element & REVERSE else image


def act_on_area(element: int, area: float) -> float:
    """Return the area that the image of an orbit under an element encloses."""
    return 0.0 - area if element in ODD else area  # not -area, so that 0 has no sign


def encloses_nothing(stabilisers: Masks) -> NDArray[np.bool_]:
    """Tell which orbits an element that changes the sign of their area maps to themselves, shape (N,)."""
    return stabilisers & np.uint8(sum(1 << g for g in ODD)) > 0


def image_coordinates(
    words: Sequence[str], least: Sequence[str], element: int, coordinates: Floats
) -> Floats:
    """Return the coordinates of the images of N orbits in given rotations, shape (N, p).

    Parameters
    ----------
    words : sequence of str
        For each image, its word in the rotation in which to return its coordinates.
    least : sequence of str
        The words of the orbits.
    element : int
        The element that maps the orbits to their images.
    coordinates : ndarray, shape (N, p)
        The coordinates of the orbits, in the order of ``least``.

    Raises
    ------
    ValueError
        If a word is not a rotation of the image.
    """
    symbols = from_strings(least)
    pairs = zip(to_strings(act_on_words(element, symbols)), words, strict=True)
    shift = np.array([(2 * image).index(word) for image, word in pairs])[:, None]
    turned, p = act_on_coordinates(element, symbols, coordinates), symbols.shape[1]
    return np.take_along_axis(turned, (shift + np.arange(p)) % p, axis=1)


class Classes(NamedTuple):
    """The symmetry classes of N cyclic words, as arrays of shape (N,)."""

    representative: Integers  # the packed representatives
    element: NDArray[np.uint8]  # the first element that maps the representative to the word
    stabiliser: Masks  # bit g is set if element g maps the cyclic word to itself


def classify(codes: Integers, p: int) -> Classes:
    """Find the symmetry class of each packed primitive code, of period p <= 20."""
    images = all_images(codes, p)
    stabiliser = np.packbits(images == codes, axis=0, bitorder="little")[0]
    return Classes(images.min(axis=0), images.argmin(axis=0).astype(np.uint8), stabiliser)


def all_images(codes: Integers, p: int) -> Integers:
    """Return the images of packed codes, p <= 20, under the eight elements, again as codes, shape (8, N)."""
    return np.stack([codes, *(least_rotations(image, p) for image in packed_images(codes, p)[1:])])


def packed_images(codes: Integers, p: int) -> list[Integers]:
    """Return the images of packed words, p <= 20, under the eight elements in order, without rotation."""
    images: list[Integers] = []
    for one in (codes, reversed_words(codes, p)):
        sense, walls = _changes(one, p)
        forth = (one ^ sense, one ^ walls) if images else (one, one ^ sense ^ walls)
        images += [image for plain in forth for image in (plain, mirrored(plain))]
    return images


def mirrored(codes: Integers) -> Integers:
    """Return the images of packed words under the mirror x: 1 <-> 3 and 4 <-> 5."""
    high, low = (codes >> 2) & _UNITS, codes & _UNITS
    return codes ^ high ^ ((low & ~high) << 1)


def _changes(codes: Integers, p: int) -> tuple[Integers, Integers]:
    """Return the bits of packed words that flip if runs change their sense, and if 0 and 2 are exchanged.

    A change of sense means 1 = 001 <-> 4 = 100 and 3 = 011 <-> 5 = 101, except for single bounces.
    """
    units = _UNITS & ((np.int64(1) << BITS * p) - 1)
    low, middle, high = (codes >> place & units for place in range(BITS))
    curved = low | high
    top = BITS * (p - 1)
    change = codes ^ ((codes & ((np.int64(1) << top) - 1)) << BITS | codes >> top)  # from the next symbol
    ends = (change | change >> 1 | change >> 2) & units
    single = ends & (ends >> BITS | (ends & 1) << top) & ~high
    run, right = curved & ~single, low & (high | middle)
    return run << 2 | (run & right) << 1 | run & ~right, (curved ^ units) << 1


def reversed_words(codes: Integers, p: int) -> Integers:
    """Return packed words of period p with their symbols reversed."""
    back = codes & 7
    for place in range(1, p):
        back <<= BITS
        back |= codes >> BITS * place & 7
    return back


@dataclass(frozen=True)
class SymmetryClass:
    """The symmetry class of a cyclic word."""

    representative: str  # the least of all rotations of all images
    element: int  # the first element that maps the representative to the word
    stabiliser: int  # bit mask of the elements that map the cyclic word to itself
    words: tuple[str, ...]  # all words of the class, as least rotations, in their order


def class_of(word: str) -> SymmetryClass:
    """Find the symmetry class of a primitive word of any period, in any rotation."""
    images = [least_rotation(image) for image in images_of(word)]
    representative = min(images)
    stabiliser = sum(1 << g for g in ELEMENTS if images[g] == images[0])
    element = images.index(representative)
    words = tuple(dict.fromkeys(images[element ^ g] for g in ELEMENTS))
    return SymmetryClass(representative, element, stabiliser, words)


def images_of(word: str) -> list[str]:
    """Return the images of a word under the eight elements, in order and not rotated."""
    images = _TABLES[:, _lone_apart(from_strings([word]))[0]]
    return [text[::-1] if g & REVERSE else text for g, text in enumerate(to_strings(images))]


def images_of_pattern(pattern: str) -> set[str]:
    """Return the images of a pattern; each image of a cyclic word that contains it contains one of them.

    There are more than eight, because the symbols beside a pattern tell whether a bounce at its end belongs
    to a run.
    """
    enclosed = from_strings([left + pattern + right for left in SYMBOLS for right in SYMBOLS])
    return {image[1:-1] for g in ELEMENTS for image in to_strings(act_on_words(g, enclosed))}


def members(word: str) -> dict[str, int]:
    """Return the distinct images of a word as least rotations, and the first element leading to each."""
    elements: dict[str, int] = {}
    for g, image in enumerate(images_of(word)):
        elements.setdefault(least_rotation(image), g)
    return elements


def class_size(stabiliser: int) -> int:
    """Return the number of distinct cyclic words in the class of a word with the given stabiliser."""
    return len(ELEMENTS) // stabiliser.bit_count()


SIZES = np.array([class_size(mask) if mask else 0 for mask in range(1 << len(ELEMENTS))])
"""`class_size` of each stabiliser; 0 for the mask 0, which is not a group."""


def label(stabiliser: int) -> str:
    """Return the elements of a stabiliser except the identity, such as ``x,T,xT``, or ``1`` if none."""
    return ",".join(NAMES[g] for g in ELEMENTS[1:] if stabiliser >> g & 1) or "1"


def half_of(symmetry: str) -> str | None:
    """Return the element that makes the second half of an orbit the image of the first, given its label."""
    elements = symmetry.split(",")
    return next((name for name in ("x", "y", "xy") if name in elements), None)


QUARTER_SIGNS = {
    None: (1, 1, 1, 1),
    "x": (1, 1, -1, -1),
    "y": (1, -1, 1, -1),
    "xy": (1, -1, -1, 1),
}
"""For each `half_of`, the signs by which it multiplies waves of the parities ee, eo, oe and oo."""

AXIS = "13"
"""The word of the orbit along the long axis, the only one that both mirrors map to itself."""


def smallest_group(elements: Iterable[int]) -> int:
    """Return the mask of the smallest group that contains the given elements."""
    held = sum(1 << g for g in set(elements))
    return min(mask for mask in GROUPS if mask & held == held)  # it is a subset of all others


def time_reversal(stabiliser: int) -> str:
    """Return ``self`` if the orbit retraces its path, ``pair`` if its reverse is another word."""
    return "self" if stabiliser >> REVERSE & 1 else "pair"


_BATCH = 1 << 14
"""Number of classes treated at once; they fit into the processor's cache."""


def _elements() -> NDArray[np.uint8]:
    table = np.zeros((256, len(ELEMENTS)), dtype=np.uint8)
    for mask in GROUPS:
        kept = [s for s in ELEMENTS if mask >> s & 1]
        table[mask, : SIZES[mask]] = [g for g in ELEMENTS if g == min(g ^ s for s in kept)]
    return table


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
