"""Weights of orbits, tilted until chosen means are exact.

A finite set of orbits with the weights e^-lambda has wrong means of everything, for it lacks the long
orbits. Among all weights w e^(mu x) with which some quantities x have the mean 0, there is one mu for
each x at most: the minimum of the convex function ln sum w e^(mu x). It exists where 0 is inside the
convex hull of the points x, and Newton's method finds it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue

Floats = NDArray[np.float64]

_SMALL = 1e-16
"""Square of the Newton step, in its own metric, at which the rest is rounding."""

_MOST_STEPS = 60
_LEAST_FRACTION = 1e-6
_ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class Tilt(ByValue):
    """A tilt that makes means vanish.

    Attributes
    ----------
    mu : ndarray, shape (k,)
    weights : ndarray, shape (N,)
        Of the orbits, with the sum 1.
    """

    mu: Floats
    weights: Floats


def tilt(log_weights: Floats, x: Floats, start: Floats | None = None) -> Tilt | None:
    """Tilt weights until the means of some quantities are 0.

    Parameters
    ----------
    log_weights : ndarray, shape (N,)
    x : ndarray, shape (k, N)
        The quantities; k may be 0.
    start : ndarray, shape (k,), optional
        Where to begin.

    Returns
    -------
    Tilt or None
        None where no tilt exists: some combination of the quantities is positive for all orbits.

    Notes
    -----
    Newton's method with step halving. If no tilt exists, mu grows until mu x < 0 for all orbits, which
    proves it.
    """
    mu = np.zeros(len(x)) if start is None else start
    value, weights = _log_sum(log_weights, mu @ x)
    for _ in range(_MOST_STEPS):
        slope = x @ weights
        step = _newton_step(slope, (x * weights) @ x.T - np.outer(slope, slope))
        if step is None:
            return None
        drop = -float(slope @ step)
        if drop < _SMALL:
            return Tilt(mu, weights)
        fraction = 1.0
        while fraction > _LEAST_FRACTION:
            exponents = (mu + fraction * step) @ x
            if exponents.max() < 0:
                return None
            lower, weights = _log_sum(log_weights, exponents)
            if lower <= value - fraction * drop / 4 + _ROUNDING * abs(value):
                break
            fraction /= 2
        mu, value = mu + fraction * step, lower
    return None


def _newton_step(slope: Floats, spread: Floats) -> Floats | None:
    """Return the Newton step; None if the quantities do not scatter in all directions."""
    if not len(slope):
        return slope
    try:
        return np.asarray(-np.linalg.solve(spread, slope), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None


def _log_sum(log_weights: Floats, exponents: Floats) -> tuple[float, Floats]:
    """Return ln sum w e^x and the terms' shares in the sum."""
    total = log_weights + exponents
    most = total.max()
    terms = np.exp(total - most)
    scale = terms.sum()
    return float(most + np.log(scale)), terms / scale
