"""Sums over the orbits of one period that all averages over fixed points and pseudo-cycles are made of.

They can be added up in parts, in any order: parts are sums of doubles, and what joins them is rounded once
(`math.fsum`). So averages of periods are had whose orbits nobody keeps.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.by_period import Lyapunov, Ranges, lyapunov_of_sums
from orbitdb.averages.fixed_points import ClassRows, Weight, determinant_factor, divisors
from orbitdb.equality import ByValue

Floats = NDArray[np.float64]

HIGHEST = 20
"""The highest order that sums are kept for."""

_COLUMNS = 4
_RANGES = 3


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
    ranges : Ranges
        Those of the orbits.
    """

    p: int
    sums: Floats
    ranges: Ranges

    @classmethod
    def of(cls, rows: ClassRows, p: int) -> "PeriodSums":
        """Add up over classes, all of period p."""
        sums = np.zeros((repetitions(p), len(Weight), _COLUMNS))
        for r, of_weights in enumerate(sums, 1):
            lyapunov, length = r * rows.lyapunov, r * rows.length
            plain = rows.size * np.exp(-lyapunov)
            factor = determinant_factor(lyapunov, rows.inverse & (r % 2 == 1))
            for found, w in zip(of_weights, (plain, plain / factor), strict=True):
                terms = w, w * lyapunov, w * length, w * (lyapunov / length)
                found[:] = [term.sum() for term in terms]
        return cls(p, sums, Ranges.of(rows))

    @classmethod
    def joined(cls, parts: "Sequence[PeriodSums]", p: int) -> "PeriodSums":
        """Add up parts, exactly and with one rounding."""
        shape = repetitions(p), len(Weight), _COLUMNS
        columns = zip(*(part.sums.ravel().tolist() for part in parts), strict=True)
        sums = np.array([math.fsum(column) for column in columns] or [0.0] * math.prod(shape))
        return cls(p, sums.reshape(shape), Ranges.joined(part.ranges for part in parts))

    def numbers(self) -> bytes:
        """Return all of it but p as little-endian doubles."""
        ranges = (*self.ranges.least, *self.ranges.greatest)
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
        ranges = len(values) - math.prod(shape)
        if ranges not in (0, 2 * _RANGES) or not np.isfinite(values).all():
            raise ValueError(f"{len(values)} numbers are no sums of period {p}")
        least, greatest = (tuple(part) for part in values[:ranges].reshape(2, -1).tolist())
        return cls(p, values[ranges:].reshape(shape), Ranges(least, greatest))


def lyapunov(rows: ClassRows, highest: int, weight: Weight = Weight.EXPONENTIAL) -> Lyapunov:
    """Return the Lyapunov averages at p = 2 .. highest of orbits, truncated by period."""
    return lyapunov_of_periods(
        {p: PeriodSums.of(part, p) for p, part in rows.by_period().items()}, highest, weight
    )


def lyapunov_of_periods(
    periods: Mapping[int, PeriodSums], highest: int, weight: Weight = Weight.EXPONENTIAL
) -> Lyapunov:
    """Return the Lyapunov averages at p = 2 .. highest.

    Parameters
    ----------
    periods : mapping of int to PeriodSums
        The sums by period; what is not there has no orbit.
    highest : int
        At most `HIGHEST`.
    weight : Weight, optional
    """
    column = list(Weight).index(weight)
    fixed_points = np.zeros((_COLUMNS, highest))
    for p in range(1, highest + 1):  # d points an orbit of each divisor d
        parts = [d * periods[d].sums[p // d - 1, column] for d in divisors(p) if d in periods]
        fixed_points[:, p - 1] = [math.fsum(terms) for terms in zip(*parts, strict=True)] or 0.0
    ranges = [Ranges.joined(periods[d].ranges for d in periods if d <= p) for p in range(2, highest + 1)]
    return lyapunov_of_sums(fixed_points, ranges)
