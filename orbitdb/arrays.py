"""The types of arrays that the whole package uses."""

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
"""Symbols 0 to 5 of words, one row per word."""

Masks = NDArray[np.uint8]
"""Sets of up to eight members, one bit per member."""

Values = Floats | Sequence[Any]
"""A column: numbers, with NaN for a missing one, or any values, with None for a missing one."""
