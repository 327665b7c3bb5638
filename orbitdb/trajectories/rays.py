"""Single trajectories, bounce by bounce.

Everything is vectorised over trajectories: one ray each. `orbitdb.trajectories.ensemble` goes faster, from
semicircle to semicircle, where only averages are wanted.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_TINY = 1e-300


class Rays(NamedTuple):
    """N trajectories just behind a bounce; all arrays of shape (N,)."""

    x: Floats  # the point of the bounce, from the middle of the stadium
    y: Floats
    vx: Floats  # direction of the path that leaves it, a unit vector
    vy: Floats
    side: Floats  # where the bounce was: -1 left semicircle, +1 right semicircle, 0 a straight wall


class Bounce(NamedTuple):
    """The next bounce of N rays; all arrays of shape (N,)."""

    rays: Rays  # just behind it
    path: Floats  # length of the path to it
    kick: Floats  # what it adds to the convergence of a beam, 2 / sin(theta) on a semicircle and 0 on a wall


def bounce(rays: Rays, a: float) -> Bounce:
    """Move rays to their next bounce and reflect them.

    Parameters
    ----------
    rays : Rays
    a : float
        Half the length of a straight wall.

    Notes
    -----
    Where a path crosses the level of the wall ahead decides what it hits: the stadium is convex, so
    within (-a, a) it is the wall and beyond it the semicircle of that side. The distance to a circle
    comes from the impact parameter about its centre, which is as exact far away as near; from one
    bounce to the next on the same circle the angle is kept as it is, however grazing. Points and
    directions are put back to radius and length 1 to first order at each bounce on a circle.
    """
    x, y, vx, vy = rays.x, rays.y, rays.vx, rays.vy
    wall = np.copysign(1.0, vy)
    to_wall = (1 - wall * y) / np.maximum(np.abs(vy), _TINY)
    x_wall = x + vx * to_wall
    curved = np.abs(x_wall) > a
    side = np.copysign(curved, x_wall)
    dx = x - side * a
    along = dx * vx + y * vy
    impact = dx * vy - y * vx
    sine = np.sqrt(np.maximum((1 - impact) * (1 + impact), 0))
    sine = np.where(curved & (side == rays.side), np.maximum(-along, 0), sine)
    path = np.where(curved, np.maximum(sine - along, 0), to_wall)
    nx = dx + path * vx
    ny = y + path * vy
    scale = 1.5 - 0.5 * (nx * nx + ny * ny)
    nx *= scale
    ny *= scale
    back = 2 * sine
    out_x = vx - back * nx
    out_y = vy - back * ny
    scale = 1.5 - 0.5 * (out_x * out_x + out_y * out_y)
    after = Rays(
        x=np.where(curved, nx + side * a, x_wall),
        y=np.where(curved, ny, wall),
        vx=np.where(curved, out_x * scale, vx),
        vy=np.where(curved, out_y * scale, -vy),
        side=side,
    )
    return Bounce(after, path, np.where(curved, 2 / np.maximum(sine, _TINY), 0.0))
