"""Zeta functions: cycle expansions, their leading zero, and the averages that follow from it.

If each cycle c has the weight t_c e^(beta A_c) z^(p_c), the zeta function is given by

    1/zeta(z, beta) = prod over c (1 - t_c e^(beta A_c) z^(p_c)).

This is a power series in z. It is truncated by order (here) or by the stability of its terms
(`orbitdb.averages.pseudocycles`). Its leading zero z0 is the inverse of the growth factor per bounce, and the
derivative of z0 with respect to beta gives the average of A.

Source: Artuso, Aurell and Cvitanovic, Nonlinearity 3 (1990) 325.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Expansion:
    """The truncated power series of 1/zeta in z."""

    coefficients: Floats  # coefficients of z^0 .. z^n at beta = 0, the first of which is 1, shape (n + 1,)
    slopes: Floats  # their derivatives with respect to the beta of each of k observables, shape (k, n + 1)

    def cut(self, order: int) -> "Expansion":
        """Return the series truncated after z^order."""
        return Expansion(self.coefficients[: order + 1], self.slopes[:, : order + 1])


def expand(traces: Floats, slopes: Floats) -> Expansion:
    """Return the power series of 1/zeta, given the traces.

    Parameters
    ----------
    traces : ndarray, shape (n,)
        T_1 .. T_n, where T_j is the sum of the weights over all fixed points of order j, so that
        ln zeta = sum T_j z^j / j.
    slopes : ndarray, shape (k, n)
        Derivatives of the traces with respect to the exponents beta of k observables. They are the same sums,
        with each weight multiplied by the observable.

    Notes
    -----
    The coefficients follow from Newton's identities, j c_j = -sum_i T_i c_(j-i), and their slopes from the
    derivatives of these, so no products of cycles are formed. If T_j is the trace of the j-th power of an
    operator, the result is its Fredholm determinant.
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
    """Return the least positive zero of a polynomial, or NaN if it has none.

    The coefficients, shape (n + 1,), are in ascending order of the power.
    """
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
    """Return why a truncated series, shape (n + 1,), has no usable leading zero; empty if it has one.

    The first term of the series is 1. If the last term is larger at the zero, the series does not converge
    there, and the zero is an artefact of the truncation.
    """
    if math.isnan(zero):
        return "(it has no positive zero)"
    last = np.flatnonzero(coefficients)[-1]
    end = float(abs(coefficients[last])) * zero ** float(last)
    if end > 1 + _ROUNDING:
        return f"(its zero {zero:.4g} is spurious: the first term there is 1, but the last is {end:.3g})"
    return ""


def cycle_averages(expansion: Expansion) -> tuple[float, float, Floats]:
    """Return the leading zero z0, the mean period <p> and <A> of each observable, shape (k,).

    All are NaN if there is no leading zero. In a closed system, whose weights conserve probability, z0 is 1.
    At z0, <p> = -z d/dz (1/zeta) and <A> = -d/dbeta (1/zeta) (Artuso et al.). The average of A per bounce is
    <A> / <p>.
    """
    z0 = leading_zero(expansion.coefficients)
    orders = np.arange(len(expansion.coefficients))
    powers = z0**orders
    return z0, -float((orders * expansion.coefficients) @ powers), -(expansion.slopes @ powers)


@dataclass(frozen=True)
class ZetaAverages:
    """Averages at the leading zero of a zeta function; all are NaN if it has no usable zero."""

    z0: float  # the leading zero; with all orbits of a closed system, it is 1
    lambda_d: float  # <lambda>/<p>
    lambda_c: float  # <lambda>/<L>
    mean_path: float  # <L>/<p>
    fault: str = ""  # why the averages are NaN; empty if they are numbers or if there are no orbits

    @classmethod
    def none(cls, fault: str = "") -> "ZetaAverages":
        """Return averages that are all NaN, with the reason given in `fault`."""
        return cls(math.nan, math.nan, math.nan, math.nan, fault)

    @classmethod
    def within(cls, expansion: Expansion, ranges: Floats) -> "ZetaAverages":
        """Return the ratios of cycle averages of lambda and L, if they are within `OrbitClasses.ranges`.

        Notes
        -----
        An average over orbits lies between the least and the greatest value that an orbit has. The terms of a
        truncated zeta function have both signs, so a zero that is an artefact of the truncation can give any
        average. All averages are rejected if one is out of range or the series does not converge at the zero.
        """
        z0, period, observables = cycle_averages(expansion)
        if not np.isfinite(ranges).all():
            return cls.none()
        exponent, length = observables.tolist()
        period = period or math.nan  # it is 0 at a double zero
        values = exponent / period, exponent / (length or math.nan), length / period
        fault = zero_fault(expansion.coefficients, z0) or _range_fault(z0, values, ranges)
        return cls.none(fault) if fault else cls(z0, *values)


def _range_fault(z0: float, values: Sequence[float], ranges: Floats) -> str:
    """Return a text that names the first average outside the range of the orbits; empty if all are inside."""
    names = ("lambda_d", "lambda_c", "mean path")
    for name, value, low, high in zip(names, values, *ranges, strict=True):
        if not low * (1 - _ROUNDING) <= value <= high * (1 + _ROUNDING):
            return f"(its zero {z0:.4g} is spurious: {name} = {value:.4g} is outside {low:.4g} to {high:.4g})"
    return ""
