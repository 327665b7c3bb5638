"""Statistics of levels: ratios of gaps, spacings, number variance and spectral rigidity.

Sources: Y. Y. Atas et al., Phys. Rev. Lett. 110 (2013) 084101 (ratios); M. L. Mehta, Random Matrices (2004),
chapter 16 (number variance, Delta_3); O. Bohigas, M.-J. Giannoni, Lecture Notes in Physics 209 (1984) 1.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import sici

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.quantum.bouncing_balls import family_count
from orbitdb.quantum.weyl import Parity, weyl

LENGTHS = (1, 5, 20)
"""Lengths L for the number variance and Delta_3, in mean spacings."""

FAMILY_TO = 30.0
"""Maximum length of the bouncing balls that can be removed from the staircase, in units of the radius."""

_WINDOWS_A_SPACING = 4
_NODES = 64


class Statistics(NamedTuple):
    """Statistics of the levels of one parity, unfolded to a mean spacing near 1.

    Attributes
    ----------
    parity : str
        A parity, or ``GOE`` for random matrices, or ``Poisson`` for random numbers.
    balls : str
        ``in`` if the levels are unfolded with Weyl's law alone, ``out`` if the contribution of the bouncing
        balls is removed as well, empty for ``GOE`` and ``Poisson``.
    levels : int or None
        Number of levels; None for ``GOE`` and ``Poisson``.
    gap_ratio, gap_ratio_error : float or None
        Mean ratio of the smaller to the larger of two neighbouring gaps, and its standard error.
    spacing_variance : float
        Variance of the unfolded gap between neighbouring levels, whose mean is only near 1.
    delta3_1, delta3_5, delta3_20 : float or None
        Dyson and Mehta's Delta_3 for L = 1, 5, 20; None if there are too few levels.
    variance_1, variance_5, variance_20 : float or None
        Variance of the number of levels in a stretch of L = 1, 5, 20; None if there are too few levels.
    missing : float or None
        Share of the levels that the list lacks, according to the orbits, for which Delta_3 and the variances
        allow; None if it is not known.
    """

    parity: str
    balls: str
    levels: int | None
    gap_ratio: float
    gap_ratio_error: float | None
    spacing_variance: float
    delta3_1: float | None
    delta3_5: float | None
    delta3_20: float | None
    variance_1: float | None
    variance_5: float | None
    variance_20: float | None
    missing: float | None


def unfolded(k: Floats, stadium: Stadium, parity: Parity, balls: bool = False) -> Floats:
    """Unfold levels to a mean spacing of 1 by Weyl's law, with the bouncing-ball term if `balls` is true."""
    smooth: Floats = weyl(stadium, parity)(k)
    return smooth + family_count(stadium, k, FAMILY_TO, parity) if balls else smooth


def statistics(
    k: Floats, stadium: Stadium, parity: Parity, balls: bool = False, missing: float | None = None
) -> Statistics:
    """Return the statistics of N levels k of one parity in ascending order, shape (N,), in 1/radius.

    `missing` is the share of the levels that the list lacks, if it is known.
    """
    x = np.sort(unfolded(k, stadium, parity, balls))
    gaps = np.diff(x)
    ratios = gap_ratios(x)
    error = float(ratios.std(ddof=1) / math.sqrt(len(ratios)))
    long: list[float | None] = [
        of(x, length, missing or 0.0) for of in (delta3, number_variance) for length in LENGTHS
    ]
    long.append(missing)
    return Statistics(
        str(parity), "out" if balls else "in", len(x), float(ratios.mean()), error, float(gaps.var()),
        *long,
    )  # fmt: skip


def expected() -> list[Statistics]:
    """Return the statistics expected for random matrices (GOE) and for random numbers (Poisson)."""
    goe = [*map(goe_delta3, LENGTHS), *(float(goe_variance(length)) for length in LENGTHS), None]
    poisson = [*(length / 15 for length in LENGTHS), *map(float, LENGTHS), None]
    return [
        Statistics("GOE", "", None, 0.5307, None, 0.2856, *goe),
        Statistics("Poisson", "", None, 2 * math.log(2) - 1, None, 1.0, *poisson),
    ]


def gap_ratios(x: Floats) -> Floats:
    """Return the ratio min/max of each pair of neighbouring gaps, shape (N - 2,); 1 if both are zero."""
    gaps = np.diff(x)
    low, high = np.minimum(gaps[1:], gaps[:-1]), np.maximum(gaps[1:], gaps[:-1])
    return np.where(high > 0, low / np.where(high > 0, high, 1.0), 1.0)


def _windows(x: Floats, length: float) -> Floats:
    """Return where stretches of the given length begin; empty if the levels span less than two lengths."""
    room = x[-1] - x[0] - length
    count = math.floor(room * _WINDOWS_A_SPACING) if room >= length else 0
    return x[0] + room * (np.arange(count) + 0.5) / max(count, 1)


def number_variance(x: Floats, length: float, missing: float = 0.0) -> float | None:
    """Return the mean of (n - L)^2 over stretches of length L with n levels; None for too few levels.

    If a share f of the levels is missing at random, the mean of (n - (1 - f) L)^2 is (1 - f)^2 times the
    variance of the complete list, plus f (1 - f) L; the result is that of the complete list.
    """
    starts = _windows(x, length)
    if not len(starts):
        return None
    number = np.searchsorted(x, starts + length) - np.searchsorted(x, starts)
    found = 1 - missing
    own = float(((number - found * length) ** 2).mean())
    return (own - missing * found * length) / found**2


def delta3(x: Floats, length: float, missing: float = 0.0) -> float | None:
    """Return Delta_3, the mean square deviation of the staircase from its best straight line over a length L.

    It is averaged over stretches of length L, and None if there are too few levels. For n levels at distances
    z_i from the middle of a stretch, with S1 = sum z_i and S2 = sum z_i^2, it is n^2/16 - S1^2/L^2 + 3 n S2 /
    (2 L^2) - 3 S2^2 / L^4 + sum (n - 2 i + 1) z_i / L. If a share f of the levels is missing at random, it is
    (1 - f)^2 times that of the complete list, plus f (1 - f) L / 15; the result is that of the complete list.
    """
    starts = _windows(x, length)
    if not len(starts):
        return None
    values = []
    for start in starts.tolist():
        first, last = np.searchsorted(x, [start, start + length])
        z, n = x[first:last] - start - length / 2, int(last - first)
        one, two = z.sum(), (z**2).sum()
        order = n - 2 * np.arange(1, n + 1) + 1
        value = n**2 / 16 - (one / length) ** 2 + 1.5 * n * two / length**2 - 3 * two**2 / length**4
        values.append(value + (order * z).sum() / length)
    found = 1 - missing
    return (float(np.mean(values)) - missing * found * length / 15) / found**2


def goe_variance(length: float | Floats) -> Floats:
    """Return the number variance of the Gaussian orthogonal ensemble (GOE)."""
    length = np.maximum(np.asarray(length, np.float64), 1e-12)
    one, _ = sici(np.pi * length)
    two, cosine = sici(2 * np.pi * length)
    unitary = np.log(2 * np.pi * length) + np.euler_gamma + 1 - np.cos(2 * np.pi * length) - cosine
    unitary = unitary / np.pi**2 + length * (1 - 2 * two / np.pi)
    return np.asarray(2 * unitary + (one / np.pi) ** 2 - one / np.pi)


def goe_delta3(length: float) -> float:
    """Return Delta_3 of the GOE: 2/L^4 times the integral of (L^3 - 2 L^2 r + r^3) variance(r) over 0..L."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    r = (nodes + 1) * length / 2
    kernel = length**3 - 2 * length**2 * r + r**3
    return float((weights * kernel * goe_variance(r)).sum() * length / 2 * 2 / length**4)
