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


class _Rounds(NamedTuple):
    """One round of orbits, or of halves of them.

    Attributes
    ----------
    length, lyapunov, weight : ndarray, shape (N,)
        The weight holds the number of words, too.
    maslov : ndarray of int64, shape (N,)
    negative : ndarray of bool, shape (N,)
        Where the eigenvalues of M are negative.
    sign : ndarray of int64, shape (N,)
        chi(g), a factor for each round.
    mirrored : ndarray of bool, shape (N,)
        Where the other side of the axis is seen: M^r changes its sign.
    orbit : ndarray of int64, shape (N,)
    """

    length: Floats
    lyapunov: Floats
    weight: Floats
    maslov: Integers
    negative: NDArray[np.bool_]
    sign: Integers
    mirrored: NDArray[np.bool_]
    orbit: Integers


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
    once = _whole(classes) if parity is None else _by_parity(classes, parity)
    times = (longest // once.length).astype(np.int64)
    each = _Rounds._make(np.repeat(values, times) for values in once)
    r = np.arange(1, len(each.length) + 1) - np.repeat(np.cumsum(times) - times, times)
    phase = np.array([1, -1j, -1, 1j])[r * each.maslov % 4]
    half = np.minimum(r * each.lyapunov / 2, _LARGEST)
    negative = (each.negative & (r % 2 == 1)) ^ each.mirrored
    root = np.where(negative, 2 * np.cosh(half), 2 * np.sinh(half))
    size = each.weight * each.length / (math.pi * root)
    return Terms(r * each.length, phase * (each.sign**r * size), each.orbit, r)


def _whole(of: Classes) -> _Rounds:
    number = np.arange(len(of.length))
    never = np.zeros(len(number), np.bool_)
    ones = np.ones_like(number)
    return _Rounds(
        of.length, of.lyapunov, of.words.astype(float), of.maslov, of.walls % 2 == 1, ones, never, number
    )


def _by_parity(of: Classes, parity: Parity) -> _Rounds:
    """Return what counts for one parity: whole orbits, half orbits, and both sides of those on the axis."""
    x, y = parity.signs
    labels, which = np.unique(of.symmetry.astype(str), return_inverse=True)
    spatial = [SPATIAL[label] for label in labels.tolist()]
    kind = np.array([len(each) for each in spatial])[which]
    g = np.array([each[0] if each else 0 for each in spatial])[which]  # on the axis x: to and fro
    halved, whole = kind > 0, _whole(of)
    turned = (of.walls // 2 + (g != _BOTH)) % 2 == 1
    one_side = whole._replace(
        length=np.where(halved, of.length / 2, of.length),
        lyapunov=np.where(halved, of.lyapunov / 2, of.lyapunov),
        weight=of.words / np.where(halved, 2, 4),
        maslov=np.where(halved, of.maslov // 2, of.maslov),
        negative=np.where(halved, turned, whole.negative),
        sign=np.array([1, x, y, x * y])[g],
    )
    axis = _Rounds._make(values[kind > 1] for values in one_side)
    other_side = axis._replace(weight=y * axis.weight, mirrored=~axis.mirrored)
    return _Rounds._make(map(np.concatenate, zip(one_side, other_side, strict=True)))
