"""Proof that a word begins or ceases to be an orbit inside a narrow bracket of a.

At a (1 - delta) and a (1 + delta) the word's maximum is bounded as in `orbitdb.orbits.error_bounds`: on one
side every slack is above its error and no direction at a limit, so that the word is an orbit there; on
the other some slack is below minus its error, so that it is none. Slacks being continuous in a, the
change lies between, whatever found it. Where rounding hides the sides the bracket is made wider, and
then decided in ball arithmetic.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.bounces import slack_errors
from orbitdb.billiard.legs import Chain, derivatives, direction_limits
from orbitdb.equality import ByValue
from orbitdb.orbits.births.continuation import motion, slacks_and_slopes
from orbitdb.orbits.births.crossings import Zeros
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.orbit import Status
from orbitdb.orbits.status import decide

Floats = NDArray[np.float64]
Integers = NDArray[np.intp]
Signs = NDArray[np.int8]

_WIDER = 4.0
_NARROWEST = 2.0**-51
_WIDEST = 1e-11
"""Relative; from here on balls decide."""
_SAFETY = 1.05
_POLISH = 1e-9
"""A zero that is found needs no larger step in ln a."""


@dataclass(frozen=True, eq=False)
class Bracketed(ByValue):
    """Zeros of slacks and what is proved of the words on both sides, as a structure of arrays.

    Attributes
    ----------
    a, low, high : ndarray, shape (K,)
        The zero, and the ends of its bracket.
    slope : ndarray, shape (K,)
        Of the slack in ln a (radians).
    before, after : ndarray of int8, shape (K,)
        At the ends: 1 where the word is an orbit, -1 where it is not, 0 where that is not decided.
    """

    a: Floats
    low: Floats
    high: Floats
    slope: Floats
    before: Signs
    after: Signs


def bracket(legs: Chain, zeros: Zeros, surely: Callable[[Integers, Floats], Signs]) -> Bracketed:
    """Put brackets around zeros and prove what their words are at the ends.

    Parameters
    ----------
    legs : Chain
    zeros : Zeros
        K zeros of some of the words' slacks.
    surely : callable
        Tells in ball arithmetic which of some words, given by their places, are orbits, each at its a.
    """
    part, own = legs.chain(zeros.word), (zeros.slack, np.arange(len(zeros)))
    x, alpha = np.exp(zeros.x), zeros.alpha
    for _ in range(2):  # once to the zero as near as doubles come, and once more there
        step, drift = motion(part, x, alpha, direction_limits(part, x))
        alpha = alpha + step
        slack, slopes = slacks_and_slopes(part, alpha, drift)
        with np.errstate(divide="ignore", invalid="ignore"):
            shift = np.nan_to_num(-slack[own] / slopes[own], posinf=0.0, neginf=0.0)
        shift = np.clip(shift, -_POLISH, _POLISH)
        x, alpha = x * (1 + shift), alpha + shift * drift
    slack, _ = slacks_and_slopes(part, alpha, drift)
    alpha_error = direction_errors(part, x, alpha, derivatives(part, x, alpha))
    error = slack_errors(part, alpha_error).max(axis=(0, 1))
    slope = slopes[own]
    with np.errstate(divide="ignore"):
        delta = _SAFETY * (np.abs(slack[own]) + 2 * error) / np.abs(slope)
    delta = np.clip(delta, _NARROWEST, _WIDEST)
    low, high = x * (1 - delta), x * (1 + delta)
    before, after = np.zeros(len(x), np.int8), np.zeros(len(x), np.int8)
    open_ = np.arange(len(x))
    while len(open_):
        here, away = part.chain(open_), delta[open_] * drift.take(open_, axis=1)
        low[open_], high[open_] = x[open_] * (1 - delta[open_]), x[open_] * (1 + delta[open_])
        before[open_] = statuses(here, low[open_], alpha.take(open_, axis=1) - away)
        after[open_] = statuses(here, high[open_], alpha.take(open_, axis=1) + away)
        open_ = open_[(before[open_] * after[open_] == 0) & (delta[open_] < _WIDEST)]
        delta[open_] = np.minimum(_WIDER * delta[open_], _WIDEST)
    for side, ends in ((before, low), (after, high)):
        unknown = np.flatnonzero(side == 0)
        if len(unknown):
            side[unknown] = surely(zeros.word[unknown], ends[unknown])
    return Bracketed(x, low, high, slope, before, after)


def statuses(legs: Chain, a: Floats, alpha: Floats) -> Signs:
    """Tell which words are orbits, each at its own a: 1, -1, or 0 where doubles do not decide.

    Parameters
    ----------
    legs : Chain
    a : ndarray, shape (N,)
    alpha : ndarray, shape (m, N)
        Directions near the maximum; the verdicts do not depend on them.
    """
    limits = direction_limits(legs, a)
    here = np.clip(alpha, *limits)
    here = np.clip(here + motion(legs, a, here, limits)[0], *limits)
    status = decide(legs, a, here).status
    return (status == Status.ORBIT).astype(np.int8) - (status == Status.DYNAMICAL).astype(np.int8)


PROVED_SIGNS = {Status.ORBIT: 1, Status.DYNAMICAL: -1}
"""What statuses say of a word as an orbit."""
