"""Follow orbits as a varies: the maxima of the length, and the slacks of their bounces.

Let x = ln a. The maximum moves as d alpha/dx = (-H)^-1 (-2 a sin alpha), which takes one additional
right-hand side in the solver's linear system. A word is an orbit if and only if the six *smooth slacks* of
each run and its leg are positive, that is, the slacks of `orbitdb.billiard.bounces.slacks` without absolute
values. They are linear in alpha and independent of a, so their slopes in x follow from d alpha/dx by the same
linear map.

Everything here is numerical; `orbitdb.orbits.births.brackets` proves each change that is found.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.bounces import slack_changes, smooth_slacks
from orbitdb.billiard.legs import Chain, derivatives, direction_limits, pressed_directions
from orbitdb.equality import Batch
from orbitdb.orbits.newton import newton, responses

_ON_THE_WAY = 2e-3
"""Step (radians) at which Newton's method stops; the error, about its square, is harmless between zeros."""
_PLAIN_STEPS = 4


@dataclass(frozen=True, eq=False)
class Station(Batch):
    """State of N words at one grid point x = ln a."""

    x: float  # ln a
    alpha: Floats  # directions of the legs (radians), shape (m, N)
    drift: Floats  # d alpha/dx
    slack: Floats  # the smooth slacks (radians), shape (6 m, N); missing slacks are infinite
    slope: Floats  # derivatives of the slacks in x

    @classmethod
    def at(cls, legs: Chain, x: float, alpha: Floats, drift: Floats) -> "Station":
        """Return a station with the slacks that belong to the given directions and drift."""
        return cls(x, alpha, drift, *slacks_and_slopes(legs, alpha, drift))


def hermite(t: float | Floats, h: float, ends: Sequence[Floats], slopes: Sequence[Floats]) -> Floats:
    """Return a cubic at fraction t of an interval of width h, given its values and slopes at the ends."""
    near, far = (1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)
    bent = h * t * (1 - t) * ((1 - t) * slopes[0] - t * slopes[1])
    value: Floats = near * ends[0] + far * ends[1] + bent
    return value


def motion(
    legs: Chain, a: float | Floats, alpha: Floats, limits: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Return Newton's step and the drift of words at directions within their limits, each of shape (m, N).

    The drift is d alpha/dx with x = ln a. It is zero for directions pressed against a limit.
    """
    slopes = derivatives(legs, a, alpha)
    pressed = pressed_directions(alpha, slopes, limits)
    step, drift = responses(legs, slopes, pressed, slopes.gradient, -2 * a * np.sin(alpha))
    return step, drift


def follow(legs: Chain, grid: Floats) -> Iterator[Station]:
    """Follow N words along a grid of x = ln a; yield a station for each point of the grid.

    Newton's method starts from an extrapolation of the last two stations.
    """
    first = float(np.exp(grid[0]))
    alpha = newton(legs, first).alpha
    _, drift = motion(legs, first, alpha, direction_limits(legs, first))
    bend = np.zeros_like(drift)
    yield Station.at(legs, float(grid[0]), alpha, drift)
    for x, h in zip(grid[1:].tolist(), np.diff(grid).tolist(), strict=True):
        a = float(np.exp(x))
        limits = direction_limits(legs, a)
        before, start = drift, np.clip(alpha + h * (drift + h / 2 * bend), *limits)
        alpha, drift = _settle(legs, a, start, limits)
        bend = (drift - before) / h
        yield Station.at(legs, x, alpha, drift)


def _settle(legs: Chain, a: float, start: Floats, limits: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Solve words, starting from nearby directions; return directions and drift, each of shape (m, N)."""
    alpha, drift = start.copy(), np.empty_like(start)
    part, here, active = legs, start, np.arange(len(legs))
    for _ in range(_PLAIN_STEPS):
        step, drift[:, active] = motion(part, a, here, limits)
        new = np.clip(here + step, *limits)
        alpha[:, active] = new
        going = np.flatnonzero(np.abs(new - here).max(axis=0) > _ON_THE_WAY)
        if not len(going):
            return alpha, drift
        active, here, part = active[going], new.take(going, axis=1), part.chain(going)
        limits = (limits[0].take(going, axis=1), limits[1].take(going, axis=1))
    alpha[:, active] = newton(part, a, start=here).alpha
    _, drift[:, active] = motion(part, a, alpha[:, active], limits)
    return alpha, drift


def slacks_and_slopes(legs: Chain, alpha: Floats, drift: Floats) -> tuple[Floats, Floats]:
    """Return the smooth slacks and their slopes in x, each of shape (6 m, N)."""
    slack, slope = smooth_slacks(legs, alpha), slack_changes(legs, drift)
    shape = (6 * len(alpha), len(legs))
    return slack.reshape(shape), slope.reshape(shape)


def between(legs: Chain, start: Station, end: Station) -> Station:
    """Return the station halfway between two stations of the same words."""
    x, h = (start.x + end.x) / 2, end.x - start.x
    a = float(np.exp(x))
    limits = direction_limits(legs, a)
    guess = (start.alpha + end.alpha) / 2 + h / 8 * (start.drift - end.drift)
    alpha, drift = _settle(legs, a, np.clip(guess, *limits), limits)
    return Station.at(legs, x, alpha, drift)
