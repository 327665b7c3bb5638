"""Lower bounds on the length and lambda of all orbits with more than a given number of bounces.

A catalogue of all orbits of up to p bounces therefore contains every orbit below these bounds. Both bounds
follow from the runs of k bounces and the legs of n straight bounces (docs/proof.md): a word of m legs, where
m is even, has k_1 + n_1 + ... + k_m + n_m bounces.
"""

import math

import numpy as np

_ROUNDING = 1e-12


def least_length(p: int, a: float) -> float:
    """Return a length that every orbit of more than p bounces exceeds, in units of the radius.

    Notes
    -----
    The length of an orbit is the maximum of L over the box of directions. It is therefore at least L with all
    legs parallel to the lines between centres, at the angles theta_n = atan(n / a):

        L >= sum of 2 sqrt(a^2 + n^2) + sum of 2k sin(psi / 2k),  psi = pi - theta - theta'

    where theta and theta' belong to the legs beside the run; other signs of theta give no smaller value. The
    terms of runs increase with k. For four or more legs, cos((theta + theta') / 2), which is half of what a
    single bounce adds, is at least the mean of cos theta and cos theta'. Each leg thus adds 2 (r + a / r) or
    more, with r = sqrt(a^2 + n^2), whatever p is. Its derivative in n, 2 (n / r) (1 - a / r^2), is not
    negative from n = 1 on, because a^2 + 1 > a.

    For two legs of n and m straight bounces, where n >= m, the minimum is found by trying all n + m <= p. No
    other pair is shorter: both of its runs are single bounces, which add 4 cos((theta + theta') / 2)
    together, so the derivative in n is at least 2 (n / r) (1 - a / r^2), and twice as large along n = m.
    """
    four = min(8 * (math.hypot(a, n) + a / math.hypot(a, n)) for n in (0, 1))
    two = min(_two_legs(p, a, n, m) for n in range(p + 1) for m in range(min(n, p - n) + 1))
    return min(four, two) * (1 - _ROUNDING)


def largest_least_length(a: float) -> float:
    """Return the limit of `least_length` as p grows: no fill proves a list complete beyond it.

    Notes
    -----
    With two legs of n and m straight bounces, more bounces only lengthen one run, towards an arc:

        2 sqrt(a^2 + n^2) + 2 sqrt(a^2 + m^2) + 2 sin(psi / 2) + psi

    From n = 1 on, the derivative of this in n, 2n / r - (1 + cos(psi / 2)) a / r^2, is positive. Four legs
    have the bound of `least_length`, whatever p is.
    """
    lines, angles = (math.hypot(a, 0), math.hypot(a, 1)), (0.0, math.atan2(1, a))
    four = min(8 * (r + a / r) for r in lines)
    pairs = ((0, 0), (0, 1), (1, 1))
    psis = [math.pi - angles[n] - angles[m] for n, m in pairs]
    two = min(
        2 * (lines[n] + lines[m]) + 2 * math.sin(psi / 2) + psi
        for (n, m), psi in zip(pairs, psis, strict=True)
    )
    return min(four, two)


def least_limit_of_lengths(a: float) -> float:
    """Return the perimeter 4a + 2 pi, in units of the radius: infinitely many orbits are shorter.

    Notes
    -----
    For every a, the words of k bounces up one semicircle and k down the other are orbits: the path crosses
    the stadium horizontally at the heights cos(pi / 2k) and -cos(pi / 2k). Its length 4a + 4k sin(pi / 2k)
    increases with k to the perimeter.
    """
    return 4 * a + 2 * math.pi


def _two_legs(p: int, a: float, n: int, m: int) -> float:
    """Return the least length of two legs of n and m straight bounces, and more than p bounces in total."""
    bounces = max(p + 1 - n - m, 2)
    psi = math.pi - math.atan2(n, a) - math.atan2(m, a)
    k = np.arange(1, bounces)
    runs = 2 * k * np.sin(psi / (2 * k))
    return 2 * (math.hypot(a, n) + math.hypot(a, m)) + float((runs + runs[::-1]).min())


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
