"""Parities of waves, and Weyl's law: the smooth number of levels below k, of all parities or of one.

The levels of one parity are those of a quarter of the stadium. Its outer walls are Dirichlet edges; each of
its axes is a Dirichlet or a Neumann edge, depending on the parity. To the number of levels below k, a
Dirichlet edge contributes -length k / (4 pi), a Neumann edge +length k / (4 pi), the curvature of the arc
1/24, and a right angle 1/16 if its edges are of the same kind or -1/16 if they are not.

Source: H. P. Baltes and E. R. Hilf, Spectra of Finite Systems (1976).
"""

import math
from collections.abc import Iterable
from enum import StrEnum

from numpy.polynomial import Polynomial

from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError


class Parity(StrEnum):
    """Parity of a wave: even or odd under x -> -x (first letter) and under y -> -y (second letter)."""

    EE = "ee"
    EO = "eo"
    OE = "oe"
    OO = "oo"

    @property
    def signs(self) -> tuple[int, int]:
        """Signs by which x -> -x and y -> -y multiply the wave: +1 if it is even, -1 if it is odd."""
        return 1 if self.value[0] == "e" else -1, 1 if self.value[1] == "e" else -1


def parities_of(names: "Parity | str | Iterable[Parity | str] | None" = None) -> list[Parity]:
    """Return parities without repetitions, from a name, several separated by commas, or a sequence.

    None stands for all four.

    Raises
    ------
    InputError
        If one of them is not ``ee``, ``eo``, ``oe`` or ``oo``.
    """
    if names is None:
        return list(Parity)
    given = names.split(",") if isinstance(names, str) else list(names)
    try:
        return list(dict.fromkeys(Parity(name.strip()) for name in given))
    except (ValueError, AttributeError):
        raise InputError(f"parity {names!s:.40}: use ee, eo, oe or oo") from None


def one_parity(name: "Parity | str | None") -> Parity | None:
    """Return the parity with a name, or None for None; raise `InputError` for several or another name."""
    if name is None:
        return None
    first, *others = parities_of(name)
    if others:
        raise InputError(f"parity {name}: give one parity, or none for the levels of all parities")
    return first


def weyl(stadium: Stadium, parity: Parity | None) -> Polynomial:
    """Return Weyl's law, the smooth number of levels below k (in 1/radius), as a polynomial in k.

    It counts the levels of the given parity, or all levels if the parity is None.
    """
    if parity is None:
        return Polynomial([1 / 6, -stadium.perimeter / (4 * math.pi), stadium.area / (4 * math.pi)])
    x, y = parity.signs
    edge = stadium.perimeter / 4 - x - y * (stadium.a + 1)
    corners = (x * y - x - y) / 16
    return Polynomial([1 / 24 + corners, -edge / (4 * math.pi), stadium.area / (16 * math.pi)])


def wavenumber(smooth: Polynomial, number: float) -> float:
    """Return the k at which the smooth number of levels reaches `number`.

    If the smooth number is larger at every k, return the k >= 0 at which it has its minimum.
    """
    constant, linear, quadratic = smooth.coef.tolist()
    root = linear**2 - 4 * quadratic * (constant - number)
    return max(0.0, (math.sqrt(max(root, 0.0)) - linear) / (2 * quadratic))
