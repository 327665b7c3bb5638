"""Weights of orbits, tilted until chosen means are exact.

With the weights e^-lambda, a finite set of orbits gives inexact means, because it lacks the long orbits.
Weights w e^(mu x) give the quantities x the mean 0 for at most one mu, the minimum of the convex function
ln sum w e^(mu x). It exists if 0 is inside the convex hull of the points x, and Newton's method finds it.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats

_SMALL = 1e-16
"""Square of the Newton step, in the metric of the spread, below which only rounding is left."""

_MOST_STEPS = 60
_LEAST_FRACTION = 1e-6
_ROUNDING = 1e-14


class Tilted(NamedTuple):
    """The tilted sum and its derivatives in mu."""

    log_sum: float  # ln sum w e^(mu x)
    means: Floats  # its gradient, the means of the quantities, shape (k,)
    spread: Floats  # its Hessian, their covariances, shape (k, k)


def exact_tilt(at: Callable[[Floats], Tilted | None], start: Floats, small: float = _SMALL) -> Floats | None:
    """Return the mu at which all means are 0, shape (k,), or None if Newton's method with step halving fails.

    `at` returns the tilted sums at mu, or None if mu x < 0 for all orbits, which proves that no tilt exists.
    The iteration ends when the square of the Newton step, in the metric of the spread, is `small`.
    """
    mu, here = start, at(start)
    for _ in range(_MOST_STEPS):
        if here is None:
            return None
        try:
            step = -np.linalg.solve(here.spread, here.means)
        except np.linalg.LinAlgError:  # the quantities do not scatter in all directions
            return None
        drop, fraction = -float(here.means @ step), 1.0
        if drop < small:
            return mu
        slack = _ROUNDING * (1 + abs(here.log_sum))
        while (there := at(mu + fraction * step)) is not None and fraction > _LEAST_FRACTION:
            if there.log_sum <= here.log_sum - fraction * drop / 4 + slack:
                break
            fraction /= 2
        mu, here = mu + fraction * step, there
    return None


def tilt(log_weights: Floats, x: Floats, start: Floats | None = None) -> tuple[Floats, Floats] | None:
    """Tilt weights, shape (N,), until the means of quantities x, shape (k, N), are 0; k may be 0.

    Newton's method starts from mu = 0 by default. Returns mu, shape (k,), and the weights of the orbits,
    whose sum is 1; None if no tilt is found, for example because some combination of the quantities is
    positive for all orbits.
    """

    def at(mu: Floats) -> Tilted | None:
        if (exponents := mu @ x).max() < 0:
            return None
        log_sum, weights = _log_sum(log_weights, exponents)
        means = x @ weights
        return Tilted(log_sum, means, (x * weights) @ x.T - np.outer(means, means))

    mu = exact_tilt(at, np.zeros(len(x)) if start is None else start)
    return None if mu is None else (mu, _log_sum(log_weights, mu @ x)[1])


def _log_sum(log_weights: Floats, exponents: Floats) -> tuple[float, Floats]:
    """Return ln sum w e^x and the terms' shares in the sum."""
    total = log_weights + exponents
    most = total.max()
    terms = np.exp(total - most)
    scale = terms.sum()
    return float(most + np.log(scale)), terms / scale
