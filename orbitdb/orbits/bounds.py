"""How well an orbit is known, and whether it is one.

Doubles first. At directions alpha let g be the gradient of the length and D the curvatures of the
legs' own terms (`orbitdb.billiard.legs`). Let the maximum lie at alpha + delta between the direction limits,
and let F_i be a bound from below on the mean of D_i along the way; D being concave and positive,
F = D / 2 is one from any distance. The runs' terms are concave too, and each depends on a sum of two
directions only. So they can but help in

    g . delta >= sum of F_i delta_i^2,   hence   sum of F_i delta_i^2 <= sum of g_i^2 / F_i,

and in the row of the largest |delta_i|, where they all pull the way F_i delta_i does:

    max |delta_i| <= max |g_i| / F_i.

Neither needs an inverse Hessian or that alpha is near. Once they have shown it to be near, F is almost
D, and they are applied again. Where a bounce's distance from a joint is not clearly larger than what
follows, the first of them is evaluated in ball arithmetic.

Every bound holds for the numbers as they are computed: it adds what they are rounded by, and `ABOVE`
times it is above what its own evaluation loses (`orbitdb.arithmetic` says what is assumed).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import ABOVE, check_functions
from orbitdb.billiard.bounces import (
    coordinates,
    margin_distances,
    slack_errors,
    slacks,
)
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    Legs,
    add_up,
    derivatives,
    direction_limits,
    following,
    gradient_rounding,
    length,
    summation_rounding,
    turns,
)
from orbitdb.billiard.stability import exponent, exponent_error, forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.orbit import Orbits, Status

Floats = NDArray[np.float64]
EPSILON = float(np.finfo(float).eps)


def assess(
    words: NDArray[np.uint8],
    legs: Legs,
    stadium: Stadium,
    alpha: Floats,
    iterations: NDArray[np.int64],
) -> Orbits:
    """Turn solved directions into orbits with error bounds and a status, as far as doubles can decide.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
    legs : Legs
        The same words, cut.
    stadium : Stadium
    alpha : ndarray, shape (m, N)
        Directions of the legs at (or near) the maximum of the length, between the limits.
    iterations : ndarray of int, shape (N,)
        Steps the solver took.

    Returns
    -------
    Orbits
    """
    return _measured(words, legs, stadium, alpha, iterations, _decided(legs, stadium.a, alpha))


def assess_orbits(
    words: NDArray[np.uint8],
    chain: Chain,
    legs: Callable[[NDArray[np.intp]], Legs],
    stadium: Stadium,
    found: tuple[Floats, NDArray[np.int64]],
) -> Orbits:
    """Do as `assess` does, but of words that are proved to be no orbits tell margin and steps alone.

    Parameters
    ----------
    words, stadium, found
        As there, ``found`` being the directions and the steps that the solver took.
    chain : Chain
        The words, cut.
    legs : callable
        From places among the words to their `Legs`.
    """
    alpha, iterations = found
    verdict = _decided(chain, stadium.a, alpha)
    orbits = replace(Orbits.empty(words), status=verdict.status, margin=verdict.margin, iterations=iterations)
    left = np.flatnonzero(verdict.status != Status.DYNAMICAL)
    if len(left):
        here = legs(left), stadium, alpha.take(left, axis=1), iterations[left]
        orbits.place(left, _measured(words[left], *here, verdict.of_words(left)))
    return orbits


@dataclass(frozen=True, eq=False)
class _Verdict(ByValue):
    """What has become of N words, and what that was decided by.

    Attributes
    ----------
    slopes : Derivatives
    alpha_error : ndarray, shape (m, N)
    slack_error : ndarray, shape (4, m, N)
    status, margin : ndarray, shape (N,)
        As in `Orbits`.
    """

    slopes: Derivatives
    alpha_error: Floats
    slack_error: Floats
    status: NDArray[np.str_]
    margin: Floats

    def of_words(self, words: NDArray[np.intp]) -> "_Verdict":
        """Return those of some of the words."""
        errors = self.alpha_error.take(words, axis=1), self.slack_error.take(words, axis=2)
        return _Verdict(self.slopes.of_words(words), *errors, self.status[words], self.margin[words])


def _decided(legs: Chain, a: float, alpha: Floats) -> _Verdict:
    """Tell which words are orbits, as far as doubles can."""
    check_functions()
    slopes = derivatives(legs, a, alpha)
    alpha_error = direction_errors(legs, a, alpha, slopes, pressed_directions(legs, a, alpha, slopes))
    slack = slacks(legs, alpha)
    slack_error = slack_errors(legs, alpha_error)
    status = status_of(slack, slack_error, between_limits(legs, a, alpha, alpha_error))
    margin = margin_distances(legs, alpha, slack).min(axis=(0, 1))
    return _Verdict(slopes, alpha_error, slack_error, status, margin)


def _measured(
    words: NDArray[np.uint8],
    legs: Legs,
    stadium: Stadium,
    alpha: Floats,
    iterations: NDArray[np.int64],
    verdict: _Verdict,
) -> Orbits:
    """Return all that is to be known of words of which it has been decided what becomes of them."""
    a, slopes, alpha_error = stadium.a, verdict.slopes, verdict.alpha_error
    place, lyapunov = coordinates(legs, a, alpha), exponent(slopes)
    return Orbits(
        words=words,
        status=verdict.status,
        coordinates=place,
        length=length(legs, a, alpha),
        lyapunov=lyapunov,
        margin=verdict.margin,
        residual=np.abs(forces(stadium, words, place)).max(axis=1),
        error=_coordinate_error(legs, a, alpha, alpha_error, verdict.slack_error),
        length_error=_length_error(legs, a, alpha, slopes, alpha_error),
        lyapunov_error=exponent_error(legs, slopes, alpha_error, lyapunov),
        iterations=iterations,
    )


def pressed_directions(
    legs: Chain, a: float | Floats, alpha: Floats, slopes: Derivatives
) -> NDArray[np.bool_]:
    """Tell which directions stand at a limit that the gradient pushes against."""
    low, high = direction_limits(legs, a)
    return ((alpha <= low) & (slopes.gradient < 0)) | ((alpha >= high) & (slopes.gradient > 0))


def between_limits(legs: Chain, a: float | Floats, alpha: Floats, alpha_error: Floats) -> NDArray[np.bool_]:
    """Tell for which words the maximum is surely away from the limits, and so a stationary point."""
    low, high = direction_limits(legs, a)
    return np.all(np.minimum(alpha - low, high - alpha) > ABOVE * alpha_error, axis=0)


def direction_errors(
    legs: Chain, a: float | Floats, alpha: Floats, slopes: Derivatives, pressed: NDArray[np.bool_]
) -> Floats:
    """Bound the distance of every direction from the maximum, rounding included, shape (m, N).

    Directions that are pressed against a limit do not enter but for rounding: there g_i delta_i <= 0.
    Along the way D stays above D - |lean| |delta| / 2 - D delta^2 / 2 in the mean.
    """
    size, rounding = np.abs(slopes.gradient), gradient_rounding(legs, a, alpha)
    steep = np.where(pressed, np.maximum(rounding - size, 0.0), size + rounding)
    first = _concave_bound(steep, slopes.beyond / 2)
    loss = (np.abs(slopes.lean) + rounding) * first / (2 * slopes.beyond) + first**2 / 2
    return _concave_bound(steep, slopes.beyond * (1 - np.minimum(loss, 0.5)))


def surely_outside(legs: Chain, a: float, alpha: Floats, slopes: Derivatives) -> NDArray[np.bool_]:
    """Tell which words leave the stadium for sure, shape (N,), from directions that need not be near.

    One step of Newton's method is enough to tell nearly all of them. It is `direction_errors` and
    `orbitdb.billiard.bounces.slack_errors` once more, with one bound for all directions of a word and
    roundings that are quicker to find and larger.
    """
    eps = float(np.finfo(float).eps)
    run = 2 + 2 * np.pi / legs.k
    rounding = ABOVE * eps * (6 * (a + legs.n) + run + following(run))
    ratio = (np.abs(slopes.gradient) + rounding) / slopes.beyond
    first = 2 * ABOVE * ratio.max(axis=0)
    loss = (np.abs(slopes.lean) + rounding) / slopes.beyond * (first / 2) + first**2 / 2
    error = ABOVE * (ratio / (1 - np.minimum(loss, 0.5))).max(axis=0)
    slack = slacks(legs, alpha).min(axis=1)
    ends, walls = np.minimum(slack[0], slack[1]), np.minimum(slack[2], slack[3])
    return (ends < -ABOVE * (error + 26 * eps)) | (walls < -ABOVE * (3 * error + 26 * eps))


def _concave_bound(steep: Floats, firm: Floats) -> Floats:
    """Return the smaller of the two bounds of the module's docstring, g = steep and F = firm."""
    share = steep / firm
    energy = np.sqrt(add_up(steep * share))
    return ABOVE * np.minimum(share.max(axis=0), energy / np.sqrt(firm))


def status_of(slack: Floats, slack_error: Floats, between: NDArray[np.bool_]) -> NDArray[np.str_]:
    """Return the statuses that slacks with error bounds, shape (4, m, N), show; shape (N,)."""
    outside = (slack < -slack_error).any(axis=(0, 1))
    inside = (slack > slack_error).all(axis=(0, 1)) & between
    return np.where(
        outside, Status.DYNAMICAL.value, np.where(inside, Status.ORBIT.value, Status.UNRESOLVED.value)
    )


def _coordinate_error(
    legs: Legs, a: float, alpha: Floats, alpha_error: Floats, slack_error: Floats
) -> Floats:
    """Bound the error of the coordinates, shape (N,).

    A leg is drawn between the ends of two runs. An end that is off by e along the circle is off the
    orbit's leg, which meets the circle at an angle within e of the computed psi/2k, by at most
    e (sin(psi/2k) + 2 e); any point between the ends by at most the larger of the two, and a bounce on a
    wall by this over |sin alpha| of the orbit. Rounding of the interpolation is below 9 eps (a + 1), with
    more than one wall 19 eps (a + 1).
    """
    first, last = slack_error[:2]
    across = np.sin(turns(legs, alpha).half)
    shift = np.maximum(last * (across + 2 * last), following(first * (across + 2 * first)))
    least = np.abs(np.sin(alpha)) * (1 - 4 * EPSILON) - ABOVE * alpha_error
    with np.errstate(divide="ignore"):
        wall = shift / np.maximum(least, 0.0)
    wall += 10 * EPSILON * (a + 1) * np.where(legs.n > 1, 2.0, 1.0)
    worst: Floats = np.maximum(np.maximum(first, last), np.where(legs.n > 0, wall, 0)).max(axis=0)
    return ABOVE * worst


def _length_error(legs: Legs, a: float, alpha: Floats, slopes: Derivatives, alpha_error: Floats) -> Floats:
    """Bound the error of the length, shape (N,): 0 <= L(maximum) - L <= g . delta, and rounding.

    A leg's terms, and for the sine, the product and the sums a run's, are good to 2.5 eps of their size;
    psi/2k being good to 4.3 eps / k, that adds 8.5 eps |cos(psi/2k)|.
    """
    half = turns(legs, alpha).half
    terms = 2 * a * np.cos(alpha) + 2 * legs.n * np.abs(np.sin(alpha)) + 2 * legs.k * np.sin(half)
    second = add_up((np.abs(slopes.gradient) + gradient_rounding(legs, a, alpha)) * alpha_error)
    each = 3 * EPSILON + summation_rounding(len(terms))
    return ABOVE * (second + add_up(each * terms + 9 * EPSILON * np.abs(np.cos(half))))
