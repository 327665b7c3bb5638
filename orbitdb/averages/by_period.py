"""Entropy and Lyapunov averages over periodic orbits: arrays in, numbers out.

The paper's averages are sums over fixed points; beside them stand those of the zeta function that the
same sums are the traces of.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.fixed_points import ClassRows, Weight, divisors
from orbitdb.averages.pseudocycles import Factors, expand_by_stability
from orbitdb.averages.zeta import CycleAverages, cycle_averages, expand, last_term, leading_zero
from orbitdb.equality import ByValue

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Entropy(ByValue):
    """Entropies by period; all arrays have the shape of p.

    Attributes
    ----------
    p : ndarray of int
        2, 3, .. to the highest period.
    N : ndarray of int
        Number of points on orbits of period p and its divisors.
    K_0 : ndarray
        ln N / p; NaN where there is no point.
    h_zeta : ndarray
        -ln of the leading zero of the topological zeta function cut off at order p.
    h_zeta_change : ndarray
        Modulus of its change from the order before. It is no error: h_zeta creeps, or turns, beyond it.
    faults : tuple of str
        Why h_zeta is NaN, of each period; empty where it is not, or where there is no orbit.
    """

    p: Integers
    N: Integers
    K_0: Floats
    h_zeta: Floats
    h_zeta_change: Floats
    faults: tuple[str, ...]


def entropy(rows: ClassRows, highest: int) -> Entropy:
    """Return the topological entropy at p = 2 .. highest.

    Notes
    -----
    N(p) = sum over d | p of d N_c(d) are the traces of the zeta function prod (1 - z^p)^N_c(p).
    Its zero, which weighs all periods up to p together, settles sooner than K_0.

    Source: Biham and Kvale, Table 1.
    """
    cycles = np.bincount(rows.period, rows.size, minlength=highest + 1)[: highest + 1]
    return entropy_of_counts(cycles.astype(np.int64))


def entropy_of_counts(cycles: Integers) -> Entropy:
    """Return the topological entropy, as `entropy` does, from numbers of orbits alone.

    Parameters
    ----------
    cycles : ndarray of int, shape (n + 1,)
        How many cyclic words of each period 0 .. n are orbits.
    """
    highest = len(cycles) - 1
    orders = range(1, highest + 1)
    points = np.array([sum(d * cycles[d] for d in divisors(p)) for p in orders], dtype=np.int64)
    series = expand(points.astype(float), np.zeros((0, highest)))
    truncated = [series.cut(p).coefficients for p in orders]
    zeros = [leading_zero(part) for part in truncated]
    faults = [_zero_fault(zero, last_term(part, zero)) for part, zero in zip(truncated, zeros, strict=True)]
    h = 0.0 - np.log([np.nan if fault else zero for fault, zero in zip(faults, zeros, strict=True)])
    faults = ["" if not points[:p].any() else fault for p, fault in enumerate(faults, 1)]
    change = np.abs(np.diff(h, prepend=np.nan))
    p = np.array(orders)
    k0 = np.log(np.where(points > 0, points, np.nan)) / p
    return Entropy(p[1:], points[1:], k0[1:], h[1:], change[1:], tuple(faults[1:]))


def _zero_fault(zero: float, end: float) -> str:
    """Tell why a zeta function has no zero that can be used, its last term there given; else empty."""
    if math.isnan(zero):
        return "(it has no real zero)"
    if end > 1 + _ROUNDING:
        return f"(its zero {zero:.4g} is spurious: the series ends there in {end:.3g}, having begun with 1)"
    return ""


@dataclass(frozen=True, eq=False)
class Lyapunov(ByValue):
    """Lyapunov averages by period; all arrays have the shape of p, and NaN where there is no orbit.

    Attributes
    ----------
    p : ndarray of int
        2, 3, .. to the highest period.
    lambda_d, lambda_c : ndarray
        The paper's averages over fixed points, per bounce and per length.
    lambda_d_pair, lambda_c_pair : ndarray
        Means of the values at p - 1 and p, which even out the paper's oscillation.
    lambda_d_zeta, lambda_c_zeta, mean_path_zeta : ndarray
        <lambda>/<p>, <lambda>/<L> and <L>/<p> from the zeta function cut off at order p.
    z0 : ndarray
        The leading zero of the zeta function; 1 for a closed system and all its orbits.
    faults : tuple of str
        Why the values of the zeta function are NaN (`ZetaAverages`), of each period.
    """

    p: Integers
    lambda_d: Floats
    lambda_c: Floats
    lambda_d_pair: Floats
    lambda_c_pair: Floats
    lambda_d_zeta: Floats
    lambda_c_zeta: Floats
    mean_path_zeta: Floats
    z0: Floats
    faults: tuple[str, ...]


def lyapunov_of_sums(sums: Floats, ranges: "Sequence[Ranges]") -> Lyapunov:
    """Return the Lyapunov averages from sums over fixed points.

    Parameters
    ----------
    sums : ndarray, shape (4, n)
        Of w, w lambda, w L and w lambda / L over all fixed points of the orders 1 to n, orbits of divisors
        repeated.
    ranges : sequence of Ranges
        Of all orbits up to p = 2, 3, .. n.

    Notes
    -----
    Source: Biham and Kvale, eqs. (5) and (6); the weights may be others than theirs.
    """
    p = np.arange(1, sums.shape[1] + 1)
    total = np.where(sums[0] > 0, sums[0], np.nan)
    discrete, continuous = sums[1] / total / p, sums[3] / total
    series = expand(sums[0], sums[1:3])
    found = [
        ZetaAverages.within(cycle_averages(series.cut(n)), each)
        for n, each in zip(p[1:].tolist(), ranges, strict=True)
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


@dataclass(frozen=True)
class Ranges:
    """Between what the averages of some orbits are: lambda / p, lambda / L and L / p, in this order.

    Attributes
    ----------
    least, greatest : tuple of float
        Empty if there is no orbit.
    """

    least: tuple[float, ...]
    greatest: tuple[float, ...]

    @classmethod
    def of(cls, rows: ClassRows) -> "Ranges":
        """Return those of some orbits."""
        if not len(rows):
            return cls((), ())
        values = rows.lyapunov / rows.period, rows.lyapunov / rows.length, rows.length / rows.period
        return cls(tuple(float(v.min()) for v in values), tuple(float(v.max()) for v in values))

    @classmethod
    def joined(cls, parts: "Iterable[Ranges]") -> "Ranges":
        """Return those of the orbits of all parts."""
        some = [part for part in parts if part.least]
        least = zip(*(part.least for part in some), strict=True)
        greatest = zip(*(part.greatest for part in some), strict=True)
        return cls(tuple(map(min, least)), tuple(map(max, greatest)))


@dataclass(frozen=True)
class ZetaAverages:
    """Averages at the leading zero of a zeta function; all are NaN where it has none that can be used.

    Attributes
    ----------
    z0 : float
        The leading zero; 1 for a closed system and all its orbits.
    lambda_d, lambda_c, mean_path : float
        <lambda>/<p>, <lambda>/<L> and <L>/<p>.
    fault : str
        Why they are NaN; empty where they are not, or where there is no orbit.
    """

    z0: float
    lambda_d: float
    lambda_c: float
    mean_path: float
    fault: str = ""

    @classmethod
    def none(cls, fault: str = "") -> "ZetaAverages":
        """Return no averages."""
        return cls(math.nan, math.nan, math.nan, math.nan, fault)

    @classmethod
    def within(cls, found: CycleAverages, ranges: Ranges) -> "ZetaAverages":
        """Take ratios of cycle averages of the observables lambda and L, given the ranges of the orbits.

        Notes
        -----
        No average over orbits is less than the least of them or more than the greatest. The terms of a
        truncated zeta function have both signs, and where its zero is an artefact of the truncation its
        averages may be anything: one outside that range shows it, and condemns the others. So does a
        series that does not converge at the zero (`orbitdb.averages.zeta.last_term`).
        """
        exponent, length = (float(value) for value in found.observables)
        period = found.period or math.nan  # 0 at a double zero
        values = (exponent / period, exponent / (length or math.nan), length / period)
        if not ranges.least:
            return cls.none()
        fault = _zero_fault(found.z0, found.last_term) or _range_fault(found.z0, values, ranges)
        if fault:
            return cls.none(fault)
        return cls(found.z0, *values)


def _range_fault(z0: float, values: tuple[float, float, float], ranges: Ranges) -> str:
    """Tell which average at a zero of the zeta function no orbits can have; empty if they can."""
    names = ("lambda_d", "lambda_c", "mean path")
    for name, value, low, high in zip(names, values, ranges.least, ranges.greatest, strict=True):
        if not low * (1 - _ROUNDING) <= value <= high * (1 + _ROUNDING):
            return f"(its zero {z0:.4g} is spurious: {name} = {value:.4g}, of orbits {low:.4g} to {high:.4g})"
    return ""


def lyapunov_by_stability(
    rows: ClassRows,
    cut: float,
    highest: int | None = None,
    weight: Weight = Weight.EXPONENTIAL,
    progress: Callable[[float], None] | None = None,
) -> ZetaAverages:
    """Return the Lyapunov averages with every pseudo-cycle of multiplier up to e^cut.

    Parameters
    ----------
    rows : ClassRows
        All orbits with lambda <= cut. Where longer ones are missing, the products of shorter ones
        that should cancel against them must go too: give the period up to which all are known.
    cut : float
        Largest sum of lambda over the orbits of a pseudo-cycle.
    highest : int, optional
        Largest sum of periods; by default any.
    weight : Weight, optional
        With `Weight.DETERMINANT`, an orbit has the factors (1 - t e^(-k lambda) z^p)^(k+1),
        k = 0, 1, .. with multipliers e^((k+1) lambda), all subject to the cut.
    progress : callable, optional
        Called now and then with the share that is done, as far as it can be guessed.
    """
    levels = 1
    if weight is Weight.DETERMINANT and len(rows):
        levels = max(1, int(cut / rows.lyapunov.min()))
    series = expand_by_stability(_factors(rows, levels, cut), cut, highest, progress)
    kept = rows.rows((rows.lyapunov <= cut) & (rows.period <= (highest or rows.period)))
    if not len(kept):
        return ZetaAverages.none(f"(no orbit has a lambda up to {cut:g})")
    return ZetaAverages.within(cycle_averages(series), Ranges.of(kept))


def largest_cut(rows: ClassRows, cut: float, most: int) -> float:
    """Return the cut, or a smaller one if the determinant has more than so many factors within it.

    The factors of a class are as many as its lambda goes into the cut. What is smaller has two digits.
    """

    def fits(value: float) -> bool:
        return float(np.floor(value / rows.lyapunov).sum()) <= most

    low, high = 0.0, cut
    if fits(high):
        return cut
    while high - low > 1e-3 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    unit = 10.0 ** (math.floor(math.log10(low)) - 1)
    return float(f"{math.floor(low / unit) * unit:.2g}")


def _factors(rows: ClassRows, levels: int, cut: float) -> Factors:
    """Return the factors of the zeta function (one level) or of the Fredholm determinant."""
    parts = [rows.rows((k + 1) * rows.lyapunov <= cut) for k in range(levels)]
    cost = [(k + 1) * part.lyapunov for k, part in enumerate(parts)]
    signs = [np.where(part.inverse & (k % 2 == 1), -1.0, 1.0) for k, part in enumerate(parts)]
    return Factors(
        period=np.concatenate([part.period for part in parts]),
        count=np.concatenate([(k + 1) * part.size for k, part in enumerate(parts)]),
        cost=np.concatenate(cost),
        weight=np.concatenate(signs) * np.exp(-np.concatenate(cost)),
        observables=np.concatenate([np.stack([part.lyapunov, part.length]) for part in parts], axis=1),
    )
