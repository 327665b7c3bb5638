"""Find patterns, that is factors and texts with wildcards, in many packed words at once.

The positions at which the rest of a pattern may continue in a word are stored as bits, three apart like the
symbols. Each symbol of the pattern moves these sets of positions, for all words together, with a few integer
operations.
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
    """Successive symbols of a cyclic word.

    A factor longer than the word must fit into two rounds of its least rotation. A factor that fits a word
    fits all rotations of the word.
    """

    factor: str
    cyclic = True

    def fits(self, word: str) -> bool:
        """Tell whether a word, given as its least rotation, contains the factor."""
        return self.factor in 2 * word

    def fitting(self, codes: Integers, p: int) -> Marks:
        """Tell which packed words of period p <= `MAX_KEYED`, in any rotation, contain the factor."""
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
    """A pattern with the wildcards ``%`` for any number of symbols and ``_`` for one symbol."""

    pattern: str
    wanted: bool = True  # False to find the words that do not match
    cyclic = False

    def fits(self, word: str) -> bool:
        """Tell whether a word, as written, matches; if `wanted` is false, whether it does not."""
        return fnmatchcase(word, self.pattern.replace("%", "*").replace("_", "?")) == self.wanted

    def fitting(self, codes: Integers, p: int) -> Marks:
        """Apply `fits` to packed words of period p <= `MAX_KEYED`, as written."""
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
    """Return, as sets of bits, the positions at which packed words have the given symbol."""
    if symbol not in SYMBOLS:
        return np.zeros_like(codes)
    units = np.int64(_UNITS & (1 << BITS * p) - 1)
    other = codes ^ units * int(symbol)
    return ~(other | other >> 1 | other >> 2) & units


def _spread(places: Integers, p: int) -> None:
    """Add all later positions to sets of positions, in place."""
    step = BITS
    while step <= BITS * p:
        places |= places >> step
        step *= 2


def words_containing(codes: Integers, stabiliser: Masks, p: int, factor: str) -> Integers:
    """Count the words of each symmetry class that contain a factor, shape (N,).

    `codes` contains one packed word of each class, of period p <= 20, and `stabiliser` the stabilisers of the
    classes. A word is said to contain the factors of its code written twice. These include every factor of up
    to p + 1 symbols of any rotation, and none of more than 2 p symbols.
    """
    images = np.zeros(len(codes), dtype=np.int64)
    for image in packed_images(codes, p):
        images += Factor(factor).fitting(image, p)
    return images * SIZES[stabiliser] // len(ELEMENTS)  # each word is an image under 8 / size elements
