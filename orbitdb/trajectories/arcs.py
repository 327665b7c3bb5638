"""Trajectories from one bounce on a semicircle to the next.

Unfold the stadium at its walls: a path that leaves a semicircle for the other one is a straight line,
and the copy of the strip it is in when it reaches the other circle says how many walls it has hit. So
the thousands of bounces of a path that runs up and down between the walls cost no more than one, and no
rounding adds up in them. All is vectorised over trajectories.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import HALF_PI

Floats = NDArray[np.float64]

_TINY = 1e-150


class Arcs(NamedTuple):
    """N trajectories just behind a bounce on a semicircle; all arrays of shape (N,)."""

    side: Floats  # -1 left, +1 right semicircle
    x: Floats  # the point of the bounce, from the centre of its circle
    y: Floats
    vx: Floats  # direction of the path that leaves it, a unit vector
    vy: Floats


def random_arcs(n: int, rng: np.random.Generator) -> Arcs:
    """Draw n bounces on the semicircles from the invariant measure."""
    side = np.where(rng.random(n) < 0.5, -1.0, 1.0)
    angle = rng.uniform(-HALF_PI, HALF_PI, n)
    sine = rng.uniform(-1, 1, n)
    cosine = np.sqrt(1 - sine**2)
    x, y = side * np.cos(angle), np.sin(angle)
    return Arcs(side, x, y, -cosine * x - sine * y, -cosine * y + sine * x)


class Step(NamedTuple):
    """The way of N trajectories to their next bounce on a semicircle; all arrays of shape (N,)."""

    arcs: Arcs  # just behind that bounce
    path: Floats  # length of the path to it
    walls: Floats  # straight bounces on the way
    kick: Floats  # 2 / sin(theta), what the bounce adds to the convergence of a beam


def advance(arcs: Arcs, a: float) -> Step:
    """Move trajectories to their next bounce on a semicircle and reflect them.

    Parameters
    ----------
    arcs : Arcs
    a : float
        Half the length of a straight wall.

    Notes
    -----
    The next bounce is on the same semicircle where the chord of the circle ends on it; then sin(theta)
    is kept as it is, however grazing. Otherwise the level at which the unfolded path reaches the other
    centre's x gives the copy, and the impact parameter about the centre of that copy the bounce. Points
    and directions are put back to length 1 to first order each time.
    """
    side, x, y, vx, vy = arcs.side, arcs.x, arcs.y, arcs.vx, arcs.vy
    along = x * vx + y * vy
    same = side * (x - 2 * along * vx) > 0
    dx = np.where(same, x, x + 2 * a * side)
    level = y - vy * dx / np.copysign(np.maximum(np.abs(vx), _TINY), -side)
    copy = np.where(same, 0.0, np.rint(level / 2))
    dy = y - 2 * copy
    along = dx * vx + dy * vy
    impact = dx * vy - dy * vx
    sine = np.sqrt(np.maximum((1 - impact) * (1 + impact), 0))
    sine = np.where(same, np.maximum(-along, 0), sine)
    path = np.maximum(sine - along, 0)
    walls = np.abs(copy)
    fold = 1 - 2 * (walls % 2)
    nx, ny, vy = dx + path * vx, (dy + path * vy) * fold, vy * fold
    scale = 1.5 - 0.5 * (nx * nx + ny * ny)
    nx, ny = nx * scale, ny * scale
    vx, vy = vx - 2 * sine * nx, vy - 2 * sine * ny
    scale = 1.5 - 0.5 * (vx * vx + vy * vy)
    after = Arcs(np.where(same, side, -side), nx, ny, vx * scale, vy * scale)
    return Step(after, path, walls, 2 / np.maximum(sine, _TINY))
