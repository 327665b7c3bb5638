"""The statuses of words, and how the directions of the legs decide them in double precision if possible.

Words that remain undecided, including orbits through joints, go to `orbitdb.orbits.balls.enclosure`.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import ABOVE, check_functions
from orbitdb.arrays import Floats
from orbitdb.billiard.bounces import slack_errors, slacks
from orbitdb.billiard.legs import Chain, Derivatives, derivatives, direction_limits
from orbitdb.equality import Batch
from orbitdb.orbits.error_bounds import direction_errors


class Status(StrEnum):
    """The status of a word."""

    ORBIT = "orbit"
    GEOMETRIC = "geometric"
    DYNAMICAL = "dynamical"
    BOUNDARY = "boundary"
    FAMILY = "family"
    UNRESOLVED = "unresolved"

    @property
    def sentence(self) -> str:
        """The status as a phrase."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.ORBIT: "an unstable periodic orbit",
    Status.GEOMETRIC: "geometrically pruned: no orbit at any a",
    Status.DYNAMICAL: "dynamically pruned: its fixed point leaves the stadium at this a",
    Status.BOUNDARY: "runs exactly through a joint of wall and semicircle: not counted",
    Status.FAMILY: "the bouncing-ball family: marginal and not isolated, so never counted",
    Status.UNRESOLVED: "not decided",
}


STORED = tuple(status for status in Status if status is not Status.FAMILY)
"""Statuses that rows of a catalogue can have."""

EXISTING = (Status.ORBIT.value, Status.BOUNDARY.value)
"""Statuses of words that have coordinates, length and lambda."""


@dataclass(frozen=True, eq=False)
class Verdict(Batch):
    """Statuses of N words, and the numbers from which they were decided."""

    slopes: Derivatives
    alpha_error: Floats  # shape (m, N)
    slack: Floats  # shape (4, m, N)
    slack_error: Floats
    status: NDArray[np.str_]  # values of `Status`, shape (N,)


def decide(legs: Chain, a: float | Floats, alpha: Floats) -> Verdict:
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
    return Verdict(slopes, alpha_error, slack, slack_error, status)
