"""Verdicts on windows: allowed, forbidden or undecided, for all continuations beyond their ends.

Two clamped problems decide a window; they give its directions when the continuations push to either extreme.
Every extreme continuation is that of a given run, which may be infinitely long, and a given outer leg. So
legs 0 and m + 1 are given, and the legs between them maximise the length within their limits. All directions
theta_j = sigma_j alpha_j, with sigma_{j+1} = -sigma_j (-1)^{n_j}, increase with the push at either end
(docs/entropy-proof.md has the ranges and the proof).
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Marks
from orbitdb.billiard.arithmetic import ABOVE, EPSILON, check_functions
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    centre_directions,
    derivatives,
    direction_limits,
    gradient_rounding,
    pressed_directions,
)
from orbitdb.billiard.stadium import HALF_PI
from orbitdb.entropy_bounds.windows import PART_OF_LEG, UNKNOWN_RUN, OpenChains, Windows, open_chains
from orbitdb.orbits.error_bounds import steepness
from orbitdb.orbits.newton import responses
from orbitdb.progress import Tell

MAX_STEPS = 16
_CLEAR = 8.0
"""Ratio of f to its error at which the sign of f is known and its value is accurate enough."""

_SMALL = 1e-9
ROUNDING = 12 * EPSILON
"""Bound on the rounding of f: 4.3 units for psi/2k, 2.5 for the sum, less than 1 for pi/2 as a double."""


@dataclass(frozen=True, eq=False)
class Corner(Batch):
    """N windows with an extreme push at each end."""

    legs: Chain  # runs and legs 0 to m + 1 as in `OpenChains`, with the runs at the ends set by the push
    # limits of the directions, which coincide for the outer legs, shape (m + 2, N)
    low: Floats
    high: Floats
    marked: Indices  # the row of the marked junction, shape (N,)
    # c in its condition f = h + c o > 0, where h = psi/2k of the run and o is the leg's direction, shape (N,)
    lean: Floats


def orientation(chains: OpenChains) -> Floats:
    """Return sigma, shape (m + 2, N), which is +1 at the marked leg."""
    sigma = np.ones_like(chains.n)
    for row in range(1, len(sigma) - 1):
        sigma[row + 1] = sigma[row] * np.where(chains.n[row] % 2 == 1, 1.0, -1.0)
    return sigma * chains.at_mark(sigma)


def corner(chains: OpenChains, a: float, left: Floats, right: Floats) -> Corner:
    """Return windows with the given pushes at their ends.

    Parameters
    ----------
    a : float
        Half length of the stadium.
    left, right : ndarray, shape (N,)
        +1 to push an end so that the marked direction is as large as possible, -1 for as small as possible.
    """
    sigma = orientation(chains)
    k, d, n, s = chains.k.copy(), chains.d.copy(), chains.n.copy(), chains.s.copy()
    low, high = direction_limits(Chain(k, d, n, s), a)
    ends = ((0, 1, chains.left, -sigma[1] * left), (-1, -1, chains.right, sigma[-1] * right))
    for leg, run, kind, push in ends:
        d[run] = np.where(kind == UNKNOWN_RUN, push, d[run])
        endless = (kind != PART_OF_LEG) & (push * d[run] > 0)
        k[run] = np.where(endless, np.inf, k[run])
        steep = np.where(push * s[leg] > 0, HALF_PI, np.where(s[leg] > 0, low[leg], -high[leg]))
        low[leg] = high[leg] = np.where(kind == PART_OF_LEG, s[leg] * steep, -d[run] * HALF_PI)
        n[leg] = s[leg] = 0
    k[0] = np.inf
    return Corner(Chain(k, d, n, s), low, high, chains.marked, chains.lean)


@dataclass(frozen=True, eq=False)
class JunctionCondition:
    """The condition f > 0 of the marked junction at directions near the maximum of the length."""

    alpha: Floats  # the directions, shape (m + 2, N)
    value: Floats  # f, in radians, shape (N,)
    # bound on the difference from f at the maximum, including rounding, shape (N,)
    error: Floats


def solve_corner(problem: Corner, a: float, enough: Floats) -> JunctionCondition:
    """Find the sign of f at the marked junctions by Newton's method on all windows at once.

    A window leaves the batch when its error bound is at most `enough`, shape (N,), or small compared with f,
    or no longer decreases.
    """
    alpha = np.clip(centre_directions(problem.legs, a), problem.low, problem.high)
    solved = JunctionCondition(alpha.copy(), *np.empty((2, len(problem.marked))))
    active = np.arange(len(problem.marked))
    last = np.full(len(active), np.inf)
    for _ in range(MAX_STEPS):
        slopes = derivatives(problem.legs, a, alpha)
        pressed = pressed_directions(alpha, slopes, (problem.low, problem.high))
        condition = _condition(problem, alpha, _direction_error(problem.legs, a, alpha, slopes, pressed))
        solved.alpha[:, active] = alpha
        solved.value[active], solved.error[active] = condition.value, condition.error
        unclear = (condition.error > enough[active]) & (np.abs(condition.value) < _CLEAR * condition.error)
        improving = (condition.error > _SMALL) | (condition.error < last / 2)
        going = np.flatnonzero(unclear & improving)
        if not len(going):
            break
        if len(going) < len(active):
            active, alpha, pressed = active[going], alpha.take(going, axis=1), pressed.take(going, axis=1)
            problem, slopes = problem.rows(going), slopes.rows(going)
        last = condition.error[going]
        (step,) = responses(problem.legs, slopes, pressed, slopes.gradient)
        alpha = np.clip(alpha + step, problem.low, problem.high)
    return solved


def _direction_error(legs: Chain, a: float, alpha: Floats, slopes: Derivatives, pressed: Marks) -> Floats:
    """Bound the distance of all directions from the maximum by max |g| / F with F = D / 2, shape (N,).

    The bound is that of `orbitdb.orbits.error_bounds`; the outer legs are given and do not enter.
    """
    steep = steepness(slopes, pressed, gradient_rounding(legs, a, alpha))
    worst: Floats = (2 * steep / slopes.between_centres)[1:-1].max(axis=0, initial=0.0)
    return ABOVE * worst


def _condition(problem: Corner, alpha: Floats, error: Floats) -> JunctionCondition:
    """Evaluate f at the marked junctions, given the error of the directions."""
    row, word = problem.marked, np.arange(len(problem.marked))
    k, d = problem.legs.k[row, word], problem.legs.d[row, word]
    outgoing = alpha[row, word]
    incoming = problem.legs.parity[row - 1, word] * alpha[row - 1, word]
    half = (np.pi - d * (incoming + outgoing)) / (2 * k)
    value = half + problem.lean * outgoing
    return JunctionCondition(alpha, value, ABOVE * error * (1 + 1 / k) + ROUNDING)


BATCH = 1 << 15
"""Number of windows solved at a time, which limits the memory."""

_ROUGH = 0.02
"""Error of f, as a fraction of its range, that suffices to choose which end to extend."""


class Verdict(IntEnum):
    """Whether the marked junction satisfies its condition f > 0."""

    UNDECIDED = 0
    ALLOWED = 1
    FORBIDDEN = 2


@dataclass(frozen=True, eq=False)
class Decision:
    """Verdicts on N windows."""

    # values of `Verdict`, shape (N,): allowed if f > 0 for all continuations, forbidden if f < 0 for all
    verdict: NDArray[np.uint8]
    # whether the left end of an undecided window changes f more than the right end, shape (N,)
    extend_left: Marks


def decide_windows(windows: Windows, a: float, tell: Tell | None = None, size: int = BATCH) -> Decision:
    """Decide windows at a given a, `size` of them at a time, and report progress.

    f increases with the push d at the left end and the push c at the right end (`OpenChains.lean`), or at
    least crosses zero only upwards. Therefore f > 0 is decided with both pushes reversed, and f < 0 with both
    unchanged.
    """
    check_functions()
    verdict = np.zeros(len(windows), dtype=np.uint8)
    extend_left = np.zeros(len(windows), dtype=np.bool_)
    for start in range(0, len(windows), size):
        if tell:
            tell(start, len(windows), f"{windows.edges} letters")
        batch = np.arange(start, min(start + size, len(windows)))
        for rows, chains in open_chains(windows.rows(batch)):
            decision = _decide(chains, a)
            verdict[batch[rows]], extend_left[batch[rows]] = decision.verdict, decision.extend_left
    return Decision(verdict, extend_left)


def _decide(chains: OpenChains, a: float) -> Decision:
    nothing = np.zeros(len(chains))
    least, most = _f(chains, a, -1, -1, nothing), _f(chains, a, 1, 1, nothing)
    verdict = np.full(len(chains), Verdict.UNDECIDED, dtype=np.uint8)
    verdict[least.value > least.error] = Verdict.ALLOWED
    verdict[most.value < -most.error] = Verdict.FORBIDDEN
    extend_left = np.zeros(len(chains), dtype=np.bool_)
    rows = np.flatnonzero(verdict == Verdict.UNDECIDED)
    low, high = least.value[rows], most.value[rows]
    between = _f(chains.rows(rows), a, 1, -1, _ROUGH * (high - low)).value
    extend_left[rows] = between - low > high - between
    return Decision(verdict, extend_left)


def _f(chains: OpenChains, a: float, left: int, right: int, enough: Floats) -> JunctionCondition:
    """Return f with each end pushed so as to raise it (+1) or lower it (-1)."""
    pushed = corner(chains, a, left * chains.sense, right * chains.lean)
    return solve_corner(pushed, a, enough)
