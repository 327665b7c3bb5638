"""The likelihood of the difference between the staircase from the orbits and that of a list of levels.

The difference r is known on a grid. If the list is right, or its missing and spurious levels are accounted
for, r is Gaussian noise with a covariance that is the sum of

* the error of N_X. Its spectrum, a function of the length l, was measured against exact levels: N_X is nearly
  exact below the lengths at which orbits creep along a semicircle, half the perimeter for one parity;
* the unknown levels beyond the ends of the list;
* the unknown places of missing levels within their gaps;
* the scatter of the levels.

Each point is compared with its prediction from the 20 points before it. The deviations u from the prediction,
in units of the standard deviation s, are independent, so that ln L = -sum (u^2 / (2 tau^2) + ln(s tau)).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers

BEFORE = 20
"""Number of points from which the next one is predicted."""

_STEP, _LONGEST = 0.1, 31.4
"""Step and end of the lengths in the spectrum of the error of N_X."""
_FLOOR, _NUGGET = 2e-4, 0.01
_END_X, _END_PSI = (-2.0, -1.0, 0.0, 1.0, 2.0, 3.0), (2.8, 2.1, 1.0, 0.26, 0.03, 0.0)
"""Effect of the unknown levels beyond an end at a distance inside, in units of 1/X, relative to the end."""
_END_CORRELATION, _END_FACTOR = 54.0, 1.3
_PLACES = 1.44
"""Factor on the variance of the places of missing levels."""
_DRAWS, _CLOSEST = 48, 0.1
_REACH = 3.5
"""Distance from a level in units of 1/X beyond which its smoothed step is 0 or 1."""


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


def spectrum_of_error(length: Floats, perimeter: float, mixed: bool) -> Floats:
    """Return the power of the error of N_X at each length, for one parity or all mixed."""
    creeping = (length > perimeter / 2) * 0.003
    if not mixed:
        first = (length > perimeter / 2 - 0.2) & (length < perimeter / 2 + 0.8)
        return np.asarray(_FLOOR + creeping + 0.10 * first + 0.10 * (length > perimeter - 0.5))
    first = (length > perimeter - 0.4) & (length < perimeter + 1.4)
    second = (length > 2 * perimeter - 0.5) & (length < 2 * perimeter + 2)
    return np.asarray(_FLOOR + creeping + 0.40 * first + 0.08 * (length > perimeter) + 0.40 * second)


def covariance_of_error(distance: Floats, perimeter: float, mixed: bool, cutoff: float) -> Floats:
    """Return the covariance of the errors of N_X at two k with the given distance."""
    length = np.arange(_STEP / 2, _LONGEST, _STEP)
    power = spectrum_of_error(length, perimeter, mixed) * np.exp(-((length / cutoff) ** 2))
    return np.asarray(_STEP / _LONGEST * np.cos(distance[..., None] * length) @ power)


def whitening(
    grid: Floats,
    cutoff: float,
    perimeter: float,
    mixed: bool,
    ends: tuple[float | None, float | None],
    density: Floats,
    gaps: Floats,
    noise: float,
) -> Whitening:
    """Return the coefficients that turn residuals into independent deviations.

    Parameters
    ----------
    grid : ndarray, shape (n,)
        Evenly spaced points k.
    ends : (float or None, float or None)
        First and last level of the list, beyond which the levels are unknown; None if they are known.
    density : ndarray, shape (n,)
        Mean density of levels at each point.
    gaps : ndarray, shape (n, BEFORE + 1)
        Covariance of point t with the points t - BEFORE .. t from missing levels (`covariance_of_gaps`).
    noise : float
        Scatter of the levels of the list, in mean spacings.
    """
    n, size = len(grid), BEFORE + 1
    step = grid[1] - grid[0]
    lag = np.arange(size)
    apart = np.abs(lag[:, None] - lag)
    between = apart * step
    same = covariance_of_error(lag * step, perimeter, mixed, cutoff)[apart] + _NUGGET**2 * np.eye(size)
    index = np.arange(n)[:, None] - BEFORE + lag
    outside = index < 0
    index = np.maximum(index, 0)
    full = np.broadcast_to(same, (n, size, size)).copy()
    rows, columns = np.maximum(lag[:, None], lag), BEFORE - apart
    full += gaps[np.clip(np.arange(n)[:, None, None] - BEFORE + rows, 0, n - 1), columns]
    if noise:
        kernel = np.exp(-((cutoff * between) ** 2) / 4) * noise**2 * cutoff / (2 * math.sqrt(math.pi))
        full += kernel / density[:, None, None]
    for end, inside in zip(ends, (1, -1), strict=True):
        if end is None:
            continue
        x = cutoff * inside * (grid - end)
        psi = _END_FACTOR * _of_end(mixed, density / cutoff) * np.interp(x, _END_X, _END_PSI)
        near = np.flatnonzero((psi[index] > 0).any(axis=1))
        at, effect = x[index[near]], psi[index[near]]
        correlated = np.exp(-((at[:, :, None] - at[:, None, :]) ** 2) / _END_CORRELATION)
        full[near] += effect[:, :, None] * effect[:, None, :] * correlated
    full[:BEFORE][outside[:BEFORE]] = 0
    full[:BEFORE].swapaxes(1, 2)[outside[:BEFORE]] = 0
    t, j = np.nonzero(outside)
    full[t, j, j] = 1.0
    predicted = np.linalg.solve(full[:, :BEFORE, :BEFORE], full[:, :BEFORE, BEFORE:])[..., 0]
    scale = np.sqrt(full[:, BEFORE, BEFORE] - (predicted * full[:, :BEFORE, BEFORE]).sum(axis=1))
    weights = np.concatenate([-predicted, np.ones((n, 1))], axis=1) / scale[:, None]
    return Whitening(weights, np.log(scale))


def _of_end(mixed: bool, crowded: Floats) -> Floats:
    """Return the rms effect of the unknown levels beyond an end, for the levels within 1/X."""
    return 0.2 + 0.065 * crowded if mixed else 0.15 + 0.045 * crowded


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
