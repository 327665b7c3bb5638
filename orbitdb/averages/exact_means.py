"""Exact means over the invariant measure, leg by leg, and the bounds on lambda that follow without any orbit.

A leg here is one run of k bounces on a semicircle and the n straight bounces up to the next run. With
its drift D and its kick K (`orbitdb.billiard.stability`), a beam grows over it by

    lambda = ln D + ln K + ln(1 + (1/D + 1/(D' + 1/(K' + ...)))/K),

where D' and K' belong to the leg before, and so on. The means of the first two terms over the invariant
measure are sums of elementary integrals, because the measure is uniform on the lines between two circles of
radius 1: every offset and direction has the same weight.

The lines from a semicircle to copy n of the other one, at height 2 n, rise by h = 2 n + u over the distance
2 a. At each slope, a share (2 - |u|) meets both circles in order. The direction is alpha = arctan(h / 2a),
R = sqrt(4 a^2 + h^2), and D = (4 a^2 + 2 n h) / R.
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
"""Nodes per panel of the two quadratures; their difference estimates the error."""


LOG_KICK = Mean(1.1985591860593168, 1.0063987387440932e-13)
"""The mean of ln K for every a, where K = 2 k / sin(t) is the kick of a run of k bounces at the angle t.

The density of t is t sin t, and the integral of t sin t ln(2 / sin t) up to pi/2 is ln 2 + 2 - 2 C with
Catalan's constant C. The rest is sum P_k ln k, where P_k = -[S_(k+1) - 2 S_k + S_(k-1)] / 2 is the
probability of k bounces in a run, S_k = 2 k sin(pi / 2k) and S_0 = 0: 2000 terms, and an integral.
"""


def log_drift(a: float) -> Mean:
    """Return the mean of ln D at half length a, where D is the part of a leg beyond the feet of the centres.

    Notes
    -----
    ln D = ln R + ln(1 - h u / R^2). The shares of the copies of the other circle add up to the same number at
    every slope, so the mean of ln R needs no sum. It is half the integral of cos(alpha) ln(2 a / cos(alpha)),
    which is 1 + ln a. The rest is a sum over n that falls off like a^2 / n^5; the tail uses the leading term.
    """
    last = min(_LEGS + math.ceil(_LEGS_PER_A * a), _MOST_LEGS)
    coarse, fine = (_near_legs(a, nodes) + _far_legs(a, last, nodes) for nodes in (_COARSE, _FINE))
    tail = _last_legs(a, 2 * last + 1)
    return Mean(1 + math.log(a) + fine + tail, abs(fine - coarse) + 2 * abs(tail) / last + 1e-13)


def _near_legs(a: float, nodes: int) -> float:
    """Return the contribution of n = 0 and 1 to the mean of ln(1 - h u / R^2), integrated over alpha.

    At small a the integrand varies only near alpha = 0 and pi/2, so the panels halve towards both.
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
    """Return the contribution of n = 2 .. last, integrated over u on both sides of 0."""
    x, weight = np.polynomial.legendre.leggauss(nodes)
    u = np.concatenate([x - 1, x + 1])[:, None]
    h = 2.0 * np.arange(2, last + 1) + u
    square = 4 * a * a + h * h
    terms = (2 - np.abs(u)) * 4 * a * a / square**1.5 * np.log1p(-h * u / square)
    return float(np.tile(weight, 2) @ terms.sum(axis=1)) / 2


def _last_legs(a: float, h: float) -> float:
    """Return the contribution of the legs that rise by more than h, to leading order in 1/R.

    The mean of u over a copy is zero. To second order a leg contributes
    (4/3) (4 a^2 / R^3) (4.5 h^2 / R^4 - 1 / R^2). The sum over n is half the integral over h; h / R = 1 - m.
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
    """Means over the invariant measure for a leg with its run."""

    a: float  # half the length of a straight wall
    log_drift: Mean  # the mean of ln D
    log_kick: Mean  # the mean of ln K
    coupling: Mean  # the mean of c2 = ln(1 + (1/D_before + 1/D_after)/K)

    @property
    def terms(self) -> tuple[Mean, Mean, Mean]:
        """The three means."""
        return self.log_drift, self.log_kick, self.coupling

    @property
    def growth(self) -> Mean:
        """The mean of ln D + ln K + c2, slightly above lambda per leg."""
        return Mean(
            math.fsum(mean.value for mean in self.terms), math.fsum(mean.error for mean in self.terms)
        )

    @property
    def bounds(self) -> tuple[float, float]:
        """Lower and upper bounds on lambda per leg, widened by the errors.

        A beam arrives at a run with a convergence from 0 to 1/D_before, so its last term is from 0 to c2.
        """
        low = self.log_drift.value + self.log_kick.value - self.log_drift.error - self.log_kick.error
        growth = self.growth
        return low, growth.value + growth.error


@lru_cache(maxsize=32)
def exact_means(a: float) -> ExactMeans:
    """Return the exact means at half length a."""
    return ExactMeans(a, log_drift(a), LOG_KICK, mean_coupling(a))
