"""From directions to a status: whether a word is an orbit, as far as doubles can decide it.

What they leave open, orbits through joints among it, goes to `orbitdb.orbits.balls.enclosure`; words that
break the geometric rules are described in `orbitdb.orbits.pruned`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import ABOVE, check_functions
from orbitdb.billiard.bounces import (
    coordinates,
    margin_distances,
    slack_errors,
    slacks,
)
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    Legs,
    derivatives,
    direction_limits,
    following,
    length,
)
from orbitdb.billiard.stability import exponent, forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.error_bounds import (
    coordinate_error,
    direction_errors,
    lambda_error,
    length_error,
    pressed_directions,
)
from orbitdb.orbits.orbit import Orbits, Status

Floats = NDArray[np.float64]


def assess(
    words: NDArray[np.uint8],
    legs: Legs,
    stadium: Stadium,
    alpha: Floats,
    iterations: NDArray[np.int64],
) -> Orbits:
    """Turn solved directions into orbits with error bounds and a status, as far as doubles can decide.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
    legs : Legs
        The same words, cut.
    stadium : Stadium
    alpha : ndarray, shape (m, N)
        Directions of the legs at (or near) the maximum of the length, between the limits.
    iterations : ndarray of int, shape (N,)
        Steps the solver took.

    Returns
    -------
    Orbits
    """
    return _measured(words, legs, stadium, alpha, iterations, _decided(legs, stadium.a, alpha))


def assess_orbits(
    words: NDArray[np.uint8],
    chain: Chain,
    legs: Callable[[NDArray[np.intp]], Legs],
    stadium: Stadium,
    found: tuple[Floats, NDArray[np.int64]],
) -> Orbits:
    """Do as `assess` does, but of words that are proved to be no orbits tell margin and steps alone.

    Parameters
    ----------
    words, stadium, found
        As there, ``found`` being the directions and the steps that the solver took.
    chain : Chain
        The words, cut.
    legs : callable
        From places among the words to their `Legs`.
    """
    alpha, iterations = found
    verdict = _decided(chain, stadium.a, alpha)
    orbits = replace(Orbits.empty(words), status=verdict.status, margin=verdict.margin, iterations=iterations)
    left = np.flatnonzero(verdict.status != Status.DYNAMICAL)
    if len(left):
        here = legs(left), stadium, alpha.take(left, axis=1), iterations[left]
        orbits.place(left, _measured(words[left], *here, verdict.of_words(left)))
    return orbits


@dataclass(frozen=True, eq=False)
class _Verdict(ByValue):
    """What has become of N words, and what that was decided by.

    Attributes
    ----------
    slopes : Derivatives
    alpha_error : ndarray, shape (m, N)
    slack_error : ndarray, shape (4, m, N)
    status, margin : ndarray, shape (N,)
        As in `Orbits`.
    """

    slopes: Derivatives
    alpha_error: Floats
    slack_error: Floats
    status: NDArray[np.str_]
    margin: Floats

    def of_words(self, words: NDArray[np.intp]) -> "_Verdict":
        """Return those of some of the words."""
        errors = self.alpha_error.take(words, axis=1), self.slack_error.take(words, axis=2)
        return _Verdict(self.slopes.of_words(words), *errors, self.status[words], self.margin[words])


def _decided(legs: Chain, a: float, alpha: Floats) -> _Verdict:
    """Tell which words are orbits, as far as doubles can."""
    check_functions()
    slopes = derivatives(legs, a, alpha)
    alpha_error = direction_errors(legs, a, alpha, slopes, pressed_directions(legs, a, alpha, slopes))
    slack = slacks(legs, alpha)
    slack_error = slack_errors(legs, alpha_error)
    status = status_of(slack, slack_error, between_limits(legs, a, alpha, alpha_error))
    margin = margin_distances(legs, alpha, slack).min(axis=(0, 1))
    return _Verdict(slopes, alpha_error, slack_error, status, margin)


def _measured(
    words: NDArray[np.uint8],
    legs: Legs,
    stadium: Stadium,
    alpha: Floats,
    iterations: NDArray[np.int64],
    verdict: _Verdict,
) -> Orbits:
    """Return all that is to be known of words of which it has been decided what becomes of them."""
    a, slopes, alpha_error = stadium.a, verdict.slopes, verdict.alpha_error
    place, lyapunov = coordinates(legs, a, alpha), exponent(slopes)
    return Orbits(
        words=words,
        status=verdict.status,
        coordinates=place,
        length=length(legs, a, alpha),
        lyapunov=lyapunov,
        margin=verdict.margin,
        residual=np.abs(forces(stadium, words, place)).max(axis=1),
        error=coordinate_error(legs, a, alpha, alpha_error, verdict.slack_error),
        length_error=length_error(legs, a, alpha, slopes, alpha_error),
        lyapunov_error=lambda_error(legs, slopes, alpha_error, lyapunov),
        iterations=iterations,
    )


def between_limits(legs: Chain, a: float | Floats, alpha: Floats, alpha_error: Floats) -> NDArray[np.bool_]:
    """Tell for which words the maximum is surely away from the limits, and so a stationary point."""
    low, high = direction_limits(legs, a)
    return np.all(np.minimum(alpha - low, high - alpha) > ABOVE * alpha_error, axis=0)


def status_of(slack: Floats, slack_error: Floats, between: NDArray[np.bool_]) -> NDArray[np.str_]:
    """Return the statuses that slacks with error bounds, shape (4, m, N), show; shape (N,)."""
    outside = (slack < -slack_error).any(axis=(0, 1))
    inside = (slack > slack_error).all(axis=(0, 1)) & between
    return np.where(
        outside, Status.DYNAMICAL.value, np.where(inside, Status.ORBIT.value, Status.UNRESOLVED.value)
    )


def surely_outside(legs: Chain, a: float, alpha: Floats, slopes: Derivatives) -> NDArray[np.bool_]:
    """Tell which words leave the stadium for sure, shape (N,), from directions that need not be near.

    One step of Newton's method is enough to tell nearly all of them. It is `direction_errors` and
    `orbitdb.billiard.bounces.slack_errors` once more, with one bound for all directions of a word and
    roundings that are quicker to find and larger.
    """
    eps = float(np.finfo(float).eps)
    run = 2 + 2 * np.pi / legs.k
    rounding = ABOVE * eps * (6 * (a + legs.n) + run + following(run))
    ratio = (np.abs(slopes.gradient) + rounding) / slopes.beyond
    first = 2 * ABOVE * ratio.max(axis=0)
    loss = (np.abs(slopes.lean) + rounding) / slopes.beyond * (first / 2) + first**2 / 2
    error = ABOVE * (ratio / (1 - np.minimum(loss, 0.5))).max(axis=0)
    slack = slacks(legs, alpha).min(axis=1)
    ends, walls = np.minimum(slack[0], slack[1]), np.minimum(slack[2], slack[3])
    return (ends < -ABOVE * (error + 26 * eps)) | (walls < -ABOVE * (3 * error + 26 * eps))
