"""The map from one run on a semicircle to the next, as random trajectories take it.

By its mirrors and time reversal the stadium has but one kind of run: up the right semicircle. Such a run
is fixed by the angle t between path and circle, in (0, pi/2), and the direction beta in (-t, t) of the
line it comes in by, which passes the centre at the distance cos(t). Its first bounce is beta + t behind
the lower end of the semicircle, and all are 2 t apart: k = floor((pi - beta - t) / 2t) + 1. Seen backwards
and upside down the run comes in at pi - beta - 2 k t. The invariant measure of runs is sin(t) dt dbeta / 2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

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
