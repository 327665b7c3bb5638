"""The density of levels: its smooth part (Weyl's law) and the terms of orbits, for all levels or one parity.

d(k) is the smooth density plus the sum of Re(A exp(i k l)) over all terms, with Gutzwiller's amplitudes A.

A quarter of the stadium has Dirichlet outer walls, and axes that are Dirichlet or Neumann by parity. An edge
adds -length k / (4 pi) if it is Dirichlet, + if it is Neumann. The curvature of the arc adds 1/24. A right
angle adds 1/16 between edges of the same kind and -1/16 between edges of different kinds.

A cyclic word of length L, exponent lambda and Maslov index mu has terms for r = 1, 2, ... with l = r L and

    A = (L / pi) exp(-i r mu pi / 2) / sqrt|det(M^r - 1)|.

The root is 2 sinh(r lambda / 2), or 2 cosh(r lambda / 2) if r times the number of walls is odd. For one
parity a word counts as a quarter; if a symmetry maps it to itself, half the orbit counts (docs/spectrum.md).

Sources: M. C. Gutzwiller, J. Math. Phys. 12 (1971) 343; J. M. Robbins, Phys. Rev. A 40 (1989) 2128;
H. P. Baltes and E. R. Hilf, Spectra of Finite Systems (1976).
"""

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from orbitdb.arrays import Complexes, Floats, Integers
from orbitdb.billiard.stadium import Stadium
from orbitdb.symbols.members import STABILISER_OF
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y


class Parity(StrEnum):
    """Even or odd under x -> -x, then under y -> -y."""

    EE = "ee"
    EO = "eo"
    OE = "oe"
    OO = "oo"

    @property
    def signs(self) -> tuple[int, int]:
        """Signs under x -> -x and y -> -y: +1 for even, -1 for odd."""
        return 1 if self.value[0] == "e" else -1, 1 if self.value[1] == "e" else -1


def weyl(stadium: Stadium, parity: Parity | None) -> Polynomial:
    """Return the smooth number of levels below k (1/radius) as a polynomial, for one parity or all (None)."""
    if parity is None:
        return Polynomial([1 / 6, -stadium.perimeter / (4 * math.pi), stadium.area / (4 * math.pi)])
    x, y = parity.signs
    edge = stadium.perimeter / 4 - x - y * (stadium.a + 1)
    corners = (x * y - x - y) / 16
    return Polynomial([1 / 24 + corners, -edge / (4 * math.pi), stadium.area / (16 * math.pi)])


def wavenumber(smooth: Polynomial, number: float) -> float:
    """Return the k at which the smooth number of levels reaches `number`, or is least if always above it."""
    constant, linear, quadratic = smooth.coef.tolist()
    root = linear**2 - 4 * quadratic * (constant - number)
    return max(0.0, (math.sqrt(max(root, 0.0)) - linear) / (2 * quadratic))


_LARGEST = 700.0
_BOTH = MIRROR_X | MIRROR_Y
SPATIAL = {
    label: [g for g in (MIRROR_X, MIRROR_Y, _BOTH) if mask >> g & 1] for label, mask in STABILISER_OF.items()
}
"""By symmetry label, the spatial elements that map a word to itself; all three for an orbit on the axis."""


class Terms(NamedTuple):
    """Terms Re(A exp(i k l)) of the density of levels.

    Attributes
    ----------
    length : ndarray, shape (N,)
        l, in units of the radius.
    amplitude : ndarray of complex128, shape (N,)
        A, in units of the radius.
    orbit : ndarray of int64, shape (N,)
        Index of the class; -1 for the bouncing balls.
    repetitions : ndarray of int64, shape (N,)
        Number of traversals of the orbit or half orbit.
    parts : ndarray of int64, shape (N,)
        1 for an orbit, 2 for a half orbit.
    """

    length: Floats
    amplitude: Complexes
    orbit: Integers
    repetitions: Integers
    parts: Integers

    def rows(self, here: NDArray[np.intp] | NDArray[np.bool_]) -> "Terms":
        """Return the chosen terms."""
        return Terms._make(values[here] for values in self)


class Classes(NamedTuple):
    """Symmetry classes of orbits, one entry per class.

    Attributes
    ----------
    maslov, walls, words : ndarray of int64, shape (N,)
        Maslov index and straight bounces of one traversal, and the number of cyclic words to count.
    length, lyapunov : ndarray, shape (N,)
    symmetry : ndarray of str or object, shape (N,)
        Symmetry labels.
    """

    maslov: Integers
    walls: Integers
    words: Integers
    length: Floats
    lyapunov: Floats
    symmetry: NDArray[np.object_]


def orbit_terms(classes: Classes, longest: float, parity: Parity | None = None) -> Terms:
    """Return the terms of orbits and their repetitions, or of half orbits for one parity.

    Parameters
    ----------
    classes : Classes
    longest : float
        Largest length of a term.
    parity : Parity, optional
        All levels by default.
    """
    number = len(classes.length)
    kind, g = np.zeros((2, number), np.int64) if parity is None else _spatial(classes)
    x, y = (1, 1) if parity is None else parity.signs
    halved = kind > 0
    parts = np.where(halved, 2, 1)
    length, lyapunov, maslov = classes.length / parts, classes.lyapunov / parts, classes.maslov // parts
    weight = classes.words / (1 if parity is None else np.where(halved, 2, 4))
    turned = (classes.walls // 2 + (g != _BOTH)) % 2 == 1
    negative = np.where(halved, turned, classes.walls % 2 == 1)
    sign = np.array([1, x, y, x * y])[g]

    orbit = np.concatenate([np.arange(number), np.flatnonzero(kind > 1)])  # two sides on the axis
    times = (longest // length[orbit]).astype(np.int64)
    other_side = np.repeat(np.arange(len(orbit)) >= number, times)
    r = np.arange(1, times.sum() + 1) - np.repeat(np.cumsum(times) - times, times)
    orbit = np.repeat(orbit, times)
    phase = np.array([1, -1j, -1, 1j])[r * maslov[orbit] % 4]
    half = np.minimum(r * lyapunov[orbit] / 2, _LARGEST)
    cosh = (negative[orbit] & (r % 2 == 1)) ^ other_side
    root = np.where(cosh, 2 * np.cosh(half), 2 * np.sinh(half))
    size = weight[orbit] * length[orbit] / (math.pi * root) * np.where(other_side, y, 1)
    return Terms(r * length[orbit], phase * (sign[orbit] ** r * size), orbit, r, parts[orbit])


def _spatial(of: Classes) -> tuple[Integers, Integers]:
    """Return the number of spatial elements that map each orbit to itself, and the first of them (or 0)."""
    labels, which = np.unique(of.symmetry.astype(str), return_inverse=True)
    spatial = [SPATIAL[label] for label in labels.tolist()]
    kind = np.array([len(each) for each in spatial])[which]
    return kind, np.array([each[0] if each else 0 for each in spatial])[which]
