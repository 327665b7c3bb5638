"""Orbits: what is known of a batch of words, as a structure of arrays."""

from dataclasses import dataclass, fields
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NUMBERS = ("length", "lyapunov", "margin", "residual", "error", "length_error", "lyapunov_error")
"""The columns of `Orbits` that hold one number a word."""


class Status(StrEnum):
    """What became of a word."""

    ORBIT = "orbit"
    GEOMETRIC = "geometric"
    DYNAMICAL = "dynamical"
    BOUNDARY = "boundary"
    FAMILY = "family"
    UNRESOLVED = "unresolved"

    @property
    def sentence(self) -> str:
        """The status in words."""
        return _SENTENCES[self]


_SENTENCES = {
    Status.ORBIT: "an unstable periodic orbit",
    Status.GEOMETRIC: "geometrically pruned: no orbit at any a",
    Status.DYNAMICAL: "dynamically pruned: its fixed point leaves the stadium at this a",
    Status.BOUNDARY: "runs exactly through a joint of wall and semicircle: not counted",
    Status.FAMILY: "the bouncing-ball family: marginal and not isolated, so never counted",
    Status.UNRESOLVED: "not decided",
}


@dataclass(frozen=True)
class Orbits:
    """N words of one order p and the stationary points of their length.

    Attributes
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words.
    status : ndarray of str, shape (N,)
        Values of `Status`.
    coordinates : ndarray, shape (N, p)
        x on a straight wall, radians on a semicircle, in the order of the word.
    length, lyapunov : ndarray, shape (N,)
        Total length (units of the radius), and lambda of one traversal.
    margin : ndarray, shape (N,)
        Least distance of a bounce from the end of its wall or semicircle, negative outside.
    residual : ndarray, shape (N,)
        Largest violation of the law of reflection at a bounce, in cosines.
    error, length_error, lyapunov_error : ndarray, shape (N,)
        Bounds on the error of every coordinate, of the length and of lambda.
    iterations : ndarray of int, shape (N,)
        Steps the solver took.
    """

    words: NDArray[np.uint8]
    status: NDArray[np.str_]
    coordinates: Floats
    length: Floats
    lyapunov: Floats
    margin: Floats
    residual: Floats
    error: Floats
    length_error: Floats
    lyapunov_error: Floats
    iterations: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.words)

    @classmethod
    def empty(cls, words: NDArray[np.uint8]) -> "Orbits":
        """Return the words with nothing known of them yet: unresolved, all numbers NaN."""
        n, p = words.shape
        return cls(
            words=words,
            status=np.full(n, Status.UNRESOLVED.value, dtype="U10"),
            coordinates=np.full((n, p), np.nan),
            iterations=np.zeros(n, np.int64),
            **{name: np.full(n, np.nan) for name in NUMBERS},
        )

    def rows(self, chosen: NDArray[np.intp] | NDArray[np.bool_]) -> "Orbits":
        """Return some of the words."""
        return Orbits(**{each.name: getattr(self, each.name)[chosen] for each in fields(self)})

    def place(self, rows: NDArray[np.intp], part: "Orbits") -> None:
        """Write what a part of the batch has become into the given rows."""
        for name in ("status", "coordinates", "iterations", *NUMBERS):
            getattr(self, name)[rows] = getattr(part, name)
