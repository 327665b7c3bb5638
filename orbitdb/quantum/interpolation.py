"""Interpolation of functions given at the nodes of cells, with one polynomial per cell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from orbitdb.arrays import Floats
from orbitdb.quantum.elements import nodes

_NEAREST = 12
"""Number of nearest nodes whose cells are tried in the search for the cell that contains a point."""
_NEWTON, _SETTLED = 20, 1e-12
INSIDE = 1e-7
"""Maximum distance outside a cell, in the coordinates of the cell, at which a point counts as inside."""


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells that all waves of a window share, given by their nodes `points`, shape (E, n, n, 2)."""

    points: Floats

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points.reshape(-1, 2))

    def at(self, points: Floats) -> "Places":
        """Find the cell that contains each point, shape (N, 2), and the point's coordinates in the cell."""
        n = self.points.shape[1]
        x, _, slope = nodes(n - 1)
        _, near = self._tree.query(points, k=_NEAREST)
        cell, inside = np.full(len(points), -1), np.zeros((len(points), 2))
        closest = np.full(len(points), np.inf)
        for nearest in near.T:
            open_ = np.flatnonzero(closest > 0)
            if not len(open_):
                break
            which, node = np.divmod(nearest[open_], n * n)
            place = np.stack([x[node // n], x[node % n]], axis=-1)
            place = self._newton(points[open_], which, place, slope)
            beyond = np.maximum(np.abs(place).max(axis=-1) - 1, 0.0)
            beyond[beyond < INSIDE] = 0.0
            better = beyond < closest[open_]
            rows = open_[better]
            cell[rows], inside[rows], closest[rows] = which[better], place[better], beyond[better]
        return Places(cell, inside, self.points)

    def _newton(self, points: Floats, which: NDArray[np.intp], place: Floats, slope: Floats) -> Floats:
        place, moving = place.copy(), np.arange(len(points))
        for _ in range(_NEWTON):
            at = Places(which[moving], place[moving], self.points)
            off = points[moving] - at.interpolated(self.points[at.cell])
            step = np.linalg.solve(at.jacobian(), off[..., None])[..., 0]
            place[moving] = np.clip(at.inside + step, -1.5, 1.5)
            moving = moving[np.abs(step).max(axis=-1) > _SETTLED]
            if not len(moving):
                break
        return place


@dataclass(frozen=True, eq=False)
class Places:
    """N points, each given by its cell and by its coordinates in that cell, which run from -1 to 1."""

    cell: NDArray[np.intp]
    inside: Floats
    points: Floats

    @cached_property
    def _bases(self) -> tuple[Floats, Floats]:
        order = self.points.shape[1] - 1
        return _lagrange(self.inside[:, 0], order), _lagrange(self.inside[:, 1], order)

    def interpolated(self, nodal: Floats) -> Floats:
        """Interpolate at each point, given the nodal values of its cell, shape (N, n, n, ...)."""
        one, other = self._bases
        return _contracted(one, other, nodal)

    def jacobian(self) -> Floats:
        """Return the Jacobian of x and y with respect to the coordinates in the cell, shape (N, 2, 2)."""
        return np.stack(self._derivatives(self.points[self.cell]), axis=-1)

    def _derivatives(self, nodal: Floats) -> tuple[Floats, Floats]:
        slope = nodes(self.points.shape[1] - 1)[2]
        one, other = self._bases
        return _contracted(one @ slope, other, nodal), _contracted(one, other @ slope, nodal)

    def values(self, function: Floats) -> Floats:
        """Return the values of a function at the points, given its nodal values, shape (E, n, n)."""
        return self.interpolated(function[self.cell])

    def slopes(self, function: Floats) -> Floats:
        """Return the gradient of a function at the points, shape (N, 2), given its nodal values."""
        by = np.stack(self._derivatives(function[self.cell]), axis=-1)
        found = np.linalg.solve(np.swapaxes(self.jacobian(), -1, -2), by[..., None])[..., 0]
        return np.asarray(found, np.float64)


def _contracted(one: Floats, other: Floats, nodal: Floats) -> Floats:
    """Return the sum of one_i other_j nodal_ij for each point, shape (N, ...)."""
    found: Floats = np.einsum("pi,pi...->p...", one, np.einsum("pj,pij...->pi...", other, nodal))
    return found


def _lagrange(x: Floats, order: int) -> Floats:
    """Return the Lagrange polynomials of the nodes at each x, shape (N, n), from Legendre polynomials."""
    return legvander(x, order) @ np.linalg.inv(legvander(nodes(order)[0], order))
