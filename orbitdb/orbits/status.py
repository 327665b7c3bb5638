"""From directions to a status, as far as doubles can decide, with bounds on all errors.

Undecided words, including orbits through joints, go to `orbitdb.orbits.balls.enclosure`.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import ABOVE, check_functions
from orbitdb.arrays import Floats, Integers, Words
from orbitdb.billiard.bounces import coordinates, margin_distances, slack_errors, slacks
from orbitdb.billiard.legs import Chain, Derivatives, Legs, derivatives, direction_limits, length
from orbitdb.billiard.stability import exponent, forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import Batch
from orbitdb.orbits.error_bounds import coordinate_error, direction_errors, lambda_error, length_error
from orbitdb.orbits.orbit import Orbits, Status


@dataclass(frozen=True, eq=False)
class Verdict(Batch):
    """Statuses of N words, and the numbers that decided them."""

    slopes: Derivatives
    alpha_error: Floats  # shape (m, N)
    slack: Floats  # shape (4, m, N)
    slack_error: Floats
    status: NDArray[np.str_]  # values of `Status`, shape (N,)


def decide(legs: Chain, a: float | Floats, alpha: Floats) -> Verdict:
    """Tell which words are orbits, as far as doubles can.

    Parameters
    ----------
    legs : Chain
    a : float or ndarray, shape (N,)
    alpha : ndarray, shape (m, N)
        Directions of the legs at (or near) the maximum of the length, between the limits.
    """
    check_functions()
    slopes = derivatives(legs, a, alpha)
    alpha_error = direction_errors(legs, a, alpha, slopes)
    slack, slack_error = slacks(legs, alpha), slack_errors(legs, alpha_error)
    outside = (slack < -slack_error).any(axis=(0, 1))
    low, high = direction_limits(legs, a)
    # surely away from the limits, the maximum is a stationary point
    between = np.all(np.minimum(alpha - low, high - alpha) > ABOVE * alpha_error, axis=0)
    inside = (slack > slack_error).all(axis=(0, 1)) & between
    undecided = np.where(inside, Status.ORBIT.value, Status.UNRESOLVED.value)
    status = np.where(outside, Status.DYNAMICAL.value, undecided)
    return Verdict(slopes, alpha_error, slack, slack_error, status)


def assess(
    words: Words, legs: Legs, stadium: Stadium, found: tuple[Floats, Integers], every: bool = True
) -> Orbits:
    """Turn solved directions into orbits with error bounds and a status, as far as doubles can decide.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
    legs : Legs
        The same words, cut.
    stadium : Stadium
    found : (ndarray, ndarray)
        The directions, as in `decide`, and the steps that the solver took.
    every : bool, optional
        If false, words that are proved not to be orbits only get status, margin and steps.
    """
    alpha, iterations = found
    verdict = decide(legs, stadium.a, alpha)
    margin = margin_distances(legs, alpha, verdict.slack).min(axis=(0, 1))
    orbits = replace(Orbits.empty(words), status=verdict.status, margin=margin, iterations=iterations)
    left = np.flatnonzero(every | (verdict.status != Status.DYNAMICAL))
    if len(left):
        here = legs.rows(left), stadium, alpha.take(left, axis=1), verdict.rows(left)
        orbits.place(left, _measured(orbits.rows(left), *here))
    return orbits


def _measured(orbits: Orbits, legs: Legs, stadium: Stadium, alpha: Floats, verdict: Verdict) -> Orbits:
    """Return the results for words with a decided status."""
    a, slopes, alpha_error = stadium.a, verdict.slopes, verdict.alpha_error
    place, lyapunov = coordinates(legs, a, alpha), exponent(slopes)
    return replace(
        orbits,
        coordinates=place,
        length=length(legs, a, alpha),
        lyapunov=lyapunov,
        residual=np.abs(forces(stadium, orbits.words, place)).max(axis=1),
        error=coordinate_error(legs, a, alpha, alpha_error, verdict.slack_error),
        length_error=length_error(legs, a, alpha, slopes, alpha_error),
        lyapunov_error=lambda_error(legs, slopes, alpha_error, lyapunov),
    )
