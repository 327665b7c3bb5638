"""Number the levels of a list in which some levels are missing and others spurious, at the lowest cost.

The orbits give the i-th level of the list a number x_i, which is not an integer. Its true number n_i
increases with i and costs (x_i - n_i)^2 / (2 sigma_i^2). Each skipped number costs `MISSING`, each spurious
level `SPURIOUS`. Dynamic programming finds the cheapest assignment (`numbered`).

The orbits see a step of the staircase smoothed over several levels, so this puts some missing levels a few
gaps away from their places. `Filling` then moves all of them together to where the staircase from the orbits
has them.
"""

import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers

MISSING, SPURIOUS = 6.0, 8.0
"""Cost of a missing level, and of a spurious one, which is rarer in practice."""

_BAND = 12
"""Maximum distance between the true number and the expected number of a level."""
_WIDTH = 2 * _BAND + 2
"""Number of true numbers to choose from for each level."""
_PLACED, _PLACED_END = 0.05, 5.0
"""Uncertainty of the excess with which missing levels are placed, and how much more it is at an end."""
_WAVE, _LARGE = 0.033, 0.5
"""Amplitude expected of each wave; larger residuals than this are cut, because levels are misplaced there."""
_STRETCH = 12.0
"""Approximate length of the stretches of k in which waves are fitted."""
_STEPS, _LONGEST, _SETTLED, _DAMPING = 15, 0.4, 0.02, 3.0
"""Number of steps; the longest and the last of them, and their damping, in mean spacings."""
_LEAST_DENSITY = 0.1
_TURNS, _GAPS, _ROWS = 3, 9, 60
"""Number of times to look for levels missing at the ends, of levels between which to look, and of levels at
which to compare the residual."""
_DOUBT = 1.6
"""Cost of a change at an end for each spectrum after the first, because levels beyond the end matter more."""
_FILLED, _FILLED_END = 1.2, 2.3
"""Uncertainty once the missing levels are filled in, in units of the scatter, and the factor at an end."""
_LEAST_SPREAD = 0.08
"""Lower limit for the scatter in these uncertainties."""
_PART = 256


def numbered(expected: Floats, sigma: Floats, first_free: bool = False) -> tuple[Integers, float]:
    """Return the true numbers of N levels that have the lowest cost, and this cost.

    True numbers are counted from 1 and increase; spurious levels have 0.

    Parameters
    ----------
    expected, sigma : ndarray, shape (N,)
        Number of each level according to the orbits, not rounded to an integer, and its uncertainty.
    first_free : bool, optional
        Whether the list may begin with any number; otherwise numbers below its first level count as missing.
    """
    low = np.maximum.accumulate(np.floor(expected).astype(np.int64)) - _BAND
    number = low[:, None] + np.arange(_WIDTH)
    off = (expected[:, None] - number) ** 2 / (2 * sigma[:, None] ** 2)
    true = (off <= MISSING + SPURIOUS) & (number > 0)  # otherwise a spurious and a missing level cost less
    off = np.where(true, off, MISSING + SPURIOUS)
    came = np.zeros(number.shape, np.int8)
    # cost[j] is the lowest cost so far if the last true number is the j-th of the band
    cost = np.where(number[0] >= 0, 0.0 if first_free else MISSING * number[0], np.inf)
    for i, shift in enumerate(np.diff(low, prepend=low[0]).tolist()):
        skipping, stays = _rises(shift)
        changed = cost + np.where(stays, SPURIOUS, skipping + off[i, :, None])
        came[i] = changed.argmin(axis=1)
        cost = changed.min(axis=1)
    place, numbers = int(cost.argmin()), np.zeros(len(expected), np.int64)
    for i in range(len(expected) - 1, -1, -1):
        before = int(came[i, place])
        if true[i, place] and number[i, place] > number[max(i - 1, 0), before]:
            numbers[i] = number[i, place]
        place = before
    return numbers, float(cost.min())


@lru_cache(maxsize=64)
def _rises(shift: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the costs of the numbers skipped between two bands, the second of which is `shift` higher.

    The second result tells where the number stays the same.
    """
    rise = np.subtract.outer(np.arange(_WIDTH), np.arange(_WIDTH)) + shift
    return np.where(rise >= 1, MISSING * (rise - 1), np.inf), rise == 0


class Filling:
    """Fills in the missing levels of a list, all at once, where the orbits put them.

    The places y of the missing levels minimise the rms of the residual

        excess - (levels missing below the first) - sum over y of Phi(X (k - y)) - waves.

    The waves have the lengths at which the orbits are wrong. They are fitted, for each stretch of k, together
    with the places, so that these lengths do not affect the places.

    Parameters
    ----------
    k : ndarray, shape (N,)
        The levels of the list, in 1/radius.
    smooth : Polynomial
        Weyl's law.
    end : ndarray, shape (N,)
        How near each level is to an end of the list: 1 at the end, 0 far from it.
    cutoff : float
        The cutoff X of the staircase from the orbits.
    lengths : ndarray, shape (2,)
        Least and largest length of the waves.
    independent : int
        Number of independent spectra in the list: 4 if it has levels of all parities, otherwise 1.
    first_free : bool
        As for `numbered`.
    """

    def __init__(
        self,
        k: Floats,
        smooth: Polynomial,
        end: Floats,
        cutoff: float,
        lengths: Floats,
        independent: int,
        first_free: bool,
    ) -> None:
        self.k, self.end, self.cutoff = k, end, cutoff
        self.density = smooth.deriv()
        self.independent, self.first_free = independent, first_free
        self.sigma = _PLACED * (1 + _PLACED_END * end)
        count = max(1, math.ceil(np.ptp(k) / _STRETCH))
        bounds = np.linspace(0, len(k), count + 1).astype(int).tolist()
        self.ends = k[bounds[1:-1]]
        self.stretches = [(slice(*pair), self._waves(slice(*pair), lengths)) for pair in pairwise(bounds)]

    def _waves(self, rows: slice, lengths: Floats) -> Floats:
        """Return waves Q such that Q Q^T r is their fit to a residual r, both in units of sigma."""
        k = self.k[rows]
        count = math.ceil(np.ptp(k) * np.ptp(lengths) / (2 * math.pi)) + 1
        phase = k[:, None] * np.linspace(lengths[0], lengths[1], max(count, 2))
        waves = np.concatenate([np.cos(phase), np.sin(phase)], axis=1) / self.sigma[rows, None]
        normal = waves.T @ waves + np.eye(waves.shape[1]) / _WAVE**2
        return np.linalg.solve(np.linalg.cholesky(normal), waves.T).T

    def filled(self, number: Integers, excess: Floats) -> tuple[Integers, Floats]:
        """Return the true numbers, and the excess that remains once the missing levels are filled in.

        `number` has true numbers from which to begin. `excess` is the number of levels below each k from the
        orbits, minus that of the list smoothed with the same X.
        """
        true = np.flatnonzero(number > 0)
        if not len(true):
            return number, excess
        k, first = self.k[true], int(number[true[0]]) - 1
        missing = np.setdiff1d(np.arange(first + 1, number[true[-1]]), number[true])
        y = np.interp(missing, number[true], k)
        rest = excess + smoothed(self.k, self.k[number == 0], self.cutoff)
        for _ in range(_TURNS):
            y = self._settled(y, rest - first)
            residual = rest - first - smoothed(self.k, y, self.cutoff)
            lower, more = self._at_ends(residual - self._fitted(residual), first)
            if not more:
                break
            first, y = first - lower, np.sort([*y, *more])
        number = number.copy()
        number[true] = first + 1 + np.arange(len(true)) + np.searchsorted(y, k)
        return number, residual

    def _fitted(self, residual: Floats) -> Floats:
        """Return the waves in a residual."""
        off = np.clip(residual, -_LARGE, _LARGE) / self.sigma
        return self.sigma * np.concatenate([waves @ (off[rows] @ waves) for rows, waves in self.stretches])

    def _settled(self, y: Floats, rest: Floats) -> Floats:
        """Return the places, in ascending order, that minimise the residual, by damped Gauss-Newton steps."""
        for _ in range(_STEPS):
            off, step = (rest - smoothed(self.k, y, self.cutoff)) / self.sigma, np.zeros(len(y))
            density = np.maximum(self.density(y), _LEAST_DENSITY)
            stretch = np.searchsorted(self.ends, y)
            for n in np.unique(stretch).tolist():
                inside, (rows, waves) = stretch == n, self.stretches[n]
                z = self.cutoff * (self.k[rows, None] - y[inside])
                slope = -self.cutoff * np.exp(-(z**2) / 2) / math.sqrt(2 * math.pi) / self.sigma[rows, None]
                slope_of_rest = slope - waves @ (waves.T @ slope)
                normal = slope.T @ slope_of_rest + np.diag((density[inside] / _DAMPING) ** 2)
                step[inside] = np.linalg.solve(normal, slope_of_rest.T @ off[rows])
            step = np.clip(step, -_LONGEST / density, _LONGEST / density)
            y = np.sort(y + step)
            if (np.abs(step * density) < _SETTLED).all():
                break
        return y

    def _at_ends(self, residual: Floats, first: int) -> tuple[int, list[float]]:
        """Return levels missing near the ends, and how many of them are taken from those below the first."""
        spread = 1.4826 * float(np.median(np.abs(residual)))
        sigma = filled_sigma(spread, self.end)
        lower, more = 0, []
        for low in (True, False) if first else (False,):
            rows, near = (slice(_ROWS), slice(_GAPS)) if low else (slice(-_ROWS, None), slice(-_GAPS, None))
            middle = (self.k[near][1:] + self.k[near][:-1]) / 2
            before = residual[rows, None]
            after = before + low - ndtr(self.cutoff * (self.k[rows, None] - middle))
            cost = ((after**2 - before**2) / (2 * sigma[rows, None] ** 2)).sum(axis=0)
            cost += (0 if low and not self.first_free else MISSING) + _DOUBT * (self.independent - 1)
            if cost.min() < 0:
                more.append(float(middle[cost.argmin()]))
                lower += low
        return lower, more


def filled_sigma(spread: float, end: Floats) -> Floats:
    """Return the uncertainty of the excess at each level once the missing levels are filled in."""
    return np.asarray(_FILLED * max(spread, _LEAST_SPREAD) * (1 + (_FILLED_END - 1) * end))


def smoothed(k: Floats, levels: Floats, cutoff: float) -> Floats:
    """Return the number of levels below each k, smoothed with a Gaussian of width 1/cutoff."""
    counts = []
    for first in range(0, len(k), _PART):
        part = k[first : first + _PART]
        low, high = np.searchsorted(levels, [part[0] - 9 / cutoff, part[-1] + 9 / cutoff])
        counts.append(low + ndtr(cutoff * (part[:, None] - levels[low:high])).sum(axis=1))
    return np.concatenate(counts)
