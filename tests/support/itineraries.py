"""Random trajectories, recorded bounce by bounce, and a test of uniformity."""

from dataclasses import dataclass

import numpy as np

from orbitdb.billiard.stadium import HALF_PI, Stadium, written
from orbitdb.trajectories.rays import Rays, bounce


def random_rays(stadium: Stadium, n: int, rng: np.random.Generator) -> Rays:
    """Draw n rays from the invariant measure of the bounces.

    The position is uniform in arclength and the sine of the angle to the normal uniform, so each later bounce
    has the same distribution.

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


@dataclass(frozen=True)
class Itineraries:
    """Symbols and coordinates of successive bounces, and the path length to each, shape (N, p)."""

    symbols: np.ndarray
    coordinates: np.ndarray
    path: np.ndarray


def itineraries(stadium: Stadium, rays: Rays, steps: int) -> Itineraries:
    """Follow trajectories for some steps, and one more to see whether the last bounce is a run of its own."""
    hits = [bounce(rays, stadium.a)]
    for _ in range(steps):
        hits.append(bounce(hits[-1].rays, stadium.a))
    every = [rays, *(hit.rays for hit in hits)]
    x, y, side = (np.stack([getattr(each, name) for each in every], axis=1) for name in ("x", "y", "side"))
    path = np.stack([hit.path for hit in hits[:-1]], axis=1)
    return Itineraries(*written(stadium, x, y, side), path)


def is_uniform(values: np.ndarray, low: float, high: float) -> bool:
    """Run a Kolmogorov-Smirnov test at the level 1e-3."""
    from scipy.stats import kstest  # importing it takes as long as many tests

    return bool(kstest(values, "uniform", (low, high - low)).pvalue > 1e-3)
