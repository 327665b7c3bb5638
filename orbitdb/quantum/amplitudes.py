"""What an orbit contributes to the density of levels: Gutzwiller's amplitudes, whole and by parity.

d(k) is the smooth density plus the sum of Re(A exp(i k l)) over all terms. A cyclic word of length L,
exponent lambda and Maslov index mu has, for r = 1, 2, ..., l = r L and

    A = (L / pi) exp(-i r mu pi / 2) / sqrt|det(M^r - 1)|.

The root is 2 sinh(r lambda / 2), or 2 cosh(r lambda / 2) where r times the number of walls is odd. Among the
levels of one parity a word counts for a quarter, unless an element g of the stadium's symmetries maps it to
itself: then half the orbit counts (docs/spectrum.md).

Sources: M. C. Gutzwiller, J. Math. Phys. 12 (1971) 343; J. M. Robbins, Phys. Rev. A 40 (1989) 2128.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.quantum.weyl import Parity
from orbitdb.symbols.members import STABILISER_OF
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Complexes = NDArray[np.complex128]

_LARGEST = 700.0
_BOTH = MIRROR_X | MIRROR_Y
SPATIAL = {
    label: [g for g in (MIRROR_X, MIRROR_Y, _BOTH) if mask >> g & 1] for label, mask in STABILISER_OF.items()
}
"""By symmetry label, the elements without time reversal that map a word to itself; all three: on the axis."""


class Terms(NamedTuple):
    """Terms Re(A exp(i k l)) of the density of levels.

    Attributes
    ----------
    length : ndarray, shape (N,)
        l, in units of the radius.
    amplitude : ndarray of complex128, shape (N,)
        A, in units of the radius.
    orbit : ndarray of int64, shape (N,)
        Which of the classes a term is of; -1 for none.
    repetitions : ndarray of int64, shape (N,)
        How often the orbit, or half of it, is gone round.
    """

    length: Floats
    amplitude: Complexes
    orbit: Integers
    repetitions: Integers

    def rows(self, here: NDArray[np.intp] | NDArray[np.bool_]) -> "Terms":
        """Return some of the terms."""
        return Terms._make(values[here] for values in self)


class Classes(NamedTuple):
    """Symmetry classes of orbits, one entry a class.

    Attributes
    ----------
    maslov, walls, words : ndarray of int64, shape (N,)
        Maslov index and straight bounces of one traversal, and how many cyclic words count.
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
        Terms up to this length.
    parity : Parity, optional
        By default of all levels.
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

    orbit = np.concatenate([np.arange(number), np.flatnonzero(kind > 1)])  # on the axis: both sides of it
    times = (longest // length[orbit]).astype(np.int64)
    other_side = np.repeat(np.arange(len(orbit)) >= number, times)
    r = np.arange(1, times.sum() + 1) - np.repeat(np.cumsum(times) - times, times)
    orbit = np.repeat(orbit, times)
    phase = np.array([1, -1j, -1, 1j])[r * maslov[orbit] % 4]
    half = np.minimum(r * lyapunov[orbit] / 2, _LARGEST)
    cosh = (negative[orbit] & (r % 2 == 1)) ^ other_side
    root = np.where(cosh, 2 * np.cosh(half), 2 * np.sinh(half))
    size = weight[orbit] * length[orbit] / (math.pi * root) * np.where(other_side, y, 1)
    return Terms(r * length[orbit], phase * (sign[orbit] ** r * size), orbit, r)


def _spatial(of: Classes) -> tuple[Integers, Integers]:
    """Return how many spatial elements map each orbit to itself, and the first of them (or 0)."""
    labels, which = np.unique(of.symmetry.astype(str), return_inverse=True)
    spatial = [SPATIAL[label] for label in labels.tolist()]
    kind = np.array([len(each) for each in spatial])[which]
    return kind, np.array([each[0] if each else 0 for each in spatial])[which]
