"""Zeta functions: cycle expansions, their leading zero, and the averages they give.

With a weight t_c e^(beta A_c) z^(p_c) for each of the cycles c,

    1/zeta(z, beta) = prod over c (1 - t_c e^(beta A_c) z^(p_c)),

a power series in z that is cut off at some order (here) or at some stability of its terms
(`orbitdb.averages.pseudocycles`). Its leading zero z0 is one over the growth rate, and what z0 changes
by with beta gives the average of A.

Source: Artuso, Aurell and Cvitanovic, Nonlinearity 3 (1990) 325.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Expansion(ByValue):
    """A truncated power series of 1/zeta in z.

    Attributes
    ----------
    coefficients : ndarray, shape (n + 1,)
        Of z^0 .. z^n at beta = 0; the first is 1.
    slopes : ndarray, shape (k, n + 1)
        Derivatives of the coefficients in the exponents beta of k observables.
    """

    coefficients: Floats
    slopes: Floats

    def cut(self, order: int) -> "Expansion":
        """Return the series up to z^order."""
        return Expansion(self.coefficients[: order + 1], self.slopes[:, : order + 1])


def expand(traces: Floats, slopes: Floats) -> Expansion:
    """Return 1/zeta from its traces.

    Parameters
    ----------
    traces : ndarray, shape (n,)
        T_1 .. T_n, the sums of the weights over all fixed points of each order; minus the logarithm
        of 1/zeta is sum T_j z^j / j.
    slopes : ndarray, shape (k, n)
        Derivatives of the traces in the exponents of k observables: the same sums, each weight times
        the observable.

    Notes
    -----
    Newton's identities, j c_j = -sum_i T_i c_(j-i), and their derivatives: no product of cycles is
    ever formed. With T_j = trace of the j-th power of an operator, this is its Fredholm determinant.
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
    """Return the least positive zero of a polynomial, shape (n + 1,), lowest power first; NaN if none."""
    last = np.flatnonzero(coefficients)
    polynomial = np.polynomial.Polynomial(coefficients[: last[-1] + 1])
    roots = polynomial.roots()
    positive = roots[(roots.imag == 0) & (roots.real > 0)].real
    if not len(positive):
        return float("nan")
    zero = float(positive.min())
    slope = polynomial.deriv()(zero)
    return float(zero - polynomial(zero) / slope) if slope else zero


def last_term(coefficients: Floats, zero: float) -> float:
    """Return the modulus of the last term of a truncated series, shape (n + 1,), at its zero.

    The first term is 1. A series that converges at its zero ends in less; where it ends in more, the
    zero is an artefact of the truncation.
    """
    last = np.flatnonzero(coefficients)[-1]
    return float(abs(coefficients[last])) * zero ** float(last)


@dataclass(frozen=True, eq=False)
class CycleAverages(ByValue):
    """What a zeta function says of the average cycle.

    Attributes
    ----------
    z0 : float
        The leading zero; 1 for a closed system with weights that conserve probability.
    period : float
        <p>, the mean period.
    observables : ndarray, shape (k,)
        <A> of each observable; <A> / <p> is its average per bounce.
    last_term : float
        Of the series at its zero (`last_term`).
    """

    z0: float
    period: float
    observables: Floats
    last_term: float


def cycle_averages(expansion: Expansion) -> CycleAverages:
    """Return the cycle averages at the leading zero; NaN where there is none.

    Notes
    -----
    <p> = -z d/dz (1/zeta) and <A> = -d/dbeta (1/zeta), both at z0 (Artuso et al.).
    """
    z0 = leading_zero(expansion.coefficients)
    if np.isnan(z0):
        return CycleAverages(z0, z0, np.full(len(expansion.slopes), z0), z0)
    orders = np.arange(len(expansion.coefficients))
    powers = z0**orders
    return CycleAverages(
        z0=z0,
        period=-float((orders * expansion.coefficients) @ powers),
        observables=-(expansion.slopes @ powers),
        last_term=last_term(expansion.coefficients, z0),
    )
