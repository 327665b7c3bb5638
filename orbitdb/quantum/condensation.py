"""Eigenvalues of the Laplacian on spectral elements, by static condensation.

The stiffness matrix K of each cell's interior is diagonalised once, K = Q diag(l) Q^T. At any shift s,
eliminating the interiors then costs only a division by l - s. What remains is the Schur complement on the
rims of the cells, with about an eighth of the unknowns. By Sylvester's law of inertia and Haynsworth's
inertia additivity formula, the number of eigenvalues below s is the number of negative pivots of the Schur
complement plus the number of l below s.

Sources: E. V. Haynsworth, Linear Algebra Appl. 1 (1968) 73; W. H. Wittrick and F. W. Williams, Q. J. Mech.
Appl. Math. 24 (1971) 263.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg
from threadpoolctl import threadpool_limits

from orbitdb.arrays import Floats
from orbitdb.errors import WorkError
from orbitdb.quantum.elements import Grid

Fixed = Callable[[Floats], NDArray[np.bool_]]
"""Returns whether functions must be 0 (Dirichlet) at each point, shape (..., 2); other edges are Neumann."""

_MORE = 6
"""Number of extra eigenvalues, outside the interval, that make the iterations converge faster."""
_NEAR = 1e-7
"""Minimum relative distance between a shift and any l, where the Schur complement has a pole."""
_UNSURE = 1e-12
"""Relative distance from a shift within which rounding decides whether an eigenvalue is counted below it."""


_linear_algebra = threading.RLock()


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep linear algebra on one thread, for one caller at a time; then restore the caller's limit.

    Several threads are slower for matrices of this size, and their number would change the last bits.
    """
    with _linear_algebra, threadpool_limits(1, "blas"):
        yield


class Interiors:
    """The stiffness matrices of the cells, with their interiors diagonalised.

    Nodal values are multiplied by the square root of the mass, so that the mass matrix is the identity.

    Attributes
    ----------
    grid : Grid
    rim : ndarray of bool, shape (n n,)
        Whether each node of a cell is on the rim of the cell; r nodes are.
    scale : ndarray, shape (E, n n)
        Inverse square root of the mass of each node.
    levels : ndarray, shape (E, m)
        The eigenvalues l of the interiors.
    modes : ndarray, shape (E, m, m)
        The eigenvectors Q, in columns.
    coupling : ndarray, shape (E, r, m)
        Stiffness between the nodes of the rim and the modes.
    stiffness : ndarray, shape (E, r, r)
        Stiffness between the nodes of the rim, for each cell alone; at a node shared by several cells, their
        contributions add up.
    """

    def __init__(self, grid: Grid) -> None:
        count, n, _ = grid.node.shape
        inside = np.zeros((n, n), np.bool_)
        inside[1:-1, 1:-1] = True
        self.grid, self.rim = grid, ~inside.ravel()
        mass = np.bincount(grid.node.ravel(), grid.weight.ravel())
        self.scale = 1 / np.sqrt(mass[grid.node]).reshape(count, -1)
        r, m = np.count_nonzero(self.rim), np.count_nonzero(inside)
        self.levels, self.modes = np.empty((count, m)), np.empty((count, m, m))
        self.coupling, self.stiffness = np.empty((count, r, m)), np.empty((count, r, r))
        for cell, scale in enumerate(self.scale):
            alone = grid._replace(slope=grid.slope[:, :, cell, None])
            slopes = alone.gradient(np.diag(scale).reshape(-1, 1, n, n))
            slopes = slopes.swapaxes(0, 1).reshape(n * n, -1)
            rim, within = slopes[self.rim], slopes[~self.rim]
            self.levels[cell], modes = np.linalg.eigh(within @ within.T)
            self.modes[cell], self.coupling[cell] = modes, rim @ within.T @ modes
            self.stiffness[cell] = rim @ rim.T

    def clear(self, shift: float, away: float) -> float:
        """Return the shift, moved away from any pole nearby: up if `away` is 1, down if it is -1."""
        while np.abs(self.levels - shift).min() < _NEAR * shift:
            shift *= 1 + 2 * away * _NEAR
        return shift


class _Condensed:
    """Cells whose rims are joined at their common nodes, without the fixed nodes.

    A vector contains the values at the `size` free nodes of the rims, then the amplitudes of the modes. Each
    rim node has its index among the free nodes in `node`, shape (E, r); a fixed node has `size` there.
    """

    def __init__(self, of: Interiors, fixed: Fixed) -> None:
        points, node = of.grid.points.reshape(*of.scale.shape, 2), of.grid.node.reshape(of.scale.shape)
        node = np.where(fixed(points[:, of.rim]), -1, node[:, of.rim])
        free = np.unique(node[node >= 0])
        self.of, self.size = of, len(free)
        self.node = np.where(node < 0, len(free), np.searchsorted(free, node))

    def factors(self, shift: float) -> tuple[linalg.SuperLU, int]:
        """Return the factors of the Schur complement at a shift, and the number of eigenvalues below it."""
        of, n = self.of, self.size
        blocks = of.stiffness - of.coupling / (of.levels - shift)[:, None] @ of.coupling.swapaxes(1, 2)
        row = np.broadcast_to(self.node[:, :, None], blocks.shape)
        entries = (blocks.ravel(), (row.ravel(), row.swapaxes(1, 2).ravel()))
        whole = sparse.csc_array(entries, shape=(n + 1, n + 1))[:n, :n] - shift * sparse.eye_array(n)
        factors = linalg.splu(
            whole.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
        if not np.array_equal(factors.perm_r, factors.perm_c):
            raise WorkError(f"the levels below k^2 = {shift:g} cannot be counted: give another range")
        return factors, int((factors.U.diagonal() < 0).sum() + (of.levels < shift).sum())

    def inverse(self, shift: float) -> Callable[[Floats], Floats]:
        """Return a function that multiplies a vector by the inverse of (stiffness matrix - shift)."""
        of, n, (factors, _) = self.of, self.size, self.factors(shift)
        flexible, back = 1 / (of.levels - shift), np.ascontiguousarray(of.coupling.swapaxes(1, 2))

        def solve(vector: Floats) -> Floats:
            modes = vector[n:].reshape(flexible.shape) * flexible
            loads = (of.coupling @ modes[..., None])[..., 0]
            rims = factors.solve(vector[:n] - np.bincount(self.node.ravel(), loads.ravel(), n + 1)[:n])
            modes -= flexible * (back @ np.append(rims, 0.0)[self.node][..., None])[..., 0]
            return np.concatenate([rims, modes.ravel()])

        return solve

    def functions(self, vectors: Floats) -> Floats:
        """Return the normalised functions, shape (F, E, n, n), of vectors, shape (size + E m, F)."""
        of, count = self.of, vectors.shape[1]
        rims = np.concatenate([vectors[: self.size], np.zeros((1, count))])[self.node]
        values = np.empty((count, *of.scale.shape))
        values[:, :, of.rim] = np.moveaxis(rims, -1, 0)
        values[:, :, ~of.rim] = np.moveaxis(
            of.modes @ vectors[self.size :].reshape(*of.levels.shape, -1), -1, 0
        )
        values = (values * of.scale).reshape(count, *of.grid.node.shape)
        return values / np.sqrt((values**2 * of.grid.weight).sum(axis=(1, 2, 3), keepdims=True))


def eigenfunctions(of: Interiors, fixed: Fixed, low: float, high: float) -> tuple[int, Floats, Floats]:
    """Return the number of eigenvalues of -Laplace below an interval, and the eigenpairs in the interval.

    The F eigenvalues ascend. Their eigenfunctions at the nodes of the cells have the shape (F, E, n, n), and
    the integral of the square of each is 1. An end at a pole of the Schur complement is moved outwards.

    Shift-and-invert Lanczos iterations find the eigenfunctions. The count checks that none is missing, and
    `WorkError` is raised if one is. Each eigenvalue is computed as the energy of its function. If rounding
    leaves open on which side of an end it lies, the count decides.
    """
    condensed = _Condensed(of, fixed)
    low, high = of.clear(low, -1), of.clear(high, 1)
    below = condensed.factors(low)[1] if low > 0 else 0
    count = condensed.factors(high)[1] - below
    if not count:
        return below, np.zeros(0), np.zeros((0, *of.grid.node.shape))
    middle = of.clear((low + high) / 2, 1)
    size = condensed.size + of.levels.size
    inverse = linalg.LinearOperator((size, size), condensed.inverse(middle), dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(size)  # a fixed seed gives reproducible levels
    asked = min(count + _MORE, size - 2)
    _, vectors = linalg.eigsh(inverse, asked, sigma=middle, OPinv=inverse, v0=start, tol=1e-13)
    functions = condensed.functions(vectors)
    values = of.grid.energy(functions).sum(axis=1)
    order = np.argsort(values)
    for wider in (0.0, _UNSURE, -_UNSURE):
        ends = np.searchsorted(values[order], [low * (1 - wider), high * (1 + wider)])
        inside = order[slice(*ends)]
        if len(inside) == count:
            break
    else:
        raise WorkError(
            f"only {len(inside)} of {count} levels with k^2 from {low:g} to {high:g} were found: "
            "change the ends of the range slightly"
        )
    return below, values[inside], functions[inside]
