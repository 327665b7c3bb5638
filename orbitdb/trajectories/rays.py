"""Trajectories, either bounce by bounce or, faster and for averages, between bounces on semicircles.

If the stadium is unfolded at its straight walls, a path from one semicircle to the other is a straight line.
The number of walls that it hits follows from the copy of the stadium in which it ends. So thousands of
bounces between the walls cost no more than one bounce, and their rounding errors do not accumulate.
"""

from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.stadium import HALF_PI

_TINY = 1e-150


class Rays(NamedTuple):
    """N trajectories just after a bounce; all arrays have shape (N,)."""

    x: Floats  # point of the bounce, from the centre of the stadium
    y: Floats
    vx: Floats  # direction of the outgoing path, a unit vector
    vy: Floats
    side: Floats  # what the bounce is on: -1 left semicircle, +1 right semicircle, 0 straight wall


class Bounce(NamedTuple):
    """The next bounce of each of N rays; all arrays have shape (N,)."""

    rays: Rays  # the rays just after the bounce
    path: Floats  # length of the path to the bounce
    kick: Floats  # convergence that the bounce adds to a beam: 2 / sin(theta) on a semicircle, 0 on a wall


def bounce(rays: Rays, a: float) -> Bounce:
    """Move rays to their next bounce and reflect them.

    Because the stadium is convex, a path hits the straight wall ahead if it reaches the height of the wall at
    an x in (-a, a). Otherwise it hits the semicircle on the side of this x.
    """
    x, y, vx, vy = rays.x, rays.y, rays.vx, rays.vy
    wall = np.copysign(1.0, vy)
    to_wall = (1 - wall * y) / np.maximum(np.abs(vy), _TINY)
    x_wall = x + vx * to_wall
    curved = np.abs(x_wall) > a
    side = np.copysign(curved, x_wall)
    dx = x - side * a
    path, sine, nx, ny, out_x, out_y = _off_circle(dx, y, vx, vy, curved & (side == rays.side))
    after = Rays(
        x=np.where(curved, nx + side * a, x_wall),
        y=np.where(curved, ny, wall),
        vx=np.where(curved, out_x, vx),
        vy=np.where(curved, out_y, -vy),
        side=side,
    )
    return Bounce(after, np.where(curved, path, to_wall), np.where(curved, 2 / np.maximum(sine, _TINY), 0.0))


class Arcs(NamedTuple):
    """N trajectories just after a bounce on a semicircle; all arrays have shape (N,)."""

    side: Floats  # -1 for the left semicircle, +1 for the right semicircle
    x: Floats  # point of the bounce, from the centre of its circle
    y: Floats
    vx: Floats  # direction of the outgoing path, a unit vector
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
    """The step of N trajectories to their next bounce on a semicircle; all arrays have shape (N,)."""

    arcs: Arcs  # the trajectories just after this bounce
    path: Floats  # length of the path to this bounce
    walls: Floats  # number of straight bounces on the way
    kick: Floats  # 2 / sin(theta), the convergence that the bounce adds to a beam


def advance(arcs: Arcs, a: float) -> Step:
    """Move trajectories to their next bounce on a semicircle and reflect them.

    The next bounce is on the same semicircle if the chord of the full circle ends on it. Otherwise, the path
    is unfolded, and the height at which it reaches the x of the other centre determines the copy it hits.
    """
    side, x, y, vx, vy = arcs.side, arcs.x, arcs.y, arcs.vx, arcs.vy
    along = x * vx + y * vy
    same = side * (x - 2 * along * vx) > 0
    dx = np.where(same, x, x + 2 * a * side)
    level = y - vy * dx / np.copysign(np.maximum(np.abs(vx), _TINY), -side)
    copy = np.where(same, 0.0, np.rint(level / 2))
    dy = y - 2 * copy
    path, sine, nx, ny, vx, vy = _off_circle(dx, dy, vx, vy, same)
    walls = np.abs(copy)
    fold = 1 - 2 * (walls % 2)
    after = Arcs(np.where(same, side, -side), nx, ny * fold, vx, vy * fold)
    return Step(after, path, walls, 2 / np.maximum(sine, _TINY))


def _off_circle(dx: Floats, dy: Floats, vx: Floats, vy: Floats, same: Marks) -> tuple[Floats, ...]:
    """Reflect paths at a circle; return their lengths, sin(theta), points from the centre, and directions.

    The length is computed from the impact parameter, which is accurate at any distance. Successive bounces on
    the same circle keep their angle exactly. Points and directions are normalised to first order.
    """
    along = dx * vx + dy * vy
    impact = dx * vy - dy * vx
    sine = np.sqrt(np.maximum((1 - impact) * (1 + impact), 0))
    sine = np.where(same, np.maximum(-along, 0), sine)
    path = np.maximum(sine - along, 0)
    nx, ny = dx + path * vx, dy + path * vy
    scale = 1.5 - 0.5 * (nx * nx + ny * ny)
    nx, ny = nx * scale, ny * scale
    vx, vy = vx - 2 * sine * nx, vy - 2 * sine * ny
    scale = 1.5 - 0.5 * (vx * vx + vy * vy)
    return path, sine, nx, ny, vx * scale, vy * scale
