"""Entropy and Lyapunov averages by period: sums over the fixed points of each order, from symmetry classes.

One row per class, with the size of the class, is enough (`OrbitClasses`). The fixed points of order p are the
points of all orbits whose period d divides p. Such an orbit has d points, and its lambda and L are multiplied
by the number of repetitions, p/d.

Averages over fixed points and zeta functions truncated by period are built from sums over the orbits of each
period (`PeriodSums`). These sums can be computed in parts and joined in any order, because joining them
rounds only once (`math.fsum`). This gives averages for periods whose orbits are not stored. The paper's
averages are ratios of these sums; the zeta function gives averages that follow from its leading zero.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers
from orbitdb.averages.zeta import ZetaAverages, expand, leading_zero, zero_fault
from orbitdb.orbits.exponents import OrbitClasses


class Weight(StrEnum):
    """Weight of an orbit in an average."""

    EXPONENTIAL = "exp"
    """e^-lambda, as in the paper; the corresponding zeta function is the dynamical zeta function."""

    DETERMINANT = "det"
    """1/|det(1 - M^r)|, the exact weight; the corresponding zeta function is the Fredholm determinant."""


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
    """Return the ranges over all orbits, given the ranges of parts of them (`OrbitClasses.ranges`)."""
    every = np.array([NO_RANGES, *parts])
    return np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)])


def repetitions(p: int) -> int:
    """Return how many repetitions of an orbit of period p fit into the order `HIGHEST`; at least 1."""
    return max(HIGHEST // p, 1)


@dataclass(frozen=True, eq=False)
class PeriodSums:
    """Sums over the orbits of period p, or over some of these orbits."""

    p: int
    # Sums over all cyclic words of w, w lambda, w L and w lambda / L for 1, 2, .. r repetitions and for each
    # `Weight`, where the weight w, lambda and L are those of the repeated orbit; shape (r, 2, 4)
    sums: Floats
    ranges: Floats  # the ranges over these orbits (`OrbitClasses.ranges`), shape (2, 3)

    @classmethod
    def of(cls, rows: OrbitClasses, p: int) -> "PeriodSums":
        """Sum over classes, all of which must have period p."""
        sums = np.zeros((repetitions(p), len(Weight), _COLUMNS))
        for r, of_weights in enumerate(sums, 1):
            lyapunov, length = r * rows.lyapunov, r * rows.length
            plain = rows.words * np.exp(-lyapunov)
            # |det(1 - M)| e^-lambda = (1 -+ e^-lambda)^2, with + if the eigenvalues are negative
            negative = rows.negative & (r % 2 == 1)
            factor = np.where(negative, 1 + np.exp(-lyapunov), -np.expm1(-lyapunov)) ** 2
            for of_weight, w in zip(of_weights, (plain, plain / factor), strict=True):
                terms = w, w * lyapunov, w * length, w * (lyapunov / length)
                of_weight[:] = [term.sum() for term in terms]
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


@dataclass(frozen=True, eq=False)
class Entropy:
    """Entropies by period; all arrays have the same shape as p."""

    p: Integers  # 2, 3, .. up to the highest period
    N: Integers  # number of points on the orbits whose period is p or a divisor of p
    K_0: Floats  # ln N / p; NaN if N is 0
    h_zeta: Floats  # -ln of the leading zero of the topological zeta function truncated at order p
    # Absolute change of h_zeta from order p - 1. This is not an error estimate: the changes at higher orders
    # can add up to more.
    h_zeta_change: Floats
    # for each period, why h_zeta is NaN; empty if h_zeta is a number or if there are no orbits
    faults: tuple[str, ...]


def entropy_of_counts(cycles: Integers) -> Entropy:
    """Return estimates of the topological entropy at p = 2 .. n.

    `cycles`, shape (n + 1,), contains the number N_c(p) of cyclic words that are orbits for each period
    p = 0 .. n. The number of fixed points, N(p) = sum over d | p of d N_c(d), is the p-th trace of the
    topological zeta function, 1/zeta = prod (1 - z^p)^N_c(p). Its leading zero combines all periods up to p
    and converges faster than K_0.

    Source: Biham and Kvale, Table 1.
    """
    highest = len(cycles) - 1
    orders = range(1, highest + 1)
    points = np.array([sum(d * cycles[d] for d in divisors(p)) for p in orders], dtype=np.int64)
    series = expand(points.astype(float), np.zeros((0, highest)))
    truncated = [series.cut(p).coefficients for p in orders]
    zeros = [leading_zero(part) for part in truncated]
    faults = [zero_fault(part, zero) for part, zero in zip(truncated, zeros, strict=True)]
    h = 0.0 - np.log([np.nan if fault else zero for fault, zero in zip(faults, zeros, strict=True)])
    faults = ["" if not points[:p].any() else fault for p, fault in enumerate(faults, 1)]
    change = np.abs(np.diff(h, prepend=np.nan))
    p = np.array(orders)
    k0 = np.log(np.where(points > 0, points, np.nan)) / p
    return Entropy(p[1:], points[1:], k0[1:], h[1:], change[1:], tuple(faults[1:]))


@dataclass(frozen=True, eq=False)
class Lyapunov:
    """Lyapunov averages by period; all arrays have the same shape as p, with NaN where there is no orbit."""

    p: Integers  # 2, 3, .. up to the highest period
    # the paper's averages over fixed points, per bounce and per unit length
    lambda_d: Floats
    lambda_c: Floats
    # means of the averages at p - 1 and p, which smooth out their oscillation with p
    lambda_d_pair: Floats
    lambda_c_pair: Floats
    # <lambda>/<p>, <lambda>/<L> and <L>/<p> from the zeta function truncated at order p
    lambda_d_zeta: Floats
    lambda_c_zeta: Floats
    mean_path_zeta: Floats
    z0: Floats  # leading zero of the zeta function; with all orbits of a closed system, it is 1
    faults: tuple[str, ...]  # for each period, why the zeta averages are NaN (`ZetaAverages.fault`)


def lyapunov_of_periods(
    periods: Mapping[int, PeriodSums], highest: int, weight: Weight = Weight.EXPONENTIAL
) -> Lyapunov:
    """Return the Lyapunov averages at p = 2 .. `highest`, which must not exceed `HIGHEST`.

    A period that is not in `periods` counts as having no orbits.

    Source: Biham and Kvale, eqs. (6) and (7), with the weights `Weight.EXPONENTIAL`.
    """
    column, p = list(Weight).index(weight), np.arange(1, highest + 1)
    sums = np.zeros((4, highest))
    for order in p.tolist():  # an orbit of period d has d points
        parts = [d * periods[d].sums[order // d - 1, column] for d in divisors(order) if d in periods]
        sums[:, order - 1] = [math.fsum(terms) for terms in zip(*parts, strict=True)] or 0.0
    total = np.where(sums[0] > 0, sums[0], np.nan)
    discrete, continuous = sums[1] / total / p, sums[3] / total
    series = expand(sums[0], sums[1:3])
    averages = [
        ZetaAverages.within(
            series.cut(order), joined_ranges(part.ranges for d, part in periods.items() if d <= order)
        )
        for order in p[1:].tolist()
    ]
    return Lyapunov(
        p=p[1:],
        lambda_d=discrete[1:],
        lambda_c=continuous[1:],
        lambda_d_pair=(discrete[:-1] + discrete[1:]) / 2,
        lambda_c_pair=(continuous[:-1] + continuous[1:]) / 2,
        lambda_d_zeta=np.array([average.lambda_d for average in averages]),
        lambda_c_zeta=np.array([average.lambda_c for average in averages]),
        mean_path_zeta=np.array([average.mean_path for average in averages]),
        z0=np.array([average.z0 for average in averages]),
        faults=tuple(average.fault for average in averages),
    )


def none_where_incomplete(
    p: Integers, columns: Mapping[str, NDArray[Any]], needs: Callable[[int], set[int]], filled: Iterable[int]
) -> dict[str, list[Any]]:
    """Return averages by period as lists, with None where the average is NaN or a period it needs is missing.

    The periods `p` and the columns have shape (n,). `needs` returns the periods that an average of order p
    needs. A period is missing if it is not in `filled`, the periods whose chosen orbits have all been
    included.
    """
    have = set(filled)
    stands = [have >= needs(order) for order in p.tolist()]
    return {
        name: [value if known and value == value else None
               for value, known in zip(values.tolist(), stands, strict=True)]
        for name, values in columns.items()
    }  # fmt: skip


def faults_of(averages: Entropy | Lyapunov, filled: Iterable[int], shown: Iterable[int] | None = None) -> str:
    """Return a line that says at which orders, and why, the zeta function has no usable zero.

    The line is empty if the zeta function has a usable zero at each order. Only `shown` orders (by
    default, all) are named, and only if all periods up to the order are filled.
    """
    have = set(filled)
    periods: dict[str, list[int]] = {}
    named = have if shown is None else set(shown)
    for p, fault in zip(averages.p.tolist(), averages.faults, strict=True):
        if fault and p in named and have >= every_period(p):
            periods.setdefault(fault, []).append(p)
    said = "; ".join(f"at p = {', '.join(map(str, orders))} {fault}" for fault, orders in periods.items())
    none = "there is no h_zeta" if isinstance(averages, Entropy) else "the zeta function gives no average"
    return said and f"{none} {said}"
