"""Solved words of one period as arrays."""

from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Indices, Integers, Marks, Masks, Words
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.symbols.symmetry import encloses_nothing

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
