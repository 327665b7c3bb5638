"""Lyapunov exponents from random trajectories leg by leg, given the exact means of the largest terms.

Over a leg a beam grows by ln D + ln K + c2 + rest (`orbitdb.averages.exact_means`), and the mean of all
but the rest is known exactly. The rest

    ln(1 + (1/D + b)/K) - ln(1 + (1/D + 1/D')/K),     b = 1/(D' + 1/(K' + b')),

is small and scatters little, D', K' and b' those of the leg before. Starts are drawn afresh from the
invariant measure of the runs, so that every one of them is independent.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.ensemble import LEAST, Reference

_TINY = 1e-150


class Runs(NamedTuple):
    """N runs of trajectories; arrays of shape (N,)."""

    t: Floats  # angle between path and circle, in (0, pi/2)
    beta: Floats  # direction of the line that comes in, in (-t, t)


def random_runs(n: int, rng: np.random.Generator) -> Runs:
    """Draw n runs from the invariant measure.

    A bounce with a uniform place u in (0, pi) and cosine of its angle is the first one of its run
    where u < 2 t.
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
    """The bounces of N runs and the legs behind them, up to the next runs; arrays of shape (N,)."""

    runs: Runs  # the next ones
    bounces: Floats  # of the run
    walls: Floats  # straight bounces of the leg
    kick: Floats  # K = 2 k / sin(t) of the run
    drift: Floats  # D of the leg
    path: Floats  # length from the foot of the centre on the line that comes in to the next one


def next_leg(runs: Runs, a: float) -> Leg:
    """Follow runs to their end and on to the next ones.

    Notes
    -----
    The line behind a run, turned as above, comes from copy q of the other semicircle, the one that its
    level there is nearest to, and passes that centre at s, cos(t) of the next run but for a sign that
    says whether it goes up or down. Either way, the mirror that makes it go up leaves beta.
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
"""Followed at the same time, at most; few enough for their arrays to stay in the cache."""

LEGS = 32
"""Legs of a start that are averaged over, at most; more would say little that is new."""

_SETTLED = 1e-9
_LONGEST_WAY = 2000


class Beams(NamedTuple):
    """What N trajectories bring to a run, shape (N,) each."""

    drift: Floats  # D of the leg that they come by
    low: Floats  # the convergence b of the beam at its end, for the least that it can have been at the start
    high: Floats  # and for the most: equal once the start is forgotten


def simulate_legs(
    stadium: Stadium,
    bounces: int,
    known: tuple[float, float],
    seed: int = 0,
    progress: Callable[[float, Reference], None] | None = None,
) -> Reference:
    """Average over random trajectories, leg by leg.

    Parameters
    ----------
    stadium : Stadium
    bounces : int
        Bounces to expect in all, `LEGS` legs from every start, or fewer where there would be less than
        `LEAST` starts.
    known : tuple of float
        The exact mean of ln D + ln K + c2 of a leg, and a bound on its error.
    seed : int, optional
        The same seed and number give the same result.
    progress : callable, optional
        Called after every batch with the fraction done and the averages so far.

    Returns
    -------
    Reference
        The errors come from the spread of independent starts, `Reference.groups` of them, and are added
        to those of the known mean and of starts that are not quite forgotten.

    Raises
    ------
    ValueError
        If there are no bounces.

    Notes
    -----
    Below about a = 0.1 an angle t changes little over many legs, and what is left of lambda is no longer
    small: the errors hold, but those of `orbitdb.trajectories.ensemble` are smaller.
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
    """Follow fresh starts; return the means a leg of each of the terms that `follow` gives, shape (4, N)."""
    runs, beams = _settled(a, random_runs(starts, rng))
    sums = np.zeros((4, starts))
    for _ in range(legs):
        runs, beams, terms = follow(runs, beams, a)
        sums += terms
    return sums / legs


def _settled(a: float, runs: Runs) -> tuple[Runs, Beams]:
    """Follow starts until their beams have forgotten how they began, to all that matters."""
    first = next_leg(runs, a)
    runs, beams = first.runs, Beams(first.drift, np.zeros(len(first.drift)), 1 / first.drift)
    for _ in range(_LONGEST_WAY):
        runs, beams, terms = follow(runs, beams, a)
        if terms[1].mean() < _SETTLED:
            break
    return runs, beams


def follow(runs: Runs, beams: Beams, a: float) -> tuple[Runs, Beams, Floats]:
    """Follow trajectories over a run and the leg behind it.

    Parameters
    ----------
    runs : Runs
    beams : Beams
        What is known of the slopes of tangent vectors at their beginning.
    a : float

    Returns
    -------
    tuple
        The next runs, the beams there, and per trajectory, shape (4, N): the rest, the width of what
        it may be, the path less two for every wall, and the bounces.
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
    moments: Floats, starts: int, legs: int, stadium: Stadium, known: tuple[float, float], seed: int
) -> Reference:
    """Put averages together, from sums over starts of the terms and of their squares, shape (2, 4).

    A leg has a + pi/2 bounces and a path of pi (pi + 4a) / 4 on average.
    The path of a leg of n walls is about 2 n; what it has more is soon known, unlike n itself, and the
    mean of n is a. So the mean free path is a check of the map and of the measure.
    """
    rest, width, path, bounces = means = moments[0] / starts
    errors = np.sqrt(np.maximum(moments[1] / starts - means**2, 0) / (starts - 1))
    per_leg, error = known[0] + rest, math.hypot(errors[0], known[1]) + width / 2
    legs_per_bounce = 1 / (stadium.a + math.pi / 2)
    legs_per_length = 4 / (math.pi * (math.pi + 4 * stadium.a))
    return Reference(
        lambda_d=float(per_leg * legs_per_bounce),
        lambda_d_error=float(error * legs_per_bounce),
        lambda_c=float(per_leg * legs_per_length),
        lambda_c_error=float(error * legs_per_length),
        mean_free_path=float((path + 2 * stadium.a) * legs_per_bounce),
        mean_free_path_error=float(errors[2] * legs_per_bounce),
        bounces=round(bounces * starts * legs),
        groups=starts,
        seed=seed,
    )
