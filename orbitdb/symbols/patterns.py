"""Find patterns, that is factors and texts with wildcards, in many packed words at once.

The places where a pattern may continue in a word are bits, three apart like the symbols. Each symbol of the
pattern moves the sets of all words on, in a few operations on integers.
"""

from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from orbitdb.arrays import Integers, Marks, Masks
from orbitdb.symbols.symmetry import ELEMENTS, SIZES, next_symbols, packed_images
from orbitdb.symbols.words import BITS, MAX_KEYED, SYMBOLS, least_rotation

_UNITS = int("1" * MAX_KEYED, 8)


@dataclass(frozen=True)
class Factor:
    """Successive symbols of a word in some rotation.

    A factor longer than the word must fit into two rounds from the least rotation on. If a word fits, all its
    rotations do.
    """

    factor: str
    cyclic = True

    def fits(self, word: str) -> bool:
        """Tell whether a least rotation has the factor."""
        return self.factor in 2 * word

    def fitting(self, codes: Integers, p: int) -> Marks:
        """Return which packed words of period p <= `MAX_KEYED`, in any rotation, have the factor."""
        symbols = self.factor[:p]
        if len(self.factor) > p and not self.fits(least_rotation(symbols)):
            return np.zeros(len(codes), dtype=np.bool_)
        where = {symbol: _where(symbol, codes, p) for symbol in set(symbols)}
        begins = where[symbols[-1]]
        for symbol in symbols[-2::-1]:
            begins = where[symbol] & next_symbols(begins, p)
        return begins != 0


@dataclass(frozen=True)
class Like:
    """A text with wildcards: ``%`` for any number of symbols, ``_`` for one."""

    pattern: str
    wanted: bool = True  # False to find the words that do not fit
    cyclic = False

    def fits(self, word: str) -> bool:
        """Tell whether a word, as written, fits."""
        return fnmatchcase(word, self.pattern.replace("%", "*").replace("_", "?")) == self.wanted

    def fitting(self, codes: Integers, p: int) -> Marks:
        """Return which packed words of period p <= `MAX_KEYED`, as written, fit."""
        where = {symbol: _where(symbol, codes, p) for symbol in set(self.pattern) - {"%", "_"}}
        places = np.full(len(codes), 1 << BITS * p, dtype=np.int64)  # the lowest bit is after the word
        for symbol in self.pattern:
            if symbol == "%":
                _spread(places, p)
                continue
            places >>= BITS
            if symbol != "_":
                places &= where[symbol]
        return (places & 1 != 0) == self.wanted


Pattern = Factor | Like


def _where(symbol: str, codes: Integers, p: int) -> Integers:
    """Return the lowest bits of the places where packed words have a symbol."""
    if symbol not in SYMBOLS:
        return np.zeros_like(codes)
    units = np.int64(_UNITS & (1 << BITS * p) - 1)
    other = codes ^ units * int(symbol)
    return ~(other | other >> 1 | other >> 2) & units


def _spread(places: Integers, p: int) -> None:
    """Add all later places, in place."""
    step = BITS
    while step <= BITS * p:
        places |= places >> step
        step *= 2


def words_containing(codes: Integers, stabiliser: Masks, p: int, factor: str) -> Integers:
    """Count the words of each symmetry class that contain a factor, shape (N,).

    The codes are one packed word of each class, of period p <= 20, with the stabilisers of the classes. By
    definition, a word contains the factors of its code written twice. These are all factors of up to p + 1
    symbols of any rotation, and none of more than 2 p.
    """
    images = np.zeros(len(codes), dtype=np.int64)
    for image in packed_images(codes, p):
        images += Factor(factor).fitting(image, p)
    return images * SIZES[stabiliser] // len(ELEMENTS)  # each word is an image under this many elements
