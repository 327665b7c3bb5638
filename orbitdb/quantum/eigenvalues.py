"""The eigenvalues of a sparse symmetric matrix in an interval, all of them."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import linalg

from orbitdb.errors import WorkError

Floats = NDArray[np.float64]

_MORE = 6
"""Eigenvalues beyond those of an interval that are asked for: iterations then settle sooner."""


def eigenvalues(root: sparse.csr_matrix, low: float, high: float) -> tuple[int, Floats]:
    """Return how many eigenvalues of B^T B lie below an interval, and those in it.

    Parameters
    ----------
    root : csr_matrix
        B.
    low, high : float
        The interval, low < high; low may be 0.

    Returns
    -------
    int; ndarray, in rising order

    Raises
    ------
    WorkError
        If not all of them are found.

    Notes
    -----
    By Sylvester's law of inertia the negative pivots of B^T B - s are as many as eigenvalues below s: that
    counts what shifted and inverted Lanczos iterations then have to find. Values are Rayleigh quotients
    |B v|^2 / |v|^2.
    """
    matrix = (root.T @ root).tocsc()
    below = _factors(matrix, low)[1] if low > 0 else 0
    count = _factors(matrix, high)[1] - below
    if not count:
        return below, np.zeros(0)
    middle = (low + high) / 2
    factors, _ = _factors(matrix, middle)
    inverse = linalg.LinearOperator(matrix.shape, factors.solve, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(matrix.shape[0])  # the same levels every time
    asked = min(count + _MORE, matrix.shape[0] - 2)
    _, vectors = linalg.eigsh(matrix, asked, sigma=middle, OPinv=inverse, v0=start, tol=1e-13)
    values = np.sort((np.square(root @ vectors)).sum(axis=0) / np.square(vectors).sum(axis=0))
    found: Floats = values[(values >= low) & (values < high)]
    if len(found) != count:
        raise WorkError(
            f"only {len(found)} of {count} levels with k^2 from {low:g} to {high:g} were found: "
            "change the ends of the range slightly"
        )
    return below, found


def _factors(matrix: sparse.csc_matrix, shift: float) -> tuple[linalg.SuperLU, int]:
    """Return the factors of a matrix less a shift, and its number of negative eigenvalues."""
    shifted = (matrix - shift * sparse.eye_array(matrix.shape[0])).tocsc()
    factors = linalg.splu(
        shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    if not np.array_equal(factors.perm_r, factors.perm_c):
        raise WorkError(f"the levels below k^2 = {shift:g} cannot be counted: give another range")
    return factors, int((factors.U.diagonal() < 0).sum())
