"""Spectral elements: functions on curved cells, and the energy of their gradients.

On each cell, a function is the polynomial that interpolates its values at Gauss-Lobatto-Legendre nodes. The
quadrature uses the same nodes, so the mass matrix is diagonal. The energy of a function is computed as a sum
of squares, which avoids cancellation.

Sources: A. T. Patera, J. Comput. Phys. 54 (1984) 468; G. E. Karniadakis and S. J. Sherwin,
Spectral/hp Element Methods for Computational Fluid Dynamics (2005).
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from orbitdb.arrays import Floats
from orbitdb.quantum.mesh import Cell

_SAME = 1e-10
"""Nodes closer together than this are the same node; different nodes are at least 1e-6 apart."""

_NOTHING = np.finfo(np.float64).tiny


@cache
def nodes(order: int) -> tuple[Floats, Floats, Floats]:
    """Return the nodes and weights of Gauss-Lobatto-Legendre quadrature on -1..1, and the derivative matrix.

    Parameters
    ----------
    order : int
        Degree of the polynomials; there are order + 1 nodes.

    Returns
    -------
    x, weights : ndarray, shape (order + 1,)
        The nodes in ascending order, and their weights.
    matrix : ndarray, shape (order + 1, order + 1)
        Maps the values of a polynomial at the nodes to the values of its derivative there.
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
        found = np.empty(values.shape[:2])
        for n in range(len(values)):  # one function at a time, to save memory
            found[n] = np.square(self.gradient(values[n : n + 1])).sum(axis=(0, 1, 3, 4))
        return found

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
