"""Trajectories written down bounce by bounce."""

from dataclasses import dataclass

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.billiard.writing import written
from orbitdb.trajectories.rays import Rays, bounce


@dataclass(frozen=True)
class Itineraries:
    """The symbols and coordinates of the bounces behind given ones, and the path to each, shape (N, p)."""

    symbols: np.ndarray
    coordinates: np.ndarray
    path: np.ndarray


def itineraries(stadium: Stadium, rays: Rays, steps: int) -> Itineraries:
    """Follow trajectories, and one bounce more, which says whether the last one is single."""
    hits = [bounce(rays, stadium.a)]
    for _ in range(steps):
        hits.append(bounce(hits[-1].rays, stadium.a))
    every = [rays, *(hit.rays for hit in hits)]
    x, y, side = (np.stack([getattr(each, name) for each in every], axis=1) for name in ("x", "y", "side"))
    path = np.stack([hit.path for hit in hits[:-1]], axis=1)
    return Itineraries(*written(stadium, x, y, side), path)
