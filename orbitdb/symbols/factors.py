"""Which words contain a factor: some symbols in a row, in any rotation."""

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.symmetry import ELEMENTS, SIZES, next_symbols, packed_images
from orbitdb.symbols.words import BITS, least_rotations

Integers = NDArray[np.int64]


def words_containing(codes: Integers, stabiliser: NDArray[np.uint8], p: int, factor: str) -> Integers:
    """Count the words of symmetry classes that contain a factor.

    Parameters
    ----------
    codes : ndarray of int64, shape (N,)
        One packed word of order p <= 20 of each class.
    stabiliser : ndarray of uint8, shape (N,)
        Their stabilisers.
    p : int
    factor : str
        Symbols 0..5.

    Returns
    -------
    ndarray of int64, shape (N,)

    Notes
    -----
    As a selection has it, a word contains what its least rotation, written twice, contains. So it has every
    factor of up to p + 1 symbols that it has in any rotation, and none of more than 2 p.
    """
    images = np.zeros(len(codes), dtype=np.int64)
    if len(factor) <= 2 * p and factor[p:] == factor[: max(len(factor) - p, 0)]:
        starts = min(2 * p - len(factor) + 1, p)
        for image in packed_images(codes, p):
            images += _begins_with(image if starts == p else least_rotations(image, p), p, factor[:p], starts)
    return images * SIZES[stabiliser] // len(ELEMENTS)  # each word is the image under so many elements


def _begins_with(codes: Integers, p: int, factor: str, starts: int) -> NDArray[np.bool_]:
    """Tell which words have a factor of up to p symbols at one of their first places."""
    wanted, behind = int(factor, 8), BITS * (p - len(factor))
    found = np.zeros(len(codes), dtype=np.bool_)
    for _ in range(starts):
        found |= codes >> behind == wanted
        codes = next_symbols(codes, p)
    return found
