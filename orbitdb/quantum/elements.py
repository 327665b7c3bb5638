"""Spectral elements: the Laplacian on curved cells, and all its eigenvalues in an interval.

The polynomials interpolate at Gauss-Lobatto-Legendre nodes. The quadrature uses the same nodes, so the mass
matrix is diagonal. The gradient is a matrix B of its values at all nodes, weighted so that K = B^T B. Then
|B v|^2 gives the energy of a function as a sum of positive terms, without cancellation.

Source: A. T. Patera, J. Comput. Phys. 54 (1984) 468; G. E. Karniadakis and S. J. Sherwin,
Spectral/hp Element Methods for Computational Fluid Dynamics (2005).
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph, linalg
from scipy.spatial import cKDTree

from orbitdb.arrays import Floats
from orbitdb.errors import WorkError
from orbitdb.quantum.mesh import Cell

_MORE = 6
"""Extra eigenvalues outside the interval, which make the iterations converge sooner."""

_SAME = 1e-10
"""Nodes closer than this are the same; different ones are at least 1e-6 apart."""


@cache
def nodes(order: int) -> tuple[Floats, Floats, Floats]:
    """Return nodes and weights of Gauss-Lobatto-Legendre quadrature on -1..1, and the differentiation matrix.

    Parameters
    ----------
    order : int
        Degree of the polynomials; there are order + 1 nodes.

    Returns
    -------
    ndarray, shape (order + 1,); the same; ndarray, shape (order + 1, order + 1)
    """
    polynomial = legendre.Legendre.basis(order)
    inside = np.sort(polynomial.deriv().roots().real)
    x = np.concatenate([[-1.0], inside, [1.0]])
    values = polynomial(x)
    matrix = values[:, None] / values / (x[:, None] - x + np.eye(order + 1))
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return x, 2 / (order * (order + 1) * values**2), matrix


class Grid(NamedTuple):
    """Nodes of cells, and the gradient on them.

    Attributes
    ----------
    root : csr_matrix
        The matrix B. The eigenvalues of B^T B are those of -Laplace, k^2 in units of 1/radius^2. It has two
        rows per node of a cell and a column per free node. Functions are multiplied by the root of the mass,
        so that |v|^2 is the integral of the square.
    points : ndarray, shape (E, n, n, 2)
        The nodes of each cell.
    node : ndarray of int, shape (E, n, n)
        Index of each of them among the M different nodes.
    mass : ndarray, shape (M,)
        Diagonal of the mass matrix.
    free : ndarray of bool, shape (M,)
        Whether a node is free, that is, the function there is not fixed to 0.
    """

    root: sparse.csr_matrix
    points: Floats
    node: NDArray[np.intp]
    mass: Floats
    free: NDArray[np.bool_]

    def functions(self, vectors: Floats) -> Floats:
        """Return eigenvectors, shape (free nodes, F), as functions at the nodes of cells, (F, E, n, n)."""
        values = np.zeros((vectors.shape[1], len(self.mass)))
        values[:, self.free] = vectors.T / np.sqrt(self.mass[self.free])
        return values[:, self.node]


def grid(cells: Sequence[Cell], order: int, fixed: Callable[[Floats], NDArray[np.bool_]]) -> Grid:
    """Return the nodes of cells, and the gradient of functions on them.

    Parameters
    ----------
    cells : sequence of Cell
        Neighbouring cells share whole edges.
    order : int
        Degree of the polynomials.
    fixed : callable
        Returns at which points, shape (N, 2), functions are 0 (Dirichlet); the rest of the edge is free.
    """
    x, weights, slope = nodes(order)
    s, t = np.meshgrid((x + 1) / 2, (x + 1) / 2, indexing="ij")
    points = np.stack([cell.points(s, t) for cell in cells])
    along = np.einsum("ij,ejkc->eikc", slope, points)
    across = np.einsum("kj,eijc->eikc", slope, points)
    inverse = np.linalg.inv(np.stack([along, across], axis=-1))
    area = weights[:, None] * weights / np.abs(np.linalg.det(inverse))
    flat, node = _joined(points.reshape(-1, 2))
    node, free = node.reshape(area.shape), ~fixed(flat)
    mass = np.bincount(node.ravel(), area.ravel())
    shape = (*area.shape, order + 1)
    columns = (
        np.broadcast_to(node.transpose(0, 2, 1)[:, None], shape),
        np.broadcast_to(node[:, :, None], shape),
    )
    slopes = (slope[None, :, None], slope[None, None])
    root, row = np.sqrt(area), np.arange(area.size).reshape(area.shape)
    matrix = sparse.csr_matrix((2 * area.size, len(mass)))
    for part in range(2):
        for direction in range(2):
            values = (root * inverse[..., direction, part])[..., None] * slopes[direction]
            rows = np.broadcast_to((row + part * area.size)[..., None], shape)
            entries = (rows.ravel(), columns[direction].ravel())
            matrix += sparse.csr_matrix((values.ravel(), entries), shape=matrix.shape)
    matrix.eliminate_zeros()
    root_of_mass = sparse.diags_array(1 / np.sqrt(mass))
    return Grid((matrix @ root_of_mass)[:, free], points, node, np.asarray(mass, np.float64), free)


def _joined(points: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the different points, shape (M, 2), and the index of each point among them."""
    pairs = cKDTree(points).query_pairs(_SAME, output_type="ndarray")
    links = sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points), len(points)))
    _, node = csgraph.connected_components(links, directed=False)
    return points[np.unique(node, return_index=True)[1]], node


def eigenvalues(root: sparse.csr_matrix, low: float, high: float) -> tuple[int, Floats]:
    """Return the number of eigenvalues of B^T B below an interval, and those in it, in rising order."""
    below, values, _ = eigenvectors(root, low, high)
    return below, values


def eigenvectors(root: sparse.csr_matrix, low: float, high: float) -> tuple[int, Floats, Floats]:
    """Return the number of eigenvalues of B^T B below an interval, those in it, and their eigenvectors.

    Parameters
    ----------
    root : csr_matrix
        The matrix B.
    low, high : float
        The interval, low < high; low may be 0.

    Returns
    -------
    int; ndarray, shape (F,), in rising order; ndarray, shape (M, F), of norm 1

    Raises
    ------
    WorkError
        If the eigenvalues cannot be counted or not all are found.

    Notes
    -----
    By Sylvester's law of inertia, the negative pivots of B^T B - s count the eigenvalues below s. This checks
    shift-and-invert Lanczos iterations. The values are Rayleigh quotients |B v|^2 / |v|^2.
    """
    matrix = (root.T @ root).tocsc()
    below = _factors(matrix, low)[1] if low > 0 else 0
    count = _factors(matrix, high)[1] - below
    if not count:
        return below, np.zeros(0), np.zeros((matrix.shape[0], 0))
    middle = (low + high) / 2
    factors, _ = _factors(matrix, middle)
    inverse = linalg.LinearOperator(matrix.shape, factors.solve, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(matrix.shape[0])  # the same levels every time
    asked = min(count + _MORE, matrix.shape[0] - 2)
    _, vectors = linalg.eigsh(matrix, asked, sigma=middle, OPinv=inverse, v0=start, tol=1e-13)
    vectors /= np.sqrt(np.square(vectors).sum(axis=0))
    values = np.square(root @ vectors).sum(axis=0)
    inside = np.flatnonzero((values >= low) & (values < high))
    inside = inside[np.argsort(values[inside])]
    found: Floats = values[inside]
    if len(found) != count:
        raise WorkError(
            f"only {len(found)} of {count} levels with k^2 from {low:g} to {high:g} were found: "
            "change the ends of the range slightly"
        )
    return below, found, vectors[:, inside]


def _factors(matrix: sparse.csc_matrix, shift: float) -> tuple[linalg.SuperLU, int]:
    """Return the factors of a matrix minus a shift, and its number of negative eigenvalues."""
    shifted = (matrix - shift * sparse.eye_array(matrix.shape[0])).tocsc()
    factors = linalg.splu(
        shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    if not np.array_equal(factors.perm_r, factors.perm_c):
        raise WorkError(f"the levels below k^2 = {shift:g} cannot be counted: give another range")
    return factors, int((factors.U.diagonal() < 0).sum())
