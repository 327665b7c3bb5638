"""Zeta functions: cycle expansions, their leading zero, and the averages they give.

With a weight t_c e^(beta A_c) z^(p_c) for each cycle c,

    1/zeta(z, beta) = prod over c (1 - t_c e^(beta A_c) z^(p_c)),

a power series in z that is truncated by order (here) or by the stability of its terms
(`orbitdb.averages.pseudocycles`). Its leading zero z0 is the inverse of the growth factor per bounce, and the
derivative of z0 in beta gives the average of A.

Source: Artuso, Aurell and Cvitanovic, Nonlinearity 3 (1990) 325.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.equality import ByValue

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Expansion(ByValue):
    """A truncated power series of 1/zeta in z."""

    coefficients: Floats  # of z^0 .. z^n at beta = 0; the first is 1, shape (n + 1,)
    slopes: Floats  # their derivatives in the exponents beta of k observables, shape (k, n + 1)

    def cut(self, order: int) -> "Expansion":
        """Return the series up to z^order."""
        return Expansion(self.coefficients[: order + 1], self.slopes[:, : order + 1])


def expand(traces: Floats, slopes: Floats) -> Expansion:
    """Return 1/zeta from its traces.

    Parameters
    ----------
    traces : ndarray, shape (n,)
        T_1 .. T_n, the sums of the weights over all fixed points of each order; ln zeta = sum T_j z^j / j.
    slopes : ndarray, shape (k, n)
        Derivatives of the traces in k exponents: the same sums with each weight times the observable.

    Notes
    -----
    Uses Newton's identities, j c_j = -sum_i T_i c_(j-i), and their derivatives, so no products of cycles are
    formed. If T_j is the trace of the j-th power of an operator, the result is its Fredholm determinant.
    """
    order = len(traces)
    c = np.zeros(order + 1)
    dc = np.zeros((len(slopes), order + 1))
    c[0] = 1.0
    for j in range(1, order + 1):
        back = slice(j - 1, None, -1)
        c[j] = -(traces[:j] @ c[back]) / j
        dc[:, j] = -(slopes[:, :j] @ c[back] + dc[:, back] @ traces[:j]) / j
    return Expansion(c, dc)


def leading_zero(coefficients: Floats) -> float:
    """Return the least positive zero of a polynomial, shape (n + 1,), lowest power first; NaN without one."""
    last = np.flatnonzero(coefficients)
    polynomial = np.polynomial.Polynomial(coefficients[: last[-1] + 1])
    roots = polynomial.roots()
    positive = roots[(roots.imag == 0) & (roots.real > 0)].real
    if not len(positive):
        return float("nan")
    zero = float(positive.min())
    slope = polynomial.deriv()(zero)
    return float(zero - polynomial(zero) / slope) if slope else zero


def zero_fault(coefficients: Floats, zero: float) -> str:
    """Say why a truncated series, shape (n + 1,), has no usable zero; empty if it has one.

    The first term is 1. If the last term at the zero is larger, the series does not converge there, and
    the zero is an artefact of the truncation.
    """
    if math.isnan(zero):
        return "(it has no real zero)"
    last = np.flatnonzero(coefficients)[-1]
    end = float(abs(coefficients[last])) * zero ** float(last)
    if end > 1 + _ROUNDING:
        return f"(its zero {zero:.4g} is spurious: the first term there is 1, but the last is {end:.3g})"
    return ""


def cycle_averages(expansion: Expansion) -> tuple[float, float, Floats]:
    """Return z0, <p> and <A> of each observable, shape (k,), at the leading zero; NaN without one.

    z0 is the leading zero; 1 for a closed system whose weights conserve probability. <p> is the mean period,
    and <A> / <p> the average per bounce. <p> = -z d/dz (1/zeta) and <A> = -d/dbeta (1/zeta), both at z0
    (Artuso et al.).
    """
    z0 = leading_zero(expansion.coefficients)
    orders = np.arange(len(expansion.coefficients))
    powers = z0**orders
    return z0, -float((orders * expansion.coefficients) @ powers), -(expansion.slopes @ powers)


@dataclass(frozen=True)
class ZetaAverages:
    """Averages at the leading zero of a zeta function; all are NaN if it has no usable zero."""

    z0: float  # the leading zero; 1 for all orbits of a closed system
    lambda_d: float  # <lambda>/<p>
    lambda_c: float  # <lambda>/<L>
    mean_path: float  # <L>/<p>
    fault: str = ""  # why they are NaN; empty if they are numbers or if there is no orbit

    @classmethod
    def none(cls, fault: str = "") -> "ZetaAverages":
        """Return NaN for every average."""
        return cls(math.nan, math.nan, math.nan, math.nan, fault)

    @classmethod
    def within(cls, expansion: Expansion, ranges: Floats) -> "ZetaAverages":
        """Take the ratios of cycle averages of lambda and L and check them against `ClassRows.ranges`.

        Notes
        -----
        An average over orbits is between the least and the greatest value of an orbit. The terms of a
        truncated zeta function have both signs, so a zero that is an artefact of the truncation can give any
        average. All averages are rejected if one is out of range or the series does not converge at the zero.
        """
        z0, period, observables = cycle_averages(expansion)
        if not np.isfinite(ranges).all():
            return cls.none()
        exponent, length = observables.tolist()
        period = period or math.nan  # 0 at a double zero
        values = exponent / period, exponent / (length or math.nan), length / period
        fault = zero_fault(expansion.coefficients, z0) or _range_fault(z0, values, ranges)
        return cls.none(fault) if fault else cls(z0, *values)


def _range_fault(z0: float, values: Sequence[float], ranges: Floats) -> str:
    """Name the first average at a zero that is out of the range of the orbits; empty if none is."""
    names = ("lambda_d", "lambda_c", "mean path")
    for name, value, low, high in zip(names, values, *ranges, strict=True):
        if not low * (1 - _ROUNDING) <= value <= high * (1 + _ROUNDING):
            return f"(its zero {z0:.4g} is spurious: {name} = {value:.4g} is outside {low:.4g} to {high:.4g})"
    return ""
