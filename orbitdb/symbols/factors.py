"""Which words contain a factor: some symbols in a row, in any rotation."""

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.patterns import Factor
from orbitdb.symbols.symmetry import ELEMENTS, SIZES, packed_images

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
    for image in packed_images(codes, p):
        images += Factor(factor).fitting(image, p)
    return images * SIZES[stabiliser] // len(ELEMENTS)  # each word is the image under so many elements
