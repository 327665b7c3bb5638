"""Words cut into runs and legs, and the length of their orbits as a function of leg directions.

An admissible word alternates between *runs* of bounces on the left and right semicircle, joined by
*legs* over n >= 0 straight bounces. Unfold every leg at the walls it hits: it becomes one straight
line, and its direction alpha at the start (the slope, seen towards the other side) fixes where the
runs at both its ends lie, for a circle of radius 1 is touched at equal angles. Take the directions of
the m legs as unknowns, with

    L(alpha) = sum over legs  2 a cos(alpha) + 2 n s sin(alpha)
             + sum over runs  2 k sin(psi / 2k),     psi = pi - d (alpha_in + alpha_out),

where s = -1, +1 is the first wall of the leg (bottom, top), k the number of bounces of the run and
d = +1, -1 its sense (up, down). A stationary point of L is an orbit on the continued walls, and its
value there is the length.

Every leg term has the curvature -D, D = 2 a cos(alpha) + 2 n s sin(alpha) the part of the leg beyond
the feet of the two circle centres, and every run term the curvature -sin(psi/2k)/2k in its sum of
directions. Between the directions that an orbit can have (`direction_limits`) all these are negative:
L is strictly concave, an orbit is its one maximum, and no word has two orbits. The condition that
every bounce lies on its own wall or semicircle is linear in alpha (`slacks`).

All arrays of legs and runs have shape (m, N): unknowns first, words along the second axis.
Run i precedes leg i; run 0 is on the left.
"""

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.stadium import HALF_PI, STRAIGHT

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

_WIDER = 1.0625
_DOWNWARD = np.array([False, False, False, False, True, True])
_LEFT = np.array([False, True, False, False, True, False])


@dataclass(frozen=True)
class Legs:
    """N admissible words of order p with m runs and m legs each.

    Attributes
    ----------
    k, d : ndarray, shape (m, N)
        Number of bounces and sense (+1 up, -1 down) of each run.
    n, s : ndarray, shape (m, N)
        Number of straight bounces of each leg, and the first wall (-1 bottom, +1 top, 0 none).
    run : ndarray of intp, shape (p, N)
        The run, or the leg, that each bounce of the word belongs to.
    place : ndarray, shape (p, N)
        The bounce's place in it, from 0.
    straight : ndarray of bool, shape (p, N)
        Whether the bounce is on a straight wall.
    """

    k: Floats
    d: Floats
    n: Floats
    s: Floats
    run: NDArray[np.intp]
    place: Floats
    straight: NDArray[np.bool_]

    @cached_property
    def parity(self) -> Floats:
        """(-1)^n of each leg, shape (m, N)."""
        return 1.0 - 2.0 * (self.n % 2)

    def __len__(self) -> int:
        return self.k.shape[1]

    def chosen(self, words: NDArray[np.intp] | NDArray[np.bool_]) -> "Legs":
        """Return the same structure for some of the words."""
        return Legs(**{field.name: getattr(self, field.name)[:, words] for field in fields(self)})


def cut(words: NDArray[np.uint8]) -> list[tuple[NDArray[np.intp], Legs]]:
    """Cut admissible words into runs and legs.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words, in any rotation.

    Returns
    -------
    list of (ndarray of intp, Legs)
        One entry for each number of runs: the rows of ``words`` it holds, and their structure.
    """
    symbols = words.T
    left = _LEFT[symbols]
    origin = (left & ~np.roll(left, 1, axis=0)).argmax(axis=0)
    steps = np.arange(len(symbols))[:, None]
    symbols = np.take_along_axis(symbols, (steps + origin) % len(symbols), axis=0)
    straight, left = STRAIGHT[symbols], _LEFT[symbols]
    run_starts = ~straight & (np.roll(straight, 1, axis=0) | (left != np.roll(left, 1, axis=0)))
    leg_starts = straight & ~np.roll(straight, 1, axis=0)
    run = run_starts.cumsum(axis=0) - 1
    place = steps - np.maximum.accumulate(np.where(run_starts | leg_starts, steps, 0), axis=0)
    downward = run_starts & _DOWNWARD[symbols]
    first_wall = leg_starts * (symbols - 1.0)
    back = (steps - origin) % len(symbols)

    groups = []
    for m in np.unique(run[-1]) + 1:
        rows = np.flatnonzero(run[-1] + 1 == m)
        cell = run[:, rows] * len(rows) + np.arange(len(rows))

        def total(values: NDArray[Any], m: int = m, rows: Rows = rows, cell: Rows = cell) -> Floats:
            sums = np.bincount(cell.ravel(), values[:, rows].ravel(), minlength=m * len(rows))
            return sums.reshape(m, -1).astype(float)

        turned = (back[:, rows], rows)
        legs = Legs(
            k=total(~straight),
            d=1.0 - 2.0 * total(downward),
            n=total(straight),
            s=total(first_wall),
            run=run[turned],
            place=place[turned].astype(float),
            straight=straight[turned],
        )
        groups.append((rows, legs))
    return groups


def direction_limits(legs: Legs, a: float) -> tuple[Floats, Floats]:
    """Return directions, shape (m, N) each, below and above all that a leg of an orbit can have.

    A leg spans 2 a <= dx <= 2 a + 2 and 2 n - 2 <= s dy <= 2 n + 2; without a wall, -2 <= dy <= 2.
    The limits are a little wider, so that orbits through two joints do not lie on them, and keep to
    where the curvature D of the leg's term is positive.
    """
    steep = np.arctan((legs.n + _WIDER) / a)
    flat = np.arctan(np.maximum(legs.n - _WIDER, 0) / (a + 1))
    no_wall = legs.n == 0
    low = np.where(no_wall | (legs.s < 0), -steep, flat)
    return low, np.where(no_wall | (legs.s > 0), steep, -flat)


def centre_directions(legs: Legs, a: float) -> Floats:
    """Return the directions of the lines between the unfolded circle centres, shape (m, N)."""
    return np.arctan(legs.n * legs.s / a)


@dataclass(frozen=True)
class Turns:
    """What the directions of the legs say of the runs, all of shape (m, N).

    Attributes
    ----------
    incoming, outgoing : ndarray
        Slope of the leg before the run at its end, and of the leg behind it at its start (radians).
    half : ndarray
        psi / 2k, half the turn at every bounce; also the angle between path and tangent.
    """

    incoming: Floats
    outgoing: Floats
    half: Floats


def turns(legs: Legs, alpha: Floats) -> Turns:
    """Return the turns of the runs between legs of directions alpha, shape (m, N)."""
    incoming = np.roll(legs.parity * alpha, 1, axis=0)
    half = (np.pi - legs.d * (incoming + alpha)) / (2 * legs.k)
    return Turns(incoming, alpha, half)


def length(legs: Legs, a: float, alpha: Floats) -> Floats:
    """Return L(alpha) of each word, shape (N,).

    NumPy adds in pairs only along contiguous rows, and a long word needs that (`summation_rounding`).
    """
    half = turns(legs, alpha).half
    terms = 2 * a * np.cos(alpha) + 2 * legs.n * legs.s * np.sin(alpha) + 2 * legs.k * np.sin(half)
    total: Floats = np.ascontiguousarray(terms.T).sum(axis=1)
    return total


def summation_rounding(m: int) -> float:
    """Bound the relative rounding error of NumPy's sum over m contiguous positive terms.

    Blocks of 128 terms go to 8 partial sums, the blocks are added in pairs.
    """
    return min(m, 20 + math.log2(m)) * float(np.finfo(float).eps) / 2


@dataclass(frozen=True)
class Derivatives:
    """First and second derivatives of L at some directions, all of shape (m, N).

    Attributes
    ----------
    gradient : ndarray
        dL/dalpha: the offset, across the leg, of the points that its ends should meet.
    lean : ndarray
        The part of the gradient that is the leg's own term; also dD/dalpha.
    beyond : ndarray
        D, minus the curvature of each leg's own term: its length beyond the feet of the centres.
    stiffness : ndarray
        sin(psi/2k) / 2k, minus the curvature of each run's term in alpha_in + alpha_out.
    """

    gradient: Floats
    lean: Floats
    beyond: Floats
    stiffness: Floats


def derivatives(legs: Legs, a: float, alpha: Floats) -> Derivatives:
    """Return the derivatives of L at directions alpha, shape (m, N)."""
    half = turns(legs, alpha).half
    across, along = np.sin(alpha), np.cos(alpha)
    lift = 2 * legs.n * legs.s
    pull = -legs.d * np.cos(half)
    lean = lift * along - 2 * a * across
    gradient = lean + pull + legs.parity * np.roll(pull, -1, axis=0)
    return Derivatives(gradient, lean, 2 * a * along + lift * across, np.sin(half) / (2 * legs.k))


def gradient_rounding(legs: Legs, a: float, alpha: Floats) -> Floats:
    """Bound the rounding error of the gradient in doubles, shape (m, N).

    Products and sines are good to two units in the last place and every sum adds one; psi carries
    the rounding of pi and of two sums of size pi.
    """
    terms = 2 * a * np.abs(np.sin(alpha)) + 2 * legs.n * np.cos(alpha)
    run = 2 + 2 * np.pi / legs.k
    return np.finfo(float).eps * (3 * terms + run + np.roll(run, -1, axis=0))


def end_angles(legs: Legs, alpha: Floats) -> tuple[Floats, Floats]:
    """Return the angles of the first and the last bounce of each run, shape (m, N) each."""
    turn = turns(legs, alpha)
    middle = (turn.incoming - turn.outgoing) / 2
    spread = legs.d * turn.half * (legs.k - 1)
    return middle - spread, middle + spread


def slacks(legs: Legs, alpha: Floats) -> Floats:
    """Return by how much, in radians, each end of run and leg keeps to its wall or semicircle.

    Parameters
    ----------
    legs : Legs
    alpha : ndarray, shape (m, N)

    Returns
    -------
    ndarray, shape (4, m, N)
        For each run, pi/2 - |t| of its first and last bounce; for each leg, pi/2 - s t - 2 |alpha|
        at its start and, seen backwards, at its end: with t the last bounce on the semicircle, the
        angle from the joint to the bounce that would follow if the semicircle went on. Infinite for
        a leg without walls. All are positive for an orbit; an orbit through a joint has a zero.
    """
    first, last = end_angles(legs, alpha)
    steep = HALF_PI - 2 * legs.s * alpha
    ahead = -legs.s * legs.parity * np.roll(first, -1, axis=0)
    walled = legs.n > 0
    return np.stack([
        HALF_PI - np.abs(first),
        HALF_PI - np.abs(last),
        np.where(walled, steep - legs.s * last, np.inf),
        np.where(walled, steep - ahead, np.inf),
    ])  # fmt: skip


def slack_errors(legs: Legs, alpha_error: Floats) -> Floats:
    """Bound the errors of `slacks`, given those of the directions, shape (m, N).

    An end of a run moves by 1/2k of one neighbour's change and 1 - 1/2k of the other's.
    """
    incoming = np.roll(alpha_error, 1, axis=0)
    near, far = 1 / (2 * legs.k), 1 - 1 / (2 * legs.k)
    rounding = 8 * np.finfo(float).eps * np.pi
    first = far * incoming + near * alpha_error + rounding
    last = near * incoming + far * alpha_error + rounding
    tilt = 2 * alpha_error
    return np.stack([first, last, last + tilt, np.roll(first, -1, axis=0) + tilt])


def margin_distances(legs: Legs, alpha: Floats, slack: Floats) -> Floats:
    """Return the slacks in coordinate units, shape (4, m, N): radians on a semicircle, x on a wall.

    The first bounce of a leg lies 2 cos(pi/4 + s t/2) sin(slack/2) / sin|alpha| from the joint.
    """
    first, last = end_angles(legs, alpha)
    ahead = -legs.s * legs.parity * np.roll(first, -1, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        widths = [np.cos(HALF_PI / 2 + t / 2) / np.sin(np.abs(alpha)) for t in (legs.s * last, ahead)]
        walls = [
            np.where(legs.n > 0, 2 * w * np.sin(v / 2), np.inf)
            for w, v in zip(widths, slack[2:], strict=True)
        ]
    return np.stack([slack[0], slack[1], *walls])


def coordinates(legs: Legs, a: float, alpha: Floats) -> Floats:
    """Return the coordinates of all bounces in the order of the words, shape (N, p)."""
    columns = np.arange(len(legs))
    first, last = end_angles(legs, alpha)
    step = 2 * legs.d * turns(legs, alpha).half
    ahead = np.roll(first, -1, axis=0)
    start_y, end_y = np.sin(last), legs.parity * np.sin(ahead) + 2 * legs.n * legs.s
    across = 2 * a + np.cos(last) + np.cos(ahead)
    slope = across / np.where(legs.n > 0, end_y - start_y, 1.0)
    side = 1.0 - 2.0 * (np.arange(len(legs.k)) % 2)
    here = (legs.run, columns)
    height = legs.s[here] * (2 * legs.place + 1) - start_y[here]
    wall = side[legs.run] * (height * slope[here] - np.cos(last)[here] - a)
    angle = first[here] + legs.place * step[here]
    found: Floats = np.where(legs.straight, wall, angle).T
    return np.ascontiguousarray(found)
