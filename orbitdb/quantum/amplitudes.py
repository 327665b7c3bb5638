"""The density of levels, of all parities or of one: its smooth part (Weyl's law) and the orbit terms.

The density d(k) is the smooth part plus the sum of Re(A exp(i k l)) over all terms, where the A are
Gutzwiller's amplitudes.

The levels of one parity are those of a quarter of the stadium. Its outer walls are Dirichlet edges; each of
its axes is a Dirichlet or a Neumann edge, depending on the parity. To the number of levels below k, a
Dirichlet edge contributes -length k / (4 pi), a Neumann edge +length k / (4 pi), the curvature of the arc
1/24, and a right angle 1/16 if its edges are of the same kind or -1/16 if they are not.

A cyclic word of length L, exponent lambda and Maslov index mu has one term for each number of repetitions
r = 1, 2, ..., with l = r L and

    A = (L / pi) exp(-i r mu pi / 2) / sqrt|det(M^r - 1)|.

The square root is 2 sinh(r lambda / 2), or 2 cosh(r lambda / 2) if r times the number of straight bounces is
odd. For one parity, a word contributes a quarter of each term. If a mirror or the half turn maps the word to
itself, half the orbit takes its place, with weight 1/2 (docs/spectrum.md).

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
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, STABILISER_OF


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


_LARGEST = 700.0
_BOTH = MIRROR_X | MIRROR_Y
SPATIAL = {
    label: [g for g in (MIRROR_X, MIRROR_Y, _BOTH) if mask >> g & 1] for label, mask in STABILISER_OF.items()
}
"""For each symmetry label, the mirrors and the half turn that map a word to itself.

These are all three if the orbit lies on the long axis of the stadium."""


class Terms(NamedTuple):
    """N terms Re(A exp(i k l)) of the density of levels.

    Attributes
    ----------
    length : ndarray, shape (N,)
        The lengths l, in units of the radius.
    amplitude : ndarray of complex128, shape (N,)
        The amplitudes A, in units of the radius.
    orbit : ndarray of int64, shape (N,)
        Index of the symmetry class, or -1 for the bouncing balls.
    repetitions : ndarray of int64, shape (N,)
        Number of traversals of the orbit or half orbit.
    parts : ndarray of int64, shape (N,)
        1 if the term belongs to a full orbit, 2 if it belongs to a half orbit.
    """

    length: Floats
    amplitude: Complexes
    orbit: Integers
    repetitions: Integers
    parts: Integers

    def rows(self, here: NDArray[np.intp] | NDArray[np.bool_]) -> "Terms":
        """Return the terms with the given indices, or those for which the given mask is true."""
        return Terms._make(values[here] for values in self)


class Classes(NamedTuple):
    """Symmetry classes of orbits; each array has one entry per class.

    Attributes
    ----------
    maslov, walls, words : ndarray of int64, shape (N,)
        Maslov index and number of straight bounces of one traversal, and number of cyclic words included.
    length, lyapunov : ndarray, shape (N,)
        Length (in units of the radius) and lambda of one traversal.
    symmetry : ndarray of str or object, shape (N,)
        Symmetry labels, as in `SPATIAL`.
    """

    maslov: Integers
    walls: Integers
    words: Integers
    length: Floats
    lyapunov: Floats
    symmetry: NDArray[np.object_]


def orbit_terms(classes: Classes, longest: float, parity: Parity | None = None) -> Terms:
    """Return the terms of the orbits and of their repetitions.

    For one parity, half orbits replace the orbits that a mirror or the half turn maps to themselves.

    Parameters
    ----------
    classes : Classes
    longest : float
        Maximum length l of a term.
    parity : Parity, optional
        Parity of the levels; by default, levels of all parities.
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

    orbit = np.concatenate([np.arange(number), np.flatnonzero(kind > 1)])  # an orbit on the axis counts twice
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
    """Return how many mirrors and half turns map each orbit to itself, and the first of them (0 if none)."""
    labels, which = np.unique(of.symmetry.astype(str), return_inverse=True)
    spatial = [SPATIAL[label] for label in labels.tolist()]
    kind = np.array([len(each) for each in spatial])[which]
    return kind, np.array([each[0] if each else 0 for each in spatial])[which]
