"""Rays: trajectories just after a bounce, and their way to the next bounce, for many at once."""

from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Marks

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

    It is the only map from each bounce to the next. `orbitdb.trajectories.ensemble.advance` goes from one
    bounce on a semicircle to the next, and `orbitdb.trajectories.legwise.next_leg` from run to run: their
    time does not depend on the number of bounces in between.

    Source: this is the map F of Biham and Kvale, eq. (5).
    """
    x, y, vx, vy = rays.x, rays.y, rays.vx, rays.vy
    wall = np.copysign(1.0, vy)
    to_wall = (1 - wall * y) / np.maximum(np.abs(vy), _TINY)
    x_wall = x + vx * to_wall
    curved = np.abs(x_wall) > a
    side = np.copysign(curved, x_wall)
    dx = x - side * a
    path, sine, nx, ny, out_x, out_y = reflect_off_circle(dx, y, vx, vy, curved & (side == rays.side))
    after = Rays(
        x=np.where(curved, nx + side * a, x_wall),
        y=np.where(curved, ny, wall),
        vx=np.where(curved, out_x, vx),
        vy=np.where(curved, out_y, -vy),
        side=side,
    )
    return Bounce(after, np.where(curved, path, to_wall), np.where(curved, 2 / np.maximum(sine, _TINY), 0.0))


def reflect_off_circle(dx: Floats, dy: Floats, vx: Floats, vy: Floats, same: Marks) -> tuple[Floats, ...]:
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
