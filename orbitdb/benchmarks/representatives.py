"""One word a symmetry class: what benchmarks solve."""

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import all_least_words
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import unpack


def representatives(p: int) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """Return the admissible classes of order p: least words, shape (N, p), and class sizes, shape (N,)."""
    found = all_least_words(Span.whole(p))
    return unpack(found.codes, p), SIZES[found.stabiliser]
