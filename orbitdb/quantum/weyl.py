"""The smooth part of the number of levels (Weyl's law), by parity.

A quarter of the stadium has the walls of the stadium, on which the functions are 0, and two axes, on which
they or their normal derivatives are, by parity. Perimeter terms are -length k / (4 pi) for the first kind,
+ for the second; the arc adds 1/24 for its curvature; a right angle adds 1/16 between edges of one kind, and
-1/16 between those of two (H. P. Baltes and E. R. Hilf, Spectra of Finite Systems, 1976).
"""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium

Floats = NDArray[np.float64]


class Parity(StrEnum):
    """Even or odd under x -> -x, then under y -> -y."""

    EE = "ee"
    EO = "eo"
    OE = "oe"
    OO = "oo"

    @property
    def signs(self) -> tuple[int, int]:
        """+1 for even, -1 for odd, by x and y."""
        return 1 if self.value[0] == "e" else -1, 1 if self.value[1] == "e" else -1


@dataclass(frozen=True)
class Weyl:
    """N(k) = quadratic k^2 + linear k + constant.

    Attributes
    ----------
    quadratic, linear, constant : float
    """

    quadratic: float
    linear: float
    constant: float

    @classmethod
    def of(cls, stadium: Stadium, parity: Parity | None) -> "Weyl":
        """Return it for one parity, or for all levels (None)."""
        if parity is None:
            return cls(stadium.area / (4 * math.pi), -stadium.perimeter / (4 * math.pi), 1 / 6)
        x, y = parity.signs
        edge = stadium.perimeter / 4 - x - y * (stadium.a + 1)
        corners = (x * y - x - y) / 16
        return cls(stadium.area / (16 * math.pi), -edge / (4 * math.pi), 1 / 24 + corners)

    def number(self, k: Floats) -> Floats:
        """Return the smooth number of levels below k (1/radius)."""
        return (self.quadratic * k + self.linear) * k + self.constant

    def density(self, k: Floats) -> Floats:
        """Return its derivative."""
        return 2 * self.quadratic * k + self.linear

    def wavenumber(self, number: float) -> float:
        """Return the k below which there are so many levels, roughly; 0 where there are fewer at all."""
        root = self.linear**2 - 4 * self.quadratic * (self.constant - number)
        return max(0.0, (math.sqrt(max(root, 0.0)) - self.linear) / (2 * self.quadratic))
