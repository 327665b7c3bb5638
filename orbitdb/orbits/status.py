"""Statuses, and solved words as arrays: how the directions of the legs become orbits with error bounds.

Double precision decides the statuses if it can. Words that remain undecided, including orbits through joints,
go to `orbitdb.orbits.balls`.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Integers, Marks, Masks, Words
from orbitdb.billiard.arithmetic import ABOVE, check_functions
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    Legs,
    coordinates,
    derivatives,
    direction_limits,
    length,
    margin_distances,
    slack_errors,
    slacks,
)
from orbitdb.billiard.stability import exponent, forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.error_bounds import (
    coordinate_error,
    direction_errors,
    enclosed_areas,
    lambda_error,
    length_error,
)
from orbitdb.symbols.symmetry import encloses_nothing
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


NUMBERS = (
    "length", "lyapunov", "margin", "residual", "error", "length_error", "lyapunov_error",
    "area", "area_error",
)  # fmt: skip
"""The attributes of `Orbits` with one number per word."""


def finite(number: np.float64) -> float | None:
    """Return a number as a float, or None if it is not finite."""
    return float(number) if np.isfinite(number) else None


@dataclass(frozen=True, eq=False, repr=False)
class Orbits:
    """N words of the same period p, and the stationary points of their lengths.

    Attributes
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words.
    status : ndarray of str, shape (N,)
        Values of `Status`.
    coordinates : ndarray, shape (N, p)
        x on a straight wall, radians on a semicircle, in the order of the word's symbols.
    length, lyapunov : ndarray, shape (N,)
        Total length in units of the radius, and lambda for one traversal.
    margin : ndarray, shape (N,)
        Least distance of a bounce from an end of its wall or semicircle, negative if it is outside. For a
        dynamical word, that of its fixed point or, if a direction of the fixed point is beyond the limits for
        orbits, of the longest path within the limits.
    residual : ndarray, shape (N,)
        Largest violation of the law of reflection at a bounce, as a difference of cosines.
    error, length_error, lyapunov_error : ndarray, shape (N,)
        Bounds on the errors of every coordinate, of the length and of lambda.
    area, area_error : ndarray, shape (N,)
        Area that one traversal encloses, anticlockwise positive, and a bound on its error, in radius^2.
    iterations : ndarray of int, shape (N,)
        Number of steps that the solver took.
    """

    words: Words
    status: NDArray[np.str_]
    coordinates: Floats
    length: Floats
    lyapunov: Floats
    margin: Floats
    residual: Floats
    error: Floats
    length_error: Floats
    lyapunov_error: Floats
    area: Floats
    area_error: Floats
    iterations: Integers

    def __len__(self) -> int:
        return len(self.words)

    def __repr__(self) -> str:
        count = int(np.isin(self.status, EXISTING).sum())
        return f"<{len(self)} words of period {self.words.shape[1]}, {count} with an orbit>"

    @classmethod
    def empty(cls, words: Words) -> "Orbits":
        """Return words that are not yet solved: their status is unresolved, and all numbers are NaN."""
        n, p = words.shape
        return cls(
            words=words,
            status=np.full(n, Status.UNRESOLVED.value, dtype="U10"),
            coordinates=np.full((n, p), np.nan),
            iterations=np.zeros(n, np.int64),
            **{name: np.full(n, np.nan) for name in NUMBERS},
        )

    def rows(self, chosen: Indices | Marks) -> "Orbits":
        """Return the orbits of the chosen words."""
        return Orbits(**{column.name: getattr(self, column.name)[chosen] for column in fields(self)})

    def with_symmetries(self, stabilisers: Masks) -> "Orbits":
        """Return the same orbits, with an area of exactly 0 where an odd symmetry says so."""
        exact = encloses_nothing(stabilisers)
        area, error = (np.where(exact, 0.0 * np.abs(of), of) for of in (self.area, self.area_error))
        return replace(self, area=area, area_error=error)

    def place(self, rows: Indices, part: "Orbits") -> None:
        """Write the results of a part of the batch into the given rows, in place."""
        for name in ("status", "coordinates", "iterations", *NUMBERS):
            getattr(self, name)[rows] = getattr(part, name)


def assess(
    words: Words, legs: Legs, stadium: Stadium, directions: tuple[Floats, Integers], every: bool = True
) -> Orbits:
    """Turn solved directions into orbits with error bounds, and with a status if doubles can decide it.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words.
    legs : Legs
        The runs and legs of these words.
    directions : (ndarray, ndarray)
        The directions, as in `decide`, and the number of steps that the solver took.
    every : bool, optional
        If false, words that are proved not to be orbits only get a status, a margin and a number of steps.
    """
    alpha, iterations = directions
    decided = decide(legs, stadium.a, alpha)
    margin = margin_distances(legs, alpha, decided.slack).min(axis=(0, 1))
    orbits = replace(Orbits.empty(words), status=decided.status, margin=margin, iterations=iterations)
    left = np.flatnonzero(every | (decided.status != Status.DYNAMICAL))
    if len(left):
        existing = legs.rows(left), stadium, alpha.take(left, axis=1), decided.rows(left)
        orbits.place(left, _measured(orbits.rows(left), *existing))
    return orbits


def _measured(
    orbits: Orbits, legs: Legs, stadium: Stadium, alpha: Floats, decided: DecidedStatuses
) -> Orbits:
    """Complete orbits whose statuses are known with coordinates, length, lambda and their error bounds."""
    a, slopes, alpha_error = stadium.a, decided.slopes, decided.alpha_error
    place, lyapunov = coordinates(legs, a, alpha), exponent(slopes)
    error = coordinate_error(legs, a, alpha, alpha_error, decided.slack_error)
    area, area_error = enclosed_areas(stadium, orbits.words, place, error)
    return replace(
        orbits,
        coordinates=place,
        length=length(legs, a, alpha),
        lyapunov=lyapunov,
        residual=np.abs(forces(stadium, orbits.words, place)).max(axis=1),
        error=error,
        length_error=length_error(legs, a, alpha, slopes, alpha_error),
        lyapunov_error=lambda_error(legs, slopes, alpha_error, lyapunov),
        area=area,
        area_error=area_error,
    )
