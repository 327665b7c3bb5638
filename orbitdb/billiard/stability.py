"""Stability of orbits: monodromy matrix, Lyapunov exponent, the Hessian of the length and its systems.

The paper's matrices (eqs. 3 and 4) contain two errors. If they act on (d theta, d y), and a factor -1 is
taken out at every bounce, a straight bounce has the matrix [[-1, 0], [-l, -1]] and a bounce on a semicircle
[[2 al l - 1, 2 al], [-l, -1]] with al = 1 / sin(theta), where l is the length of the path *before* the bounce
in both. As printed, the first matrix has a different sign and the second one the path after the bounce;
hyperbolic orbits would then get lambda = 0.

Between the midpoints of chords, a run acts as one kick 2 k / sin(theta) and a leg as one drift D. Therefore
tr M - 2 is a sum of products of positive numbers, in which nothing cancels, however small or large it is
(docs/proof.md).
"""

from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats, Indices, Words
from orbitdb.billiard.legs import Derivatives, following, preceding
from orbitdb.billiard.stadium import ANTICLOCKWISE, STRAIGHT, Stadium

_LARGE = 1e120


def exponent(slopes: Derivatives) -> Floats:
    """Return lambda of N orbits, the logarithm of the largest modulus of an eigenvalue of M, shape (N,).

    Let 1 + X, with X = [[0, D], [K, K D]], be the factor of a run and the leg after it, and 1 + P the product
    of the factors so far. The update P <- P X + P + X has only positive terms. A power of two is stored
    separately, so words of any length stay in range. The factors are multiplied in the order of time, which
    gives M of the reversed orbit; it has the same trace. With t = |tr M| - 2, lambda is 2
    arsinh(sqrt(t) / 2).
    """
    unit = np.ones(slopes.between_centres.shape[1])
    doublings = np.zeros(len(unit), dtype=np.int64)
    p = np.zeros((4, len(unit)))
    for drift, stiffness in zip(slopes.between_centres, slopes.stiffness, strict=True):
        kick = 1 / stiffness
        p = np.stack([
            p[0] + p[1] * kick,
            p[1] + p[0] * drift + p[1] * kick * drift + unit * drift,
            p[2] + p[3] * kick + unit * kick,
            p[3] + p[2] * drift + p[3] * kick * drift + unit * kick * drift,
        ])  # fmt: skip
        size = p.max(axis=0)
        if size.max() > _LARGE:
            power = np.where(size > _LARGE, np.frexp(size)[1], 0)
            p, unit = np.ldexp(p, -power), np.ldexp(unit, -power)
            doublings += power
    excess = p[0] + p[3]
    return np.where(
        doublings > 0, np.log(excess) + doublings * np.log(2.0), 2 * np.arcsinh(np.sqrt(excess) / 2)
    )


def product_of(factors: Floats) -> tuple[Floats, Indices]:
    """Multiply N times p matrices of 2 x 2, shape (2, 2, p, N), each later one from the left.

    Returns the products, shape (2, 2, N), and the powers of two taken out of them, shape (N,), so that words
    of any length stay in range. `exponent` does not use it, because tr M - 2 would cancel.
    """
    product = factors[:, :, 0]
    doublings = np.zeros(product.shape[-1], np.int64)
    for n in range(1, factors.shape[2]):
        product = np.einsum("ijn,jkn->ikn", factors[:, :, n], product)
        size = np.abs(product).max(axis=(0, 1))
        if (large := size > _LARGE).any():
            power = np.where(large, np.frexp(size)[1], 0)
            product = np.ldexp(product, -power)
            doublings += power
    return product, doublings


def bounce_matrices(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the monodromy matrix of every bounce of orbits, shape (N, p, 2, 2), as in the paper.

    These are eqs. (3) and (4) of Biham and Kvale, corrected as described at the top of this module. They act
    on (d theta, d y) and are computed from the bounces alone, which makes them an independent check of
    `exponent`.
    """
    links = Links.of(stadium, words, coordinates)
    path = links.before
    straight = STRAIGHT[words]
    bend = np.where(straight, 0.0, 2 / np.sqrt(1 - links.cos_in**2))
    top = np.stack([bend * path - 1, bend], axis=-1)
    bottom = np.stack([-path, -np.ones_like(path)], axis=-1)
    return np.stack([top, bottom], axis=-2)


def hessian(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the Hessian of the length with respect to all p coordinates of orbits, shape (N, p, p).

    At an orbit, det H = prod(-b_i) (tr M - 2), where the b_i are the off-diagonal entries. If p = 2, both
    links contribute to the same entry, and b_i is the contribution of one link (`couplings_of`).
    """
    links, (n, p) = Links.of(stadium, words, coordinates), words.shape
    couplings = couplings_of(links, stadium.tangents(words, coordinates))
    sin_in, sin_out = np.sqrt(1 - links.cos_in**2), np.sqrt(1 - links.cos_out**2)
    curved = np.where(STRAIGHT[words], 0.0, sin_in + sin_out)
    matrix = np.zeros((n, p, p))
    own, after = np.arange(p), np.roll(np.arange(p), -1)
    matrix[:, own, own] += sin_in**2 / links.before + sin_out**2 / links.after - curved
    matrix[:, own, after] += couplings
    matrix[:, after, own] += couplings
    return matrix


def couplings_of(links: "Links", tangents: Floats) -> Floats:
    """Return b_i, the mixed derivative of each link's length with respect to its ends, shape (N, p).

    `tangents` contains the unit tangents at the bounces, shape (N, p, 2).
    """
    dot = (tangents * np.roll(tangents, -1, axis=1)).sum(axis=-1)
    return (links.cos_out * np.roll(links.cos_in, -1, axis=1) - dot) / links.after


@dataclass(frozen=True, eq=False)
class Links:
    """The links of closed paths that meet at each bounce, as arrays of shape (N, p)."""

    before: Floats  # length of the link that arrives at the bounce
    after: Floats  # length of the link that leaves it
    cos_in: Floats  # cosine of the angle between the tangent and the arriving direction
    cos_out: Floats  # cosine of the angle between the tangent and the leaving direction

    @classmethod
    def of(cls, stadium: Stadium, words: Words, coordinates: Floats) -> "Links":
        """Measure the links of closed paths, which need not be orbits."""
        symbols, coordinates = np.ascontiguousarray(words.T), np.ascontiguousarray(coordinates.T)
        (x, y), (along_x, along_y) = stadium.frames(symbols, coordinates)  # bounces first: faster shifts
        step_x, step_y = following(x) - x, following(y) - y
        path = np.sqrt(step_x**2 + step_y**2)
        ahead_x, ahead_y = step_x / path, step_y / path
        cos_out = along_x * ahead_x + along_y * ahead_y
        cos_in = along_x * preceding(ahead_x) + along_y * preceding(ahead_y)
        return cls(preceding(path).T, path.T, cos_in.T, cos_out.T)


def forces(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the violation of the law of reflection at each bounce of a closed path, shape (N, p).

    It is cos theta_in - cos theta_out, the derivative of the length with respect to the coordinate of the
    bounce. Its modulus is the force in Biham and Kvale, eq. (2), and the sum of its squares is V in eq. (1).
    """
    links = Links.of(stadium, words, coordinates)
    return links.cos_in - links.cos_out


def birkhoff(stadium: Stadium, words: Words, coordinates: Floats) -> tuple[Floats, Floats]:
    """Return the bounces of closed paths in phase space, as two arrays of shape (N, p).

    The first contains the arc length (`Stadium.arclength`), the second the sine of the angle between the
    outgoing path and the normal, which is positive if the path goes anticlockwise.
    """
    leaving = Links.of(stadium, words, coordinates).cos_out
    return stadium.arclength(words, coordinates), ANTICLOCKWISE[words] * leaving


_LONG = 64
"""Above this number of unknowns, SciPy's banded solver is faster than a loop over the unknowns."""


def solve_cyclic(diagonal: Floats, beside: Floats, rhs: Floats, definite: bool = True) -> Floats:
    """Solve N cyclic tridiagonal systems of m >= 2 unknowns; rhs has shape (r, m, N).

    They are positive definite, unless `definite` is false, or may be eliminated in any order all the same.
    The last unknown is split off. The others then form a tridiagonal system, which is solved for one
    additional right-hand side, the column of the last unknown. The numbers may be of any type, including
    balls.
    """
    column = np.zeros_like(diagonal[:-1])
    column[0] += beside[0]
    column[-1] += beside[-1]
    long = definite and len(diagonal) > _LONG and diagonal.dtype == np.float64
    eliminate = _tridiagonal_long if long else tridiagonal
    solution = eliminate(diagonal[:-1], beside[1:-1], np.concatenate([rhs[:, :-1], column[None]]))
    plain, through = solution[:-1], solution[-1]
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
