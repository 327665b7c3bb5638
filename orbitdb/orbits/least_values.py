"""Lower bounds on the length and lambda of orbits with more bounces than were enumerated.

A catalogue of all orbits up to p bounces contains all orbits below these bounds. Both rest on runs of k
bounces and legs of n straight ones (docs/proof.md): a word of m legs, m even, has
k_1 + n_1 + ... + k_m + n_m bounces.
"""

import math

import numpy as np

_ROUNDING = 1e-12


def least_length(p: int, a: float) -> float:
    """Return a length below that of every orbit of more than p bounces, in units of the radius.

    Notes
    -----
    The length of an orbit is the maximum of L over the box of directions, so it is at least L with all legs
    parallel to the lines between centres, at the angles theta_n = atan(n / a):

        L >= sum of 2 sqrt(a^2 + n^2) + sum of 2k sin(psi / 2k),  psi = pi - theta - theta'

    with theta, theta' of the legs beside the run, for other signs of theta give no less. Runs grow with k.
    With four legs or more, cos((theta + theta') / 2), half of what one bounce adds, is no less than the mean
    of both cosines; so each leg adds 2 (r + a / r) or more, with r = sqrt(a^2 + n^2), whatever p. Its slope
    2 (n / r) (1 - a / r^2) is no less than 0 from n = 1 on, as a^2 + 1 > a.

    With two legs of n and m straight bounces, n the larger, the least is found by trying all with
    n + m <= p. The others are no shorter: both runs are single bounces there, of 4 cos((theta + theta') / 2)
    together, so that the slope in n is no less than 2 (n / r) (1 - a / r^2), and twice that along n = m.
    """
    four = min(8 * (math.hypot(a, n) + a / math.hypot(a, n)) for n in (0, 1))
    two = min(_two_legs(p, a, n, m) for n in range(p + 1) for m in range(min(n, p - n) + 1))
    return min(four, two) * (1 - _ROUNDING)


def _two_legs(p: int, a: float, n: int, m: int) -> float:
    """Return the least length with two legs of n and m straight bounces, and more than p bounces in all."""
    bounces = max(p + 1 - n - m, 2)
    psi = math.pi - math.atan2(n, a) - math.atan2(m, a)
    k = np.arange(1, bounces)
    runs = 2 * k * np.sin(psi / (2 * k))
    return 2 * (math.hypot(a, n) + math.hypot(a, m)) + float((runs + runs[::-1]).min())


def least_exponent(p: int, a: float) -> float:
    """Return a lambda below that of every orbit, and of all products of orbits, of more than p bounces.

    Notes
    -----
    M is, but for its sign, the product of [[1, D], [K, 1 + K D]] over all legs, with K = 2k / sin(h) of the
    run and D of the leg, all positive. So its trace, e^lambda + e^-lambda, is at least 1 + prod (1 + K D),
    and lambda is at least the sum of ln(1 + K D). The same holds for the sum of lambda over several orbits
    that have more than p bounces together. In a run (k - 1) h < pi/2, so K is at least 2k if k < 3, else
    2k / sin(pi / 2(k - 1)). D is concave on the box, so it is no less than at one of its ends. Both bounds
    grow with k, and with n from n = 1 on.
    """
    best = [math.inf] * (p + 2)  # by bounces or more: the least that one leg adds, then one or more
    for k in range(1, p + 2):
        kick = 2 * k / math.sin(math.pi / max(2 * (k - 1), 2))
        for n in range(p + 2 - k):
            best[k + n] = min(best[k + n], math.log1p(kick * _least_drift(n, a)))
    for q in range(p, 0, -1):
        best[q] = min(best[q], best[q + 1])
    for q in range(2, p + 1):
        best[q] = min(best[q], _two_parts(best, q))
    return _two_parts(best, p + 1) * (1 - _ROUNDING)


def _two_parts(best: list[float], bounces: int) -> float:
    """Return the least sum of two parts of a word that share the given bounces."""
    return min(best[q] + best[bounces - q] for q in range(1, bounces))


def _least_drift(n: int, a: float) -> float:
    """Return a lower bound on D of a leg over n walls, attained at one end of its directions."""
    ends = [(1, a)] if n == 0 else [(n + 1, a), (n - 1, a + 1)]
    return min((2 * a * dx + 2 * n * dy) / math.hypot(dx, dy) for dy, dx in ends)
