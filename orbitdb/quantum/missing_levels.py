"""Number the levels of a list, with some missing and some spurious, at the least cost.

The orbits give each level a number x_i, which is not an integer. Its true number n_i rises with i and costs
(x_i - n_i)^2 / (2 sigma^2). A skipped number and a spurious level cost `LEFT_OUT` each. Dynamic programming
finds the cheapest assignment, for many lists at once.
"""

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers

LEFT_OUT = 6.0
"""Cost of a missing or a spurious level."""

_BAND = 12
"""Largest distance of true numbers from the expected ones."""


def numbered(expected: Floats, sigma: float) -> tuple[Integers, Floats]:
    """Return the true numbers of levels with the least cost, for several lists at once.

    Parameters
    ----------
    expected : ndarray, shape (S, N)
        Number of each level according to the orbits, in rising order; not an integer.
    sigma : float
        Its uncertainty.

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
