"""The fixed points of each order, from symmetry classes.

One row per class, with its size, is enough (`ClassRows`). The fixed points of order p are the points of all
orbits whose period d divides p. Such an orbit has d points; p/d repetitions multiply its lambda and L.

Averages over fixed points, and zeta functions truncated by period, are built from sums over the orbits of one
period (`PeriodSums`). The sums can be added up in parts and in any order, because joining the parts rounds
only once (`math.fsum`). This gives averages for periods whose orbits are not stored.
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
    """e^-lambda, as in the paper; the zeta function is the dynamical one."""

    DETERMINANT = "det"
    """1/|det(1 - M^r)|, the exact weight; the zeta function is the Fredholm determinant."""


@dataclass(frozen=True, eq=False)
class ClassRows(Batch):
    """Symmetry classes of isolated orbits, with any periods and in any order.

    Raises
    ------
    ValueError
        If the arrays differ in length, or a period, size, length or lambda is not positive and finite.
    """

    period: Integers  # shape (N,)
    size: Integers  # number of different cyclic words in the class, shape (N,)
    length: Floats  # length of one traversal, in units of the radius, shape (N,)
    lyapunov: Floats  # lambda of one traversal, shape (N,)
    inverse: Marks  # whether the eigenvalues of M are negative: an odd number of straight bounces, shape (N,)

    def __post_init__(self) -> None:
        columns = (self.period, self.size, self.length, self.lyapunov, self.inverse)
        if len({column.shape for column in columns}) != 1 or self.period.ndim != 1:
            raise ValueError("the columns of class rows must be vectors of the same length")
        if not all((column > 0).all() and np.isfinite(column).all() for column in columns[:4]):
            raise ValueError("class rows need a positive period, size, length and lambda: pass orbits only")

    def __len__(self) -> int:
        return len(self.period)

    def ranges(self) -> Floats:
        """Return the least and the greatest lambda / p, lambda / L and L / p, shape (2, 3).

        Without orbits they are inf and -inf.
        """
        per_bounce, per_length = self.lyapunov / self.period, self.lyapunov / self.length
        values = np.stack([per_bounce, per_length, self.length / self.period])
        return np.stack([values.min(axis=1, initial=np.inf), values.max(axis=1, initial=-np.inf)])

    def by_period(self) -> dict[int, "ClassRows"]:
        """Return the rows by period, for the periods that have any."""
        order = np.argsort(self.period, kind="stable")
        periods, starts = np.unique(self.period[order], return_index=True)
        parts = np.split(order, starts)[1:]
        return {int(p): self.rows(part) for p, part in zip(periods, parts, strict=True)}


def divisors(p: int) -> list[int]:
    """Return the divisors of p from 1 to p."""
    return [d for d in range(1, p + 1) if p % d == 0]


def of_divisors(p: int) -> set[int]:
    """Return the periods that a sum over the fixed points of order p needs; no orbit has period 1."""
    return set(divisors(p)) - {1}


def of_pairs(p: int) -> set[int]:
    """Return the periods that a mean of orders p - 1 and p needs."""
    return of_divisors(p - 1) | of_divisors(p)


def every_period(p: int) -> set[int]:
    """Return the periods, all from 2 to p, that a zeta function or a sum rule of order p needs."""
    return set(range(2, p + 1))


HIGHEST = 20
"""The highest order for which sums are kept."""

_COLUMNS = 4
NO_RANGES = np.array([[np.inf] * 3, [-np.inf] * 3])


def joined_ranges(parts: Iterable[Floats]) -> Floats:
    """Return the ranges over all parts (`ClassRows.ranges`)."""
    every = np.array([NO_RANGES, *parts])
    return np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])


def repetitions(p: int) -> int:
    """Return the largest number of repetitions of period p within order `HIGHEST`, at least 1."""
    return max(HIGHEST // p, 1)


@dataclass(frozen=True, eq=False)
class PeriodSums(ByValue):
    """Sums over the orbits of period p, or over some of these orbits."""

    p: int
    # For 1, 2, .. repetitions and each `Weight`, the sums over all cyclic words of w, w lambda, w L and w
    # lambda / L, where w, lambda and L belong to the repeated orbit, shape (r, 2, 4).
    sums: Floats
    ranges: Floats  # as from `ClassRows.ranges`, shape (2, 3)

    @classmethod
    def of(cls, rows: ClassRows, p: int) -> "PeriodSums":
        """Add up over classes that all have period p."""
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
        """Add up parts exactly, then round once."""
        shape = repetitions(p), len(Weight), _COLUMNS
        columns = zip(*(part.sums.ravel().tolist() for part in parts), strict=True)
        sums = np.array([math.fsum(column) for column in columns] or [0.0] * math.prod(shape))
        return cls(p, sums.reshape(shape), joined_ranges(part.ranges for part in parts))

    def numbers(self) -> bytes:
        """Return everything except p as little-endian doubles."""
        ranges = self.ranges[np.isfinite(self.ranges)]
        return np.concatenate([ranges, self.sums.ravel()]).astype("<f8").tobytes()

    @classmethod
    def from_numbers(cls, p: int, numbers: bytes) -> "PeriodSums":
        """Return the sums that `numbers` wrote.

        Raises
        ------
        ValueError
            If their count does not fit period p, or one of them is not finite.
        """
        shape = repetitions(p), len(Weight), _COLUMNS
        values = np.frombuffer(numbers, dtype="<f8").astype(float)
        count = len(values) - math.prod(shape)
        if count not in (0, NO_RANGES.size) or not np.isfinite(values).all():
            raise ValueError(f"{len(values)} numbers are not finite sums of period {p}")
        ranges = values[:count].reshape(NO_RANGES.shape) if count else NO_RANGES
        return cls(p, values[count:].reshape(shape), ranges)
