"""From words to orbits: Newton's method for the leg directions of entire batches of words.

The length is strictly concave between the limits of an orbit's directions, and its Hessian is cyclic
tridiagonal. Newton's method therefore finds the only maximum of every word, whether it is an orbit or leaves
the stadium. Words that have converged are removed from the batch.
"""

from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    centre_directions,
    derivatives,
    direction_limits,
    following,
    length,
    preceding,
    pressed_directions,
)
from orbitdb.billiard.stability import solve_cyclic

TOLERANCE = 1e-16
MAX_STEPS = 50
_PLAIN_STEPS = 8
"""Number of unchecked steps; later ones must lengthen the path, because a few words would cycle."""
_SMALL = 1e-7


class Directions(NamedTuple):
    """State of Newton's method for N words."""

    alpha: Floats  # directions of the legs (radians), shape (m, N)
    iterations: Integers  # number of steps taken, shape (N,)


def newton(
    legs: Chain, a: float | Floats, tolerance: float = TOLERANCE, start: Floats | None = None
) -> Directions:
    """Find the maximum of the length of each word between its direction limits.

    Parameters
    ----------
    legs : Chain
        N words of m legs.
    a : float or ndarray, shape (N,)
        Half the length of a straight wall, the same for all words or one value for each.
    tolerance : float, optional
        Error of the directions (radians) at which to stop. The error is predicted from the last two steps:
        after a step of size e it is about e^3 / e_before^2. If rounding errors are larger, the iteration
        stops when it reaches them.
    start : ndarray, shape (m, N), optional
        Directions to start from, within the limits; by default those of the lines between the unfolded circle
        centres.
    """
    alpha = centre_directions(legs, a) if start is None else start.copy()
    iterations = np.zeros(len(legs), dtype=np.int64)
    active = np.arange(len(legs))
    part: Chain = legs
    now = alpha  # directions of the words that still move
    limits = around = direction_limits(part, a)
    last = np.full(len(legs), np.nan)
    for count in range(MAX_STEPS):
        step = newton_step(part, a, now, limits)
        if count >= _PLAIN_STEPS:
            step = _uphill(part, a, now, step)
        now = now + step
        size = np.abs(step).max(axis=0)
        iterations[active] += 1
        stalled = (size < 1e-6) & (size >= last / 2)  # small steps that no longer shrink are noise
        done = (size <= tolerance) | (size**3 <= tolerance * last**2) | stalled
        held = ((now <= limits[0]) | (now >= limits[1])).any(axis=0)  # a direction may still leave its limit
        done &= (last < _SMALL) | ~held
        if done.any():
            alpha[:, active[done]] = now[:, done]
            going = np.flatnonzero(~done)
            active, now, last = active[going], now.take(going, axis=1), size[going]
            limits = (limits[0].take(going, axis=1), limits[1].take(going, axis=1))
            part = part.chain(going)
            a = a[going] if isinstance(a, np.ndarray) else a
        else:
            last = size
        if not len(active):
            break
    alpha[:, active] = now
    return Directions(np.clip(alpha, *around), iterations)  # rounding may exceed the limits


def _uphill(legs: Chain, a: float | Floats, alpha: Floats, step: Floats) -> Floats:
    """Halve steps until they lengthen the path, except small steps, whose effect rounding would hide."""
    before = length(legs, a, alpha)
    while True:
        down = (np.abs(step).max(axis=0) > _SMALL) & (length(legs, a, alpha + step) <= before)
        if not down.any():
            return step
        step = np.where(down, step / 2, step)


def newton_step(legs: Chain, a: float | Floats, alpha: Floats, limits: tuple[Floats, Floats]) -> Floats:
    """Return the Newton step, kept within the limits; directions pressed against a limit do not move."""
    slopes = derivatives(legs, a, alpha)
    (step,) = responses(legs, slopes, pressed_directions(alpha, slopes, limits), slopes.gradient)
    return np.clip(alpha + step, *limits) - alpha


def responses(legs: Chain, slopes: Derivatives, pressed: Marks, *forces: Floats) -> Floats:
    """Solve -H x = force for r forces, with shape (r, m, N); pressed directions do not move."""
    return solve_cyclic(*minus_hessian(legs, slopes, pressed), np.where(pressed, 0.0, np.stack(forces)))


def minus_hessian(legs: Chain, slopes: Derivatives, pressed: Marks) -> tuple[Floats, Floats]:
    """Return the diagonal of -H and the entries beside it; entry i couples directions i - 1 and i."""
    w = slopes.stiffness
    beside = w * preceding(legs.parity)
    diagonal = slopes.between_centres + w + following(w)
    if pressed.any():
        beside = np.where(pressed | preceding(pressed), 0.0, beside)
    return diagonal, beside
