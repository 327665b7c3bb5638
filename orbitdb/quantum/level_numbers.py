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

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

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

_KEPT = 8

_MOVES = (1, 2, 3, 5)
"""Number of levels across which a missing level is moved in one step."""
_PASSES = 20
_REACH = 5.0
"""Distance, in units of 1/X, beyond which a level has no effect on the smoothed staircase."""


def numbered(
    expected: Floats, sigma: float | Floats, place: Floats, independent: int = 1, first_free: bool = False
) -> tuple[Integers, Floats]:
    """Return the true numbers of levels that have the lowest cost, for S lists at once.

    Parameters
    ----------
    expected : ndarray, shape (S, N)
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
    number : ndarray of int, shape (S, N)
        True numbers, counted from 1 and increasing along each list; 0 for spurious levels.
    cost : ndarray, shape (S,)
        Total cost of each list.
    """
    lists, count = expected.shape
    low = np.maximum.accumulate(np.floor(expected).astype(np.int64), axis=1) - _BAND
    offset = np.arange(2 * _BAND + 2)
    sigma, gaps = np.broadcast_to(sigma, count), np.diff(place, prepend=place[0])
    came = np.zeros((count, lists, 2, len(offset)), np.int8)
    # cost[s, 0, j] is the lowest cost with the last level assigned the number base[s] + j, cost[s, 1, j] with
    # the last level spurious and base[s] + j the last number that is settled
    base = low[:, :1] + offset
    start = np.where(base >= 0, 0.0 if first_free else MISSING * base, np.inf)
    cost = np.stack([np.full_like(start, np.inf), start], axis=1)
    rises: dict[bytes, _Rise] = {}  # most levels of a list have one of a few
    for i in range(count):
        number = low[:, i, None] + offset
        rise = number[:, :, None] - base[:, None]
        key = rise[:, 0, 0].tobytes()
        if key not in rises:
            if len(rises) == _KEPT:
                rises.clear()
            rises[key] = _Rise.of(rise, independent)
        skipping, counted, spread, rare = rises[key]
        spurious = cost[:, :, None] + (skipping + SPURIOUS)[:, None]
        true = cost[:, :, None] + counted[:, None]
        true[:, 0] += _tailed(np.abs(gaps[i] - rise) / spread) + rare
        both = np.stack([true, spurious], axis=1).transpose(0, 1, 3, 2, 4).reshape(lists, 2, len(offset), -1)
        came[i] = both.argmin(axis=3)
        cost = both.min(axis=3)
        off = np.where(number >= 1, (expected[:, i, None] - number) ** 2 / (2 * sigma[i] ** 2), np.inf)
        cost[:, 0] += off
        base = number
    return _traced(cost, came, low)


class _Rise(NamedTuple):
    """Costs of the rise from each number in a band to each in the next, shape (S, B, B) each."""

    skipping: Floats
    """Cost of the numbers that are skipped if the level is spurious; infinite for a fall."""
    counted: Floats
    """The same if the level takes the last number."""
    spread: Floats
    rare: Floats

    @classmethod
    def of(cls, rise: Integers, independent: int) -> "_Rise":
        spread, rare = _spread(rise, independent)
        skipping = np.where(rise >= 0, MISSING * rise, np.inf)
        return cls(skipping, np.where(rise >= 1, skipping - MISSING, np.inf), spread, rare)


def distance_cost(gap: float, rise: int, independent: int) -> float:
    """Return the cost of a distance, in mean spacings, of two levels whose true numbers differ by `rise`.

    Near its mean it is (gap - rise)^2 / (2 v) + ln(v) / 2, up to a constant, where v is the variance.
    """
    spread, rare = _spread(np.array(rise), independent)
    return float(_tailed(np.abs(gap - rise) / spread) + rare)


def _spread(rise: Integers, independent: int) -> tuple[Floats, Floats]:
    variance = neighbour_variance(independent)
    v = variance[np.clip(rise, 1, _MOST_SKIPPED)]
    return np.sqrt(v), (np.log(v / variance[1]) - 1) / 2


def _tailed(z: Floats) -> Floats:
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


def _traced(cost: Floats, came: NDArray[np.int8], low: Integers) -> tuple[Integers, Floats]:
    """Trace the cheapest assignment of each list back from its last level; return numbers and costs."""
    count, lists, _, width = came.shape
    every, state = np.arange(lists), cost.reshape(lists, -1).argmin(axis=1)
    least = cost.reshape(lists, -1)[every, state]
    number = np.zeros((lists, count), np.int64)
    for i in range(count - 1, -1, -1):
        spurious, place = np.divmod(state, width)
        number[:, i] = np.where(spurious == 0, low[:, i] + place, 0)
        state = came[i][every, spurious, place].astype(np.intp)
    return number, least


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
    for _ in range(_PASSES):
        if not list_.improve():
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
        """Return the levels that notice what happens in the gaps from `first` to `last`."""
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
        """Return what a gap with `more` missing levels than now adds to the staircase, and what it costs."""
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

    def improve(self) -> bool:
        """Make the best move at each gap with missing levels and at both ends; return whether there was any.

        A move shifts the numbers of successive true levels by 1 in the direction `step`.
        """
        end = len(self.true)
        moves = [[(0, n, -1) for n in _MOVES], [(end - n, end, 1) for n in _MOVES]]
        moves += [
            [*((gap, gap + n, -1) for n in _MOVES), *((gap - n, gap, 1) for n in _MOVES)]
            for gap in self.with_missing()
        ]
        moved = False
        for choices in moves:
            changes = [self.change(*move) for move in choices if move[0] >= 0 and move[1] <= end]
            cost, run, step, rows, delta = min(changes, key=lambda change: change[0], default=_NO_MOVE)
            if cost < -1e-9:
                self.number[run] += step
                self.residual[rows] += delta
                moved = True
        return moved

    def change(
        self, first: int, last: int, step: int
    ) -> tuple[float, NDArray[np.intp], int, slice, Floats | float]:
        """Return by how much it changes the cost to shift the true levels from `first` to before `last`."""
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
