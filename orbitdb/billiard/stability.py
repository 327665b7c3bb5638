"""Stability of orbits: monodromy matrix, Lyapunov exponent, and the Hessian of the length.

The paper's matrices (eqs. 3 and 4) have two slips. In (d theta, d y) and with -1 taken out at every
bounce, a straight bounce is [[-1, 0], [-l, -1]] and a bounce on a semicircle
[[2 al l - 1, 2 al], [-l, -1]], al = 1 / sin(theta), both with l the path *before* the bounce. As
printed, with another sign in the first matrix and the path after the bounce in the second, hyperbolic orbits
would get lambda = 0.

Between midpoints of chords a run is one kick 2 k / sin(theta) and a leg one drift D, so that tr M - 2 is a
sum of products of positive numbers: nothing cancels, however small or large it is (docs/proof.md).
"""

from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats, Words
from orbitdb.billiard.legs import Derivatives, following, preceding
from orbitdb.billiard.stadium import ANTICLOCKWISE, STRAIGHT, Stadium
from orbitdb.equality import ByValue

_LARGE = 1e120


def exponent(slopes: Derivatives) -> Floats:
    """Return lambda of N orbits, the logarithm of the largest modulus of an eigenvalue of M, shape (N,).

    Let X = [[0, D], [K, K D]] be the factor of a run and the leg after it, minus the unit matrix, and P the
    product so far, minus the unit matrix. P <- P X + P + X has only positive terms; a power of two is stored
    separately, so words of any length stay in range. The factors are in the order of time, which gives M of
    the reversed orbit, with the same trace. From t = |tr M| - 2, lambda = 2 arsinh(sqrt(t) / 2).
    """
    unit = np.ones(slopes.beyond.shape[1])
    doublings = np.zeros(len(unit), dtype=np.int64)
    p = np.zeros((4, len(unit)))
    for drift, stiffness in zip(slopes.beyond, slopes.stiffness, strict=True):
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
    exponents: Floats = np.where(
        doublings > 0, np.log(excess) + doublings * np.log(2.0), 2 * np.arcsinh(np.sqrt(excess) / 2)
    )
    return exponents


def bounce_matrices(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the monodromy matrix of every bounce of orbits, shape (N, p, 2, 2), as in the paper.

    Biham and Kvale, eqs. (3) and (4), corrected as in this module's docstring. They act on (d theta, d y) and
    are computed from the bounces alone, which makes them an independent check of `exponent`.
    """
    links = Links.of(stadium, words, coordinates)
    path = links.before
    straight = STRAIGHT[words]
    bend = np.where(straight, 0.0, 2 / np.sqrt(1 - links.cos_in**2))
    top = np.stack([bend * path - 1, bend], axis=-1)
    bottom = np.stack([-path, -np.ones_like(path)], axis=-1)
    return np.stack([top, bottom], axis=-2)


def hessian(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the Hessian of the length in all p coordinates of orbits, shape (N, p, p).

    The identity det H = prod(-b_i) (tr M - 2), with b_i the off-diagonal entries, holds at an orbit;
    at p = 2 both links fall on one entry and b_i is each link's own part (`couplings_of`).
    """
    links, (n, p) = Links.of(stadium, words, coordinates), words.shape
    couplings = couplings_of(links, stadium.tangents(words, coordinates))
    sin_in, sin_out = np.sqrt(1 - links.cos_in**2), np.sqrt(1 - links.cos_out**2)
    curved = np.where(STRAIGHT[words], 0.0, sin_in + sin_out)
    matrix = np.zeros((n, p, p))
    here = np.arange(p)
    after = np.roll(here, -1)
    matrix[:, here, here] += sin_in**2 / links.before + sin_out**2 / links.after - curved
    matrix[:, here, after] += couplings
    matrix[:, after, here] += couplings
    return matrix


def couplings_of(links: "Links", tangents: Floats) -> Floats:
    """Return b_i, the mixed second derivative of each link's length in its two ends, shape (N, p).

    The tangents are those at the bounces, shape (N, p, 2).
    """
    dot = (tangents * np.roll(tangents, -1, axis=1)).sum(axis=-1)
    found: Floats = (links.cos_out * np.roll(links.cos_in, -1, axis=1) - dot) / links.after
    return found


@dataclass(frozen=True, eq=False)
class Links(ByValue):
    """The links of closed paths as seen from each bounce; all of shape (N, p)."""

    before: Floats  # length of the path that arrives at the bounce
    after: Floats  # length of the path that leaves it
    cos_in: Floats  # cosine of the angle between the tangent and the arriving direction
    cos_out: Floats  # the same for the leaving direction

    @classmethod
    def of(cls, stadium: Stadium, words: Words, coordinates: Floats) -> "Links":
        """Measure the links of closed paths, which need not be orbits."""
        symbols, places = np.ascontiguousarray(words.T), np.ascontiguousarray(coordinates.T)
        (x, y), (along_x, along_y) = stadium.frames(symbols, places)  # bounces first: whole rows move
        step_x, step_y = following(x) - x, following(y) - y
        path = np.sqrt(step_x**2 + step_y**2)
        ahead_x, ahead_y = step_x / path, step_y / path
        cos_out = along_x * ahead_x + along_y * ahead_y
        cos_in = along_x * preceding(ahead_x) + along_y * preceding(ahead_y)
        return cls(preceding(path).T, path.T, cos_in.T, cos_out.T)


def forces(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the violation of the law of reflection at each bounce of a closed path, shape (N, p).

    cos theta_in - cos theta_out, the derivative of the length in the coordinate of the bounce; its modulus is
    the force in Biham and Kvale, eq. (2).
    """
    links = Links.of(stadium, words, coordinates)
    return links.cos_in - links.cos_out


def birkhoff(stadium: Stadium, words: Words, coordinates: Floats) -> tuple[Floats, Floats]:
    """Return the bounces of closed paths in phase space, two arrays of shape (N, p).

    The arc length (`Stadium.arclength`), and the sine of the angle between the outgoing path and the normal,
    positive if it goes anticlockwise.
    """
    leaving = Links.of(stadium, words, coordinates).cos_out
    return stadium.arclength(words, coordinates), ANTICLOCKWISE[words] * leaving
