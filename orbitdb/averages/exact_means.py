"""Exact means per leg over the invariant measure, and the bounds on lambda that follow without any orbits.

In this module, a leg includes the run before it: a run of k bounces on a semicircle, then the n straight
bounces up to the next run. Over a leg with drift D and kick K (`orbitdb.billiard.stability`), a beam grows by

    lambda = ln D + ln K + ln(1 + (1/D + 1/(D' + 1/(K' + ...)))/K),

where D' and K' belong to the previous leg, and so on. The means of the first two terms over the invariant
measure are sums of elementary integrals, because the measure is uniform on the lines between two circles of
radius 1: every offset and every direction has the same weight.

Unfold the stadium at its walls. A line from one semicircle to the n-th copy of the other, at height 2 n,
rises by h = 2 n + u over the distance 2 a. Its direction is alpha = arctan(h / 2a), and its drift is
D = (4 a^2 + 2 n h) / R, where R = sqrt(4 a^2 + h^2). At each slope, a fraction (2 - |u|) / 2 of the lines
meets both circles in order.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.averages.mean_coupling import Mean, mean_coupling

_LEGS = 300
_LEGS_PER_A = 20
_MOST_LEGS = 4000
_COARSE, _FINE = 10, 14
"""Number of nodes per panel in two quadratures, whose difference estimates the error."""


LOG_KICK = Mean(1.1985591860593168, 1.0063987387440932e-13)
"""The mean of ln K for every a, where K = 2 k / sin(t) is the kick of a run of k bounces at the angle t.

The density of t is t sin t, and the integral of t sin t ln(2 / sin t) up to pi/2 is ln 2 + 2 - 2 C, where C
is Catalan's constant. The remainder is sum P_k ln k, where P_k = -[S_(k+1) - 2 S_k + S_(k-1)] / 2 is the
probability of k bounces in a run, S_k = 2 k sin(pi / 2k) and S_0 = 0. It was computed from 2000 terms and an
integral for the tail.
"""


def log_drift(a: float) -> Mean:
    """Return the mean of ln D at half length a.

    D is the length of a leg between the points at which its line is closest to the two circle centres.

    Notes
    -----
    ln D = ln R + ln(1 - h u / R^2). At every slope, the fractions of lines to all copies of the other circle
    add up to the same number, so the mean of ln R needs no sum over copies. It is half the integral of
    cos(alpha) ln(2 a / cos(alpha)), which is 1 + ln a. The mean of the second term is a sum over n whose
    terms decrease like a^2 / n^5; the tail of the sum is replaced by its leading term.
    """
    last = min(_LEGS + math.ceil(_LEGS_PER_A * a), _MOST_LEGS)
    coarse, fine = (_near_legs(a, nodes) + _far_legs(a, last, nodes) for nodes in (_COARSE, _FINE))
    tail = _last_legs(a, 2 * last + 1)
    return Mean(1 + math.log(a) + fine + tail, abs(fine - coarse) + 2 * abs(tail) / last + 1e-13)


def _near_legs(a: float, nodes: int) -> float:
    """Return the contribution of n = 0 and n = 1 to the mean of ln(1 - h u / R^2), integrated over alpha.

    At small a, the integrand varies only near alpha = 0 and pi/2, so the panels halve towards both of them.
    """
    turn, end = math.atan(1 / a), math.atan(2 / a)
    total = 0.0
    for n, low, high in ((0, 0.0, turn), (1, 0.0, turn), (1, turn, end)):
        alpha, weight = _graded(low, high, nodes)
        u = 2 * a * np.tan(alpha) - 2 * n
        share = weight * np.cos(alpha) * (2 - np.abs(u)) / 2
        h = 2 * a * np.tan(alpha)
        if n:  # 1 - h u / R^2 without cancellation
            total += float(share @ np.log((4 * a * a + 2 * h) * np.cos(alpha) ** 2 / (4 * a * a)))
        else:
            total += float(share @ (2 * np.log(np.cos(alpha))))
    return total


def _far_legs(a: float, last: int, nodes: int) -> float:
    """Return the contribution of n = 2 .. last to the same mean, integrated over u on both sides of 0."""
    x, weight = np.polynomial.legendre.leggauss(nodes)
    u = np.concatenate([x - 1, x + 1])[:, None]
    h = 2.0 * np.arange(2, last + 1) + u
    square = 4 * a * a + h * h
    terms = (2 - np.abs(u)) * 4 * a * a / square**1.5 * np.log1p(-h * u / square)
    return float(np.tile(weight, 2) @ terms.sum(axis=1)) / 2


def _last_legs(a: float, h: float) -> float:
    """Return the contribution of the legs that rise by more than h to the same mean, to leading order in 1/R.

    The mean of u over one copy is zero. To second order in u, a copy contributes
    (4/3) (4 a^2 / R^3) (4.5 h^2 / R^4 - 1 / R^2). The sum over n is replaced by half the integral over h, in
    closed form, where m = 1 - h / R.
    """
    r = math.hypot(2 * a, h)
    m = (2 * a / r) ** 2 / (1 + h / r)
    return (3.5 * m**2 - 21.5 / 3 * m**3 + 4.5 * m**4 - 0.9 * m**5) / (6 * a * a)


def _graded(low: float, high: float, nodes: int) -> tuple[Floats, Floats]:
    """Return Gauss-Legendre nodes and weights on panels that halve towards both ends."""
    inside = 0.5 ** np.arange(40, 0, -1)
    ends = low + (high - low) * np.concatenate([[0.0], inside, 1 - inside[-2::-1], [1.0]])
    x, weight = np.polynomial.legendre.leggauss(nodes)
    half = np.diff(ends)[:, None] / 2
    middle = (ends[1:] + ends[:-1])[:, None] / 2
    return (middle + half * x).ravel(), (half * weight).ravel()


@dataclass(frozen=True)
class ExactMeans:
    """Means over the invariant measure per leg, including the run before the leg."""

    a: float  # half length of the stadium
    log_drift: Mean  # mean of ln D
    log_kick: Mean  # mean of ln K
    coupling: Mean  # mean of c2 = ln(1 + (1/D_before + 1/D_after)/K)

    @property
    def terms(self) -> tuple[Mean, Mean, Mean]:
        """The three means."""
        return self.log_drift, self.log_kick, self.coupling

    @property
    def growth(self) -> Mean:
        """The mean of ln D + ln K + c2, which is slightly larger than lambda per leg."""
        return Mean(
            math.fsum(mean.value for mean in self.terms), math.fsum(mean.error for mean in self.terms)
        )

    @property
    def bounds(self) -> tuple[float, float]:
        """Lower and upper bounds on lambda per leg, widened by the errors of the means.

        A beam arrives at a run with a convergence between 0 and 1/D_before, so the last term of lambda is
        between 0 and c2.
        """
        low = self.log_drift.value + self.log_kick.value - self.log_drift.error - self.log_kick.error
        growth = self.growth
        return low, growth.value + growth.error


@lru_cache(maxsize=32)
def exact_means(a: float) -> ExactMeans:
    """Compute the exact means at half length a."""
    return ExactMeans(a, log_drift(a), LOG_KICK, mean_coupling(a))
