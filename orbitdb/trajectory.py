"""Ensembles of random trajectories: the reference for averages over orbits.

A trajectory is followed from one bounce on a semicircle to the next. Unfold the stadium at its walls:
a path that leaves a semicircle for the other one is a straight line, and the copy of the strip it is
in when it reaches the other circle says how many walls it has hit. So the thousands of bounces of a
path that runs up and down between the walls cost no more than one, and no rounding adds up in them.

The starts are drawn with the invariant measure of the bounces, restricted to the semicircles: position
uniform in arclength, sine of the angle to the normal uniform. So every step is a fair sample from the
first on, and only the tangent vectors need a while to settle. All is vectorised over trajectories.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.stadium import HALF_PI, Stadium

Floats = NDArray[np.float64]

TRAJECTORIES = 4096
GROUPS = 32
BLOCK = 256
_RENORMALISE = 8
_SETTLED = 8.0
_TINY = 1e-150


@dataclass(frozen=True)
class Arcs:
    """N trajectories just behind a bounce on a semicircle; all arrays of shape (N,).

    Attributes
    ----------
    side : ndarray
        -1 left, +1 right semicircle.
    x, y : ndarray
        The point of the bounce, from the centre of its circle.
    vx, vy : ndarray
        Direction of the path that leaves it, a unit vector.
    """

    side: Floats
    x: Floats
    y: Floats
    vx: Floats
    vy: Floats


def random_arcs(n: int, rng: np.random.Generator) -> Arcs:
    """Draw n bounces on the semicircles from the invariant measure."""
    side = rng.integers(0, 2, n) * 2.0 - 1
    angle = rng.uniform(-HALF_PI, HALF_PI, n)
    sine = rng.uniform(-1, 1, n)
    cosine = np.sqrt(1 - sine**2)
    x, y = side * np.cos(angle), np.sin(angle)
    return Arcs(side, x, y, -cosine * x - sine * y, -cosine * y + sine * x)


@dataclass(frozen=True)
class Step:
    """The way of N trajectories to their next bounce on a semicircle; all arrays of shape (N,).

    Attributes
    ----------
    arcs : Arcs
        Just behind that bounce.
    path : ndarray
        Length of the path to it.
    walls : ndarray
        Number of straight bounces on the way.
    kick : ndarray
        2 / sin(theta), what the bounce adds to the convergence of a beam.
    """

    arcs: Arcs
    path: Floats
    walls: Floats
    kick: Floats


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


@dataclass(frozen=True)
class Beam:
    """Tangent vectors along N trajectories and what has been summed up on the way; shape (N,) each.

    Attributes
    ----------
    y, slope : ndarray
        Offset across the path and its change of direction, scaled to |y| + |slope| = 1.
    growth : ndarray
        Logarithm of the scales taken out.
    path : ndarray
        Length of the path.
    bounces : ndarray
        Number of bounces, on walls and semicircles.
    """

    y: Floats
    slope: Floats
    growth: Floats
    path: Floats
    bounces: Floats

    @classmethod
    def begin(cls, y: Floats, slope: Floats) -> "Beam":
        """Return beams with the given tangent vectors and nothing summed up."""
        return cls(y, slope, *np.zeros((3, len(y))))


def follow(arcs: Arcs, beam: Beam, a: float, steps: int) -> tuple[Arcs, Beam]:
    """Follow trajectories and their tangent vectors over a number of steps.

    Notes
    -----
    A path of length l adds l * slope to y, a bounce on a semicircle takes 2 y / sin(theta) from the
    slope: the matrices of `orbitdb.stability` less the -1 that each bounce has.
    """
    y, slope = beam.y, beam.slope
    growth, path, bounces = beam.growth.copy(), beam.path.copy(), beam.bounces + steps
    for step in range(1, steps + 1):
        hit = advance(arcs, a)
        arcs = hit.arcs
        path += hit.path
        bounces += hit.walls
        y = y + hit.path * slope
        slope = slope - hit.kick * y
        if step % _RENORMALISE == 0 or step == steps:
            size = np.abs(y) + np.abs(slope)
            growth += np.log(size)
            y, slope = y / size, slope / size
    return arcs, Beam(y, slope, growth, path, bounces)


def _settled(n: int, a: float, rng: np.random.Generator) -> tuple[Arcs, Beam]:
    """Return random starts whose tangent vectors have forgotten how they began.

    With det M = 1, growth by e^g turns a vector to within about e^(-2g) of the one that grows.
    """
    arcs, beam = random_arcs(n, rng), Beam.begin(np.zeros(n), np.ones(n))
    while beam.growth.mean() < _SETTLED:
        arcs, beam = follow(arcs, beam, a, _RENORMALISE)
    return arcs, Beam.begin(beam.y, beam.slope)


@dataclass(frozen=True)
class Reference:
    """Averages over random trajectories, each with the standard error of its mean.

    Attributes
    ----------
    lambda_d, lambda_d_error : float
        Lyapunov exponent per bounce.
    lambda_c, lambda_c_error : float
        Lyapunov exponent per length.
    mean_free_path, mean_free_path_error : float
        Mean path between bounces; `Stadium.mean_free_path` is its exact value.
    bounces : int
        Bounces in the averages.
    groups : int
        Number of independent groups that the errors come from.
    seed : int
    """

    lambda_d: float
    lambda_d_error: float
    lambda_c: float
    lambda_c_error: float
    mean_free_path: float
    mean_free_path_error: float
    bounces: int
    groups: int
    seed: int


def simulate(
    stadium: Stadium,
    bounces: int,
    seed: int = 0,
    trajectories: int = TRAJECTORIES,
    groups: int = GROUPS,
    progress: Callable[[float, Reference], None] | None = None,
) -> Reference:
    """Average over random trajectories.

    Parameters
    ----------
    stadium : Stadium
    bounces : int
        Bounces to expect in all; at least one on a semicircle is made by every trajectory.
    seed : int, optional
        The same seed and numbers give the same result.
    trajectories, groups : int, optional
        Trajectories run at the same time, and independent groups of them.
    progress : callable, optional
        Called every few hundred steps with the fraction done and the averages so far.

    Raises
    ------
    ValueError
        If there are no bounces, fewer than two groups, or trajectories that do not fill the groups.
    """
    for done, found in references(stadium, bounces, seed, trajectories, groups):
        if progress is not None:
            progress(done, found)
    return found


def references(
    stadium: Stadium,
    bounces: int,
    seed: int = 0,
    trajectories: int = TRAJECTORIES,
    groups: int = GROUPS,
) -> Iterator[tuple[float, Reference]]:
    """Yield the fraction done and the averages so far, every few hundred steps of `simulate`.

    Every value is a full result of fewer bounces, so a caller may stop at any.
    """
    if bounces < 1 or groups < 2 or trajectories < groups or trajectories % groups:
        raise ValueError("give at least one bounce, two groups, and a multiple of them as trajectories")
    arcs, beam = _settled(trajectories, stadium.a, np.random.default_rng(seed))
    steps = math.ceil(bounces / trajectories * 2 * math.pi / stadium.perimeter)
    done = 0
    while done < steps:
        block = min(BLOCK, steps - done)
        arcs, beam = follow(arcs, beam, stadium.a, block)
        done += block
        yield done / steps, _reference(beam, done, stadium, groups, seed)


def _reference(beam: Beam, steps: int, stadium: Stadium, groups: int, seed: int) -> Reference:
    """Average over trajectories, and take the errors from the spread of the groups.

    Between two bounces on a semicircle lie perimeter / 2 pi bounces and a path of area / 2 on average,
    by the invariant measure. With these exact numbers the exponents need only the growth per step; the
    numbers counted on the way, which a few long stays between the walls throw off, go into the mean
    free path alone, a check that stands by itself.
    """
    count = len(beam.growth) // groups * steps
    growth, path, bounces = (
        values.reshape(groups, -1).sum(axis=1) / count for values in (beam.growth, beam.path, beam.bounces)
    )

    def mean(values: Floats) -> Floats:
        """Return the mean and its standard error."""
        return np.array([values.mean(), values.std(ddof=1) / math.sqrt(groups)])

    free = path.mean() / bounces.mean()
    free_error = mean(path - free * bounces)[1] / bounces.mean()
    lambda_d = mean(growth) * (2 * math.pi / stadium.perimeter)
    lambda_c = mean(growth) * (2 / stadium.area)
    return Reference(
        *lambda_d.tolist(),
        *lambda_c.tolist(),
        mean_free_path=float(free),
        mean_free_path_error=float(free_error),
        bounces=int(beam.bounces.sum()),
        groups=groups,
        seed=seed,
    )
