"""A list of levels beside the staircase from the orbits: their difference, and what may explain it."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.level_paths import BACK, Data, Steps, detail
from orbitdb.quantum.spacing_laws import SpacingLaw
from orbitdb.quantum.staircase_errors import ErrorOfOrbits, Gaps, covariance_of_gaps, whitening

CUTOFF = 10.0
"""Cutoff X of the staircase, in units of the radius; a longer one does not help."""

_STEP = 1 / CUTOFF
_BEYOND = 5.0
"""Distance beyond the ends of the list, in units of 1/X, over which levels go on as the orbits say."""
_FINE, _TINY = 200, 1e-9
"""Number of points between an end and this distance at which the orbits are asked, and a least rise."""
_LOST, _GOES_ON = 0.004, 0.9
"""Probability that a whole block of levels was lost, and that such a block goes on at each level."""
_IMPROBABLE = 18.0
"""Steps less probable than the best one by this much in ln P are not tried."""
_WIDE, _NEGLIGIBLE = 0.8, 2e-3
"""Least width of gaps, in mean spacings, and least probability, for which missing levels add errors."""
_ORDERS = 24
"""How many numbers of missing levels are tried for each gap."""
_FIRSTS, _FIRSTS_MIXED = 6, 8
"""How far the first number of a window can be from what the orbits say at its beginning."""
_LEAST_DENSITY = 0.1
_PART = 256


@dataclass(frozen=True)
class Rates:
    """Probabilities that a level is missing, and spurious, and the variance of the deviations."""

    missing: float = 0.1
    spurious: float = 0.003
    tau2: float = 1.5


class Comparison:
    """A list of levels beside the staircase from the orbits.

    Parameters
    ----------
    k : ndarray, shape (n,)
        The levels of the list, in 1/radius.
    count : callable
        Number of levels below k according to the orbits, with the cutoff `CUTOFF`.
    smooth : Polynomial
        Weyl's law.
    error : ErrorOfOrbits
        What the error of the orbits depends on.
    window : bool
        Whether the list may begin with any level.
    noise : float
        Scatter of the levels, in mean spacings.
    """

    def __init__(
        self,
        k: Floats,
        count: Callable[[Floats], Floats],
        smooth: Polynomial,
        error: ErrorOfOrbits,
        window: bool,
        noise: float,
    ) -> None:
        self.k, self.count, self.smooth, self.error = k, count, smooth, error
        self.window, self.noise = window, noise
        low = k[0] - _STEP if window else max(k[0] - _STEP, _STEP / 2)
        self.grid = low + _STEP * np.arange(math.ceil((k[-1] - low) / _STEP) + 2)
        self.law = SpacingLaw(error.parts, noise)
        self.difference = self.excess(self.grid)

    def density(self, k: Floats) -> Floats:
        """Return the mean density of levels."""
        return np.asarray(np.maximum(self.smooth.deriv()(k), _LEAST_DENSITY))

    @property
    def crowded(self) -> Floats:
        """Number of levels within 1/X, the resolution of the orbits, at each level, shape (n,)."""
        return self.density(self.k) / CUTOFF

    def excess(self, k: Floats, scale: float = 1.0) -> Floats:
        """Return the number of levels below k according to the orbits, minus the smoothed number in the list.

        `scale` multiplies k and the levels of the list.
        """
        first, last, far = self.k[0], self.k[-1], _BEYOND / CUTOFF
        low = max(first - far, 0.0) if self.window else first
        below, above = self._beyond(first, low, scale)[::-1], self._beyond(last, last + far, scale)
        own = smoothed(k, np.concatenate([below, self.k, above]), CUTOFF * scale) - len(below)
        return np.asarray(self.count(k * scale) - own)

    def _beyond(self, end: float, far: float, scale: float) -> Floats:
        """Return where levels go on beyond an end of the list: where the orbits have counted one more."""
        k = np.linspace(end, far, _FINE)
        counted = self.count(k * scale)
        more = np.maximum.accumulate(counted - counted[0] if far > end else counted[0] - counted)
        rising = more + _TINY * np.arange(_FINE)
        return np.interp(np.arange(1, math.floor(more[-1]) + 1), rising, k)

    def part(self, count: int) -> "Comparison":
        """Return the comparison of the first levels of the list."""
        return self._of(self.k[:count], self.window)

    def stretch(self, first: int, count: int) -> "Comparison":
        """Return the comparison of some levels from the middle of the list, as a window."""
        return self._of(self.k[first : first + count], True)

    def scaled(self, scale: float) -> "Comparison":
        """Return the comparison with all levels multiplied by a scale."""
        return self.moved(self.k * scale)

    def moved(self, k: Floats) -> "Comparison":
        """Return the comparison of the same levels at other places."""
        return self._of(k, self.window)

    def _of(self, k: Floats, window: bool) -> "Comparison":
        return Comparison(k, self.count, self.smooth, self.error, window, self.noise)

    def firsts(self, difference: Floats) -> Integers:
        """Return the numbers of levels that may be missing below the list, as far as steps do not tell.

        `difference` is that of this list on the grid, possibly with another scale.
        """
        if not self.window:
            return np.zeros(1, np.int64)
        reach = _FIRSTS_MIXED if self.error.mixed else _FIRSTS
        middle = max(round(float(np.median(difference[1:4]))), 0)
        return np.arange(max(middle - reach, 0), middle + reach + 1)

    def steps(self, rates: Rates) -> Steps:
        """Return the steps to each level and their probabilities by the spacing laws.

        A list that is no window begins with a step from k = 0.
        """
        n = len(self.k)
        level, back = np.repeat(np.arange(n), BACK), np.tile(np.arange(1, BACK + 1), n)
        before = np.maximum(level - back, -1) + 1
        counted = np.append(0.0, self.smooth(self.k) + 0.5)
        distance = counted[level + 1] - counted[before]
        m = np.maximum(0, np.floor(distance).astype(np.int64) - _ORDERS // 2)[:, None] + np.arange(_ORDERS)
        weight = self.law.log_density(m, distance[:, None]) + _log_missing(m, rates.missing)
        from_start = level - back == -1
        if self.window:
            m[from_start], weight[from_start, 0], weight[from_start, 1:] = np.arange(_ORDERS), 0.0, -np.inf
        weight += math.log(1 - rates.spurious)
        tried = weight > weight.max(axis=1, keepdims=True) - _IMPROBABLE
        spurious = np.full((len(level), 1), math.log(rates.spurious))
        m = np.concatenate([m, np.full((len(level), 1), -1)], axis=1)
        weight = np.concatenate([weight, spurious], axis=1)
        tried = np.concatenate([tried, back[:, None] < BACK], axis=1) & (level - back >= -1)[:, None]
        row, column = tried.nonzero()
        return Steps(
            np.searchsorted(row, np.arange(len(level) + 1)),
            level[row],
            back[row],
            m[row, column],
            np.append(0.0, self.k)[before[row]],
            weight[row, column],
        )

    def data(self, steps: Steps, probability: Floats | None, tau2: float) -> Data:
        """Return the data for paths; `probability` is that of the steps, if it is known."""
        share = _among_alternatives(steps)
        if probability is not None:
            share = np.maximum(share, probability)
        high = self.k[steps.level]
        width = (high - steps.low) * self.density((high + steps.low) / 2)
        some = (steps.missing > 0) & (share > _NEGLIGIBLE) & (width > _WIDE)
        variances = self.law.variances(int(steps.missing[some].max(initial=1)) + 1)
        gaps = Gaps(steps.low[some], high[some], steps.missing[some], share[some])
        ends = (float(self.k[0]) if self.window else None, float(self.k[-1]))
        fine = detail(float(self.crowded[len(self.k) // 2]))
        white = whitening(
            self.grid,
            self.error,
            ends,
            self.density(self.grid),
            covariance_of_gaps(self.grid, CUTOFF, gaps, variances),
            self.noise,
            fine.same,
            fine.memory,
        )
        return Data(self.k, self.grid, self.difference, CUTOFF, white, tau2, fine)

    def residual(self, steps: Steps, drawn: NDArray[np.int32], first: int) -> Floats:
        """Return what is left of the difference on a path, shape (G,)."""
        spurious = self.k[steps.missing[drawn] < 0]
        missing = np.sort(places(self.k, steps, drawn))
        left = self.difference - first - smoothed(self.grid, missing, CUTOFF)
        return np.asarray(left + smoothed(self.grid, spurious, CUTOFF))


def _log_missing(m: Integers, rate: float) -> Floats:
    """Return ln of the probability that m levels in a row are missing."""
    one_by_one = math.log((1 - _LOST) * (1 - rate)) + m * math.log(rate)
    return np.asarray(np.logaddexp(one_by_one, math.log(_LOST * (1 - _GOES_ON)) + m * math.log(_GOES_ON)))


def _among_alternatives(steps: Steps) -> Floats:
    """Return the probability of each step among those between the same two levels; 0 unless neighbours."""
    count = np.diff(steps.start)
    group = np.repeat(np.arange(len(count)), count)
    true = steps.missing >= 0
    weight = np.where(true, np.exp(np.where(true, steps.log_weight, 0.0)), 0.0)
    total = np.bincount(group, weight, len(count))[group]
    return np.where((steps.back == 1) & (total > 0), weight / np.where(total > 0, total, 1.0), 0.0)


def places(k: Floats, steps: Steps, drawn: NDArray[np.int32]) -> Floats:
    """Return the places of the missing levels on a path, evenly in their gaps."""
    m = np.maximum(steps.missing[drawn], 0)
    gap = np.repeat(np.arange(len(m)), m)
    j = np.arange(len(gap)) - np.repeat(np.cumsum(m) - m, m) + 1
    low = steps.low[drawn][gap]
    return np.asarray(low + (k[gap] - low) * j / (m[gap] + 1))


def smoothed(k: Floats, levels: Floats, cutoff: float) -> Floats:
    """Return the number of levels below each k, smoothed with a Gaussian of width 1/cutoff."""
    counts = []
    for first in range(0, len(k), _PART):
        part = k[first : first + _PART]
        low, high = np.searchsorted(levels, [part[0] - 9 / cutoff, part[-1] + 9 / cutoff])
        counts.append(low + ndtr(cutoff * (part[:, None] - levels[low:high])).sum(axis=1))
    return np.concatenate(counts)
