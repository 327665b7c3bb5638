"""Gutzwiller's trace formula: the terms of the periodic orbits.

The density of levels d(k) is its smooth part (`orbitdb.quantum.weyl`) plus the sum of Re(A exp(i k l)) over
all terms, where the A are Gutzwiller's amplitudes. The bouncing balls add terms of their own
(`orbitdb.quantum.bouncing_balls`).

A cyclic word of length L, exponent lambda and Maslov index mu has one term for each number of repetitions
r = 1, 2, ..., with l = r L and

    A = (L / pi) exp(-i r mu pi / 2) / sqrt|det(M^r - 1)|.

The square root is 2 sinh(r lambda / 2), or 2 cosh(r lambda / 2) if r times the number of straight bounces is
odd. For one parity, a word contributes a quarter of each term. If a mirror or the half turn maps the word to
itself, half the orbit takes its place, with weight 1/2 (docs/spectrum.md).

Sources: M. C. Gutzwiller, J. Math. Phys. 12 (1971) 343; J. M. Robbins, Phys. Rev. A 40 (1989) 2128.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Complexes, Floats, Integers
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.quantum.weyl import Parity
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, STABILISER_OF

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
    maslov : ndarray of int64, shape (N,)
        Maslov index of all these traversals; -1 for the bouncing balls, which have none.
    lyapunov : ndarray, shape (N,)
        Lambda of all these traversals; NaN for the bouncing balls, which are not isolated.
    """

    length: Floats
    amplitude: Complexes
    orbit: Integers
    repetitions: Integers
    parts: Integers
    maslov: Integers
    lyapunov: Floats

    @property
    def sign(self) -> Integers:
        """The sign with which A is |A| exp(-i maslov pi / 2): the product of the signs chi of the parity."""
        turned = np.array([1, 1j, -1, -1j])[self.maslov % 4] * self.amplitude
        return np.where(turned.real < 0, -1, 1)

    def rows(self, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> "Terms":
        """Return the terms with the given indices, or those for which the given mask is true."""
        return Terms._make(values[chosen] for values in self)


def orbit_terms(classes: OrbitClasses, longest: float, parity: Parity | None = None) -> Terms:
    """Return the terms of the orbits and of their repetitions.

    `longest` is the maximum length l of a term. For one parity, half orbits replace the orbits that a mirror
    or the half turn maps to themselves.
    """
    number = len(classes)
    kind, g = np.zeros((2, number), np.int64) if parity is None else _spatial(classes)
    x, y = (1, 1) if parity is None else parity.signs
    halved = kind > 0
    parts = np.where(halved, 2, 1)
    length, lyapunov, maslov = classes.length / parts, classes.lyapunov / parts, classes.maslov // parts
    weight = classes.words / (1 if parity is None else np.where(halved, 2, 4))
    turned = (classes.walls // 2 + (g != _BOTH)) % 2 == 1
    negative = np.where(halved, turned, classes.negative)
    sign = np.array([1, x, y, x * y])[g]

    orbit = np.concatenate([np.arange(number), np.flatnonzero(kind > 1)])  # an orbit on the axis counts twice
    times = (longest // length[orbit]).astype(np.int64)
    other_side = np.repeat(np.arange(len(orbit)) >= number, times)
    r = np.arange(1, times.sum() + 1) - np.repeat(np.cumsum(times) - times, times)
    orbit = np.repeat(orbit, times)
    index = r * maslov[orbit]
    phase = np.array([1, -1j, -1, 1j])[index % 4]
    grown = r * lyapunov[orbit]
    half = np.minimum(grown / 2, _LARGEST)
    cosh = (negative[orbit] & (r % 2 == 1)) ^ other_side
    root = np.where(cosh, 2 * np.cosh(half), 2 * np.sinh(half))
    size = weight[orbit] * length[orbit] / (math.pi * root) * np.where(other_side, y, 1)
    if classes.joints is not None:
        size = size * 0.5 ** (r * classes.joints[orbit] / parts[orbit])
    amplitude = phase * (sign[orbit] ** r * size)
    return Terms(r * length[orbit], amplitude, orbit, r, parts[orbit], index, grown)


def largest_amplitude(exponent: float, longest: float, parity: Parity | None = None) -> float:
    """Bound the moduli of the terms of classes whose lambda is at least `exponent`, up to a length.

    A class has at most eight words, so at most two orientations in the quarter stadium, where lambda may be
    half as large.
    """
    words, least = (8, exponent) if parity is None else (2, exponent / 2)
    return words * longest / (2 * math.pi * math.sinh(least / 2))


def _spatial(of: OrbitClasses) -> tuple[Integers, Integers]:
    """Return how many mirrors and half turns map each orbit to itself, and the first of them (0 if none)."""
    assert of.symmetry is not None
    labels, which = np.unique(of.symmetry.astype(np.dtypes.StringDType()), return_inverse=True)
    spatial = [SPATIAL[label] for label in labels.tolist()]
    kind = np.array([len(elements) for elements in spatial])[which]
    return kind, np.array([elements[0] if elements else 0 for elements in spatial])[which]
