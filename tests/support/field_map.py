"""The billiard in a magnetic field as a map from bounce to bounce, found by intersecting circles.

It shares no formula with the package: an arc is followed from its centre to the first point at which it meets
the boundary. It is the reference for words, statuses and stability of orbits in a field.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Sides = NDArray[np.int64]

BOTTOM, LEFT, TOP, RIGHT = range(4)
_TURN = 2 * np.pi
_LEAST = 1e-9
"""An angle at the centre below this is the start of an arc, not its end."""


class State(NamedTuple):
    """Where N particles have just bounced, and where they go, each of shape (N,)."""

    x: Floats
    y: Floats
    angle: Floats  # of the direction in which it leaves, from the x axis
    side: Sides  # BOTTOM, LEFT, TOP or RIGHT

    def mapped(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> "State":
        """Return the same bounces after a change of each array, such as a new shape."""
        return State(change(self.x), change(self.y), change(self.angle), change(self.side))


def start_at(a: float, arclength: Floats, sine: Floats) -> State:
    """Return particles on the boundary, anticlockwise from the bottom wall's left end.

    ``sine`` is that of the angle from the inward normal to the direction, positive anticlockwise.
    """
    s = arclength % (4 * a + _TURN)
    ends = np.cumsum([2 * a, np.pi, 2 * a])
    side = np.array([BOTTOM, RIGHT, TOP, LEFT])[np.searchsorted(ends, s, side="right")]
    right, left = s - 2 * a - np.pi / 2, s - 4 * a - np.pi - np.pi / 2
    x = np.select(
        [side == BOTTOM, side == TOP, side == RIGHT],
        [s - a, a - (s - 2 * a - np.pi), a + np.cos(right)],
        -a - np.cos(left),
    )
    y = np.select([side == BOTTOM, side == TOP, side == RIGHT], [-1.0, 1.0, np.sin(right)], -np.sin(left))
    return State(x, y, inward(a, x, y, side) - np.arcsin(sine), side)


def inward(a: float, x: Floats, y: Floats, side: Sides) -> Floats:
    """Return the angle of the inward normal."""
    of_right, of_left = np.arctan2(-y, a - x), np.arctan2(-y, -a - x)
    return np.select([side == BOTTOM, side == TOP, side == RIGHT], [np.pi / 2, -np.pi / 2, of_right], of_left)


def arclength_of(a: float, state: State) -> Floats:
    """Return the arc length, as `start_at` reads it."""
    right = np.arctan2(state.y, state.x - a)
    left = np.arctan2(-state.y, -(state.x + a))
    cases = [state.side == BOTTOM, state.side == TOP, state.side == RIGHT]
    return np.select(
        cases,
        [state.x + a, 3 * a + np.pi - state.x, 2 * a + np.pi / 2 + right],
        4 * a + 1.5 * np.pi + left,
    )


def sine_of(a: float, state: State) -> Floats:
    """Return the sine of the angle from the inward normal, positive anticlockwise."""
    return np.sin(inward(a, state.x, state.y, state.side) - state.angle)


def next_bounce(a: float, kappa: float, state: State) -> State:
    """Follow every particle along its circle (kappa != 0) to the next bounce, and reflect it there."""
    radius, way = 1 / abs(kappa), np.sign(kappa)
    centre_x = state.x - way * radius * np.sin(state.angle)
    centre_y = state.y + way * radius * np.cos(state.angle)
    begin = np.arctan2(state.y - centre_y, state.x - centre_x)
    best, side = np.full(len(state.x), np.inf), np.zeros(len(state.x), np.int64)
    for wall, height in ((BOTTOM, -1.0), (TOP, 1.0)):
        across = (height - centre_y) / radius
        with np.errstate(invalid="ignore"):
            lean = np.arcsin(across)  # NaN if the circle does not reach the wall
        for place in (lean, np.pi - lean):
            turn = way * (place - begin) % _TURN
            on_wall = np.abs(centre_x + radius * np.cos(place)) <= a
            closer = on_wall & (turn > _LEAST) & (turn < best)
            best, side = np.where(closer, turn, best), np.where(closer, wall, side)
    for wall, end in ((LEFT, -a), (RIGHT, a)):
        away_x = end - centre_x
        distance = np.hypot(away_x, centre_y)
        middle = np.arctan2(-centre_y, away_x)
        with np.errstate(invalid="ignore"):
            half = np.arccos((radius**2 + distance**2 - 1) / (2 * radius * distance))
        for place in (middle - half, middle + half):
            turn = way * (place - begin) % _TURN
            beyond = (centre_x + radius * np.cos(place) - end) * np.sign(end) >= 0
            closer = beyond & (turn > _LEAST) & (turn < best)
            best, side = np.where(closer, turn, best), np.where(closer, wall, side)
    place = begin + way * best
    x, y = centre_x + radius * np.cos(place), centre_y + radius * np.sin(place)
    arriving = state.angle + way * best
    return State(x, y, 2 * inward(a, x, y, side) - arriving + np.pi, side)


def trajectories(a: float, kappa: float, starts: State, bounces: int) -> State:
    """Return successive bounces of every particle, each of shape (bounces, N)."""
    path = [starts]
    while len(path) < bounces:
        path.append(next_bounce(a, kappa, path[-1]))
    return State(*map(np.stack, zip(*path, strict=True)))


def symbols_of(path: State, cyclic: bool = False) -> NDArray[np.uint8]:
    """Return the symbols of bounces, shape (T, N), or of all but the first and the last if not cyclic."""
    same = (path.side == np.roll(path.side, 1, axis=0)) & np.isin(path.side, (LEFT, RIGHT))
    falls = same & (path.y < np.roll(path.y, 1, axis=0))  # since the bounce before
    down = falls | np.roll(falls, -1, axis=0)
    symbols = np.where(down, np.array([0, 4, 2, 5])[path.side], path.side).astype(np.uint8)
    return symbols if cyclic else symbols[1:-1]
