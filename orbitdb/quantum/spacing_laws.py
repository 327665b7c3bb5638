"""Distributions of the distance between two levels with m levels between them.

Distances are in mean spacings. For one parity, p_m(S) is the generalised Wigner surmise S^c exp(-B S^2) with
c = m + (m + 1)(m + 2)/2 and mean m + 1. All parities together are four independent spectra with a quarter of
the density each. With E_n(S) the probability of n levels in an interval of length S, they follow from

    E_n'' = p_n - 2 p_(n-1) + p_(n-2),

because E_n of independent spectra is the convolution of theirs. Far beyond the surmise, the number of levels
in an interval is normal, with the number variance of the Gaussian orthogonal ensemble.

Sources: A. Y. Abul-Magd and M. H. Simbel, Phys. Rev. E 60 (1999) 5371 (surmise); M. L. Mehta, Random Matrices
(2004), chapters 6 and 16 (E_n, number variance).
"""

import math
from functools import lru_cache

import numpy as np
from scipy.special import gammaincc, gammaln

from orbitdb.arrays import Floats, Integers

MIXED = 4
"""Number of independent spectra in a list of levels of all parities."""

FURTHEST = 10.0
"""Distance in mean spacings up to which the surmise is used."""
_STEP, _ORDERS = 0.01, 24
"""Step of S in the table, and the number of densities in it; at S = 10, higher ones are negligible."""
_BLUR, _NOISE = 0.03, 1.4
"""Width with which the densities are blurred, in mean spacings, and in units of the scatter of the levels:
levels have errors, and the mean spacing is not quite that of Weyl's law."""
_LEAST_LOG = -60.0
_MORE_VARIANCE = 0.1
"""Addition to the number variance, because the mean density is not quite that of Weyl's law."""
_SURMISED = 5
"""Number of densities whose variances are those of the surmise; for others, differences follow the GOE."""


class SpacingLaw:
    """The densities p_m(S) for m = 0, 1, ....

    Parameters
    ----------
    parts : int
        Number of independent spectra in the list: `MIXED` if it has levels of all parities, otherwise 1.
    noise : float
        Scatter of the levels in the list, in mean spacings.
    """

    def __init__(self, parts: int, noise: float = 0.0) -> None:
        self.parts = parts
        self._log = _table(parts, math.hypot(_BLUR, _NOISE * noise))

    def log_density(self, m: Integers, s: Floats) -> Floats:
        """Return ln p_m(S); `m` and `s` broadcast to the shape of the result."""
        m, s = np.broadcast_arrays(m, s)
        position = np.minimum(s, FURTHEST) / _STEP
        low = np.minimum(position.astype(np.int64), self._log.shape[1] - 2)
        row = np.minimum(m, _ORDERS - 1)
        share = position - low
        near = (1 - share) * self._log[row, low] + share * self._log[row, low + 1]
        near = np.where(m < _ORDERS, near, _LEAST_LOG)
        far = np.maximum(s, FURTHEST)
        variance = number_variance(far, self.parts)
        normal = -((m + 1 - far) ** 2) / (2 * variance) - np.log(2 * np.pi * variance) / 2
        return np.asarray(np.where(s <= FURTHEST, near, normal))

    def variances(self, count: int) -> Floats:
        """Return the variances of p_0, p_1, ..., shape (count,), for the covariance of levels in a gap."""
        m = np.arange(max(count, _SURMISED))
        s = np.arange(self._log.shape[1]) * _STEP
        density = np.exp(self._log[:_SURMISED])
        near = (density * (s - m[:_SURMISED, None] - 1) ** 2).sum(axis=1) / density.sum(axis=1)
        later = number_variance(np.arange(1.0, len(m) + 1), self.parts)
        later += near[-1] - later[_SURMISED - 1]
        return np.concatenate([near, later[_SURMISED:]])[:count]


def number_variance(s: Floats, parts: int) -> Floats:
    """Return the variance of the distance to the level that is expected at a distance S."""
    one = 2 / np.pi**2 * (np.log(2 * np.pi * s / parts) + 1 + np.euler_gamma - np.pi**2 / 8) - 1 / 6
    return np.asarray(parts * one + _MORE_VARIANCE)


def _surmise(m: Integers) -> tuple[Floats, Floats]:
    """Return the exponent and the scale B of each generalised Wigner surmise."""
    exponent = m + (m + 1) * (m + 2) / 2
    ratio = gammaln((exponent + 2) / 2) - gammaln((exponent + 1) / 2)
    return exponent, np.exp(2 * (ratio - np.log(m + 1)))


@lru_cache(maxsize=8)
def _table(parts: int, blur: float) -> Floats:
    """Return ln p_m(S), blurred, with one row per m and one column per step of S."""
    s = np.arange(0, FURTHEST + 1 + _STEP / 2, _STEP)
    m = np.arange(_ORDERS)[:, None]
    density = _of_one(m, s) if parts == 1 else _of_all(m, s / parts)
    reach = math.ceil(4 * blur / _STEP)
    kernel = np.exp(-((np.arange(-reach, reach + 1) * _STEP / blur) ** 2) / 2)
    padded = np.pad(density, ((0, 0), (reach, reach)), "reflect")
    blurred = np.stack([np.convolve(row, kernel / kernel.sum(), "valid") for row in padded])
    return np.asarray(np.log(np.maximum(blurred, math.exp(_LEAST_LOG))))


def _of_one(m: Integers, s: Floats) -> Floats:
    """Return p_m(S) of one spectrum."""
    exponent, scale = _surmise(m)
    half = (exponent + 1) / 2
    logs = np.log(2) + half * np.log(scale) - gammaln(half) - scale * s**2
    return np.asarray(np.exp(logs + exponent * np.log(np.maximum(s, 1e-300))))


def _of_all(m: Integers, s: Floats) -> Floats:
    """Return p_m of four independent spectra of equal density; `s` is in spacings of one of them.

    With I_n the sum of (n + 1 - j) E_j over j = 0..n, I_n'' = p_n, so that E_n and its derivatives are second
    differences in n. E_n of four spectra is E * E * E * E, and its second derivative
    4 E * E * E * E'' + 12 E * E * E' * E'.
    """
    exponent, scale = _surmise(m)
    above = gammaincc((exponent + 1) / 2, scale * s**2)
    sums = (m + 1) * gammaincc((exponent + 2) / 2, scale * s**2) - s * above
    none, slope, curve = map(_second_differences, (sums, -above, _of_one(m, s)))
    two = _joined(none, none)
    four = 4 * _joined(_joined(two, none), curve) + 12 * _joined(two, _joined(slope, slope))
    return np.maximum(np.cumsum(np.cumsum(four, axis=0), axis=0), 0.0) / MIXED**2


def _second_differences(rows: Floats) -> Floats:
    """Return row n - 2 row (n - 1) + row (n - 2), where rows below the first are 0."""
    padded = np.concatenate([np.zeros((2, rows.shape[1])), rows])
    return np.asarray(padded[2:] - 2 * padded[1:-1] + padded[:-2])


def _joined(one: Floats, other: Floats) -> Floats:
    """Return the convolution over n of two functions, in which row n is for n levels."""
    joined = np.zeros_like(one)
    for n, row in enumerate(one):
        joined[n:] += row * other[: len(other) - n]
    return joined
