"""The smooth part of the number of levels (Weyl's law), by parity.

A quarter of the stadium has the walls of the stadium, on which the functions are 0, and two axes, on which
they or their normal derivatives are, by parity. Perimeter terms are -length k / (4 pi) for the first kind,
+ for the second; the arc adds 1/24 for its curvature; a right angle adds 1/16 between edges of one kind, and
-1/16 between those of two (H. P. Baltes and E. R. Hilf, Spectra of Finite Systems, 1976).
"""

import math
from enum import StrEnum

from numpy.polynomial import Polynomial

from orbitdb.billiard.stadium import Stadium


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


def weyl(stadium: Stadium, parity: Parity | None) -> Polynomial:
    """Return the smooth number of levels below k (1/radius), of one parity or of all (None)."""
    if parity is None:
        return Polynomial([1 / 6, -stadium.perimeter / (4 * math.pi), stadium.area / (4 * math.pi)])
    x, y = parity.signs
    edge = stadium.perimeter / 4 - x - y * (stadium.a + 1)
    corners = (x * y - x - y) / 16
    return Polynomial([1 / 24 + corners, -edge / (4 * math.pi), stadium.area / (16 * math.pi)])


def wavenumber(smooth: Polynomial, number: float) -> float:
    """Return the k below which there are so many levels, roughly, or that of the fewest."""
    constant, linear, quadratic = smooth.coef.tolist()
    root = linear**2 - 4 * quadratic * (constant - number)
    return max(0.0, (math.sqrt(max(root, 0.0)) - linear) / (2 * quadratic))
