"""Single trajectories, bounce by bounce: random starts, the next bounce, segments as symbols.

Everything is vectorised over trajectories: one ray each. `orbitdb.trajectories.ensemble` goes faster, from
semicircle to semicircle, where only averages are wanted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import HALF_PI, Stadium
from orbitdb.billiard.writing import written
from orbitdb.equality import ByValue

Floats = NDArray[np.float64]

_TINY = 1e-300


@dataclass(frozen=True, eq=False)
class Rays(ByValue):
    """N trajectories just behind a bounce; all arrays of shape (N,).

    Attributes
    ----------
    x, y : ndarray
        The point of the bounce, x from the middle of the stadium.
    vx, vy : ndarray
        Direction of the path that leaves it, a unit vector.
    side : ndarray
        Where the bounce was: -1 left semicircle, +1 right semicircle, 0 a straight wall.
    """

    x: Floats
    y: Floats
    vx: Floats
    vy: Floats
    side: Floats

    def __len__(self) -> int:
        return len(self.x)


def random_rays(stadium: Stadium, n: int, rng: np.random.Generator) -> Rays:
    """Draw n rays from the invariant measure of the bounces.

    The position is uniform in arclength, the sine of the angle to the normal uniform, so that every
    later bounce is as fair a sample as the first.

    Parameters
    ----------
    stadium : Stadium
    n : int
    rng : numpy.random.Generator
    """
    a = stadium.a
    on_wall = rng.random(n) < 4 * a / stadium.perimeter
    place = rng.uniform(-1, 1, n)
    sine = rng.uniform(-1, 1, n)
    half = np.where(rng.random(n) < 0.5, -1.0, 1.0)  # top or bottom, right or left
    t = place * HALF_PI
    nx = np.where(on_wall, 0.0, half * np.cos(t))
    ny = np.where(on_wall, half, np.sin(t))
    x = np.where(on_wall, place * a, half * a + nx)
    cosine = np.sqrt(1 - sine**2)
    vx, vy = -cosine * nx - sine * ny, -cosine * ny + sine * nx
    return Rays(x, ny, vx, vy, np.where(on_wall, 0.0, half))


@dataclass(frozen=True, eq=False)
class Bounce(ByValue):
    """The next bounce of N rays; all arrays of shape (N,).

    Attributes
    ----------
    rays : Rays
        Just behind it.
    path : ndarray
        Length of the path to it.
    kick : ndarray
        What it adds to the convergence of a beam, 2 / sin(theta) on a semicircle and 0 on a wall.
    """

    rays: Rays
    path: Floats
    kick: Floats


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


@dataclass(frozen=True, eq=False)
class Itineraries(ByValue):
    """The bounces of N trajectories over p steps, in the symbols and coordinates of the catalogue.

    Attributes
    ----------
    symbols : ndarray of uint8, shape (N, p)
    coordinates : ndarray, shape (N, p)
        x on a straight wall, radians on a semicircle.
    path : ndarray, shape (N, p)
        Length of the path that arrives at each bounce.
    """

    symbols: NDArray[np.uint8]
    coordinates: Floats
    path: Floats


def itineraries(stadium: Stadium, rays: Rays, steps: int) -> Itineraries:
    """Follow single trajectories and write down the bounces that come after the given ones.

    Parameters
    ----------
    stadium : Stadium
    rays : Rays
    steps : int
        Number of bounces to record.

    Notes
    -----
    A bounce is single, or in a run that goes up or down, by its neighbours on the trajectory; the
    bounce before the first and the one behind the last are looked at for that.
    """
    sides, heights, xs, paths = [rays.side], [rays.y], [rays.x], []
    for _ in range(steps + 1):
        hit = bounce(rays, stadium.a)
        rays = hit.rays
        sides.append(rays.side)
        heights.append(rays.y)
        xs.append(rays.x)
        paths.append(hit.path)
    side, y, x = (np.stack(rows, axis=1) for rows in (sides, heights, xs))
    return Itineraries(*written(stadium, x, y, side), np.stack(paths[:-1], axis=1))
