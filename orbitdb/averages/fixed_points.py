"""The fixed points of each order, from symmetry classes.

One row a class with its size is enough (`ClassRows`): no word and no coordinate is read, and nothing is
expanded to single words. The fixed points of order p are the points of all orbits whose period d divides
p: d points an orbit, and p/d repetitions, with which lambda and L grow.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import Columns

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


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
