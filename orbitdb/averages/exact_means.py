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
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Marks

_LEGS = 300
_LEGS_PER_A = 20
_MOST_LEGS = 4000
_COARSE, _FINE = 10, 14
"""Number of nodes per panel in two quadratures, whose difference estimates the error."""


class Mean(NamedTuple):
    """A mean over the invariant measure, with a bound on its error that is estimated from the quadratures."""

    value: float
    error: float


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


_TOLERANCE = 1e-7
_LONGEST = 60
"""Number of bounces beyond which a run has no panels of its own."""

_COPIES = 60
"""Jumps at copies of the other circle farther away than about this number plus a are ignored: D is so long
there that they hardly matter."""

_ROUNDS = 16
"""Number of parts into which the tolerance is divided. Each round of halving leaves the panels with the
smallest changes as they are, up to a total change of one part."""

_NARROW = 0.25
"""Width of the narrowest initial panels, where the number of bounces changes, in units of a."""

_NARROWEST = 1e-5
"""Minimum width of an initial panel; a narrower panel would contribute less than the tolerance."""

_GROWTH = 1.25
"""Ratio of the widths of successive initial panels, with growing distance from the t where the number of
bounces changes. Panels as wide as this distance would miss a kink at their ends."""

_MOST_PANELS = 4000
_T_NODES, _PHI_NODES = 6, 8
_BATCH = 4096
_STEEPEST = math.pi / 2 - 1e-9
_ROUNDING = 1e-13
_CAUTION = 8


def mean_coupling(a: float, tolerance: float = _TOLERANCE) -> Mean:
    """Return the mean of c2 at half length a.

    c2 = ln(1 + (1/D_before + 1/D_after)/K) is the coupling of a run to the legs before and after it. The
    panels are halved until their last halvings change the total by at most the tolerance. The returned error
    is eight times the sum of the absolute changes, because a change near a kink can be small by chance.

    Notes
    -----
    A run is determined by the angle t in (0, pi/2) between path and wall and by the position phi in (0, 1) of
    its first bounce; the invariant measure is t sin(t) dt dphi. With x = pi/2t, the run has k = floor(x -
    phi) + 1 bounces. The path arrives along a line of direction t (2 phi - 1), at the distance cos(t) from
    the centre. The reversed run, turned upside down, has its first bounce at phi' = x - phi + 1 - k. If
    g(phi) is 1/D_before,

        c2 = ln(1 + (g(phi) + g(phi')) sin(t) / 2k).

    The function g jumps where the line goes through a joint between copies q and q + 1 of the other circle,
    at

        t (2 phi - 1) = arccos(cos(t) / R) - arctan2(2a, -2q - 1),     R = sqrt(4 a^2 + (2q + 1)^2),

    so the integral over phi is taken piece by piece between the jumps of g(phi), g(phi') and k. The result is
    a function of t with kinks where two jumps meet; the panels of t are halved until they resolve it. At
    small a, all kinks are within about a of some t = pi/2k, where the number of bounces changes. The nodes of
    a wide panel would miss them, so the initial panels there are narrower than a. Because D can be as small
    as a, the pieces of phi shrink towards the directions in which D is so small.
    """
    ends = _first_ends(a)
    low, high = ends[:-1], ends[1:]
    whole = _integrals(a, low, high)
    settled = unsettled = 0.0
    while True:
        middle = (low + high) / 2
        left, right = _integrals(a, low, middle), _integrals(a, middle, high)
        halves = left + right
        change = np.abs(halves - whole)
        going = _largest(change, tolerance / _ROUNDS)
        if not going.any() or 2 * going.sum() > _MOST_PANELS:
            return Mean(
                settled + float(halves.sum()), _CAUTION * (unsettled + float(change.sum())) + _ROUNDING
            )
        settled += float(halves[~going].sum())
        unsettled += float(change[~going].sum())
        low, high = np.concatenate([low[going], middle[going]]), np.concatenate([middle[going], high[going]])
        whole = np.concatenate([left[going], right[going]])


def _first_ends(a: float) -> Floats:
    """Return the ends of the initial panels of t, which shrink to a fraction of a towards every t = pi/2k."""
    places = np.concatenate([[0.0], np.pi / (2 * np.arange(_LONGEST + 1, 0, -1.0))])
    found, least = [places], max(_NARROW * a, _NARROWEST)
    for low, high in zip(places[:-1].tolist(), places[1:].tolist(), strict=True):
        half = (high - low) / 2
        count = math.ceil(math.log(max(half / least, 1.0)) / math.log(_GROWTH))
        steps = half / _GROWTH ** np.arange(count + 1.0)
        found += [low + steps, high - steps]
    return np.unique(np.concatenate(found))


def _largest(change: Floats, rest: float) -> Marks:
    """Return which panels to halve: all but those with the smallest changes, which sum to at most `rest`."""
    order = np.argsort(change)
    going = np.ones(len(change), dtype=bool)
    going[order[np.cumsum(change[order]) <= rest]] = False
    return going


def _integrals(a: float, low: Floats, high: Floats) -> Floats:
    """Return the integral of t sin(t) c2 over each panel of t and over all phi, shape (N,)."""
    x, weight = np.polynomial.legendre.leggauss(_T_NODES)
    half = (high - low) / 2
    t = ((high + low) / 2)[:, None] + half[:, None] * x
    order = np.argsort(t, axis=None)
    values = np.empty(t.size)
    for rows in np.array_split(order, math.ceil(t.size / _BATCH)):
        values[rows] = _over_phi(a, t.ravel()[rows])
    return half * ((values.reshape(t.shape) * t * np.sin(t)) @ weight)


def _over_phi(a: float, t: Floats) -> Floats:
    """Return the integral of c2 over phi at each angle t, taken piece by piece between the jumps, shape (N,).

    c2 has the same value at phi and phi', and phi + phi' = x modulo 1, so half of the range of phi is enough.
    """
    turns = np.pi / (2 * t)[:, None]
    rest, jumps = turns % 1, np.concatenate([_jumps(a, t), _near_zeros(a, t)], axis=1)
    middles = [rest / 2, (1 + rest) / 2]
    ends = np.concatenate([0 * rest, jumps, (turns - jumps) % 1, rest, *middles, 0 * rest + 1], axis=1)
    ends.sort()
    centre = (ends[:, 1:] + ends[:, :-1]) / 2
    chosen = (centre < middles[0]) | ((centre > rest) & (centre < middles[1]))
    width = 2 * np.diff(ends, axis=1)
    row, place = np.nonzero(chosen & (width > 0))
    x, weight = np.polynomial.legendre.leggauss(_PHI_NODES)
    half = width[row, place][:, None] / 2
    phi = ends[row, place][:, None] + half / 2 * (1 + x)
    turns, angle = turns[row], t[row][:, None]
    bounces = np.floor(turns - phi) + 1
    before, after = _inverse_drift(a, angle, phi), _inverse_drift(a, angle, turns - phi + 1 - bounces)
    c2 = np.log1p((before + after) * np.sin(angle) / (2 * bounces))
    integral: Floats = np.bincount(row, (half * c2) @ weight, minlength=len(t)).astype(np.float64)
    return integral


def _jumps(a: float, t: Floats) -> Floats:
    """Return the positions phi at which g jumps for each angle t, clipped to [0, 1], shape (N, copies)."""
    most = math.ceil(1 + min(a * math.tan(min(t.max(), _STEEPEST)), _COPIES + min(a, _COPIES)))
    odd = 2.0 * np.arange(-most - 1, most + 1) + 1
    r = np.sqrt(4 * a * a + odd * odd)
    direction = np.arccos(np.cos(t)[:, None] / r) - np.arctan2(2 * a, -odd)
    return np.clip((direction / t[:, None] + 1) / 2, 0, 1)


def _near_zeros(a: float, t: Floats) -> Floats:
    """Return positions phi between which ln D is smooth even at small a, clipped to [0, 1], shape (N, M).

    D would vanish in the direction pi/2 (for legs without walls) or about -a (with one wall), and the
    directions of legs come within about a of these. So the pieces halve towards 0 and pi/2 until they are
    about a long.
    """
    near = _halves(a)
    direction = np.concatenate([near, math.pi / 2 - near])
    return np.clip((np.concatenate([direction, -direction]) / t[:, None] + 1) / 2, 0, 1)


def _halves(a: float) -> Floats:
    """Return 1/2, 1/4, .. down to about a/4; empty if a >= 1."""
    halves: Floats = np.exp2(-np.arange(1.0, math.ceil(math.log2(1 / a)) + 3 if a < 1 else 0.0))
    return halves


def _inverse_drift(a: float, t: Floats, phi: Floats) -> Floats:
    """Return 1/D of the leg before each run, given the angle t and the position phi of the first bounce."""
    direction = t * (2 * phi - 1)
    along, across = np.cos(direction), np.sin(direction)
    copy = np.rint(-(np.cos(t) + 2 * a * across) / (2 * along))
    return 1 / (2 * a * along - 2 * copy * across)
