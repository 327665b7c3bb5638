"""The likelihood of the difference between the staircase from the orbits and that of a list of levels.

The difference r is known on a grid. If the list is right, or its missing and spurious levels are accounted
for, r is Gaussian noise with a covariance that is the sum of

* the error of N_X (`ErrorOfOrbits`), which was measured against exact levels. N_X is nearly exact below the
  lengths at which orbits creep along a semicircle, and knows nothing beyond those of the stored periods;
* the unknown levels beyond the ends of the list, which follow the GOE (`covariance_of_end`);
* the unknown places of missing levels within their gaps;
* the scatter of the levels.

Each point is compared with its prediction from the 20 points before it. The deviations u from the prediction,
in units of the standard deviation s, are independent, so that ln L = -sum (u^2 / (2 tau^2) + ln(s tau)).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.spacing_laws import MIXED

BEFORE = 20
"""Number of points from which the next one is predicted."""

_STEP, _LONGEST = 0.1, 31.4
"""Step and end of the lengths in the spectrum of the error of N_X."""
_KNOWN, _CREEPING, _TWICE, _BEYOND, _UNKNOWN = 0.005, 0.1, 0.2, 0.05, 0.9
"""Share of the fluctuations that the orbits miss: below the lengths at which they creep along a semicircle;
at these, once and twice; beyond; and where periods are not stored. tests/benchmarks/bench_levels.py measures
them."""
_NUGGET = 0.01
"""Standard deviation of an independent error of each point, for rounding and interpolation."""
_PLACES = 1.44
"""Factor on the variance of the places of missing levels, because one of a close pair lies farther from its
even place than a normal distribution allows. tests/benchmarks/bench_levels.py counts lists that need it."""
_DRAWS, _CLOSEST = 48, 0.1
_REACH = 3.5
"""Distance from a level in units of 1/X beyond which its smoothed step is 0 or 1."""
_NEAR_END, _END_STEP, _END_LENGTH = 4.5, 0.05, 120
"""How far from an end, in units of 1/X, the unknown levels beyond it matter; step and number of points of the
quadrature over them."""
_FORM_STEP, _FORM_POINTS = 0.002, 4000
"""Step and number of points of the integral over the form factor, in units of the Heisenberg time."""
_LONG = (150.1, 200.3, 311.7)
"""Lengths of stretches, in mean spacings, whose number variance is that of infinite ones."""


@dataclass(frozen=True)
class Whitening:
    """Coefficients with which the deviations are computed, and their standard deviations.

    Attributes
    ----------
    weights : ndarray, shape (n, BEFORE + 1)
        u_t is the product of row t with the residuals at the points t - BEFORE .. t.
    log_scale : ndarray, shape (n,)
        ln s_t.
    """

    weights: Floats
    log_scale: Floats


class ErrorOfOrbits(NamedTuple):
    """What the error of N_X depends on.

    Attributes
    ----------
    cutoff : float
        X, in units of the radius.
    perimeter : float
        Of the whole stadium.
    sufficient : float
        Length up to which the stored periods contain all orbits that matter (`sufficient_length`).
    mixed : bool
        Whether the list has levels of all parities.
    """

    cutoff: float
    perimeter: float
    sufficient: float
    mixed: bool

    @property
    def parts(self) -> int:
        """Number of independent spectra in the list."""
        return MIXED if self.mixed else 1

    def spectrum(self, length: Floats) -> Floats:
        """Return the variance of the error of N_X per unit length, without the factor exp(-(l/X)^2).

        If no orbits were known, it would be that of the staircase of random matrices, 1/(pi^2 l) for each
        parity. Orbits of one parity close after half of their length.
        """
        creeping = self.perimeter if self.mixed else self.perimeter / 2
        once = (length > creeping - 0.4) & (length < creeping + 0.8)
        twice = (length > 2 * creeping - 0.5) & (length < 2 * creeping + 1)
        missed = np.where(length > 2 * creeping, _BEYOND, _KNOWN)
        missed = np.where(once, _CREEPING, np.where(twice, _TWICE, missed))
        missed = np.where(length > self.sufficient, _UNKNOWN, missed)
        return np.asarray(self.parts * missed / (math.pi**2 * length))

    def covariance(self, distance: Floats) -> Floats:
        """Return the covariance of the errors of N_X at two k with the given distance."""
        length = np.arange(_STEP / 2, _LONGEST, _STEP)
        power = self.spectrum(length) * np.exp(-((length / self.cutoff) ** 2))
        return np.asarray(_STEP * np.cos(distance[..., None] * length) @ power)


def sufficient_length(period: int, mixed: bool) -> float:
    """Return the length up to which the orbits of all periods up to `period` suffice for N_X.

    The shortest orbits that are missing bounce between the straight walls, and run from one semicircle to the
    other at the end. For one parity, orbits close after half of their length. Measured for periods 8, 10, 12,
    13 and 14.
    """
    half = 2.0 * (period // 2) + 2
    return 2 * half if mixed else half


def whitening(
    grid: Floats,
    error: ErrorOfOrbits,
    ends: tuple[float | None, float | None],
    density: Floats,
    gaps: Floats,
    noise: float,
    rounding: float = 0.0,
    memory: int = BEFORE,
) -> Whitening:
    """Return the coefficients that turn residuals into independent deviations.

    Parameters
    ----------
    grid : ndarray, shape (n,)
        Evenly spaced points k.
    error : ErrorOfOrbits
    ends : (float or None, float or None)
        First and last level of the list, beyond which the levels are unknown; None if they are known.
    density : ndarray, shape (n,)
        Mean density of levels at each point.
    gaps : ndarray, shape (n, BEFORE + 1)
        Covariance of point t with the points t - BEFORE .. t from missing levels (`covariance_of_gaps`).
    noise : float
        Scatter of the levels of the list, in mean spacings.
    rounding : float
        Step to which residuals are rounded.
    memory : int
        Number of points, up to BEFORE, from which the next one is predicted.
    """
    n, size = len(grid), BEFORE + 1
    lag = np.arange(size)
    apart = np.abs(lag[:, None] - lag)
    index = np.arange(n)[:, None] - BEFORE + lag
    unused = (index < 0) | (lag < BEFORE - memory)
    index = np.maximum(index, 0)
    step = grid[1] - grid[0]
    nugget = _NUGGET**2 + rounding**2 / 12
    same = error.covariance(lag * step)[apart] + nugget * np.eye(size)
    full = np.broadcast_to(same, (n, size, size)).copy()
    later = np.arange(n)[:, None, None] - BEFORE + np.maximum(lag[:, None], lag)
    full += gaps[np.clip(later, 0, n - 1), BEFORE - apart]
    if noise:
        scatter = noise**2 * error.cutoff / (2 * math.sqrt(math.pi))
        full += scatter * np.exp(-((error.cutoff * apart * step) ** 2) / 4) / density[:, None, None]
    for end, inside in zip(ends, (1, -1), strict=True):
        if end is not None:
            crowded = float(np.interp(end, grid, density)) / error.cutoff
            _add_end(full, index, error.cutoff * inside * (grid - end), crowded, error.parts)
    return _predictions(full, unused)


def _add_end(full: Floats, index: Integers, x: Floats, crowded: float, parts: int) -> None:
    """Add the covariance of the unknown levels beyond an end, given the distance x of each point from it."""
    close = np.flatnonzero(np.abs(x) < _NEAR_END)
    of_end = np.pad(covariance_of_end(x[close], crowded, parts), (0, 1))  # the last row is for points far off
    place = np.full(len(x), len(close))
    place[close] = np.arange(len(close))
    near = np.flatnonzero((place[index] < len(close)).any(axis=1))
    at = place[index[near]]
    full[near] += of_end[at[:, :, None], at[:, None, :]]


def _predictions(full: Floats, unused: NDArray[np.bool_]) -> Whitening:
    """Return the deviations from the best predictions, given the covariances of points t - BEFORE .. t."""
    full[unused] = 0
    full.swapaxes(1, 2)[unused] = 0
    t, j = np.nonzero(unused)
    full[t, j, j] = 1.0
    predicted = np.linalg.solve(full[:, :BEFORE, :BEFORE], full[:, :BEFORE, BEFORE:])[..., 0]
    scale = np.sqrt(full[:, BEFORE, BEFORE] - (predicted * full[:, :BEFORE, BEFORE]).sum(axis=1))
    weights = np.concatenate([-predicted, np.ones((len(full), 1))], axis=1) / scale[:, None]
    return Whitening(weights, np.log(scale))


def variance_beyond(s: Floats, crowded: float, parts: int) -> Floats:
    """Return the number variance of stretches of s mean spacings, without what N_X knows of it.

    It is the integral of (1 - cos(2 pi s t)) K(t) / (pi t)^2 (1 - exp(-(2 pi c t)^2 / 2))^2 over t > 0, where
    K is the form factor of the GOE, t = 1 its Heisenberg time, and c = `crowded` the number of levels in 1/X.
    For `parts` independent spectra, K is that of one of them.
    """
    t = (np.arange(_FORM_POINTS) + 0.5) * _FORM_STEP
    own = t * parts
    below = np.minimum(own, 1.0)
    above = np.maximum(own, 1.0)
    form = np.where(
        own < 1,
        2 * below - below * np.log(1 + 2 * below),
        2 - above * np.log((2 * above + 1) / (2 * above - 1)),
    )
    unknown = (1 - np.exp(-((2 * math.pi * crowded * t) ** 2) / 2)) ** 2
    power = form * unknown / (math.pi * t) ** 2 * _FORM_STEP
    rest = 1 / (math.pi**2 * _FORM_STEP * _FORM_POINTS)  # K = 1 beyond; its mean over s
    return np.asarray((1 - np.cos(2 * math.pi * s[..., None] * t)) @ power + rest * (s > 0))


def error_of_levels(crowded: float) -> float:
    """Return the rms error of the levels at which N_X reaches n - 1/2, in mean spacings.

    It is that of the part of the staircase that N_X does not know: half the `variance_beyond` of a long
    stretch, without the 1/12 of the steps themselves. `crowded` is the number of levels in 1/X.
    """
    far = float(variance_beyond(np.array(_LONG), crowded, 1).mean())
    return math.sqrt(max(far / 2 - 1 / 12, 0.0))


def covariance_of_end(x: Floats, crowded: float, parts: int) -> Floats:
    """Return the covariance that the unknown levels beyond an end cause inside, shape (n, n).

    The points have the distances x from the end, in units of 1/X. The number of levels up to a distance s
    beyond the end deviates from what N_X says with the covariance [V(s) + V(s') - V(s - s')] / 2, where V is
    `variance_beyond`; the list smoothed with the same Gaussian as N_X shows it.
    """
    place = np.arange(_END_LENGTH, dtype=np.float64)
    y = (place + 0.5) * _END_STEP
    apart = variance_beyond(place * _END_STEP * crowded, crowded, parts)
    own = variance_beyond(y * crowded, crowded, parts)
    lag = np.abs(place[:, None] - place).astype(np.int64)
    of_count = (own[:, None] + own - apart[lag]) / 2
    kernel = np.exp(-((x[:, None] + y) ** 2) / 2) * _END_STEP / math.sqrt(2 * math.pi)
    return np.asarray(kernel @ of_count @ kernel.T)


def places_in_gap(m: int, variances: Floats) -> Floats:
    """Return the covariance of the places of m levels in a gap, in mean spacings, shape (m, m).

    The m + 1 spacings have the covariances that follow from the variances of p_0, p_1, ..., given their sum.
    """
    padded = np.concatenate([[0.0], variances[: m + 1]])
    auto = np.concatenate([padded[1:2], np.diff(padded, 2) / 2])
    lag = np.abs(np.arange(m + 1)[:, None] - np.arange(m + 1))
    spacings = auto[lag]
    total = spacings.sum(axis=1)
    spacings = spacings - np.outer(total, total) / total.sum()
    return np.asarray(np.cumsum(np.cumsum(spacings, axis=0), axis=1)[:m, :m])


class Gaps(NamedTuple):
    """Ends in k of gaps, a number of levels that may be missing in each, and its probability, shape (g,)."""

    low: Floats
    high: Floats
    missing: Integers
    probability: Floats


def covariance_of_gaps(grid: Floats, cutoff: float, gaps: Gaps, variances: Floats) -> Floats:
    """Return the covariance from the places of missing levels, shape (n, BEFORE + 1), as for `whitening`.

    It is the mean over places drawn at random, relative to even ones. `variances` are those of p_0, p_1, ....
    """
    low, high, missing, weight = gaps
    n = len(grid)
    band = np.zeros((n, BEFORE + 1))
    step = grid[1] - grid[0]
    first = np.searchsorted(grid, low - _REACH / cutoff)
    points = np.searchsorted(grid, high + _REACH / cutoff) - first
    for m in np.unique(missing).tolist():
        factor = np.linalg.cholesky(_PLACES * places_in_gap(m, variances) + 1e-12 * np.eye(m))
        drawn = np.random.default_rng(m).standard_normal((_DRAWS // 2, m)) @ factor.T
        drawn = np.concatenate([drawn, -drawn])
        even = np.arange(1, m + 1)
        drawn = np.sort(np.clip(even + drawn, _CLOSEST, m + 1 - _CLOSEST), axis=1)
        of_m = np.flatnonzero(missing == m)
        for some in np.array_split(of_m[np.argsort(points[of_m])], max(1, math.ceil(len(of_m) / 500))):
            width = int(points[some].max())
            t = first[some, None] + np.arange(width)
            at = (grid[0] + step * t)[:, :, None]
            spacing = ((high - low)[some] / (m + 1))[:, None]
            spread = np.zeros((len(some), width, _DRAWS))
            for j in range(m):
                spread += ndtr(cutoff * (at - (low[some, None] + spacing * drawn[:, j])[:, None, :]))
                spread -= ndtr(cutoff * (at - (low[some, None] + spacing * even[j])[:, :, None]))
            spread *= np.sqrt(weight[some] / _DRAWS)[:, None, None]
            inside = (t >= 0) & (t < n)
            for lag in range(min(BEFORE + 1, width)):
                both = (spread[:, lag:] * spread[:, : width - lag]).sum(axis=2)
                ok = inside[:, lag:] & inside[:, : width - lag]
                np.add.at(band[:, BEFORE - lag], t[:, lag:][ok], both[ok])
    return band


def deviations(white: Whitening, residual: Floats) -> Floats:
    """Return the deviations of the residuals from their predictions, shape (n,)."""
    padded = np.concatenate([np.zeros(BEFORE), residual])
    return np.asarray(
        (np.lib.stride_tricks.sliding_window_view(padded, BEFORE + 1) * white.weights).sum(axis=1)
    )
