"""Escape rates of an open stadium, per leg, per time and per bounce, from the transfer matrix of the leg map.

Survival of m legs falls like rho(M(0, 0))^m, where rho is the spectral radius of the matrix
(`orbitdb.open_stadium.transfer`). The rates per time and per bounce solve rho(M(0, y)) = 1 and
rho(M(x, 0)) = 1. If the family of bouncing balls is not cut, its long legs make these two sums diverge. Runs
along a semicircle do so in rho(M(x, 0)), so the rate per bounce leaves out legs of more than 2/x to 4/x
bounces.
The rates are estimates.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.open_stadium.flight import OpenStadium
from orbitdb.open_stadium.tails import Tails
from orbitdb.open_stadium.transfer import GridLegs
from orbitdb.progress import Tell, nobody

GRIDS, GRIDS_WITH_STATES = (200, 300), (100, 150)
"""Cells along each coordinate in the two matrices whose rates are compared, without and with patterns."""

_LEAST_ERROR, _LEAST_WITH_STATES = 0.005, 0.01
"""Least relative errors of rates, without and with patterns."""

FAST = 0.15
"""Above this rate per bounce, runs along a semicircle outlive everything else before the rate shows."""

_CUTS = 2.0, 4.0
_ZERO = 1e-6
_MOST_SECANTS = 30


class EscapeRates(NamedTuple):
    """Escape rates with their errors, which are estimated; None where a rate is not defined."""

    rate_leg: float | None
    rate_leg_error: float | None
    rate_time: float | None
    rate_time_error: float | None
    rate_bounce: float | None
    rate_bounce_error: float | None


def escape_rates(stadium: OpenStadium, left: Tails, tell: Tell = nobody) -> EscapeRates:
    """Return the escape rates of an open stadium whose tails are given.

    Notes
    -----
    Each error is twice the change between two grids, at least half a per cent (one with patterns), and at
    least the statistical error of the points that escape. That of the rate per bounce includes the change
    between the two cuts.
    """
    found, lost = [], 0
    grids = GRIDS if stadium.patterns is None else GRIDS_WITH_STATES
    for done, grid in enumerate(grids):
        tell(done, len(grids), f"transfer matrix of {grid} x {grid} cells")
        legs = GridLegs.of(stadium, grid)
        found.append(_of_grid(legs, stadium, left))
        lost = legs.lost
    coarse, fine = found
    least = _LEAST_ERROR if stadium.patterns is None else _LEAST_WITH_STATES
    least = max(least, lost**-0.5) if lost else np.inf
    pairs: list[float | None] = []
    for before, after in zip(coarse, fine, strict=True):
        if before is None or after is None or not least < 1:
            pairs += [None, None]
            continue
        value = sum(after) / len(after)
        change = abs(sum(before) / len(before) - value)
        error = max(2 * change, least * value, abs(after[-1] - after[0]))
        pairs += [value, error] if error < value else [None, None]
    return EscapeRates(*pairs)


Values = tuple[float, ...] | None
"""One rate, or that of each cut; None if it is not defined."""


def _of_grid(legs: GridLegs, stadium: OpenStadium, left: Tails) -> tuple[Values, Values, Values]:
    """Return the rates per leg, time and bounce from one matrix."""
    growth, vector = legs.growth(1.0, np.ones(legs.size))
    if growth == -np.inf or (left.uncut and np.exp(growth) <= left.continuum):
        return None, None, None
    if left.uncut:
        return (-growth,), None, None
    billiard = stadium.stadium
    solve = partial(_solved, legs, vector, growth)
    per_time = solve(lambda y: np.exp(y * legs.path), -growth * billiard.legs_per_length)
    first = -growth * billiard.legs_per_bounce
    per_bounce = [solve(partial(_up_to, legs.bounces, cut), first) for cut in _CUTS]
    known = tuple(rate for rate in per_bounce if rate is not None)
    slow = len(known) == len(_CUTS) and (left.c2 == 0 or max(known) <= FAST)
    return (-growth,), None if per_time is None else (per_time,), known if slow else None


def _up_to(bounces: Floats, cut: float, x: float) -> Floats:
    """Return the factors e^(x n) of legs of at most cut / x bounces, and 0 for longer ones."""
    return np.exp(np.minimum(x * bounces, cut)) * (x * bounces <= cut)


def _solved(
    legs: GridLegs, vector: Floats, growth: float, weights: Callable[[float], Floats], first: float
) -> float | None:
    """Return the rate at which ln rho is 0, by the secant method; None if it does not converge.

    `growth` is ln rho at 0, with its vector; `weights` gives the factors of the legs at a rate.
    """
    low, below, x = 0.0, growth, first
    for _ in range(_MOST_SECANTS):
        value, vector = legs.growth(weights(x), vector)
        if abs(value) <= _ZERO or value == below:
            return x
        low, below, x = x, value, x - value * (x - low) / (value - below)
        if not 0 < x < np.inf:
            return None
    return None
