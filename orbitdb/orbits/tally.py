"""Counts of what becomes of words."""

from collections.abc import Iterable
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.orbits.sums import Exponents


@dataclass(frozen=True)
class Tally:
    """How many words have become what.

    Attributes
    ----------
    words : int
        All admissible words that were looked at.
    n_c : int
        Those that are orbits.
    classes : int
        Symmetry classes of the orbits.
    boundary, unresolved : int
        Words of these statuses. All others are dynamical.
    """

    words: int = 0
    n_c: int = 0
    classes: int = 0
    boundary: int = 0
    unresolved: int = 0

    @classmethod
    def of(cls, sizes: NDArray[np.int64], found: Iterable[Exponents]) -> "Tally":
        """Count over classes of some sizes."""
        parts = [
            (
                int(sizes[part.orbits].sum()),
                len(part.orbits),
                int(sizes[part.boundary].sum()),
                int(sizes[part.unresolved].sum()),
            )
            for part in found
        ]
        return cls(int(sizes.sum()), *(sum(column) for column in zip(*parts, strict=True)))

    def __add__(self, other: "Tally") -> "Tally":
        return Tally(*(one + more for one, more in zip(astuple(self), astuple(other), strict=True)))
