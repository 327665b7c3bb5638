"""Spectral elements on the quarter stadium: curved cells, and the energy of functions on them.

The quarter is a rectangle and a quarter disc made of three patches. A patch is a smooth image of the unit
square, and a cell is a part of a patch. The arc is represented exactly, as an edge of two patches. At the
joint of wall and arc, the boundary is only once differentiable and eigenfunctions behave like r^2 ln r, so
the cells there shrink towards the joint.

On each cell, a function is the polynomial that interpolates its values at Gauss-Lobatto-Legendre nodes. The
quadrature uses the same nodes, so the mass matrix is diagonal. The energy of a function is computed as a sum
of squares, which avoids cancellation.

Sources: A. T. Patera, J. Comput. Phys. 54 (1984) 468; G. E. Karniadakis and S. J. Sherwin,
Spectral/hp Element Methods for Computational Fluid Dynamics (2005).
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

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
    """A part of a patch."""

    patch: Patch
    corners: Floats
    """Corners in the unit square, in order around the cell, shape (4, 2)."""

    def points(self, s: Floats, t: Floats) -> Floats:
        """Return points of the stadium, shape (..., 2), at the coordinates s, t in 0..1 within the cell."""
        weights = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t], axis=-1)
        place = weights @ self.corners
        return self.patch(place[..., 0], place[..., 1])


def quarter_stadium(a: float, size: float, layers: int) -> list[Cell]:
    """Return the cells of the quarter x > 0, y > 0 of the stadium; the centre of the arc is at (a, 0).

    Their edges are at most about `size`, at most 1 along the width of the rectangle, and at most about 0.4
    along its height and in the disc. Those at the joint are divided `layers` times.
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
    at_joint = np.flatnonzero(np.abs(places - joint).max(axis=1) < 1e-9)
    if len(at_joint):
        corners = np.roll(corners, -at_joint[0], axis=0)
        for _ in range(layers):
            nearer = corners[0] + _SHRINK * (corners - corners[0])
            yield Cell(cell.patch, np.array([nearer[1], corners[1], corners[2], nearer[2]]))
            yield Cell(cell.patch, np.array([nearer[2], corners[2], corners[3], nearer[3]]))
            corners = nearer
    yield Cell(cell.patch, corners)


_SAME = 1e-10
"""Nodes closer together than this are the same node; different nodes are at least 1e-6 apart."""

_NOTHING = np.finfo(np.float64).tiny


@cache
def nodes(order: int) -> tuple[Floats, Floats, Floats]:
    """Return the nodes and weights of Gauss-Lobatto-Legendre quadrature on -1..1, and the derivative matrix.

    There are order + 1 nodes for polynomials of the given degree. The matrix maps the values of a polynomial
    at the nodes to the values of its derivative there.
    """
    polynomial = legendre.Legendre.basis(order)
    slope = polynomial.deriv()
    inside = np.sort(slope.roots().real)
    inside -= slope(inside) / slope.deriv()(inside)  # the roots alone are off by 1e-13
    x = np.concatenate([[-1.0], inside, [1.0]])
    values = polynomial(x)
    gaps = x[:, None] - x + np.eye(order + 1)
    products = gaps.prod(axis=1)  # in proportion to the values, but exact for nodes that have been rounded
    matrix = products[:, None] / products / gaps
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return x, 2 / (order * (order + 1) * values**2), matrix


class Grid(NamedTuple):
    """The nodes of the cells, and what is needed to compute gradients from values at the nodes.

    Attributes
    ----------
    points : ndarray, shape (E, n, n, 2)
        The nodes of each cell.
    node : ndarray of int, shape (E, n, n)
        Index of each node among the M different nodes; neighbouring cells share the nodes of an edge.
    weight : ndarray, shape (E, n, n)
        Weight of each node in integrals.
    slope : ndarray, shape (2, 2, E, n, n)
        Derivatives of the coordinates within the cell (second index) with respect to x and y (first index),
        times the square root of the weight.
    """

    points: Floats
    node: NDArray[np.intp]
    weight: Floats
    slope: Floats

    def gradient(self, values: Floats) -> Floats:
        """Return the weighted gradients at the nodes, shape (2, F, E, n, n), of F functions, (F, E, n, n).

        They are multiplied by the square root of the weight, so that the sum of their squares is the energy.
        """
        derivative = nodes(values.shape[-1] - 1)[2]
        along, across = derivative @ values, values @ derivative.T
        return np.stack([one * along + other * across for one, other in self.slope])

    def energy(self, values: Floats) -> Floats:
        """Return the energy of each function in each cell, shape (F, E)."""
        energy = np.empty(values.shape[:2])
        for n in range(len(values)):  # one function at a time, to save memory
            energy[n] = np.square(self.gradient(values[n : n + 1])).sum(axis=(0, 1, 3, 4))
        return energy

    def truncation(self, values: Floats) -> Floats:
        """Estimate the error that the finite degree causes in the energies of functions, shape (F, E, n, n).

        For each cell, it is the energy in the two highest degrees, multiplied by the ratio of this energy to
        that in the two degrees below.
        """
        lower, lowest = (_lowered(values, by) for by in (2, 4))
        last, before = self.energy(values - lower), self.energy(lower - lowest)
        return np.asarray((last * last / np.maximum(np.maximum(before, last), _NOTHING)).sum(axis=1))


def _lowered(values: Floats, by: int) -> Floats:
    """Return functions at the nodes without the `by` highest degrees in each coordinate."""
    order = values.shape[-1] - 1
    basis = legendre.legvander(nodes(order)[0], order)
    keep = basis[:, :-by] @ np.linalg.inv(basis)[:-by]
    return keep @ values @ keep.T


def grid(cells: Sequence[Cell], order: int) -> Grid:
    """Return the grid for polynomials of degree `order` on cells whose neighbours share entire edges."""
    x, weights, derivative = nodes(order)
    s, t = np.meshgrid((x + 1) / 2, (x + 1) / 2, indexing="ij")
    points = np.stack([cell.points(s, t) for cell in cells])
    near = points - points[:, :1, :1]  # far from the origin, rounding would spoil the derivatives
    along = np.einsum("ij,ejkc->eikc", derivative, near)
    across = np.einsum("kj,eijc->eikc", derivative, near)
    inverse = np.linalg.inv(np.stack([along, across], axis=-1))
    weight = weights[:, None] * weights / np.abs(np.linalg.det(inverse))
    slope = np.sqrt(weight) * np.moveaxis(inverse, (-1, -2), (0, 1))
    return Grid(points, _joined(points.reshape(-1, 2)).reshape(weight.shape), weight, slope)


def _joined(points: Floats) -> NDArray[np.intp]:
    """Return the index of each point, shape (N, 2), among the different points; close points count as one."""
    pairs = cKDTree(points).query_pairs(_SAME, output_type="ndarray")
    links = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    return np.asarray(csgraph.connected_components(links, directed=False)[1], np.intp)
