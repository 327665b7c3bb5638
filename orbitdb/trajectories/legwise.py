"""Lyapunov exponents from random trajectories leg by leg, given the exact means of the largest terms.

Over a leg and the run before it, a beam grows by ln D + ln K + c2 + remainder
(`orbitdb.averages.exact_means`). The means of the first three terms are known exactly. The remainder

    ln(1 + (1/D + b)/K) - ln(1 + (1/D + 1/D')/K),     b = 1/(D' + 1/(K' + b')),

is small and scatters little, where D', K' and b' belong to the previous leg. The starts are drawn
independently from the invariant measure of the runs.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, check_int
from orbitdb.trajectories.ensemble import LEAST, Measured, Reference

_TINY = 1e-150


class Runs(NamedTuple):
    """One run of each of N trajectories; all arrays have shape (N,)."""

    t: Floats  # angle between path and circle, in (0, pi/2)
    beta: Floats  # direction of the incoming path, in (-t, t)


def random_runs(n: int, rng: np.random.Generator) -> Runs:
    """Draw n runs from the invariant measure.

    The position u in (0, pi) of a bounce and cos(t) are uniformly distributed. A bounce is the first of its
    run if u < 2 t.
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
    """A run and the leg after it for each of N trajectories; all arrays have shape (N,)."""

    runs: Runs  # the runs that follow the legs
    bounces: Floats  # number k of bounces of the run
    walls: Floats  # number of straight bounces of the leg
    kick: Floats  # K = 2 k / sin(t) of the run
    drift: Floats  # D of the leg
    # path length between the points at which the incoming lines of the run and the next one pass the centres
    path: Floats


def next_leg(runs: Runs, a: float) -> Leg:
    """Follow each run and the leg after it, up to the next run.

    Notes
    -----
    In the unfolded stadium, the line that leaves a run reaches the copy of the other semicircle whose centre
    is nearest in height, and passes this centre at the signed distance s. |s| is cos(t) of the next run. The
    sign of s says whether the next run goes up or down; if it goes down, it is reflected so that it goes up.
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
"""Maximum number of starts in a batch, small enough for their arrays to stay in the cache."""

LEGS = 32
"""Maximum number of legs per start; more legs would add little information."""

_SETTLED = 1e-9
_LONGEST_WAY = 2000


class Beams(NamedTuple):
    """The beams of N trajectories as they arrive at a run; all arrays have shape (N,)."""

    drift: Floats  # D of the leg before the run
    low: Floats  # lower bound on the convergence b of the beam at the end of that leg
    high: Floats  # upper bound on b; equal to `low` once the initial value is forgotten


def simulate_legs(
    stadium: Stadium,
    bounces: int,
    exact: Measured,
    seed: int = 0,
    progress: Callable[[float, Reference], None] | None = None,
) -> Reference:
    """Average over random trajectories, leg by leg.

    Parameters
    ----------
    bounces : int
        Expected total number of bounces, from at least `LEAST` starts with at most `LEGS` legs each.
    exact : (float, float)
        The exact mean of ln D + ln K + c2 per leg, and a bound on its error.
    seed : int, optional
        Seed of the random numbers; the same arguments give the same result.
    progress : callable, optional
        Called after every batch with the fraction done and the averages so far.

    Returns
    -------
    Reference
        The errors combine the spread of the independent starts (`Reference.groups`), the error of the known
        mean, and the remaining influence of the initial beams.

    Raises
    ------
    ValueError
        If `bounces` is below 1.

    Notes
    -----
    Below about a = 0.1, the angle t changes little over many legs, and the remainder is no longer small. The
    errors are still correct, but `orbitdb.trajectories.ensemble` gives smaller errors.
    """
    check_int("seed", seed, 0)
    if bounces < 1:
        raise InputError(f"{bounces} bounces: give 1 or more")
    legs = bounces / (stadium.a + math.pi / 2)
    starts = max(LEAST, math.ceil(legs / LEGS))
    legs_each = math.ceil(min(LEGS, legs / starts))
    batches = math.ceil(starts / STARTS)
    starts_each = math.ceil(starts / batches)
    rng = np.random.default_rng(seed)
    moments = np.zeros((2, 4))
    for count in range(1, batches + 1):
        terms = _batch(stadium.a, starts_each, legs_each, rng)
        moments += terms.sum(axis=1), (terms**2).sum(axis=1)
        averages = _reference(moments, count * starts_each, legs_each, stadium, exact, seed)
        if progress is not None:
            progress(count / batches, averages)
    return averages


def _batch(a: float, starts: int, legs: int, rng: np.random.Generator) -> Floats:
    """Follow new random starts; return the mean per leg of each term from `follow_runs`, shape (4, N)."""
    runs, beams = _settled(a, random_runs(starts, rng))
    sums = np.zeros((4, starts))
    for _ in range(legs):
        runs, beams, terms = follow_runs(runs, beams, a)
        sums += terms
    return sums / legs


def _settled(a: float, runs: Runs) -> tuple[Runs, Beams]:
    """Follow trajectories until their beams no longer depend on the initial convergence."""
    first = next_leg(runs, a)
    runs, beams = first.runs, Beams(first.drift, np.zeros(len(first.drift)), 1 / first.drift)
    for _ in range(_LONGEST_WAY):
        runs, beams, terms = follow_runs(runs, beams, a)
        if terms[1].mean() < _SETTLED:
            break
    return runs, beams


def follow_runs(runs: Runs, beams: Beams, a: float) -> tuple[Runs, Beams, Floats]:
    """Follow trajectories over a run and the leg after it.

    Returns the next runs, the beams that arrive there, and an array of shape (4, N). Its rows are the
    remainder, the width of its bounds, the path length minus two for every wall, and the number of bounces.
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
    moments: Floats, starts: int, legs: int, stadium: Stadium, exact: Measured, seed: int
) -> Reference:
    """Compute the averages from sums of the terms and of their squares over all starts, shape (2, 4).

    On average, a leg with its run has a + pi/2 bounces, a of them on walls, and a path length of
    pi (pi + 4a) / 4. The path length minus 2 per wall scatters little, so the mean free path that follows
    is a check of the map and of the measure.
    """
    rest, width, path, bounces = means = moments[0] / starts
    errors = np.sqrt(np.maximum(moments[1] / starts - means**2, 0) / (starts - 1))
    growth = exact[0] + rest, math.hypot(errors[0], exact[1]) + width / 2
    way, rates = (path + 2 * stadium.a, errors[2]), (stadium.legs_per_bounce, stadium.legs_per_length)
    return Reference.of(stadium.a, growth, way, *rates, round(bounces * starts * legs), starts, seed)
