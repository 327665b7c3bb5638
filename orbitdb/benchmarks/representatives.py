"""One word a symmetry class: what benchmarks solve."""

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.enumeration import admissible_words
from orbitdb.symbols.symmetry import ELEMENTS, classify
from orbitdb.symbols.words import pack

Words = NDArray[np.uint8]


def representatives(p: int) -> tuple[Words, NDArray[np.int64]]:
    """Return the admissible classes of order p: least words, shape (N, p), and class sizes, shape (N,)."""
    words = np.concatenate(list(admissible_words(p)))
    classes = classify(words)
    least = classes.representative == pack(words)
    return words[least], len(ELEMENTS) // np.bitwise_count(classes.stabiliser[least]).astype(np.int64)
