"""Sums over the fixed points of each order, computed from symmetry classes.

One row per class, with the size of the class, is enough (`ClassRows`). The fixed points of order p are the
points of all orbits whose period d divides p. Such an orbit has d points, and its lambda and L are multiplied
by the number of repetitions, p/d.

Averages over fixed points and zeta functions truncated by period are built from sums over the orbits of each
period (`PeriodSums`). These sums can be computed in parts and joined in any order, because joining them
rounds only once (`math.fsum`). This gives averages for periods whose orbits are not stored.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.equality import Batch, ByValue


class Weight(StrEnum):
    """Weight of an orbit in an average."""

    EXPONENTIAL = "exp"
    """e^-lambda, as in the paper; the corresponding zeta function is the dynamical zeta function."""

    DETERMINANT = "det"
    """1/|det(1 - M^r)|, the exact weight; the corresponding zeta function is the Fredholm determinant."""


@dataclass(frozen=True, eq=False)
class ClassRows(Batch):
    """N symmetry classes of isolated orbits, with any periods and in any order.

    Raises
    ------
    ValueError
        If the arrays differ in length, or if a period, size, length or lambda is not positive and finite.
    """

    period: Integers  # shape (N,)
    size: Integers  # number of different cyclic words in the class, shape (N,)
    length: Floats  # length of one traversal, in units of the radius, shape (N,)
    lyapunov: Floats  # lambda of one traversal, shape (N,)
    # whether the eigenvalues of M are negative, because the number of straight bounces is odd, shape (N,)
    inverse: Marks

    def __post_init__(self) -> None:
        columns = (self.period, self.size, self.length, self.lyapunov, self.inverse)
        if len({column.shape for column in columns}) != 1 or self.period.ndim != 1:
            raise ValueError("the columns of class rows must be vectors of the same length")
        if not all((column > 0).all() and np.isfinite(column).all() for column in columns[:4]):
            raise ValueError("class rows need a positive period, size, length and lambda: pass orbits only")

    def __len__(self) -> int:
        return len(self.period)

    def ranges(self) -> Floats:
        """Return the least (row 0) and the greatest (row 1) lambda / p, lambda / L and L / p, shape (2, 3).

        If there are no orbits, the rows are inf and -inf.
        """
        per_bounce, per_length = self.lyapunov / self.period, self.lyapunov / self.length
        values = np.stack([per_bounce, per_length, self.length / self.period])
        return np.stack([values.min(axis=1, initial=np.inf), values.max(axis=1, initial=-np.inf)])

    def by_period(self) -> dict[int, "ClassRows"]:
        """Return the rows of each period, keyed by period; periods without rows are left out."""
        order = np.argsort(self.period, kind="stable")
        periods, starts = np.unique(self.period[order], return_index=True)
        parts = np.split(order, starts)[1:]
        return {int(p): self.rows(part) for p, part in zip(periods, parts, strict=True)}


def divisors(p: int) -> list[int]:
    """Return all divisors of p in ascending order, including 1 and p."""
    return [d for d in range(1, p + 1) if p % d == 0]


def of_divisors(p: int) -> set[int]:
    """Return the periods that a sum over the fixed points of order p needs, without 1, which no orbit has."""
    return set(divisors(p)) - {1}


def of_pairs(p: int) -> set[int]:
    """Return the periods that the mean of the averages of orders p - 1 and p needs."""
    return of_divisors(p - 1) | of_divisors(p)


def every_period(p: int) -> set[int]:
    """Return the periods that a zeta function or a sum rule of order p needs: all from 2 to p."""
    return set(range(2, p + 1))


HIGHEST = 20
"""The highest order for which sums over fixed points are computed."""

_COLUMNS = 4
NO_RANGES = np.array([[np.inf] * 3, [-np.inf] * 3])


def joined_ranges(parts: Iterable[Floats]) -> Floats:
    """Return the ranges over all orbits, given the ranges of parts of them (`ClassRows.ranges`)."""
    every = np.array([NO_RANGES, *parts])
    return np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])


def repetitions(p: int) -> int:
    """Return how many repetitions of an orbit of period p fit into the order `HIGHEST`; at least 1."""
    return max(HIGHEST // p, 1)


@dataclass(frozen=True, eq=False)
class PeriodSums(ByValue):
    """Sums over the orbits of period p, or over some of these orbits."""

    p: int
    # Sums over all cyclic words of w, w lambda, w L and w lambda / L for 1, 2, .. r repetitions and for each
    # `Weight`, where the weight w, lambda and L are those of the repeated orbit; shape (r, 2, 4)
    sums: Floats
    ranges: Floats  # the ranges over these orbits (`ClassRows.ranges`), shape (2, 3)

    @classmethod
    def of(cls, rows: ClassRows, p: int) -> "PeriodSums":
        """Sum over classes, all of which must have period p."""
        sums = np.zeros((repetitions(p), len(Weight), _COLUMNS))
        for r, of_weights in enumerate(sums, 1):
            lyapunov, length = r * rows.lyapunov, r * rows.length
            plain = rows.size * np.exp(-lyapunov)
            # |det(1 - M)| e^-lambda = (1 -+ e^-lambda)^2, with + if the eigenvalues are negative
            negative = rows.inverse & (r % 2 == 1)
            factor = np.where(negative, 1 + np.exp(-lyapunov), -np.expm1(-lyapunov)) ** 2
            for found, w in zip(of_weights, (plain, plain / factor), strict=True):
                terms = w, w * lyapunov, w * length, w * (lyapunov / length)
                found[:] = [term.sum() for term in terms]
        return cls(p, sums, rows.ranges())

    @classmethod
    def joined(cls, parts: "Sequence[PeriodSums]", p: int) -> "PeriodSums":
        """Add up the sums of several parts exactly, and round only the result."""
        shape = repetitions(p), len(Weight), _COLUMNS
        columns = zip(*(part.sums.ravel().tolist() for part in parts), strict=True)
        sums = np.array([math.fsum(column) for column in columns] or [0.0] * math.prod(shape))
        return cls(p, sums.reshape(shape), joined_ranges(part.ranges for part in parts))

    def numbers(self) -> bytes:
        """Return all numbers except p as the bytes of little-endian doubles."""
        ranges = self.ranges[np.isfinite(self.ranges)]
        return np.concatenate([ranges, self.sums.ravel()]).astype("<f8").tobytes()

    @classmethod
    def from_numbers(cls, p: int, numbers: bytes) -> "PeriodSums":
        """Reconstruct the sums from the bytes that `numbers` returned.

        Raises
        ------
        ValueError
            If the bytes do not contain the right number of values for period p, or if a value is not finite.
        """
        shape = repetitions(p), len(Weight), _COLUMNS
        values = np.frombuffer(numbers, dtype="<f8").astype(float)
        count = len(values) - math.prod(shape)
        if count not in (0, NO_RANGES.size) or not np.isfinite(values).all():
            raise ValueError(f"{len(values)} numbers are not finite sums of period {p}")
        ranges = values[:count].reshape(NO_RANGES.shape) if count else NO_RANGES
        return cls(p, values[count:].reshape(shape), ranges)
