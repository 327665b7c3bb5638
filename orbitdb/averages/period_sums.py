"""Sums over the orbits of one period that all averages over fixed points and pseudo-cycles are made of.

They can be added up in parts, in any order: parts are sums of doubles, and what joins them is rounded once
(`math.fsum`). So averages of periods are had whose orbits nobody keeps.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.fixed_points import ClassRows, Weight
from orbitdb.equality import ByValue

Floats = NDArray[np.float64]

HIGHEST = 20
"""The highest order that sums are kept for."""

_COLUMNS = 4
NO_RANGES = np.array([[np.inf] * 3, [-np.inf] * 3])


def joined_ranges(parts: Iterable[Floats]) -> Floats:
    """Return the ranges of the orbits of all parts."""
    every = np.array([NO_RANGES, *parts])
    return np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])


def repetitions(p: int) -> int:
    """Return how often orbits of period p are repeated in orders up to `HIGHEST`."""
    return max(HIGHEST // p, 1)


@dataclass(frozen=True, eq=False)
class PeriodSums(ByValue):
    """Sums over the orbits of period p, or some of them.

    Attributes
    ----------
    p : int
    sums : ndarray, shape (r, 2, 4)
        For 1, 2, .. repetitions and each `Weight`, the sums over all cyclic words of w, w lambda, w L and
        w lambda / L, with w, lambda and L of the repeated orbit.
    ranges : ndarray, shape (2, 3)
        Those of the orbits (`ClassRows.ranges`).
    """

    p: int
    sums: Floats
    ranges: Floats

    @classmethod
    def of(cls, rows: ClassRows, p: int) -> "PeriodSums":
        """Add up over classes, all of period p."""
        sums = np.zeros((repetitions(p), len(Weight), _COLUMNS))
        for r, of_weights in enumerate(sums, 1):
            lyapunov, length = r * rows.lyapunov, r * rows.length
            plain = rows.size * np.exp(-lyapunov)
            # |det(1 - M)| e^-lambda = (1 -+ e^-lambda)^2, + where the eigenvalues are negative
            negative = rows.inverse & (r % 2 == 1)
            factor = np.where(negative, 1 + np.exp(-lyapunov), -np.expm1(-lyapunov)) ** 2
            for found, w in zip(of_weights, (plain, plain / factor), strict=True):
                terms = w, w * lyapunov, w * length, w * (lyapunov / length)
                found[:] = [term.sum() for term in terms]
        return cls(p, sums, rows.ranges())

    @classmethod
    def joined(cls, parts: "Sequence[PeriodSums]", p: int) -> "PeriodSums":
        """Add up parts, exactly and with one rounding."""
        shape = repetitions(p), len(Weight), _COLUMNS
        columns = zip(*(part.sums.ravel().tolist() for part in parts), strict=True)
        sums = np.array([math.fsum(column) for column in columns] or [0.0] * math.prod(shape))
        return cls(p, sums.reshape(shape), joined_ranges(part.ranges for part in parts))

    def numbers(self) -> bytes:
        """Return all of it but p as little-endian doubles."""
        ranges = self.ranges[np.isfinite(self.ranges)]
        return np.concatenate([ranges, self.sums.ravel()]).astype("<f8").tobytes()

    @classmethod
    def from_numbers(cls, p: int, numbers: bytes) -> "PeriodSums":
        """Return what `numbers` was made of.

        Raises
        ------
        ValueError
            If they are not as many as period p has, or not finite.
        """
        shape = repetitions(p), len(Weight), _COLUMNS
        values = np.frombuffer(numbers, dtype="<f8").astype(float)
        count = len(values) - math.prod(shape)
        if count not in (0, NO_RANGES.size) or not np.isfinite(values).all():
            raise ValueError(f"{len(values)} numbers are no sums of period {p}")
        ranges = values[:count].reshape(NO_RANGES.shape) if count else NO_RANGES
        return cls(p, values[count:].reshape(shape), ranges)
