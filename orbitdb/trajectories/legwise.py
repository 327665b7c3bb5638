"""Lyapunov exponents from random trajectories leg by leg, given the exact means of the largest terms.

Over a leg a beam grows by ln D + ln K + c2 + rest (`orbitdb.averages.exact_means`). The means of all terms
except the rest are known exactly. The rest

    ln(1 + (1/D + b)/K) - ln(1 + (1/D + 1/D')/K),     b = 1/(D' + 1/(K' + b')),

is small and scatters little; D', K' and b' belong to the leg before. The starts are drawn from the invariant
measure of the runs and are independent.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.ensemble import LEAST, Measured, Reference

_TINY = 1e-150


class Runs(NamedTuple):
    """N runs of trajectories; arrays of shape (N,)."""

    t: Floats  # angle between path and circle, in (0, pi/2)
    beta: Floats  # direction of the incoming line, in (-t, t)


def random_runs(n: int, rng: np.random.Generator) -> Runs:
    """Draw n runs from the invariant measure.

    The place u in (0, pi) and cos(t) of a bounce are uniform; it is the first of its run if u < 2 t.
    """
    kept: list[Floats] = []
    have = 0
    while have < n:
        t, u = np.arccos(rng.random(2 * (n - have))), np.pi * rng.random(2 * (n - have))
        first = u < 2 * t
        kept.append(np.stack([t[first], u[first] - t[first]]))
        have += int(first.sum())
    return Runs(*np.concatenate(kept, axis=1)[:, :n])


class Leg(NamedTuple):
    """N runs and the legs after them, up to the next runs; arrays of shape (N,)."""

    runs: Runs  # the next runs
    bounces: Floats  # number of bounces of the run
    walls: Floats  # straight bounces of the leg
    kick: Floats  # K = 2 k / sin(t) of the run
    drift: Floats  # D of the leg
    path: Floats  # length from the foot of the centre on the incoming line to the next such foot


def next_leg(runs: Runs, a: float) -> Leg:
    """Follow runs to their end and on to the next ones.

    Notes
    -----
    The line that leaves a run reaches the copy of the other semicircle whose centre is nearest to its height
    there, and passes that centre at the signed distance s. |s| is cos(t) of the next run. The sign says
    whether that run goes up or down; a mirror makes it go up, with direction beta.
    """
    t = runs.t
    bounces = np.floor((np.pi - runs.beta - t) / (2 * t)) + 1
    direction = np.pi - runs.beta - 2 * bounces * t
    along, across = np.cos(direction), np.sin(direction)
    offset = np.cos(t) + 2 * a * across
    copy = np.rint(-offset / (2 * np.maximum(along, _TINY)))
    s = offset + 2 * copy * along
    sine = np.sin(t)
    drift = 2 * a * along - 2 * copy * across
    following = Runs(np.arccos(np.minimum(np.abs(s), 1.0)), np.where(s > 0, -direction, direction))
    return Leg(following, bounces, np.abs(copy), 2 * bounces / sine, drift, drift + 2 * bounces * sine)


STARTS = 4096
"""Largest number followed at the same time, small enough for their arrays to stay in the cache."""

LEGS = 32
"""Largest number of legs per start; more would add little information."""

_SETTLED = 1e-9
_LONGEST_WAY = 2000


class Beams(NamedTuple):
    """N trajectories as they arrive at a run, shape (N,) each."""

    drift: Floats  # D of the leg before the run
    low: Floats  # convergence b of the beam at the end of that leg, for the least possible initial value
    high: Floats  # the same for the largest initial value; equal to `low` once the start is forgotten


def simulate_legs(
    stadium: Stadium,
    bounces: int,
    known: Measured,
    seed: int = 0,
    progress: Callable[[float, Reference], None] | None = None,
) -> Reference:
    """Average over random trajectories, leg by leg.

    Parameters
    ----------
    bounces : int
        Expected total number of bounces, from at least `LEAST` starts with at most `LEGS` legs each.
    known : (float, float)
        The exact mean of ln D + ln K + c2 per leg, and a bound on its error.
    seed : int, optional
        The same arguments give the same result.
    progress : callable, optional
        Called after every batch with the fraction done and the averages so far.

    Returns
    -------
    Reference
        The errors combine the spread of the independent starts (`Reference.groups`), the error of the known
        mean, and the remaining influence of the start.

    Raises
    ------
    ValueError
        If `bounces` is below 1.

    Notes
    -----
    Below about a = 0.1 the angle t changes little over many legs, and the rest is no longer small. The errors
    are still correct, but those of `orbitdb.trajectories.ensemble` are smaller.
    """
    if bounces < 1:
        raise ValueError("give at least one bounce")
    legs = bounces / (stadium.a + math.pi / 2)
    starts = max(LEAST, math.ceil(legs / LEGS))
    legs_each = math.ceil(min(LEGS, legs / starts))
    batches = math.ceil(starts / STARTS)
    each = math.ceil(starts / batches)
    rng = np.random.default_rng(seed)
    moments = np.zeros((2, 4))
    for count in range(1, batches + 1):
        terms = _batch(stadium.a, each, legs_each, rng)
        moments += terms.sum(axis=1), (terms**2).sum(axis=1)
        found = _reference(moments, count * each, legs_each, stadium, known, seed)
        if progress is not None:
            progress(count / batches, found)
    return found


def _batch(a: float, starts: int, legs: int, rng: np.random.Generator) -> Floats:
    """Follow new random starts; return the means per leg of the terms from `follow`, shape (4, N)."""
    runs, beams = _settled(a, random_runs(starts, rng))
    sums = np.zeros((4, starts))
    for _ in range(legs):
        runs, beams, terms = follow(runs, beams, a)
        sums += terms
    return sums / legs


def _settled(a: float, runs: Runs) -> tuple[Runs, Beams]:
    """Follow starts until their beams no longer depend on the initial convergence."""
    first = next_leg(runs, a)
    runs, beams = first.runs, Beams(first.drift, np.zeros(len(first.drift)), 1 / first.drift)
    for _ in range(_LONGEST_WAY):
        runs, beams, terms = follow(runs, beams, a)
        if terms[1].mean() < _SETTLED:
            break
    return runs, beams


def follow(runs: Runs, beams: Beams, a: float) -> tuple[Runs, Beams, Floats]:
    """Follow trajectories over a run and the leg after it.

    Returns the next runs, the beams there, and an array of shape (4, N): the rest, the width of its bounds,
    the path minus two for every wall, and the number of bounces.
    """
    leg = next_leg(runs, a)
    inverse = 1 / leg.drift
    exact = np.log1p((inverse + 1 / beams.drift) / leg.kick)
    low, high = (np.log1p((inverse + b) / leg.kick) for b in (beams.low, beams.high))
    after = Beams(leg.drift, *(1 / (leg.drift + 1 / (leg.kick + b)) for b in (beams.low, beams.high)))
    terms = np.stack(
        [(low + high) / 2 - exact, high - low, leg.path - 2 * leg.walls, leg.bounces + leg.walls]
    )
    return leg.runs, after, terms


def _reference(
    moments: Floats, starts: int, legs: int, stadium: Stadium, known: Measured, seed: int
) -> Reference:
    """Compute the averages from sums over starts of the terms and of their squares, shape (2, 4).

    A leg has a + pi/2 bounces and a path of pi (pi + 4a) / 4 on average. The path minus 2 per wall scatters
    little, and the mean number of walls is a. So the mean free path checks the map and the measure.
    """
    rest, width, path, bounces = means = moments[0] / starts
    errors = np.sqrt(np.maximum(moments[1] / starts - means**2, 0) / (starts - 1))
    growth = known[0] + rest, math.hypot(errors[0], known[1]) + width / 2
    way, rates = (path + 2 * stadium.a, errors[2]), (stadium.legs_per_bounce, stadium.legs_per_length)
    return Reference.of(growth, way, *rates, round(bounces * starts * legs), starts, seed)
