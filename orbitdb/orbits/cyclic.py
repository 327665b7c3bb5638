"""Solve many cyclic tridiagonal systems at once, such as those of the Hessian of the length."""

import numpy as np

from orbitdb.arrays import Floats

_LONG = 64
"""Above this number of unknowns, SciPy's banded solver is faster than a loop over the unknowns."""


def solve_cyclic(diagonal: Floats, beside: Floats, rhs: Floats) -> Floats:
    """Solve N positive definite cyclic tridiagonal systems of m >= 2 unknowns; rhs has shape (r, m, N).

    The last unknown is split off. The others then form a tridiagonal system, which is solved for one
    additional right-hand side, the column of the last unknown. The numbers may be of any type, including
    balls.
    """
    column = np.zeros_like(diagonal[:-1])
    column[0] += beside[0]
    column[-1] += beside[-1]
    long = len(diagonal) > _LONG and diagonal.dtype == np.float64
    eliminate = _tridiagonal_long if long else tridiagonal
    found = eliminate(diagonal[:-1], beside[1:-1], np.concatenate([rhs[:, :-1], column[None]]))
    plain, through = found[:-1], found[-1]
    bottom = diagonal[-1] - _end_terms(column, through)
    last = np.stack([(b[-1] - _end_terms(column, x)) / bottom for b, x in zip(rhs, plain, strict=True)])
    return np.concatenate([plain - through * last[:, None], last[:, None]], axis=1)


def _end_terms(column: Floats, x: Floats) -> Floats:
    """Return the product of x with a column whose entries are zero except at its two ends."""
    first: Floats = column[0] * x[0]
    return first + column[-1] * x[-1] if len(column) > 1 else first


def tridiagonal(diagonal: Floats, beside: Floats, rhs: Floats) -> Floats:
    """Solve N positive definite tridiagonal systems of m unknowns for c right-hand sides, shape (c, m, N).

    The diagonals have shape (m, N). Entry i of `beside`, shape (m - 1, N), couples unknowns i and i + 1.
    """
    pivots = np.empty_like(diagonal)
    x = rhs.copy()
    pivots[0] = diagonal[0]
    for i in range(1, len(diagonal)):
        factor = beside[i - 1] / pivots[i - 1]
        pivots[i] = diagonal[i] - factor * beside[i - 1]
        x[:, i] -= factor * x[:, i - 1]
    x[:, -1] /= pivots[-1]
    for i in range(len(diagonal) - 2, -1, -1):
        x[:, i] = (x[:, i] - beside[i] * x[:, i + 1]) / pivots[i]
    return x


def _tridiagonal_long(diagonal: Floats, beside: Floats, rhs: Floats) -> Floats:
    """Solve the same systems as `tridiagonal`, but word by word, in compiled code."""
    from scipy.linalg import solveh_banded

    x = np.empty_like(rhs)
    for word in range(diagonal.shape[1]):
        bands = np.stack([np.concatenate([[0.0], beside[:, word]]), diagonal[:, word]])
        x[:, :, word] = solveh_banded(bands, rhs[:, :, word].T).T
    return x
