"""The types of arrays that all wings share."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Complexes = NDArray[np.complex128]
Marks = NDArray[np.bool_]
Places = NDArray[np.intp]
"""Indices into other arrays."""

Words = NDArray[np.uint8]
"""Symbols 0 to 5 of words, one row a word."""

Masks = NDArray[np.uint8]
"""Sets of up to eight members, a bit for each."""

Values = Floats | Sequence[Any]
"""A column: numbers with NaN, or plain values or arrays with None, for a missing value."""
