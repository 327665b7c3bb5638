"""Number the levels of a list in which some levels are missing and others spurious, at the lowest cost.

The orbits give the i-th level of the list a number x_i, which is not an integer. Its true number n_i
increases with i and costs (x_i - n_i)^2 / (2 sigma^2). Each skipped number and each spurious level costs
`LEFT_OUT`. Dynamic programming finds the cheapest assignment, for many lists at once.
"""

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers

LEFT_OUT = 6.0
"""Cost of a missing or a spurious level."""

_BAND = 12
"""Maximum distance between the true number and the expected number of a level."""


def numbered(expected: Floats, sigma: float) -> tuple[Integers, Floats]:
    """Return the true numbers of levels that have the lowest cost, for S lists at once.

    Parameters
    ----------
    expected : ndarray, shape (S, N)
        Number of each level according to the orbits, not rounded to an integer.
    sigma : float
        Uncertainty of the expected numbers.

    Returns
    -------
    number : ndarray of int, shape (S, N)
        True numbers, counted from 1 and increasing along each list; 0 for spurious levels.
    cost : ndarray, shape (S,)
        Total cost of each list.
    """
    lists, count = expected.shape
    low = np.maximum.accumulate(np.floor(expected).astype(np.int64), axis=1) - _BAND
    width = 2 * _BAND + 2
    offset = np.arange(width)
    # total[s, j] is the lowest cost at which all numbers up to base[s] + j are assigned or skipped
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
        cost = (expected[:, i, None] - number) ** 2 / (2 * sigma**2)
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
    """Return the costs for a band moved up by a shift; numbers above the old band count as skipped."""
    width = total.shape[1]
    place = np.arange(width) + shift[:, None]
    inside = np.minimum(place, width - 1)
    moved = np.take_along_axis(total, inside, axis=1)
    return moved + LEFT_OUT * (place - inside)


def _last_least(values: Floats, least: Floats) -> NDArray[np.int16]:
    """Return, for each entry, the index at which the running minimum of its row was last reached."""
    places = np.where(values <= least, np.arange(values.shape[1]), 0)
    return np.maximum.accumulate(places, axis=1).astype(np.int16)


def _traced(
    total: Floats, taken: NDArray[np.bool_], came: NDArray[np.int16], low: Integers
) -> tuple[Integers, Floats]:
    """Trace the cheapest assignment of each list back from its last level; return numbers and costs."""
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
