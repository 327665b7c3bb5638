"""Proof that a word begins or ceases to be an orbit inside a narrow bracket of a.

At both ends of the bracket, error bounds decide whether the word is an orbit. The slacks are continuous in a,
so the change lies in the bracket, however it was found. If rounding hides the status at one end, the bracket
is widened; if this does not help, the status is decided in ball arithmetic.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Marks, Places, Words
from orbitdb.billiard.bounces import slack_errors
from orbitdb.billiard.legs import Chain, derivatives, direction_limits
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import Batch
from orbitdb.orbits.births.continuation import motion, slacks_and_slopes
from orbitdb.orbits.births.crossings import Zeros
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.newton import certificates
from orbitdb.orbits.status import Status, decide

Signs = NDArray[np.int8]

_WIDER = 4.0
_NARROWEST = 2.0**-51
_WIDEST = 1e-11
"""Relative width above which brackets are not widened but decided in ball arithmetic."""
_SAFETY = 1.05
_POLISH = 1e-9
"""Largest step in ln a when a converged zero is polished."""

_SIGNS = {Status.ORBIT: 1, Status.DYNAMICAL: -1}


@dataclass(frozen=True, eq=False)
class Bracketed(Batch):
    """K proved changes of words, stored as arrays of shape (K,)."""

    word: Places  # the index of the word that changes
    a: Floats  # the value of a at which it changes
    error: Floats  # proved bound on the error of a
    born: Marks  # True if it begins to be an orbit as a increases, False if it ceases
    slack: Places  # the smooth slack that changes sign (`orbitdb.orbits.births.crossings.Zeros`)
    slope: Floats  # derivative of this slack with respect to ln a (radians)


def bracket(words: Words, legs: Chain, zeros: Zeros) -> Bracketed:
    """Bracket zeros of slacks in a; keep those at which the words, shape (N, p), are proved to change."""
    part, own = legs.chain(zeros.word), (zeros.slack, np.arange(len(zeros)))
    x, alpha = np.exp(zeros.x), zeros.alpha
    for _ in range(2):  # once to get as close to the zero as doubles allow, and again there
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
            side[unknown] = proved_signs(words[zeros.word[unknown]], ends[unknown])
    found = Bracketed(zeros.word, x, np.maximum(high - x, x - low), after > 0, zeros.slack, slope)
    return found.rows(np.flatnonzero(before * after == -1))


def statuses(legs: Chain, a: Floats, alpha: Floats) -> Signs:
    """Return 1 for each word that is an orbit at its own a, -1 if it is not, 0 if doubles cannot decide.

    The half lengths a have shape (N,). The directions alpha, shape (m, N), are near the maximum; the verdicts
    do not depend on them.
    """
    limits = direction_limits(legs, a)
    here = np.clip(alpha, *limits)
    here = np.clip(here + motion(legs, a, here, limits)[0], *limits)
    status = decide(legs, a, here).status
    return (status == Status.ORBIT).astype(np.int8) - (status == Status.DYNAMICAL).astype(np.int8)


def signs(words: Words, legs: Chain, a: Floats, alpha: Floats) -> Signs:
    """Return the same as `statuses`, but decide in ball arithmetic where doubles cannot."""
    found = statuses(legs, a, alpha)
    unknown = np.flatnonzero(found == 0)
    if len(unknown):
        found[unknown] = proved_signs(words[unknown], a[unknown])
    return found


def proved_signs(words: Words, a: Floats) -> Signs:
    """Decide in ball arithmetic which words are orbits, each at its own a, shape (N,).

    Return 1 for an orbit and -1 if the word is not one; 0 for an orbit exactly through a joint, or if
    undecided.
    """
    found = np.zeros(len(words), np.int8)
    for at in np.unique(a).tolist():
        same = np.flatnonzero(a == at)
        found[same] = [_SIGNS.get(each.status, 0) for each in certificates(words[same], Stadium(at))]
    return found
