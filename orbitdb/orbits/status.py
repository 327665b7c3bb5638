"""The status of a word, and how it is decided from the directions of the legs, if doubles can.

Words that remain undecided, including orbits through joints, go to `orbitdb.orbits.balls`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats
from orbitdb.billiard.arithmetic import ABOVE, check_functions
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    derivatives,
    direction_limits,
    slack_errors,
    slacks,
)
from orbitdb.orbits.error_bounds import (
    direction_errors,
)
from orbitdb.text import Phrased


class Status(Phrased):
    """The status of a word.

    Attributes
    ----------
    sentence : str
        The status as a phrase.
    """

    ORBIT = "orbit", "an unstable periodic orbit"
    GEOMETRIC = "geometric", "geometrically pruned: no orbit at any a"
    DYNAMICAL = "dynamical", "dynamically pruned: its closed path leaves the stadium at this a"
    BOUNDARY = "boundary", "runs exactly through a joint of wall and semicircle: not counted"
    FAMILY = "family", "the bouncing-ball family: marginal and not isolated, so never counted"
    UNRESOLVED = "unresolved", "not decided"


STORED = tuple(status for status in Status if status is not Status.FAMILY)
"""Statuses that rows of a catalogue can have."""

EXISTING = (Status.ORBIT.value, Status.BOUNDARY.value)
"""Statuses of words that have coordinates, length and lambda."""


@dataclass(frozen=True, eq=False)
class DecidedStatuses(Batch):
    """Statuses of N words, and the numbers from which they were decided."""

    slopes: Derivatives
    alpha_error: Floats  # shape (m, N)
    slack: Floats  # shape (4, m, N)
    slack_error: Floats
    status: NDArray[np.str_]  # values of `Status`, shape (N,)


def decide(legs: Chain, a: float | Floats, alpha: Floats) -> DecidedStatuses:
    """Decide which words are orbits, if doubles can.

    The directions alpha, shape (m, N), are between the limits, at or near the maximum of the length. Each
    word may have its own a, shape (N,).
    """
    check_functions()
    slopes = derivatives(legs, a, alpha)
    alpha_error = direction_errors(legs, a, alpha, slopes)
    slack, slack_error = slacks(legs, alpha), slack_errors(legs, alpha_error)
    outside = (slack < -slack_error).any(axis=(0, 1))
    low, high = direction_limits(legs, a)
    # a maximum that is surely away from the limits is a stationary point
    between = np.all(np.minimum(alpha - low, high - alpha) > ABOVE * alpha_error, axis=0)
    inside = (slack > slack_error).all(axis=(0, 1)) & between
    undecided = np.where(inside, Status.ORBIT.value, Status.UNRESOLVED.value)
    status = np.where(outside, Status.DYNAMICAL.value, undecided)
    return DecidedStatuses(slopes, alpha_error, slack, slack_error, status)
