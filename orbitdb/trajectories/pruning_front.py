"""The pruning front: the border of the orbits in the symbol plane.

The paths that leave a joint of wall and semicircle at all angles theta have their own points (gamma, delta) in
the symbol plane (`orbitdb.symbols.plane`). As theta grows from 0 to pi, gamma rises and delta falls. These
points are the *front*: no path of the billiard has a point beyond it, because gamma and delta rise together
along a wall or semicircle, and the front is where it ends.

The four joints are images of one another, so all fronts follow from the paths that leave the joint (-a, -1).
As bounces on the bottom wall, they bound all bounces on walls from above; as bounces on the left semicircle,
all bounces on semicircles. The joint at the other end bounds them from below: its front is the first one,
turned by half a turn about (1/2, 1/2). By time reversal, delta at theta is gamma at pi - theta.

Everything here is measured, not proved: the order of the paths, that a word whose points all lie on the
allowed side is an orbit, and the paths themselves, which doubles follow for `LETTERS` bounces. Statuses never
depend on it.

Source: pruning fronts are Hansen's.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks, Words
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.symbols.plane import ANTICLOCKWISE, CLOCKWISE, PIECE, ordinate, symbol_plane
from orbitdb.trajectories.trajectory import Rays, bounce

ANGLES = 1 << 12
"""Number of angles in (0, pi) at which a front is computed; points between two of them are bisected."""

_BISECTIONS = 60
"""Number of bisections after which neighbouring angles are equal."""

_LEFT = 3
"""The piece of the boundary that is the left semicircle."""


class Front(NamedTuple):
    """The upper front of the bounces on walls or on semicircles; all arrays have shape (T,)."""

    angle: Floats  # theta in (0, pi), between the outgoing path and the boundary (radians)
    gamma: Floats  # does not fall
    delta: Floats  # does not rise

    @property
    def lower(self) -> "Front":
        """The lower front of the same bounces, its points also from left to right."""
        return Front(self.angle, 1 - self.gamma[::-1], 1 - self.delta[::-1])


class PruningFront:
    """The fronts of a stadium, and the words that they allow.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium, or its half length.
    angles : int, optional
        Number of angles at which to follow the paths from the joint.

    Attributes
    ----------
    stadium : Stadium
    walls, semicircles : Front
        The upper fronts of bounces on straight walls and on semicircles.

    Examples
    --------
    >>> from orbitdb.symbols.words import from_strings
    >>> PruningFront(1.6).allows(from_strings(["12113553", "11335555"])).tolist()
    [True, False]
    """

    def __init__(self, stadium: Stadium | float, angles: int = ANGLES) -> None:
        self.stadium = as_stadium(stadium)
        theta = (np.arange(angles) + 0.5) * (math.pi / angles)
        self.walls, self.semicircles = (self._front(theta, curved) for curved in (False, True))

    def _front(self, theta: Floats, curved: bool) -> Front:
        gamma, delta = points_of_joint(self.stadium, theta, curved)
        return Front(theta, np.maximum.accumulate(gamma), np.minimum.accumulate(delta))

    def allows(self, words: Words) -> Marks:
        """Tell which admissible words, shape (N, p), have no point beyond a front, shape (N,).

        These are the orbits. Words with a bounce exactly at a joint have a point on a front, and are not
        allowed.

        Raises
        ------
        WordError
            If the argument is not an array of admissible words.
        """
        return self.allows_points(symbol_plane(words), PIECE[words] % 2 == 1).all(axis=1)

    def allows_points(self, points: Floats, curved: Marks) -> Marks:
        """Tell which points of the plane are on the allowed sides of both of their fronts.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            gamma and delta.
        curved : ndarray of bool, shape (...)
            Whether the points belong to bounces on semicircles.
        """
        allowed = np.empty(curved.shape, dtype=np.bool_)
        for kind, front in ((False, self.walls), (True, self.semicircles)):
            gamma, delta = points[curved == kind].T
            allowed[curved == kind] = self._below(front, kind, gamma, delta) & self._below(
                front, kind, 1 - gamma, 1 - delta
            )
        return allowed

    def _below(self, front: Front, curved: bool, gamma: Floats, delta: Floats) -> Marks:
        """Tell which points are below an upper front.

        A point is below the front if a point of the front has both a larger gamma and a larger delta, and
        beyond it if one has both smaller. If the two neighbouring angles decide neither, they are bisected.
        """
        angle, fronts_gamma, fronts_delta = (
            np.concatenate([[first], values, [last]])
            for values, first, last in zip(front, (0, -np.inf, np.inf), (math.pi, np.inf, -np.inf), strict=True)
        )
        right = np.searchsorted(fronts_gamma, gamma, side="right")
        below = fronts_delta[right] > delta
        left = right - 1
        beyond = (fronts_gamma[left] < gamma) & (fronts_delta[left] < delta)
        open_ = np.flatnonzero(~below & ~beyond)
        low, high = angle[left[open_]], angle[right[open_]]
        for _ in range(_BISECTIONS):
            if not len(open_):
                break
            middle = (low + high) / 2
            g, d = points_of_joint(self.stadium, middle, curved)
            larger, smaller = g > gamma[open_], d < delta[open_]
            below[open_[larger & ~smaller & (d > delta[open_])]] = True
            low, high = np.where(larger, low, middle), np.where(larger, middle, high)
            still = larger == smaller
            open_, low, high = open_[still], low[still], high[still]
        return below


def points_of_joint(stadium: Stadium, theta: Floats, curved: bool) -> tuple[Floats, Floats]:
    """Return gamma and delta of the paths that leave the joint (-a, -1) at the angles theta, shape (T,).

    If `curved`, the joint is a bounce on the left semicircle, otherwise one on the bottom wall.
    """
    both = np.concatenate([theta, math.pi - theta])
    joint = np.ones(len(both))
    side = -joint if curved else 0 * joint
    rays = Rays(-stadium.a * joint, -joint, np.cos(both), np.sin(both), side)
    gamma, delta = ordinate(side != 0, letters(rays, stadium.a)).reshape(2, -1)
    return gamma, delta


def letters(rays: Rays, a: float) -> Iterator[Words]:
    """Yield the letters of paths just after a bounce, one array of shape (N,) for each bounce, without end."""
    piece = _pieces(rays)
    while True:
        after = bounce(rays, a).rays
        following = _pieces(after)
        (x, y), (next_x, next_y) = ((each.x - each.side * a, each.y) for each in (rays, after))
        run = np.where(x * next_y > y * next_x, ANTICLOCKWISE, CLOCKWISE)
        yield np.where(piece == following, run, (following - piece) % 4)
        rays, piece = after, following


def _pieces(rays: Rays) -> Integers:
    """Return the pieces of the boundary on which bounces are (`orbitdb.symbols.plane`)."""
    return np.where(rays.side == 0, 1 + np.sign(rays.y), 2 - rays.side).astype(np.int64)
