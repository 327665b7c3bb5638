"""Proof that no birth or death of a word is missing between two values of a.

This is a second method, which shares only the equations with `orbitdb.orbits.births`. Instead of searching
for zeros, it cuts x = ln a into cells in which a word can be born at most once, or die at most once, or
neither, and counts. The bounds hold at every a in a cell.

At the middle of a cell, the directions are found in double precision. Their first and second derivatives in
x limit how the maximum of the length moves in the cell. Such bounds can prove that, in the entire cell, a
word is an orbit throughout, or nowhere, or that all slacks that could vanish increase (the word can be born
once and cannot die) or decrease. With A = -H,

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

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Indices, Marks, Words
from orbitdb.billiard.legs import (
    Chain,
    centre_directions,
    cut,
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
from orbitdb.orbits.births import signs
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


LOW, HIGH = 0.02, 1000.0
"""Range of a in which a proof is attempted."""


Segment = tuple[int, float, float]
"""A value of `Kind`, and the two ends of the range of ln a in which it holds."""

KnownChange = tuple[float, float, bool]
"""The two ends of a bracket in ln a, and whether the word is born there."""

_CONSTANT: dict[int, bool] = {Kind.ALIVE: True, Kind.DEAD: False}
"""Whether a word is an orbit in cells in which that does not change."""

_FIRST, _HALVINGS, _MOST = 0.07, 24, 1500
"""Radius of the first cells in ln a, most halvings of a cell, and most undecided cells of a word at a time.

As a goes to 0, some slacks behave like a^5. Cells would have to be as small as a^(5/2) there, so they are
left undecided.
"""


class Completeness(IntEnum):
    """What is proved about the known births and deaths of a word."""

    WRONG = -1
    UNDECIDED = 0
    PROVED = 1


def prove_all(words: Words, changes: Sequence[Sequence[KnownChange]]) -> NDArray[np.int8]:
    """Tell whether the known changes of words are complete between `LOW` and `HIGH`.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible primitive words of the same period.
    changes : sequence of sequence of KnownChange
        The changes of each word, by ascending a.

    Returns
    -------
    ndarray of int8, shape (N,)
        Values of `Completeness`.
    """
    proved = np.zeros(len(words), np.int8)
    for rows, legs in cut(words):
        first = signs(words[rows], legs, np.full(len(rows), LOW), newton(legs, LOW).alpha)
        word, kind, low, high = stretches(legs, float(np.log(LOW)), float(np.log(HIGH)))
        ends = np.searchsorted(word, np.arange(len(rows) + 1)).tolist()
        segments = list(zip(kind.tolist(), low.tolist(), high.tolist(), strict=True))
        for row, sign, start, end in zip(rows.tolist(), first.tolist(), ends, ends[1:], strict=False):
            state = None if sign == 0 else sign > 0
            proved[row] = walk(segments[start:end], changes[row], state)
    return proved


def stretches(legs: Chain, low: float, high: float) -> tuple[Indices, NDArray[np.int8], Floats, Floats]:
    """Cut [low, high] in ln a, for each word, into cells in which something is proved about it, if possible.

    Returns
    -------
    word, kind, low, high : ndarray, shape (K,)
        Ranges sorted by word and ascending a: the index of the word, the value of `Kind`, and the two ends in
        ln a.
    """
    count = int(np.ceil((high - low) / (2 * _FIRST)))
    x = np.tile(low + (np.arange(count) + 0.5) * (high - low) / count, len(legs))
    word, r = np.repeat(np.arange(len(legs)), count), np.full(len(x), (high - low) / (2 * count))
    start = centre_directions(legs.chain(word), np.exp(x))
    finished = []
    for halved in range(_HALVINGS + 1):
        kind, alpha, velocity = kinds_in_cells(legs.chain(word), x, r, start)
        many = np.bincount(word, kind == Kind.OPEN, minlength=len(legs)) > _MOST
        done = (kind != Kind.OPEN) | many[word] | (halved == _HALVINGS)
        finished.append((word[done], x[done] - r[done], x[done] + r[done], kind[done]))
        left = np.flatnonzero(~done)
        if not len(left):
            break
        r = r[left] / 2
        shift, middle = np.clip(velocity.take(left, axis=1), -1, 1) * r, alpha.take(left, axis=1)
        start = np.concatenate([middle - shift, middle + shift], axis=1)
        word, x, r = np.tile(word[left], 2), np.concatenate([x[left] - r, x[left] + r]), np.tile(r, 2)
    word, begin, end, kind = map(np.concatenate, zip(*finished, strict=True))
    order = np.lexsort((begin, word))
    word, begin, end, kind = word[order], begin[order], end[order], kind[order]
    fresh = np.ones(len(word), bool)
    fresh[1:] = (word[1:] != word[:-1]) | (kind[1:] != kind[:-1])  # neighbours of the same kind are joined
    first = np.flatnonzero(fresh)
    return word[first], kind[first], begin[first], end[np.append(first[1:], len(word)) - 1]


def walk(segments: Sequence[Segment], changes: Sequence[KnownChange], alive: bool | None) -> Completeness:
    """Tell whether the known changes are all the changes that the segments allow.

    The segments, which are adjacent, and the changes are sorted by ascending a; changes outside the segments
    are ignored. `alive` tells whether the word is an orbit where the segments begin; None means unknown.
    """
    begin, end = segments[0][1], segments[-1][2]
    word = _Walk([change for change in changes if begin < (change[0] + change[1]) / 2 < end], alive)
    following = [kind for kind, *_ in segments[1:]] + [Kind.OPEN]
    for (kind, _, high), after in zip(segments, following, strict=True):
        if kind == Kind.OPEN:
            possible = word.pass_open(high)
        elif kind in _CONSTANT:
            possible = word.pass_constant(_CONSTANT[kind], high)
        else:
            possible = word.pass_moving(kind == Kind.RISING, _CONSTANT.get(after), high)
        if not possible:
            return Completeness.WRONG
    return Completeness.PROVED if word.sure and not word.ahead else Completeness.UNDECIDED


class _Walk:
    """A word that passes segment after segment as a grows.

    Attributes
    ----------
    ahead : list of KnownChange
        The known changes that are still to come.
    alive : bool or None
        Whether the word is an orbit here; None if that is unknown.
    sure : bool
        Whether no further change was possible so far.

    Notes
    -----
    Each method passes a segment that ends at `high`, and returns False if it contradicts the known changes.
    """

    def __init__(self, changes: list[KnownChange], alive: bool | None) -> None:
        self.ahead, self.alive, self.sure = changes, alive, True

    def pass_constant(self, alive: bool, high: float) -> bool:
        """Pass a segment in which the word is an orbit throughout, or is none throughout."""
        changes_inside = bool(self.ahead) and self.ahead[0][1] < high
        possible = self.alive is not (not alive) and not changes_inside
        self.alive = alive
        return possible

    def pass_moving(self, rising: bool, after: bool | None, high: float) -> bool:
        """Pass a segment in which the word can only be born, if `rising`, or can only die.

        `after` tells whether it is an orbit in the next segment; None means unknown.
        """
        inside = self._reach(high)
        if len(inside) > 1 or any(born != rising for *_, born in inside):
            return False
        if inside:
            possible, self.alive = self.alive is not rising, rising
            return possible
        if self.alive is rising:
            return True
        unknown, self.alive = self.alive is None, after
        if after is not (not rising):  # it may have changed here, though no change is known
            self.sure = False
        return unknown or after is not rising

    def pass_open(self, high: float) -> bool:
        """Pass a segment in which nothing is proved."""
        self._reach(high)
        self.alive, self.sure = None, False
        return True

    def _reach(self, high: float) -> list[KnownChange]:
        """Go on to the end of a segment, and return the changes that begin before it."""
        inside = [change for change in self.ahead if change[0] <= high]
        self.ahead = self.ahead[len(inside) :]
        return inside
