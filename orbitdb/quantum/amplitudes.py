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
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.quantum.weyl import Parity
from orbitdb.symbols.members import STABILISER_OF
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_LARGEST = 700.0
_BOTH = MIRROR_X | MIRROR_Y
SPATIAL = {
    label: [g for g in (MIRROR_X, MIRROR_Y, _BOTH) if mask >> g & 1] for label, mask in STABILISER_OF.items()
}
"""By symmetry label, the elements without time reversal that map a word to itself; all three: on the axis."""


@dataclass(frozen=True, eq=False)
class Terms(ByValue):
    """Terms Re(A exp(i k l)) of the density of levels.

    Attributes
    ----------
    length : ndarray, shape (N,)
        l, in units of the radius.
    amplitude : ndarray of complex128, shape (N,)
        A, in units of the radius.
    orbit : ndarray of intp, shape (N,)
        Which of the classes a term is of; -1 for none.
    repetitions : ndarray of int64, shape (N,)
        How often the orbit, or half of it, is gone round.
    """

    length: Floats
    amplitude: Complexes
    orbit: NDArray[np.intp]
    repetitions: NDArray[np.int64]

    def rows(self, here: NDArray[np.intp]) -> "Terms":
        """Return some of the terms."""
        return Terms(*(values[here] for values in vars(self).values()))

    def and_more(self, others: "Terms") -> "Terms":
        """Return these terms and others behind them."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Terms(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, eq=False)
class Classes(ByValue):
    """Symmetry classes of orbits, one entry a class.

    Attributes
    ----------
    p, walls, words : ndarray of int64, shape (N,)
        Bounces, straight ones among them, and how many cyclic words count.
    length, lyapunov : ndarray, shape (N,)
    symmetry : ndarray of str or object, shape (N,)
        Symmetry labels.
    """

    p: NDArray[np.int64]
    walls: NDArray[np.int64]
    words: NDArray[np.int64]
    length: Floats
    lyapunov: Floats
    symmetry: NDArray[np.object_]

    @property
    def maslov(self) -> NDArray[np.int64]:
        """The Maslov index of one traversal."""
        return 3 * self.p - self.walls


def root(lyapunov: Floats, negative: NDArray[np.bool_]) -> Floats:
    """Return sqrt|det(M - 1)|, given whether the eigenvalues exp(+-lambda) of M have negative signs."""
    half = np.minimum(lyapunov / 2, _LARGEST)
    found: Floats = np.where(negative, 2 * np.cosh(half), 2 * np.sinh(half))
    return found


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
    parts = _whole(classes) if parity is None else _by_parity(classes, parity)
    empty = np.zeros(0, np.int64)
    found = Terms(np.zeros(0), np.zeros(0, np.complex128), empty, empty)
    for part in parts:
        r = 1
        while len(here := np.flatnonzero(r * part.length <= longest)) > 0:
            some = part.rows(here)
            rounds = np.full(len(here), r)
            found = found.and_more(Terms(r * some.length, some.amplitude(r), some.orbit, rounds))
            r += 1
    return found


@dataclass(frozen=True, eq=False)
class _Part:
    """Orbits, or halves of them, that are gone round.

    Attributes
    ----------
    length, lyapunov, weight : ndarray, shape (N,)
        Of one round; the weight holds the number of words, too.
    maslov : ndarray of int64, shape (N,)
    odd : ndarray of bool, shape (N,)
        Where the eigenvalues of M are negative.
    mirrored : bool
        Whether the other side of the axis is seen: M^r changes its sign.
    sign : ndarray of int64, shape (N,)
        chi(g), a factor for each round.
    orbit : ndarray of intp, shape (N,)
    """

    length: Floats
    lyapunov: Floats
    weight: Floats
    maslov: NDArray[np.int64]
    odd: NDArray[np.bool_]
    sign: NDArray[np.int64]
    orbit: NDArray[np.intp]
    mirrored: bool = False

    def rows(self, here: NDArray[np.intp]) -> "_Part":
        return replace(self, **{each: v[here] for each, v in vars(self).items() if each != "mirrored"})

    def amplitude(self, r: int) -> Complexes:
        phase: Complexes = np.array([1, -1j, -1, 1j])[r * self.maslov % 4]
        negative = (self.odd & bool(r % 2)) ^ self.mirrored
        size = self.weight * self.length / (math.pi * root(r * self.lyapunov, negative))
        return phase * (self.sign**r * size)


def _whole(of: Classes) -> list[_Part]:
    ones = np.ones(len(of.p), np.int64)
    odd = of.walls % 2 == 1
    number = np.arange(len(of.p))
    return [_Part(of.length, of.lyapunov, of.words.astype(float), of.maslov, odd, ones, number)]


def _by_parity(of: Classes, parity: Parity) -> list[_Part]:
    """Return what counts for one parity: whole orbits, half orbits, and both parts of that on the axis."""
    x, y = parity.signs
    labels, which = np.unique(of.symmetry.astype(str), return_inverse=True)
    spatial = [SPATIAL[label] for label in labels.tolist()]
    kind = np.array([len(each) for each in spatial])[which]
    g = np.array([each[0] if each else 0 for each in spatial])[which]
    chi = np.array([1, x, y, x * y])[g]
    whole = _whole(of)[0].rows(np.flatnonzero(kind == 0))
    turned = (of.walls // 2 + (g != _BOTH)) % 2 == 1
    halved = _Part(
        of.length / 2, of.lyapunov / 2, of.words / 2, of.maslov // 2, turned, chi, np.arange(len(of.p))
    )
    axis = halved.rows(np.flatnonzero(kind > 1))  # g is x: to and fro
    return [
        replace(whole, weight=whole.weight / 4),
        halved.rows(np.flatnonzero(kind == 1)),
        axis,
        replace(axis, weight=y * axis.weight, mirrored=True),
    ]
