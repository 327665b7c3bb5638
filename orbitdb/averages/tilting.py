"""Weights of orbits, tilted so that chosen means are exact.

With the weights w = e^-lambda, a finite set of orbits gives inexact means, because the long orbits are
missing. With the tilted weights w e^(mu x), the means of the quantities x are 0 for at most one tilt mu, at
which the convex function ln sum w e^(mu x) has its minimum. This tilt exists if 0 is inside the convex hull
of the points x, and Newton's method finds it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from orbitdb.arrays import Batch, Floats

_SMALL = 1e-16
"""Square of the Newton step, in the metric of the spread, below which a step is only a rounding error."""

_MOST_STEPS = 60
_LEAST_FRACTION = 1e-6
_ROUNDING = 1e-14


class Tilted(NamedTuple):
    """The logarithm of the tilted sum, and its derivatives with respect to mu."""

    log_sum: float  # ln sum w e^(mu x)
    means: Floats  # the gradient, which consists of the means of the quantities x, shape (k,)
    spread: Floats  # the Hessian, which consists of the covariances of x, shape (k, k)


def _solve(at: Callable[[Floats], Tilted | None], start: Floats) -> Floats | None:
    """Return the mu at which all means are 0, shape (k,), or None if Newton's method with step halving fails.

    `at` returns the tilted sum at mu, or None if mu x < 0 for all orbits, which proves that no tilt exists.
    """
    mu, now = start, at(start)
    for _ in range(_MOST_STEPS):
        if now is None:
            return None
        try:
            step = -np.linalg.solve(now.spread, now.means)
        except np.linalg.LinAlgError:  # the points x do not span all directions
            return None
        drop, fraction = -float(now.means @ step), 1.0
        if drop < _SMALL:
            return mu
        slack = _ROUNDING * (1 + abs(now.log_sum))
        while (there := at(mu + fraction * step)) is not None and fraction > _LEAST_FRACTION:
            if there.log_sum <= now.log_sum - fraction * drop / 4 + slack:
                break
            fraction /= 2
        mu, now = mu + fraction * step, there
    return None


def tilt(log_weights: Floats, x: Floats, start: Floats | None = None) -> tuple[Floats, Floats] | None:
    """Tilt weights, shape (N,), so that the means of the quantities x, shape (k, N), are 0; k may be 0.

    Newton's method starts from mu = 0 by default. The result is mu, shape (k,), and the tilted weights, whose
    sum is 1. It is None if no tilt is found, for example because some linear combination of the quantities is
    positive for all orbits.
    """

    def at(mu: Floats) -> Tilted | None:
        if (exponents := mu @ x).max() < 0:
            return None
        log_sum, weights = _log_sum(log_weights, exponents)
        means = x @ weights
        return Tilted(log_sum, means, (x * weights) @ x.T - np.outer(means, means))

    mu = _solve(at, np.zeros(len(x)) if start is None else start)
    return None if mu is None else (mu, _log_sum(log_weights, mu @ x)[1])


def _log_sum(log_weights: Floats, exponents: Floats) -> tuple[float, Floats]:
    """Return the logarithm of the sum of w e^x, and each term as a fraction of the sum."""
    total = log_weights + exponents
    most = total.max()
    terms = np.exp(total - most)
    scale = terms.sum()
    return float(most + np.log(scale)), terms / scale


HELD = ((), (1,), (0, 1), (0, 1, 2))
"""For each level, the indices of the quantities whose means are exact: 0 is ln D, 1 is ln K, 2 is c2."""


@dataclass(frozen=True, eq=False)
class TiltedOrbits(Batch):
    """The weights and other quantities of N individual orbits."""

    log_weights: Floats  # ln w, shape (N,)
    x: Floats  # the quantities whose means the tilt reduces to 0, shape (k, N)
    rest: Floats  # the remainder of lambda, which is averaged over orbits, shape (N,)
    legs: Floats  # number of legs, shape (N,)

    @classmethod
    def joined(cls, parts: Iterable[Self]) -> Self:
        """Join orbits with all three quantities; return no orbits if there are no parts."""
        return super().joined([cls(*(np.zeros(shape) for shape in (0, (3, 0), 0, 0))), *parts])
