"""The fixed points of each order, from symmetry classes.

One row a class with its size is enough (`ClassRows`): no word and no coordinate is read, and nothing is
expanded to single words. The fixed points of order p are the points of all orbits whose period d divides
p: d points an orbit, and p/d repetitions, with which lambda and L grow.

All averages over fixed points and pseudo-cycles are made of sums over the orbits of one period
(`PeriodSums`). They can be added up in parts, in any order: parts are sums of doubles, and what joins them is
rounded once (`math.fsum`). So averages of periods are had whose orbits nobody keeps.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers
from orbitdb.equality import ByValue, Columns


class Weight(StrEnum):
    """How much an orbit counts in an average."""

    EXPONENTIAL = "exp"
    """e^-lambda, as in the paper; the zeta function is the dynamical one."""

    DETERMINANT = "det"
    """1/|det(1 - M^r)|, the exact weight; the zeta function is the Fredholm determinant."""


@dataclass(frozen=True, eq=False)
class ClassRows(Columns):
    """Symmetry classes of isolated orbits, of any periods in any order.

    Attributes
    ----------
    period : ndarray of int, shape (N,)
    size : ndarray of int, shape (N,)
        Number of different cyclic words in the class.
    length : ndarray, shape (N,)
        Length of one traversal, in units of the radius.
    lyapunov : ndarray, shape (N,)
        lambda of one traversal.
    inverse : ndarray of bool, shape (N,)
        Whether the eigenvalues of M are negative: an odd number of straight bounces.

    Raises
    ------
    ValueError
        If the arrays differ in length, a period or size is below 1, or a length or lambda is not a
        positive number (the row is not an orbit).
    """

    period: Integers
    size: Integers
    length: Floats
    lyapunov: Floats
    inverse: NDArray[np.bool_]

    def __post_init__(self) -> None:
        columns = (self.period, self.size, self.length, self.lyapunov, self.inverse)
        if len({column.shape for column in columns}) != 1 or self.period.ndim != 1:
            raise ValueError("the columns of class rows must be vectors of one length")
        if not all((column > 0).all() and np.isfinite(column).all() for column in columns[:4]):
            raise ValueError("class rows need a positive period, size, length and lambda: orbits only")

    def __len__(self) -> int:
        return len(self.period)

    def ranges(self) -> Floats:
        """Return the least and the greatest lambda / p, lambda / L and L / p, shape (2, 3).

        They are inf and -inf of no orbit.
        """
        per_bounce, per_length = self.lyapunov / self.period, self.lyapunov / self.length
        values = np.stack([per_bounce, per_length, self.length / self.period])
        return np.stack([values.min(axis=1, initial=np.inf), values.max(axis=1, initial=-np.inf)])

    def by_period(self) -> dict[int, "ClassRows"]:
        """Return the rows of each period that has any."""
        order = np.argsort(self.period, kind="stable")
        periods, starts = np.unique(self.period[order], return_index=True)
        parts = np.split(order, starts)[1:]
        return {int(p): self.rows(part) for p, part in zip(periods, parts, strict=True)}


def divisors(p: int) -> list[int]:
    """Return the divisors of p from 1 to p."""
    return [d for d in range(1, p + 1) if p % d == 0]


def missing_divisors(p: int, filled: Iterable[int]) -> list[int]:
    """Return the periods that a sum over the fixed points of order p needs and that are not filled.

    Period 1 is never needed: no orbit of a stadium has it.
    """
    have = set(filled)
    return [d for d in divisors(p) if d > 1 and d not in have]


def missing_periods(p: int, filled: Iterable[int]) -> list[int]:
    """Return the periods that a zeta function of order p needs and that are not filled."""
    have = set(filled)
    return [d for d in range(2, p + 1) if d not in have]


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
