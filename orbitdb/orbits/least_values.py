"""Lower bounds on the length and lambda of all orbits with more than a given number of bounces.

A catalogue of all orbits of up to p bounces therefore contains every orbit below these bounds. Both bounds
follow from the runs of k bounces and the legs of n straight bounces (docs/proof.md): a word of m legs, where
m is even, has k_1 + n_1 + ... + k_m + n_m bounces.
"""

import math

import numpy as np

from orbitdb.arrays import Floats

_ROUNDING = 1e-12
_LEAST_TRIED = 4
"""Least number of straight bounces of two legs that are tried."""
_SHARES = np.linspace(0, 1, 33)
"""Shares of the angles of the lines between centres at which a length is computed."""


def least_length(p: int, a: float) -> float:
    """Return a length that every orbit of more than p bounces exceeds, in units of the radius.

    Notes
    -----
    The length of an orbit is the maximum of L over the box of directions, so L is a lower bound at every
    point of the box. Let theta be the angle between a leg and the x axis, from 0 to pi/2. The smallest value
    over all signs is

        L >= sum of 2 (a cos theta + n sin theta) + sum of 2k sin(psi / 2k),  psi = pi - theta - theta'

    where theta and theta' belong to the legs beside the run. The terms of runs increase with k. If all legs
    are parallel to the lines between centres, at the angles atan(n / a), a leg adds 2 r, where
    r = sqrt(a^2 + n^2). For four or more legs, cos((theta + theta') / 2), which is half of what a single
    bounce adds, is at least the mean of cos theta and cos theta'. Each leg thus adds 2 (r + a / r) or more,
    whatever p is. Its derivative in n, 2 (n / r) (1 - a / r^2), is not negative from n = 1 on, because
    a^2 + 1 > a.

    For two legs of n and m straight bounces, the minimum is found by trying all n + m up to p, or 4. The
    pairs with the largest n + m are tried along the lines between centres only. No pair with more is shorter:
    both of its runs are single bounces, which add 4 cos((theta + theta') / 2) together, so the derivative in
    n is at least 2 (n r - a) / r^2, which is positive from n = 1 on. The other pairs are also tried with
    flatter legs, and the largest of these bounds counts.
    """
    four = min(8 * (math.hypot(a, n) + a / math.hypot(a, n)) for n in (0, 1))
    most = max(p, _LEAST_TRIED)
    two = min(
        _two_legs(a, n, m, max(p + 1 - n - m, 2), _SHARES if n + m < most else _SHARES[-1:])
        for n in range(most + 1)
        for m in range(min(n, most - n) + 1)
    )
    return min(four, two) * (1 - _ROUNDING)


def largest_least_length(a: float) -> float:
    """Return the limit of `least_length` as p grows, 4a + 2 + pi, in units of the radius.

    Notes
    -----
    It is the bound for two horizontal legs without straight bounces, a run of one bounce and a run that has
    become an arc. No bound is larger, because this pair is always tried.
    """
    return 4 * a + 2 + math.pi


def least_limit_of_lengths(a: float) -> float:
    """Return the perimeter 4a + 2 pi, in units of the radius: infinitely many orbits are shorter.

    Notes
    -----
    For every a, the words of k bounces up one semicircle and k down the other are orbits: the path crosses
    the stadium horizontally at the heights cos(pi / 2k) and -cos(pi / 2k). Its length 4a + 4k sin(pi / 2k)
    increases with k to the perimeter.
    """
    return 4 * a + 2 * math.pi


def _two_legs(a: float, n: int, m: int, bounces: int, shares: Floats) -> float:
    """Return a bound on the length of two legs of n and m straight bounces, with two runs.

    The angles of the legs are the given shares of those of the lines between centres, or the least angles in
    the box of directions if these are larger. The runs have `bounces` in total.
    """
    angles = [np.maximum(shares * math.atan2(q, a), math.atan2(q - 1, a + 1)) for q in (n, m)]
    legs = [2 * (a * np.cos(theta) + q * np.sin(theta)) for theta, q in zip(angles, (n, m), strict=True)]
    psi = (math.pi - angles[0] - angles[1])[:, None]
    k = np.arange(1, bounces)
    runs = 2 * k * np.sin(psi / (2 * k))
    return float(((legs[0] + legs[1])[:, None] + runs + runs[:, ::-1]).max(axis=0).min())


def least_exponent(p: int, a: float) -> float:
    """Return a lower bound on lambda of every orbit, or product of orbits, of more than p bounces.

    Notes
    -----
    Apart from its sign, M is the product of [[1, D], [K, 1 + K D]] over all legs, where K = 2k / sin(h) of
    the run and D of the leg are positive. Its trace, e^lambda + e^-lambda, is thus at least 1 plus the
    product of all 1 + K D, and lambda is at least the sum of ln(1 + K D). The same holds for the sum of
    lambda over several orbits that have more than p bounces together. In a run, (k - 1) h < pi/2, so K is at
    least 2k if k < 3, and otherwise at least 2k / sin(pi / 2(k - 1)). D is concave on the box, so it is least
    at an end of the range of its direction. Both bounds increase with k, and with n from n = 1 on.
    """
    best = [math.inf] * (p + 2)  # best[q]: least sum over one leg, later over several, of q or more bounces
    for k in range(1, p + 2):
        kick = 2 * k / math.sin(math.pi / max(2 * (k - 1), 2))
        for n in range(p + 2 - k):
            ends = [(1, a)] if n == 0 else [(n + 1, a), (n - 1, a + 1)]  # of the range of the direction
            drift = min((2 * a * dx + 2 * n * dy) / math.hypot(dx, dy) for dy, dx in ends)
            best[k + n] = min(best[k + n], math.log1p(kick * drift))
    for q in range(p, 0, -1):
        best[q] = min(best[q], best[q + 1])
    for q in range(2, p + 1):
        best[q] = min(best[q], _two_parts(best, q))
    return _two_parts(best, p + 1) * (1 - _ROUNDING)


def _two_parts(best: list[float], bounces: int) -> float:
    """Return the least sum for two parts of a word that share the given number of bounces."""
    return min(best[q] + best[bounces - q] for q in range(1, bounces))
