"""Number the levels of a list in which some levels are missing and others spurious, at the lowest cost.

The orbits give the i-th level of the list a number x_i, which is not an integer. Its true number n_i
increases with i and costs (x_i - n_i)^2 / (2 sigma_i^2). Each skipped number costs `MISSING`, each spurious
level `SPURIOUS`. The distance of two neighbours of the list with m numbers skipped between them costs as much
as it is unlikely in random matrices (`distance_cost`). Dynamic programming finds the cheapest assignment
(`numbered`).

The orbits see a step of the staircase smoothed over several levels, so the first assignment may put a missing
level a few gaps away from its place. `rearranged` therefore fills in the missing levels and moves them to
neighbouring gaps as long as the filled list agrees better with the orbits.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.level_statistics import goe_variance

MISSING, SPURIOUS = 6.0, 8.0
"""Cost of a missing level, and of a spurious one, which is rarer in practice."""

_BAND = 12
"""Maximum distance between the true number and the expected number of a level."""
_TAIL = 1.5
"""Number of standard deviations beyond which the cost of a distance grows linearly."""
_MOST_SKIPPED = 200
"""Above this number of skipped levels, the variance of their distance is taken as constant."""

_MOVES = (1, 2, 3, 5)
"""Number of levels across which a missing level is moved in one step."""
_PASSES = 20
_REACH = 5.0
"""Distance, in units of 1/X, beyond which a level has no effect on the smoothed staircase."""


def numbered(
    expected: Floats, sigma: float | Floats, place: Floats, independent: int = 1, first_free: bool = False
) -> tuple[Integers, float]:
    """Return the true numbers of levels that have the lowest cost, and this cost.

    Parameters
    ----------
    expected : ndarray, shape (N,)
        Number of each level according to the orbits, not rounded to an integer.
    sigma : float or ndarray, shape (N,)
        Uncertainty of the expected numbers.
    place : ndarray, shape (N,)
        Smooth number of levels below each level, by Weyl's law; its differences are distances in mean
        spacings.
    independent : int, optional
        Number of independent spectra in the list, 4 if it has levels of all parities.
    first_free : bool, optional
        Whether the list may begin with any number; otherwise, numbers that it skips below its first level
        count as missing.

    Returns
    -------
    number : ndarray of int, shape (N,)
        True numbers, counted from 1 and increasing; 0 for spurious levels.
    cost : float
    """
    count, offset = len(expected), np.arange(2 * _BAND + 2)
    low = np.maximum.accumulate(np.floor(expected).astype(np.int64)) - _BAND
    number = low[:, None] + offset
    off = (expected[:, None] - number) ** 2 / (2 * np.broadcast_to(sigma, count)[:, None] ** 2)
    off[number < 1] = np.inf
    shift, gaps = np.diff(low, prepend=low[0]).tolist(), np.diff(place, prepend=place[0]).tolist()
    came = np.zeros((count, 2, len(offset)), np.int8)
    # cost[0, j] is the lowest cost with the last level assigned the j-th number of its band, cost[1, j] with
    # the last level spurious and this number the last that is settled
    start = np.where(number[0] >= 0, 0.0 if first_free else MISSING * number[0], np.inf)
    cost = np.stack([np.full_like(start, np.inf), start])
    for i in range(count):
        skipping, counted, spread, rare = _rise(shift[i], independent)
        true, spurious = cost[:, None] + counted, cost[:, None] + skipping
        true[0] += _tailed(np.abs(gaps[i] - _RISE - shift[i]) / spread) + rare
        both = np.stack([true, spurious]).transpose(0, 2, 1, 3).reshape(2, len(offset), -1)
        came[i] = both.argmin(axis=2)
        cost = both.min(axis=2)
        cost[0] += off[i]
    return _traced(cost, came, low)


_RISE = np.subtract.outer(np.arange(2 * _BAND + 2), np.arange(2 * _BAND + 2))
"""Rises from each number of a band to each number of the next, if the bands are the same."""


@lru_cache(maxsize=64)
def _rise(shift: int, independent: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the costs of the rises from each number of a band to each of the next, which is `shift` higher.

    These are the cost if the level is spurious, the cost if it takes the last number, and, for the distance,
    its standard deviation and a constant.
    """
    rise = _RISE + shift
    variance = neighbour_variance(independent)
    v = variance[np.clip(rise, 1, _MOST_SKIPPED)]
    skipping = np.where(rise >= 0, MISSING * rise, np.inf)
    counted = np.where(rise >= 1, skipping - MISSING, np.inf)
    return skipping + SPURIOUS, counted, np.sqrt(v), (np.log(v / variance[1]) - 1) / 2


def _traced(cost: Floats, came: NDArray[np.int8], low: Integers) -> tuple[Integers, float]:
    """Trace the cheapest assignment back from the last level; return numbers and cost."""
    count, _, width = came.shape
    state = int(cost.argmin())
    number = np.zeros(count, np.int64)
    for i in range(count - 1, -1, -1):
        spurious, place = divmod(state, width)
        number[i] = 0 if spurious else low[i] + place
        state = int(came[i, spurious, place])
    return number, float(cost.min())


def distance_cost(gap: float, rise: int, independent: int) -> float:
    """Return the cost of a distance, in mean spacings, of two levels whose true numbers differ by `rise`.

    Near its mean it is (gap - rise)^2 / (2 v) + ln(v) / 2, up to a constant, where v is the variance.
    """
    variance = neighbour_variance(independent)
    v = float(variance[min(max(rise, 1), _MOST_SKIPPED)])
    return float(_tailed(abs(gap - rise) / math.sqrt(v))) + (math.log(v / float(variance[1])) - 1) / 2


def _tailed(z: float | Floats) -> Floats:
    """Return z^2 / 2, continued as a straight line beyond `_TAIL`."""
    inner = np.minimum(z, _TAIL)
    return np.asarray(inner * (z - inner / 2))


@cache
def neighbour_variance(independent: int) -> Floats:
    """Return the variances of the distance to the n-th neighbour at index n, in mean spacings.

    They are those of the number of levels in a stretch of length n, minus 1/6 (French, Mello and Pandey, Ann.
    Phys. 113 (1978) 277), for a given number of independent spectra.
    """
    n = np.maximum(np.arange(_MOST_SKIPPED + 1), 1)
    return np.asarray(independent * goe_variance(n / independent) - 1 / 6)


def rearranged(
    k: Floats,
    place: Floats,
    number: Integers,
    excess: Floats,
    sigma: Floats,
    cutoff: float,
    independent: int = 1,
    first_free: bool = False,
) -> tuple[Integers, Floats]:
    """Move missing levels to neighbouring gaps, and past the ends, as long as this lowers the cost.

    Parameters
    ----------
    k : ndarray, shape (N,)
        The levels of the list, in 1/radius.
    place, sigma, independent, first_free
        As for `numbered`; sigma has the shape (N,).
    number : ndarray of int, shape (N,)
        True numbers, 0 for spurious levels.
    excess : ndarray, shape (N,)
        Number of levels below each k from the orbits, minus that of the list smoothed with the same cutoff.
    cutoff : float
        The cutoff X of the staircase from the orbits.

    Returns
    -------
    number : ndarray of int, shape (N,)
    residual : ndarray, shape (N,)
        What the excess is with the missing levels filled in, evenly spaced, and the spurious ones left out.
    """
    list_ = _FilledList(k, place, number.copy(), excess.copy(), sigma, cutoff, independent, first_free)
    if not len(list_.true):
        return number, excess
    list_.fill()
    touched = k
    for _ in range(_PASSES):
        touched = list_.improve(touched)
        if not len(touched):
            break
    return list_.number, list_.residual


@dataclass(eq=False)
class _FilledList:
    """A list of levels with its missing levels filled in; see `rearranged`."""

    k: Floats
    place: Floats
    number: Integers
    residual: Floats
    sigma: Floats
    cutoff: float
    independent: int
    first_free: bool

    def __post_init__(self) -> None:
        self.true = np.flatnonzero(self.number > 0)

    def fill(self) -> None:
        """Turn the excess into the residual."""
        for spurious in np.flatnonzero(self.number == 0):
            rows = self.near(self.k[spurious], self.k[spurious])
            self.residual[rows] += ndtr(self.cutoff * (self.k[rows] - self.k[spurious]))
            self.residual[rows.stop :] += 1
        for gap in [0, *self.with_missing()]:
            rows, (effect, _) = self.rows(gap, gap), self.gap(gap, 0, self.rows(gap, gap))
            self.residual[rows] -= effect
            self.residual[rows.stop :] -= self.steps(gap) - 1

    def near(self, low: float, high: float) -> slice:
        away = _REACH / self.cutoff
        return slice(*np.searchsorted(self.k, [low - away, high + away]).tolist())

    def rows(self, first: int, last: int) -> slice:
        """Return the levels that changes in the gaps from `first` to `last` affect."""
        low = self.k[self.true[first - 1]] if first else -np.inf
        return self.near(low, self.k[self.true[last]] if last < len(self.true) else np.inf)

    def steps(self, gap: int) -> int:
        """Return the difference between the numbers of the true levels on both sides of a gap."""
        below = int(self.number[self.true[gap - 1]]) if gap else 0
        return int(self.number[self.true[gap]]) - below

    def with_missing(self) -> list[int]:
        """Return the gaps in which levels are missing; gap n is below the n-th true level, n > 0."""
        return (np.flatnonzero(np.diff(self.number[self.true]) > 1) + 1).tolist()

    def gap(self, gap: int, more: int, rows: slice) -> tuple[Floats | float, float]:
        """Return how `more` missing levels in a gap would change the staircase and the cost."""
        if gap == len(self.true):
            return 0.0, 0.0
        missing = self.steps(gap) - 1 + more
        if missing < 0:
            return 0.0, np.inf
        if gap == 0:
            return float(missing), 0.0 if self.first_free else MISSING * missing
        low, high = self.true[gap - 1], self.true[gap]
        share = np.arange(1, missing + 1) / (missing + 1)
        filled = self.k[low] + (self.k[high] - self.k[low]) * share
        effect = ndtr(self.cutoff * (self.k[rows, None] - filled)).sum(axis=1)
        apart = distance_cost(self.place[high] - self.place[low], missing + 1, self.independent)
        return effect, MISSING * missing + apart

    def improve(self, touched: Floats) -> Floats:
        """Make the best move at each gap with missing levels and at both ends; return the k of moved levels.

        Only gaps near the levels that were `touched` before are tried. A move shifts the numbers of
        successive true levels by 1 in the direction `step`.
        """
        end = len(self.true)
        moves = [[(0, n, -1) for n in _MOVES], [(end - n, end, 1) for n in _MOVES]]
        away = 2 * _REACH / self.cutoff
        for gap in self.with_missing():
            k = self.k[self.true[gap]]
            if np.searchsorted(touched, k - away) < np.searchsorted(touched, k + away):
                moves.append([*((gap, gap + n, -1) for n in _MOVES), *((gap - n, gap, 1) for n in _MOVES)])
        moved = [np.zeros(0)]
        for choices in moves:
            changes = [self.change(*move) for move in choices if move[0] >= 0 and move[1] <= end]
            cost, run, step, rows, delta = min(changes, key=lambda change: change[0], default=_NO_MOVE)
            if cost < -1e-9:
                self.number[run] += step
                self.residual[rows] += delta
                moved.append(self.k[run])
        return np.sort(np.concatenate(moved))

    def change(
        self, first: int, last: int, step: int
    ) -> tuple[float, NDArray[np.intp], int, slice, Floats | float]:
        """Return the change in cost if the true levels from `first` to before `last` are shifted."""
        run, rows = self.true[first:last], self.rows(first, last)
        below, above = self.gap(first, step, rows), self.gap(last, -step, rows)
        if np.isinf(below[1] + above[1]) or (self.number[run] + step < 1).any():
            return (np.inf, run, step, rows, 0.0)
        now = self.gap(first, 0, rows), self.gap(last, 0, rows)
        delta = now[0][0] + now[1][0] - below[0] - above[0]
        before, weight = self.residual[rows], 2 * self.sigma[rows] ** 2
        cost = float((((before + delta) ** 2 - before**2) / weight).sum())
        return cost + below[1] + above[1] - now[0][1] - now[1][1], run, step, rows, delta


_NO_MOVE = (0.0, np.zeros(0, np.intp), 0, slice(0), 0.0)
