"""The length spectrum, the Fourier transform of the fluctuating density of levels, from levels or orbits.

F(x) is the integral of w(k) (d(k) - smooth density) exp(i k x) over 0 < k < K, where the window is
w = sin^4(pi k / K). From levels, F is the sum of w exp(i k x) over the levels minus the transform of the
smooth density. From orbits, each term Re(A exp(i k l)) gives a peak at x = l and a small image of it at -l.
"""

import math
from collections.abc import Iterator

import numpy as np

from orbitdb.arrays import Complexes, Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.amplitudes import Parity, Terms, weyl

BLOCK = 1 << 20

EDGE = (-0.25j, -0.05997 - 0.17678j, -0.09257 - 0.14331j, -0.11277 - 0.12365j,
        -0.1268 - 0.1103j, -0.1372 - 0.1005j, -0.1452 - 0.0928j, -0.1513 - 0.0870j)  # fmt: skip
"""Correction E_j for the end of the bouncing-ball family at a joint, after j = 1, 2, .. round trips.

E_j is the trace of j steps of the quantum map of the transverse coordinate s, minus the contribution of the
bouncing balls at s < 0. Each step is a drift over the length 2, and for s > 0 the phase -k s^2. E_j does not
depend on k."""


def reach(k_max: float) -> float:
    """Return the distance from its centre, in units of the radius, beyond which a peak is below 1e-5."""
    return 30 * math.pi / k_max


def of_levels(
    k: Floats, x: Floats, k_max: float, stadium: Stadium, parity: Parity | None = None
) -> Complexes:
    """Return F at the lengths x, computed from levels.

    Parameters
    ----------
    k : ndarray, shape (N,)
        All levels below `k_max`, in 1/radius; higher levels are ignored.
    x : ndarray, shape (n,)
        Lengths, in units of the radius.
    k_max : float
        The end K of the window, in 1/radius.
    stadium : Stadium
    parity : Parity, optional
        Parity of the levels; by default, levels of all parities.

    Returns
    -------
    ndarray of complex128, shape (n,)
    """
    inside = k[k < k_max]
    nodes, weights = _quadrature(k_max, x)
    smooth = weights * weyl(stadium, parity).deriv()(nodes)
    return _transform(inside, _window(inside, k_max), x) - _transform(nodes, smooth, x)


def of_terms(terms: Terms, x: Floats, k_max: float) -> Complexes:
    """Return F from terms, at lengths x in ascending order, shape (n,)."""
    found = np.zeros(len(x), np.complex128)
    far = reach(k_max)
    ordered = terms.rows(np.argsort(terms.length))
    for first in range(0, len(x), _POINTS):
        here = x[first : first + _POINTS]
        low, high = np.searchsorted(ordered.length, [here[0] - far, here[-1] + far])
        step = BLOCK // len(here)
        for at in range(low, high, step):
            some = ordered.rows(np.arange(at, min(at + step, high)))
            found[first : first + len(here)] += peak_of_each(some, here, k_max).sum(axis=1)
    return found


_POINTS = 64


def peak_of_each(terms: Terms, x: Floats, k_max: float) -> Complexes:
    """Return the contribution of each term to F at each of the lengths x, shape (n, N)."""
    at, length, amplitude = x[:, None], terms.length, terms.amplitude
    found: Complexes = (
        _peak(at - length, k_max) * amplitude.conj() + _peak(at + length, k_max) * amplitude
    ) / 2
    return found


def _peak(y: Floats, k_max: float) -> Complexes:
    """Return the integral of w(k) exp(i k y) in closed form, because w is a sum of cosines."""
    z = k_max * y / (2 * math.pi)
    sides = (np.sinc(z - 1) + np.sinc(z + 1)) / 4 + (np.sinc(z - 2) + np.sinc(z + 2)) / 16
    found: Complexes = k_max * (3 / 8 * np.sinc(z) + sides) * np.exp(1j * math.pi * z)
    return found


def of_family(stadium: Stadium, x: Floats, k_max: float, parity: Parity | None = None) -> Complexes:
    """Return the contribution of the bouncing-ball orbits (`family`) to F, at lengths x."""
    k, weights = _quadrature(k_max, x)
    balls = family(stadium, k, x[-1] + reach(k_max), parity)
    return _transform(k, weights * sum((wave.real for _, wave in balls), np.zeros_like(k)), x)


def family(
    stadium: Stadium, k: Floats, longest: float, parity: Parity | None = None
) -> Iterator[tuple[int, Complexes]]:
    """Yield each length l of the bouncing balls, with A exp(i k l) at each k as for the orbits (`Terms`).

    Notes
    -----
    For the levels of one parity, a ball that goes up and down j times in a quarter has the length l = 2j, and
    A is (-chi_y)^j times the sum of three terms: (a k / pi) sqrt(2 / (pi k l)) exp(-i pi/4) for the family,
    chi_x / (2 pi) for the axis x = 0, and (2 / pi) E_j (`EDGE`) for the edge at the joint. For the levels of
    all parities, only even j remain, and the family and edge terms are four times as large.
    """
    x, y = (0, -1) if parity is None else parity.signs
    step, share = (2, 4) if parity is None else (1, 1)
    for j in range(step, math.floor(longest / 2) + 1, step):
        edge = EDGE[j - 1] * 2 / math.pi if j <= len(EDGE) else 0.0
        balls = stadium.a * np.sqrt(k / (math.pi**3 * j)) * np.exp(-0.25j * math.pi) + edge
        yield 2 * j, (-y) ** j * (share * balls + x / (2 * math.pi)) * np.exp(2j * j * k)


def family_terms(stadium: Stadium, k_max: float, longest: float, parity: Parity | None = None) -> Terms:
    """Return the bouncing balls as terms whose amplitudes are right in the middle of the window."""
    middle = np.array([k_max / 2])
    balls = list(family(stadium, middle, longest, parity))
    length = np.array([each for each, _ in balls], np.float64)
    waves = np.array([wave[0] for _, wave in balls], np.complex128)
    once = 4 if parity is None else 2
    amplitude, times = waves * np.exp(-1j * middle * length), length.astype(int) // once
    return Terms(length, amplitude, np.full(len(balls), -1), times, np.full(len(balls), 4 // once))


def counted(terms: Terms, k: Floats) -> Floats:
    """Return what the terms add to the number of levels below each k: the sum of Im(A exp(i k l)) / l."""
    return _transform(terms.length, terms.amplitude / terms.length, k).imag


def family_count(stadium: Stadium, k: Floats, longest: float, parity: Parity | None = None) -> Floats:
    """Return the contribution of the bouncing balls to the number of levels below each k.

    To leading order, integrating a term over k delays its phase by a quarter turn and divides it by l.
    """
    return sum((wave.imag / length for length, wave in family(stadium, k, longest, parity)), np.zeros_like(k))


def _window(k: Floats, k_max: float) -> Floats:
    return np.sin(math.pi * k / k_max) ** 4


def _quadrature(k_max: float, x: Floats) -> tuple[Floats, Floats]:
    """Return nodes in 0..K that resolve the oscillations exp(i k x), and weights that include the window."""
    count = math.ceil(k_max * (2 * float(np.abs(x).max()) + reach(k_max)) / 2) + 100
    nodes, weights = np.polynomial.legendre.leggauss(count)
    k = (nodes + 1) * k_max / 2
    return k, weights * k_max / 2 * _window(k, k_max)


def _transform(k: Floats, weights: Floats | Complexes, x: Floats) -> Complexes:
    """Return the sum of weights times exp(i k x) at each x."""
    parts = np.array_split(x, max(1, len(x) * len(k) // BLOCK))
    return np.concatenate([np.exp(1j * part[:, None] * k) @ weights for part in parts])
