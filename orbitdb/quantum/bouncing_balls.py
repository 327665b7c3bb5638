"""The bouncing balls between the straight walls, a family of orbits, in the trace formula.

The family ends at the joints, where the walls begin to curve. E_j, the correction for such an end after j
round trips of a ball in a quarter, is the trace of j steps of the quantum map of the transverse coordinate s,
minus the contribution of the family at s < 0. A step is a drift over the length 2 and, for s > 0, the phase
exp(-i k s^2). E_j does not depend on k: take k = 1.

Source of the family's term: M. Sieber et al., J. Phys. A 26 (1993) 6217.
"""

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from orbitdb.arrays import Complexes, Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.trace_formula import Terms
from orbitdb.quantum.weyl import Parity

_DENSITY = 4
"""Points of the quadrature per unit of s; more do not change the 12th digit."""
_FLAT, _CURVED = 6.0, 9.0
"""Range of s < 0 per root of the number of steps (and as far again), and range of s > 0."""


@lru_cache(maxsize=8)
def edges(count: int) -> Complexes:
    """Return the corrections E_1, E_2, ..., shape (count,), for the end of the family at a joint.

    Notes
    -----
    With s = -r exp(i pi/4) on the straight side and s = r exp(-i pi/4) on the curved one, the kernel of a
    step decays: it is exp(-(r - r')^2 / 4), exp(-(r + r')^2 / 4) and exp(-(r^2 + r'^2) / 4 + i r r' / 2)
    between two points of the straight side, of the curved one, and one of each, over sqrt(4 pi). The trace
    over straight distances up to R exceeds that of the family, R / sqrt(4 pi j), by E_j and by the effect of
    the end at R, -1/(2 pi j) sum of sqrt((j - m) / m) over m < j, by Kac's and Spitzer's identity for the
    largest of j partial sums that return to 0.
    """
    far = _FLAT * (math.sqrt(count) + 1)
    flat, weight = _nodes(far)
    curved, curved_weight = _nodes(_CURVED)
    both = np.exp(-(flat[:, None] ** 2 + curved**2) / 4 + 0.5j * flat[:, None] * curved)
    kernel = np.block(
        [
            [np.exp(-((flat[:, None] - flat) ** 2) / 4), both],
            [both.T, np.exp(-((curved[:, None] + curved) ** 2) / 4)],
        ]
    )
    step = kernel * np.concatenate([weight, -1j * curved_weight]) / math.sqrt(4 * math.pi)
    values, found = np.linalg.eigvals(step), []
    for j in range(1, count + 1):
        m = np.arange(1, j)
        end = -np.sqrt((j - m) / m).sum() / (2 * math.pi * j)
        found.append((values**j).sum() - far / math.sqrt(4 * math.pi * j) - end)
    return np.array(found)


def _nodes(far: float) -> tuple[Floats, Floats]:
    """Return nodes and weights of Gauss and Legendre's quadrature from 0 to `far`."""
    nodes, weights = np.polynomial.legendre.leggauss(math.ceil(far * _DENSITY))
    return (nodes + 1) * far / 2, weights * far / 2


def family(
    stadium: Stadium, k: Floats, longest: float, parity: Parity | None = None
) -> Iterator[tuple[int, Complexes]]:
    """Yield each length l of the bouncing balls, with A exp(i k l) at each k as for the orbits (`Terms`).

    Notes
    -----
    For the levels of one parity, a ball that goes up and down j times in a quarter has the length l = 2j, and
    A is (-chi_y)^j times the sum of three terms: (a k / pi) sqrt(2 / (pi k l)) exp(-i pi/4) for the family,
    chi_x / (2 pi) for the axis x = 0, and (2 / pi) E_j (`edges`) for the end at the joint. For the levels of
    all parities, only even j remain, and the terms of the family and its end are four times as large.
    """
    x, y = (0, -1) if parity is None else parity.signs
    step, share = (2, 4) if parity is None else (1, 1)
    most = math.floor(longest / 2)
    for j in range(step, most + 1, step):
        edge = edges(most)[j - 1] * 2 / math.pi
        balls = stadium.a * np.sqrt(k / (math.pi**3 * j)) * np.exp(-0.25j * math.pi) + edge
        yield 2 * j, (-y) ** j * (share * balls + x / (2 * math.pi)) * np.exp(2j * j * k)


def family_terms(
    stadium: Stadium, ends: tuple[float, float], longest: float, parity: Parity | None = None
) -> Terms:
    """Return the bouncing balls as terms whose amplitudes are right in the middle of a window of k."""
    middle = np.array([sum(ends) / 2])
    balls = list(family(stadium, middle, longest, parity))
    length = np.array([length for length, _ in balls], np.float64)
    waves = np.array([wave[0] for _, wave in balls], np.complex128)
    once = 4 if parity is None else 2
    amplitude, times = waves * np.exp(-1j * middle * length), length.astype(int) // once
    none, parts = np.full(len(balls), -1), np.full(len(balls), 4 // once)
    return Terms(length, amplitude, none, times, parts, none, np.full(len(balls), np.nan))


def family_count(stadium: Stadium, k: Floats, longest: float, parity: Parity | None = None) -> Floats:
    """Return the contribution of the bouncing balls to the number of levels below each k.

    To leading order, integrating a term over k delays its phase by a quarter turn and divides it by l.
    """
    return sum((wave.imag / length for length, wave in family(stadium, k, longest, parity)), np.zeros_like(k))
