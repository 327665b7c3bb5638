"""Bounds on the errors of directions, coordinates, length, lambda and area (docs/proof.md).

Let g be the gradient of the length at some directions, let D be minus the second derivative of each leg's own
term, and F a lower bound on the mean of D on the way to the maximum. Then the distance of each direction from
its value at the maximum is bounded by

    max |g_i| / F_i   and   sqrt(sum of g_i^2 / F_i) / sqrt(F_i).

F = D / 2 holds at any distance. Once the directions are known to be close to the maximum, F is almost D.

Every bound holds for the computed numbers: it includes their rounding errors, and the factor `ABOVE` covers
the rounding of the bound itself (`orbitdb.billiard.arithmetic` lists the assumptions).
"""

import numpy as np

from orbitdb.arrays import Floats, Marks, Words
from orbitdb.billiard.arithmetic import ABOVE, EPSILON
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    add_up,
    direction_limits,
    following,
    gradient_rounding,
    half_turns,
    preceding,
    pressed_directions,
    summation_rounding,
)
from orbitdb.billiard.stadium import Stadium


def direction_errors(
    legs: Chain,
    a: float | Floats,
    alpha: Floats,
    slopes: Derivatives,
    limits: tuple[Floats, Floats] | None = None,
) -> Floats:
    """Bound the distance of every direction from the maximum, rounding included, shape (m, N).

    The gradient of a direction that is pressed against a limit (by default one of `direction_limits`)
    contributes only its rounding, because there g_i delta_i <= 0. On the way to the maximum, the mean of D is
    at least D - |lean| |delta| / 2 - D delta^2 / 2.
    """
    pressed = pressed_directions(alpha, slopes, direction_limits(legs, a) if limits is None else limits)
    rounding = gradient_rounding(legs, a, alpha)
    steep = steepness(slopes, pressed, rounding)
    first = _concave_bound(steep, slopes.between_centres / 2)
    loss = (np.abs(slopes.own_term) + rounding) * first / (2 * slopes.between_centres) + first**2 / 2
    return _concave_bound(steep, slopes.between_centres * (1 - np.minimum(loss, 0.5)))


def steepness(slopes: Derivatives, pressed: Marks, rounding: Floats) -> Floats:
    """Bound the part of |g| that can move each direction: if it is pressed, only what rounding may hide."""
    size = np.abs(slopes.gradient)
    return np.where(pressed, np.maximum(rounding - size, 0.0), size + rounding)


def _concave_bound(steep: Floats, firm: Floats) -> Floats:
    """Return the smaller of the two bounds at the top of this module, with g = steep and F = firm."""
    share = steep / firm
    energy = np.sqrt(add_up(steep * share))
    return ABOVE * np.minimum(share.max(axis=0), energy / np.sqrt(firm))


def coordinate_error(
    legs: Chain, a: float, alpha: Floats, alpha_error: Floats, slack_error: Floats
) -> Floats:
    """Bound the errors of the coordinates of each word, shape (N,).

    A leg is drawn between the ends of two runs. A bounce on a wall is off by at most the larger of their
    distances from the true leg, divided by |sin alpha| of that leg. The rounding of the interpolation is
    below 9 eps (a + 1), or 19 eps (a + 1) if the leg hits more than one wall.
    """
    first, last = slack_error[:2]
    across = np.sin(half_turns(legs, alpha))
    shift = np.maximum(last * (across + 2 * last), following(first * (across + 2 * first)))
    least = np.abs(np.sin(alpha)) * (1 - 4 * EPSILON) - ABOVE * alpha_error
    with np.errstate(divide="ignore"):
        wall = shift / np.maximum(least, 0.0)
    wall += 10 * EPSILON * (a + 1) * np.where(legs.n > 1, 2.0, 1.0)
    worst: Floats = np.maximum(np.maximum(first, last), np.where(legs.n > 0, wall, 0)).max(axis=0)
    return ABOVE * worst


def length_error(legs: Chain, a: float, alpha: Floats, slopes: Derivatives, alpha_error: Floats) -> Floats:
    """Bound the error of the length, shape (N,): rounding, and 0 <= L(maximum) - L <= g . delta.

    The terms of a leg, and the sine, product and sums of a run, are accurate to 2.5 eps of their size. psi/2k
    is accurate to 4.3 eps / k, which adds 8.5 eps |cos(psi/2k)|.
    """
    half = half_turns(legs, alpha)
    terms = 2 * a * np.cos(alpha) + 2 * legs.n * np.abs(np.sin(alpha)) + 2 * legs.k * np.sin(half)
    second = add_up((np.abs(slopes.gradient) + gradient_rounding(legs, a, alpha)) * alpha_error)
    relative = 3 * EPSILON + summation_rounding(len(terms))
    return ABOVE * (second + add_up(relative * terms + 9 * EPSILON * np.abs(np.cos(half))))


def lambda_error(legs: Chain, slopes: Derivatives, alpha_error: Floats, value: Floats) -> Floats:
    """Bound the error of `exponent`, given the errors of the directions, shape (m, N), and its value.

    It is at most r times tanh of half the larger of the two lambdas, where r is the sum of the errors of the
    logarithms of all drifts and kicks. Because D'' = -D, a drift changes by at most a fraction
    q = |D'| e / D + e^2 / 2. Because sin(h +- e) >= sin(h) - e, a kick changes by at most q = e / sin(h). The
    logarithm of either changes by at most q / (1 - q), or without bound if q >= 1. Rounding adds 6 eps for
    each run and leg, and 3 eps for lambda itself.
    """
    drift = (np.abs(slopes.own_term) / slopes.between_centres + alpha_error / 2) * alpha_error
    bend = alpha_error + preceding(alpha_error) + 4 * np.pi * EPSILON
    kick = bend / (4 * legs.k**2 * slopes.stiffness)
    relative = add_up(_of_logarithm(drift) + _of_logarithm(kick)) + 12 * len(legs.k) * EPSILON
    bound: Floats = relative * np.tanh((value + relative) / 2) + 3 * EPSILON * value
    return ABOVE * bound


def _of_logarithm(share: Floats) -> Floats:
    """Bound the change of a logarithm, given the relative change of its argument."""
    room = 1 - share
    return np.where(room > 0, share / np.maximum(room, 1e-17), np.inf)


def enclosed_areas(
    stadium: Stadium, words: Words, coordinates: Floats, error: Floats
) -> tuple[Floats, Floats]:
    """Return the areas that orbits enclose and bounds on their errors, in radius^2, each of shape (N,).

    `words` and `coordinates` have shape (N, p), and `error` bounds the errors of the coordinates, shape (N,).
    The area is half the sum of the cross products of successive bounces. The bounds include the rounding of
    the bounces and of the sum.
    """
    x, y = map(np.ascontiguousarray, stadium.frames(words, coordinates)[0])
    x_next, y_next = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    forward, backward = x * y_next, y * x_next
    chords = np.sqrt((x_next - np.roll(x, 1, axis=1)) ** 2 + (y_next - np.roll(y, 1, axis=1)) ** 2)
    p, moved = words.shape[1], error + 4 * EPSILON * (1 + stadium.a)
    rounding = (p + 4) * EPSILON * (np.abs(forward) + np.abs(backward)).sum(axis=1) / 2
    bound = 1.000001 * (moved / 2 * chords.sum(axis=1) + p * moved**2 / 2 + rounding)
    return (forward - backward).sum(axis=1) / 2, bound
