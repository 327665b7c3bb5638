"""What became of words that were followed into a magnetic field: their statuses and numbers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Words
from orbitdb.billiard.stadium import Stadium
from orbitdb.magnetic.action import ArcPaths
from orbitdb.magnetic.along_kappa import FollowedWords
from orbitdb.magnetic.flow import at_joints, leave_stadium, stability
from orbitdb.text import Phrased


class FieldStatus(Phrased):
    """The status of a word in a magnetic field."""

    ORBIT = "orbit", "an unstable periodic orbit"
    ELLIPTIC = "elliptic", "a stable periodic orbit, |tr M| < 2"
    JOINT = "joint", "no orbit: a bounce has left its wall or semicircle"
    GRAZING = "grazing", "no orbit: an arc meets another part of the boundary first"
    UNRESOLVED = "unresolved", "not decided: it could not be followed from kappa = 0"


IN_FIELD = (FieldStatus.ORBIT.value, FieldStatus.ELLIPTIC.value)
"""Statuses of words that are orbits, and so have numbers."""


@dataclass(frozen=True, eq=False)
class FieldNumbers(Batch):
    """Statuses and numbers of N words at their own curvatures, as arrays of shape (N,).

    The numbers are NaN for words that are not orbits.
    """

    status: NDArray[np.str_]  # values of `FieldStatus`
    action: Floats  # S = L - kappa A, in units of the radius
    length: Floats  # L
    area: Floats  # A, anticlockwise positive, in radius^2
    lyapunov: Floats  # lambda of one traversal; 0 for an elliptic orbit
    trace: Floats  # of the monodromy matrix
    residual: Floats  # largest violation of the law of reflection, as a difference of cosines
    least_sine: Floats  # smallest sin theta of a bounce, whatever the status; NaN if it could not be followed


def measure(stadium: Stadium, words: Words, followed: FollowedWords, kappa: Floats) -> FieldNumbers:
    """Decide which followed words, shape (N, p), are orbits at their curvatures, shape (N,); measure them."""
    symbols, coordinates = words.T, followed.coordinates.T
    paths = ArcPaths.of(stadium, symbols, coordinates, kappa)
    trace, lyapunov = stability(symbols, paths)
    cases = {
        FieldStatus.UNRESOLVED: followed.lost,
        FieldStatus.JOINT: at_joints(stadium, symbols, coordinates),
        FieldStatus.GRAZING: leave_stadium(stadium, paths),
        FieldStatus.ELLIPTIC: np.abs(trace) < 2,
    }
    status = np.select([*cases.values()], [each.value for each in cases], FieldStatus.ORBIT.value)
    exists = np.isin(status, IN_FIELD)
    numbers = [paths.actions, paths.lengths, paths.areas, lyapunov, trace, followed.residual]
    numbers = [np.where(exists, values, np.nan) for values in numbers]
    numbers.append(np.sqrt(1 - np.minimum(np.abs(paths.outgoing), 1) ** 2).min(axis=0))
    return FieldNumbers(status, *numbers)
