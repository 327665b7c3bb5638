"""What can be proved about a word between two values of a: whether it is an orbit there, or is born or dies.

At the middle of a cell in x = ln a, the directions are found in double precision. Their first and second
derivatives in x limit how the maximum of the length moves in the cell. Such bounds can prove that, in the
entire cell, a word is an orbit throughout, or nowhere, or that all slacks that could vanish increase (the
word can be born once and cannot die) or decrease. With A = -H,

    A alpha'  = -2 a sin(alpha),
    A alpha'' = -2 a sin(alpha) - 4 a cos(alpha) alpha' - dD/dalpha alpha'^2 -+ ...,

where the dots stand for a term cos(h) (alpha_in' + alpha')^2 / 4 k^2 for each of the two runs beside a leg.
The absolute values of a solution of A u = b are at most v max(|b_i| / q_i), for any v > 0 with

    q_i = D_i v_i + w_i (v_i - v_{i-1}) + w_{i+1} (v_i - v_{i+1}) > 0,

where D and w are the curvatures of leg and run: consider the row with the largest |u_i| / v_i. With D, w and
b at their worst in the cell, this bounds alpha' and alpha'' at all its points. The bound on alpha' also holds
where directions are pressed against limits, because the argument about the largest row applies to the maximum
on a box too. By this bound and continuity, the directions stay in the range over which the worst values were
taken. Any v > 0 will do, so the rounding of v does not matter.

Bounds are widened by 1e-10 and by a relative 1e-9, far more than the rounding of sums and products. Solutions
may have larger rounding errors. They are therefore inserted into their equations, and the residuals are
included in the bounds.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.legs import (
    Chain,
    derivatives,
    direction_limits,
    following,
    half_turns,
    preceding,
    slack_changes,
    slack_errors,
    smooth_slacks,
)
from orbitdb.billiard.stability import solve_cyclic
from orbitdb.billiard.stadium import HALF_PI
from orbitdb.orbits.along_a import motion
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.newton import minus_hessian, newton

ROUNDING = 1e-10
WIDER = 1 + 1e-9


class Reach(NamedTuple):
    """Bounds that hold at all points of a cell, each of shape (m, N)."""

    between_centres: Floats  # lower bound on D
    stiff: Floats  # upper bound on w
    soft: Floats  # lower bound on w
    lean: Floats  # upper bound on |dD/dalpha|
    pull: Floats  # upper bound on 2 a |sin alpha|
    drag: Floats  # upper bound on 2 a cos alpha
    bend: Floats  # upper bound on |dw/d(alpha_in + alpha_out)|


def reach_of(legs: Chain, a: Floats, r: Floats, alpha: Floats, room: Floats) -> Reach:
    """Bound curvatures and forces for directions within `room` of alpha and x within r of ln a."""
    low, high = a * np.exp(-r), a * np.exp(r)
    size = np.abs(alpha)
    least, most = np.maximum(size - room, 0.0), np.minimum(size + room, HALF_PI)
    lift = np.abs(legs.lift)
    half, spread = half_turns(legs, alpha), (preceding(room) + room) / (2 * legs.k)
    under, over = np.maximum(half - spread, 0.0), np.minimum(half + spread, np.pi / legs.k)
    sines = np.sin(under), np.sin(over)
    stiff = np.where((under < HALF_PI) & (over > HALF_PI), 1.0, np.maximum(*sines))
    bend = np.maximum(np.abs(np.cos(under)), np.abs(np.cos(over))) / (4 * legs.k**2)
    pull, drag = 2 * high * np.sin(most), 2 * high * np.cos(least)
    return Reach(
        between_centres=(2 * low * np.cos(most) + lift * np.sin(least)) / WIDER,
        stiff=stiff * WIDER / (2 * legs.k),
        soft=np.minimum(*sines) / WIDER / (2 * legs.k),
        lean=np.maximum(lift * np.cos(least), pull) * WIDER,
        pull=pull * WIDER,
        drag=drag * WIDER,
        bend=bend * WIDER,
    )


def firmness(reach: Reach, v: Floats) -> Floats:
    """Return lower bounds on the q_i (see the docstring of this module), slightly reduced for rounding."""
    behind, ahead = v - preceding(v), v - following(v)
    stiff, soft = reach.stiff, reach.soft
    held = reach.between_centres * v
    held = held + np.where(behind > 0, soft, stiff) * behind
    held = held + np.where(ahead > 0, following(soft), following(stiff)) * ahead
    return held - ROUNDING * (reach.between_centres + stiff + following(stiff)) * v


def displaced(reach: Reach, velocity: Floats, off: Floats) -> Floats:
    """Bound the change of the equations of the velocity, caused by an error `off` of the directions."""
    kicks = reach.bend * (preceding(off) + off) * (preceding(velocity) + velocity)
    return reach.drag * off + reach.lean * off * velocity + kicks + following(kicks)


def forcing(reach: Reach, speed: Floats) -> Floats:
    """Bound the right-hand side of the equations of the second derivative, given a bound on the first."""
    kicks = reach.bend * (preceding(speed) + speed) ** 2
    return reach.pull + 2 * reach.drag * speed + reach.lean * speed**2 + kicks + following(kicks)


_TERMS = 1e-13
"""Rounding error of a sum of terms of A x = b, relative to the size of its terms."""

_EDGE = 1e-14
"""Rounding error of ln a, by which cells are widened."""

_BEYOND_LIMITS = 12
_SHARE, _LEAST = 0.1, 0.01
_ROOM = 1.25
"""A cell is given up if its directions may move farther than this factor times the expected motion."""


class Kind(IntEnum):
    """What is proved about a word in a cell."""

    OPEN = 0
    ALIVE = 1
    DEAD = 2
    RISING = 3
    FALLING = 4


def kinds_in_cells(
    legs: Chain, x: Floats, radius: Floats, start: Floats
) -> tuple[NDArray[np.int8], Floats, Floats]:
    """Return what is proved about each of N words in its cell.

    Parameters
    ----------
    x, radius : ndarray, shape (N,)
        Middle and half width of each cell in ln a.
    start : ndarray, shape (m, N)
        Directions to start from (radians).

    Returns
    -------
    kind : ndarray of int8, shape (N,)
        Values of `Kind`.
    alpha, velocity : ndarray, shape (m, N)
        The directions in the middle of the cell, and d alpha/dx there if no direction is pressed.
    """
    a, r = np.exp(x), radius + _EDGE
    near, far = direction_limits(legs, a * np.exp(-r)), direction_limits(legs, a * np.exp(r))
    box = np.minimum(near[0], far[0]), np.maximum(near[1], far[1])  # for an orbit anywhere in the cell
    middle = _middle(legs, a, start, box)
    return _kinds(legs, r, middle, _bounded(legs, a, r, box, middle)), middle.alpha, middle.velocity


class _Middle(NamedTuple):
    """State of N words at the middle of their cells, as arrays of shape (m, N)."""

    alpha: Floats
    off: Floats  # bound on the distance of the maximum from alpha
    velocity: Floats  # d alpha/dx if no direction is pressed
    left_over: Floats  # bound on the residual of the equations of the velocity
    v: Floats  # positive vectors for the bounds on the first derivative
    u: Floats  # positive vectors for the bounds on the second derivative


class _Bounds(NamedTuple):
    """Bounds on the motion of the maximum in a cell."""

    sound: Marks  # whether the bounds hold, shape (N,)
    free: Marks  # whether no direction is pressed anywhere in the cell
    speed: Floats  # bound on the first derivative of the directions in x, shape (m, N)
    second: Floats  # bound on the second derivative, if free
    wrong: Floats  # bound on the error of the velocity in the middle, if free


def _middle(legs: Chain, a: Floats, start: Floats, box: tuple[Floats, Floats]) -> _Middle:
    alpha = _maximum(legs, a, start, box)
    slopes = derivatives(legs, a, alpha)
    off = direction_errors(legs, a, alpha, slopes, box)
    pull = 2 * a * np.sin(alpha)
    diagonal, beside = minus_hessian(legs, slopes, np.zeros(alpha.shape, np.bool_))
    velocity = solve_cyclic(diagonal, beside, -pull[None])[0]
    turning = preceding(legs.parity * velocity) + velocity
    kicks = np.abs(np.cos(half_turns(legs, alpha)) / (4 * legs.k**2)) * turning**2
    forcing = np.abs(pull) + 4 * a * np.cos(alpha) * np.abs(velocity) + np.abs(slopes.own_term) * velocity**2
    forcing += kicks + following(kicks)
    # room in every row for changes within a cell
    rhs = np.stack([
        forces + _SHARE * forces.max(axis=0) + _LEAST * slopes.between_centres
        for forces in (np.abs(pull), forcing)
    ])  # fmt: skip
    v, u = solve_cyclic(diagonal, -np.abs(beside), rhs)
    residual = (
        diagonal * velocity + beside * preceding(velocity) + following(beside) * following(velocity) + pull
    )
    size = np.abs(velocity)
    neighbours = size + preceding(size) + following(size)
    rounding = _TERMS * (2 * a + np.abs(legs.lift) + 3) * (1 + neighbours)
    return _Middle(alpha, off, velocity, np.abs(residual) + rounding, v, u)


def _bounded(legs: Chain, a: Floats, r: Floats, box: tuple[Floats, Floats], middle: _Middle) -> _Bounds:
    """Bound the motion of the maximum in each cell."""
    alpha, off, velocity = middle.alpha, middle.off, np.abs(middle.velocity)
    room = _ROOM * middle.v * r + 4 * off
    reach = reach_of(legs, a, r, alpha, room)
    q_v, q_u = firmness(reach, middle.v), firmness(reach, middle.u)
    speed = middle.v * _largest(reach.pull / q_v)
    sound: Marks = np.all((q_v > 0) & (q_u > 0) & (off + speed * r < room), axis=0)
    free: Marks = sound & np.all((alpha - room > box[0]) & (alpha + room < box[1]), axis=0)
    unsolved = displaced(reach, velocity, off) + middle.left_over
    wrong = middle.u * _largest(unsolved / q_u) + ROUNDING * (1 + velocity)
    second = middle.u * _largest(forcing(reach, speed) / q_u)
    for _ in range(2):
        along = np.minimum(speed, velocity + wrong + r * second)
        second = np.minimum(second, middle.u * _largest(forcing(reach, along) / q_u))
    return _Bounds(sound, free, speed, second, wrong)


def _kinds(legs: Chain, r: Floats, middle: _Middle, bounds: _Bounds) -> NDArray[np.int8]:
    """Return the `Kind` of each cell, which follows from the possible behaviour of its slacks."""
    slack, slope = smooth_slacks(legs, middle.alpha), slack_changes(legs, middle.velocity)
    moved = _spread(legs, middle.off + bounds.speed * r) + ROUNDING
    loose, bent = _spread(legs, bounds.wrong), _spread(legs, bounds.second)
    away = _spread(legs, middle.off) + (np.abs(slope) + loose) * r + bent * r**2 / 2 + ROUNDING
    touched = (slack - np.minimum(moved, away) <= 0) & np.isfinite(slack)
    play = (loose + bent * r) * WIDER + ROUNDING
    rising = (~touched | (slope - play > 0)).all(axis=(0, 1))
    falling = (~touched | (slope + play < 0)).all(axis=(0, 1))
    dead = (slack + moved < 0).any(axis=(0, 1)) | (bounds.free & (slack + away < 0).any(axis=(0, 1)))
    alive = ~touched.any(axis=(0, 1))
    return np.select(
        [~bounds.sound, dead, bounds.free & alive, bounds.free & rising, bounds.free & falling],
        [Kind.OPEN, Kind.DEAD, Kind.ALIVE, Kind.RISING, Kind.FALLING],
        Kind.OPEN,
    ).astype(np.int8)


def _maximum(legs: Chain, a: Floats, start: Floats, box: tuple[Floats, Floats]) -> Floats:
    """Return directions near the maximum within `box`, whose limits are wider than those at a."""
    limits = direction_limits(legs, a)
    alpha = newton(legs, a, start=np.clip(start, *limits)).alpha
    held = np.flatnonzero(((alpha <= limits[0]) | (alpha >= limits[1])).any(axis=0))
    if len(held):
        part, moved = legs.chain(held), alpha.take(held, axis=1)
        low, high = (limit.take(held, axis=1) for limit in box)
        for _ in range(_BEYOND_LIMITS):
            moved = np.clip(moved + motion(part, a[held], moved, (low, high))[0], low, high)
        alpha[:, held] = moved
    return alpha


def _largest(values: Floats) -> Floats:
    """Return the largest value of each word, rounded up, shape (N,); infinite if a value is not finite."""
    return np.where(np.isfinite(values), values, np.inf).max(axis=0) * WIDER


def _spread(legs: Chain, bound: Floats) -> Floats:
    """Bound the change of the smooth slacks, shape (6, m, N), given bounds on that of the directions."""
    return slack_errors(legs, bound)[[0, 0, 1, 1, 2, 3]] * WIDER
