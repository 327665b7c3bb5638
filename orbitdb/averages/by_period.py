"""Entropy and Lyapunov averages over periodic orbits, computed from arrays.

The paper's averages are ratios of sums over fixed points. The same sums also give a zeta function and the
averages that follow from its leading zero.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers
from orbitdb.averages.fixed_points import PeriodSums, Weight, divisors, every_period, joined_ranges
from orbitdb.averages.zeta import ZetaAverages, expand, leading_zero, zero_fault
from orbitdb.equality import ByValue


@dataclass(frozen=True, eq=False)
class Entropy(ByValue):
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
class Lyapunov(ByValue):
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

    Source: Biham and Kvale, eqs. (5) and (6), with the weights `Weight.EXPONENTIAL`.
    """
    column, p = list(Weight).index(weight), np.arange(1, highest + 1)
    sums = np.zeros((4, highest))
    for order in p.tolist():  # an orbit of period d has d points
        parts = [d * periods[d].sums[order // d - 1, column] for d in divisors(order) if d in periods]
        sums[:, order - 1] = [math.fsum(terms) for terms in zip(*parts, strict=True)] or 0.0
    total = np.where(sums[0] > 0, sums[0], np.nan)
    discrete, continuous = sums[1] / total / p, sums[3] / total
    series = expand(sums[0], sums[1:3])
    found = [
        ZetaAverages.within(
            series.cut(order), joined_ranges(each.ranges for d, each in periods.items() if d <= order)
        )
        for order in p[1:].tolist()
    ]
    return Lyapunov(
        p=p[1:],
        lambda_d=discrete[1:],
        lambda_c=continuous[1:],
        lambda_d_pair=(discrete[:-1] + discrete[1:]) / 2,
        lambda_c_pair=(continuous[:-1] + continuous[1:]) / 2,
        lambda_d_zeta=np.array([one.lambda_d for one in found]),
        lambda_c_zeta=np.array([one.lambda_c for one in found]),
        mean_path_zeta=np.array([one.mean_path for one in found]),
        z0=np.array([one.z0 for one in found]),
        faults=tuple(one.fault for one in found),
    )


def standing(
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


def faults_of(found: Entropy | Lyapunov, filled: Iterable[int]) -> str:
    """Return a line that says at which orders, and why, the zeta function has no usable zero.

    The line is empty if the zeta function has a usable zero at each order.

    Orders p are only named if all periods up to p are filled.
    """
    have = set(filled)
    periods: dict[str, list[int]] = {}
    for p, fault in zip(found.p.tolist(), found.faults, strict=True):
        if fault and have >= every_period(p):
            periods.setdefault(fault, []).append(p)
    said = "; ".join(f"at p = {', '.join(map(str, orders))} {fault}" for fault, orders in periods.items())
    return said and f"the zeta function gives no average {said}"
