"""Find missing and spurious levels in a list by comparison with the staircase of the orbits.

A missing level shifts N_X(k_i) - i by one from there on (`orbitdb.quantum.staircase`). Each k_i gets a true
number n_i, rising with i, at the cost (N_X(k_i) - n_i + 1/2)^2 / (2 sigma^2). A skipped number and a k_i
treated as spurious cost `LEFT_OUT` each. Dynamic programming finds the cheapest assignment, for many scales
of k at once if the radius is to be fitted too.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers
from orbitdb.equality import ByValue
from orbitdb.extras import Drawn, data_frame
from orbitdb.quantum.amplitudes import Parity
from orbitdb.quantum.staircase import Staircase

if TYPE_CHECKING:
    import pandas


CUTOFF, CUTOFF_OF_ALL = 12.0, 16.0
"""Cutoff X of the staircase for lists of one parity and of all levels."""

LEFT_OUT = 6.0
"""Cost of a missing or a spurious level."""

_SPREAD, _LEAST_SPREAD = 0.08, 0.12
"""sigma of complete lists is the first times the root of the density of levels, and at least the second."""

_BAND = 12
"""Largest distance of true numbers from the staircase."""

_WIDEST = 0.005
"""Largest relative correction of a fitted radius."""
_SCALES, _FINER, _REFINED = 401, 21, 4
"""Number of scales tried first, number tried around the best one, and number of grids."""
WIDEST = 1 + 2 * _WIDEST
"""End of the staircase needed, in units of the last level."""

_ROUNDS = 3
"""Number of times the spread is estimated and the levels are numbered."""


class Gap(NamedTuple):
    """A place in a list where levels are missing or spurious.

    Attributes
    ----------
    after, before : float or None
        The levels on both sides, in 1/radius; None at the beginning or end of the list.
    missing : int
        Number of missing levels minus the number of spurious or double ones between them.
    """

    after: float | None
    before: float | None
    missing: int


@dataclass(frozen=True, eq=False, repr=False)
class Assessment(ByValue, Drawn):
    """Comparison of a list of levels with the orbits; `plot` draws N_X(k_i) - i + 1/2 and its steps.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    parity : Parity or None
        None for all levels in one list.
    k : ndarray, shape (N,)
        The levels in rising order, in 1/radius, scaled by `scale`.
    number : ndarray of int, shape (N,)
        Their true numbers, counted from 1; 0 for spurious levels.
    expected : ndarray, shape (N,)
        N_X at each level.
    sigma : ndarray, shape (N,)
        Typical difference between expected and true numbers.
    scale, scale_error : float
        The fitted radius divided by the given one, and its standard error; 1 and 0 if it was not fitted.
    cost : float
        Cost of the assignment; lower is better.
    """

    a: float
    parity: Parity | None
    k: Floats
    number: Integers
    expected: Floats
    sigma: Floats
    scale: float
    scale_error: float
    cost: float

    def __len__(self) -> int:
        return len(self.k)

    def __repr__(self) -> str:
        return f"<{self.verdict()}>"

    @property
    def gaps(self) -> list[Gap]:
        """The places where levels are missing or spurious, in rising order."""
        found: list[Gap] = []
        after, last, spurious = None, 0, 0
        for k, number in zip([*self.k.tolist(), None], [*self.number.tolist(), None], strict=True):
            if number == 0:
                spurious += 1
                continue
            missing = 0 if number is None else number - last - 1
            if missing - spurious or (missing and spurious):
                found.append(Gap(after, k, missing - spurious))
            after, last, spurious = k, number or 0, 0
        return found

    @property
    def missing(self) -> int:
        """Number of levels missing below the last one."""
        return int(self.number.max(initial=0)) - int((self.number > 0).sum())

    @property
    def spurious(self) -> int:
        """Number of spurious or double levels in the list."""
        return int((self.number == 0).sum())

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the gaps as a data frame, with the columns after, before and missing."""
        return data_frame(self.gaps, Gap._fields)

    def _figure(self) -> tuple[str, Sequence[Any], str]:
        return "curves.draw_assessment", (self,), self.verdict()

    def verdict(self) -> str:
        """Say in one sentence which levels are missing or spurious."""
        of = f" of {int(self.number.max(initial=0))}, k from 0 to {self.k[-1]:.4g}"
        none = self.spurious
        extra = f"; {none} {'is' if none == 1 else 'are'} spurious or double" if none else ""
        if not self.missing:
            return f"no level is missing{of}{extra}"
        are = "level is" if self.missing == 1 else "levels are"
        return f"{self.missing} {are} missing{of}{extra}"


def assess(
    k: Floats, orbits: Staircase, a: float, parity: Parity | None = None, fit_scale: bool = False
) -> Assessment:
    """Compare a list of levels with the staircase of the orbits.

    Parameters
    ----------
    k : ndarray, shape (N,)
        Levels in rising order, in 1/radius.
    orbits : Staircase
        For one cutoff, up to `WIDEST` times the last level.
    a : float
        Half length of the stadium.
    parity : Parity, optional
        Parity of the levels; None if the list has all levels.
    fit_scale : bool, optional
        Whether to fit the radius, within half a per cent.
    """
    density = np.gradient(orbits.smooth, orbits.k)
    wider = 1.0
    scale, scale_error = 1.0, 0.0
    for _ in range(_ROUNDS):
        if fit_scale:
            scale, scale_error = _fitted(k, orbits, density, wider, scale if scale_error else None)
        expected, sigma = _held(k[None, :] * scale, orbits, density, wider)
        numbers, cost = numbered(expected, sigma)
        number = numbers[0]
        true = number > 0
        off = (expected[0] - number + 0.5)[true] / (sigma[0, true] / wider)
        spread = float(1.4826 * np.median(np.abs(off))) if true.any() else 1.0
        if spread <= wider * 1.05:
            break
        wider = spread
    return Assessment(a, parity, k * scale, number, expected[0], sigma[0], scale, scale_error, float(cost[0]))


def misfit(k: Floats, orbits: Staircase) -> float:
    """Return the least cost of numbering levels, with the spread of complete lists."""
    density = np.gradient(orbits.smooth, orbits.k)
    return float(numbered(*_held(k[None, :], orbits, density, 1.0))[1][0])


def _held(k: Floats, orbits: Staircase, density: Floats, wider: float) -> tuple[Floats, Floats]:
    """Return N_X and sigma at levels for several scales, shape (S, N)."""
    expected = orbits.at(k.ravel())[0].reshape(k.shape)
    at = np.maximum(np.interp(k, orbits.k, density), 0.0)
    return expected, wider * np.maximum(_SPREAD * np.sqrt(at), _LEAST_SPREAD)


def _fitted(
    k: Floats, orbits: Staircase, density: Floats, wider: float, near: float | None
) -> tuple[float, float]:
    """Return the scale of k with the least cost, searched on finer and finer grids, and its standard error.

    The error assumes independent deviations of the levels.
    """
    step = 2 * _WIDEST / (_SCALES - 1)
    scales = np.linspace(1 - _WIDEST, 1 + _WIDEST, _SCALES)
    if near is not None:
        scales = near + step * np.linspace(-1, 1, _FINER)
    best = 1.0
    for _ in range(_REFINED):
        costs = numbered(*_held(k * scales[:, None], orbits, density, wider))[1]
        best = float(scales[costs.argmin()])
        scales, step = best + step * np.linspace(-1, 1, _FINER), 2 * step / (_FINER - 1)
    _, sigma = _held(k[None, :] * best, orbits, density, wider)
    shift = k * best * np.interp(k * best, orbits.k, density) / sigma[0]
    return best, float(1 / math.sqrt((shift**2).sum()))


def numbered(expected: Floats, sigma: Floats) -> tuple[Integers, Floats]:
    """Return the true numbers of levels with the least cost, for several lists at once.

    Parameters
    ----------
    expected, sigma : ndarray, shape (S, N)
        N_X at each level in rising order, and its uncertainty.

    Returns
    -------
    number : ndarray of int, shape (S, N)
        Rising numbers from 1; 0 for spurious levels.
    cost : ndarray, shape (S,)
    """
    lists, count = expected.shape
    low = np.maximum.accumulate(np.floor(expected).astype(np.int64), axis=1) - _BAND
    width = 2 * _BAND + 2
    offset = np.arange(width)
    # total[s, j]: the least cost at which all numbers up to base[s] + j are settled
    base = low[:, 0]
    settled = base[:, None] + offset
    total = np.where(settled >= 0, LEFT_OUT * settled, np.inf)
    taken = np.zeros((count, lists, width), bool)
    came = np.zeros((count, lists, width), np.int16)
    for i in range(count):
        shift = low[:, i] - base
        base = low[:, i]
        total = _moved(total, shift)
        number = base[:, None] + offset
        cost = (expected[:, i, None] - number + 0.5) ** 2 / (2 * sigma[:, i, None] ** 2)
        before = np.concatenate([np.full((lists, 1), np.inf), total[:, :-1]], axis=1)
        assigned = np.where(number >= 1, before + cost, np.inf)
        skipped = total + LEFT_OUT
        taken[i] = assigned <= skipped
        here = np.minimum(assigned, skipped)
        least = np.minimum.accumulate(here - LEFT_OUT * offset, axis=1)
        came[i] = _last_least(here - LEFT_OUT * offset, least)
        total = least + LEFT_OUT * offset
    return _traced(total, taken, came, low)


def _moved(total: Floats, shift: Integers) -> Floats:
    """Return the costs in a band moved up by a shift; numbers past the old band cost `LEFT_OUT` each."""
    width = total.shape[1]
    place = np.arange(width) + shift[:, None]
    inside = np.minimum(place, width - 1)
    moved = np.take_along_axis(total, inside, axis=1)
    return moved + LEFT_OUT * (place - inside)


def _last_least(values: Floats, least: Floats) -> NDArray[np.int16]:
    """Return the last place at which the running minimum of each row was reached."""
    places = np.where(values <= least, np.arange(values.shape[1]), 0)
    return np.maximum.accumulate(places, axis=1).astype(np.int16)


def _traced(
    total: Floats, taken: NDArray[np.bool_], came: NDArray[np.int16], low: Integers
) -> tuple[Integers, Floats]:
    """Trace the cheapest assignments back from the last level; return their numbers and costs."""
    count, lists, _ = taken.shape
    every = np.arange(lists)
    at = total.argmin(axis=1)
    cost = total[every, at]
    number = np.zeros((lists, count), np.int64)
    settled = low[:, -1] + at
    for i in range(count - 1, -1, -1):
        place = np.clip(settled - low[:, i], 0, taken.shape[2] - 1)
        place = came[i][every, place].astype(np.int64)
        true = taken[i][every, place]
        number[:, i] = np.where(true, low[:, i] + place, 0)
        settled = low[:, i] + place - true
    return number, cost
