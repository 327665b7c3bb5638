"""Curved quadrilateral cells of the quarter stadium: a rectangle, and a quarter disc made of three patches.

A patch is a smooth image of the unit square, and a cell is a part of a patch. The arc is represented exactly,
as an edge of two patches. At the joint of wall and arc, the boundary is only once differentiable and
eigenfunctions behave like r^2 ln r, so the cells there shrink towards the joint.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from orbitdb.arrays import Floats

Patch = Callable[[Floats, Floats], Floats]
"""Maps coordinates in the unit square to points of the stadium, shape (..., 2)."""

_CORE = 0.5
"""Extent of the inner patch of the disc along the axes, in units of the radius."""
_DIAGONAL = 0.4
"""x and y of the corner of the inner patch that lies on the diagonal, from the centre of the disc."""
_SHRINK = 0.15
_LARGEST = 0.4


@dataclass(frozen=True, eq=False)
class Cell:
    """A part of a patch.

    Attributes
    ----------
    patch : Patch
    corners : ndarray, shape (4, 2)
        Corners of the cell in the unit square, in order around the cell.
    """

    patch: Patch
    corners: Floats

    def points(self, s: Floats, t: Floats) -> Floats:
        """Return points of the stadium, shape (..., 2), at the coordinates s, t in 0..1 within the cell."""
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
        place = weights @ self.corners
        return self.patch(place[..., 0], place[..., 1])


def quarter_stadium(a: float, size: float, layers: int) -> list[Cell]:
    """Return the cells of the quarter x > 0, y > 0 of the stadium; the centre of the arc is at (a, 0).

    Parameters
    ----------
    a : float
        Half length of a straight wall.
    size : float
        Approximate upper limit for the edges of the cells, in units of the radius. In any case, edges are at
        most 1 along the width of the rectangle, and at most about 0.4 along its height and in the disc.
    layers : int
        Number of times the cells at the joint are divided.
    """
    small = min(size, _LARGEST)
    cells = [*rectangle(a, min(size, 1.0), small), *quarter_disc(a, small)]
    return [part for cell in cells for part in _towards(np.array([a, 1.0]), cell, layers)]


def rectangle(width: float, size: float, height: float) -> list[Cell]:
    """Return the cells of 0 < x < width, 0 < y < 1, at most `size` wide and about `height` high."""

    def patch(s: Floats, t: Floats) -> Floats:
        return np.stack([width * s, t], axis=-1)

    lower = _CORE * _steps(_CORE, height)
    heights = np.concatenate([lower, _CORE + (1 - _CORE) / _CORE * lower[1:]])
    return list(_divided(patch, _steps(width, size), heights))


def quarter_disc(centre: float, size: float) -> list[Cell]:
    """Return the cells of the quarter x > centre, y > 0 of the unit disc around (centre, 0)."""

    def inner(s: Floats, t: Floats) -> Floats:
        far = _DIAGONAL * s * t
        return np.stack([centre + _CORE * s * (1 - t) + far, _CORE * t * (1 - s) + far], axis=-1)

    def upper(s: Floats, t: Floats) -> Floats:
        angle = (2 - s) * math.pi / 4
        x = (1 - t) * _DIAGONAL * s + t * np.cos(angle)
        y = (1 - t) * (_CORE + (_DIAGONAL - _CORE) * s) + t * np.sin(angle)
        return np.stack([centre + x, y], axis=-1)

    def lower(s: Floats, t: Floats) -> Floats:
        mirrored = upper(s, t)
        return np.stack([centre + mirrored[..., 1], mirrored[..., 0] - centre], axis=-1)

    steps = _steps(_CORE, size)
    return [cell for patch in (inner, upper, lower) for cell in _divided(patch, steps, steps)]


def _steps(length: float, size: float) -> Floats:
    """Return the equidistant points from 0 to 1 that divide a length into parts of at most the given size."""
    return np.linspace(0.0, 1.0, max(1, math.ceil(length / size)) + 1)


def _divided(patch: Patch, along: Floats, across: Floats) -> Iterator[Cell]:
    """Yield the cells into which the given coordinate lines divide a patch."""
    for low, high in pairwise(along):
        for near, far in pairwise(across):
            yield Cell(patch, np.array([[low, near], [high, near], [high, far], [low, far]]))


def _towards(joint: Floats, cell: Cell, layers: int) -> Iterator[Cell]:
    """Yield the parts of a cell, which shrink towards the joint if the joint is one of its corners."""
    corners = cell.corners
    places = cell.patch(corners[:, 0], corners[:, 1])
    here = np.flatnonzero(np.abs(places - joint).max(axis=1) < 1e-9)
    if len(here):
        corners = np.roll(corners, -here[0], axis=0)
        for _ in range(layers):
            nearer = corners[0] + _SHRINK * (corners - corners[0])
            yield Cell(cell.patch, np.array([nearer[1], corners[1], corners[2], nearer[2]]))
            yield Cell(cell.patch, np.array([nearer[2], corners[2], corners[3], nearer[3]]))
            corners = nearer
    yield Cell(cell.patch, corners)
