"""The pruning front: the border of the orbits in the symbol plane.

The paths that leave a joint of wall and semicircle at all angles theta have points (gamma, delta) in the
symbol plane (`orbitdb.symbols.plane`). As theta grows from 0 to pi, gamma rises and delta falls. The curve of
these points is the *front*. No path has a point beyond it, because gamma and delta rise together along a wall
or semicircle, and the joint is its end.

The four joints are images of one another, so all fronts follow from the paths that leave the joint (-a, -1).
As bounces on the bottom wall they bound the points of walls from above, and as bounces on the left semicircle
those of semicircles. The joint at the other end bounds them from below: its front is the first one, turned by
half a turn about (1/2, 1/2). By time reversal, delta at theta is gamma at pi - theta.

All of this is measured, not proved: the order of the paths, that a word without a point beyond a front is an
orbit, and the paths themselves, which are followed in double precision. No status depends on it.

Source: pruning fronts are Hansen's.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks, Words
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.display import Drawn
from orbitdb.symbols.plane import ANTICLOCKWISE, CLOCKWISE, PIECE, ordinate, symbol_plane
from orbitdb.text import format_float
from orbitdb.trajectories.rays import Rays, bounce

LEAST_A = 0.05
"""Below this half length, the letters of `orbitdb.symbols.plane` do not separate all orbits from a front."""

ANGLES = 1 << 12
"""Number of angles in (0, pi) at which a front is computed; points between two of them are bisected."""

_BISECTIONS = 60
"""Number of bisections after which neighbouring angles are equal."""


@dataclass(frozen=True, eq=False)
class Front(Drawn):
    """The upper front of the bounces on straight walls, or of those on semicircles.

    `plot` draws it with the lower front and what both forbid.

    Attributes
    ----------
    stadium : Stadium
    curved : bool
        Whether the bounces are on semicircles.
    angle : ndarray, shape (T,)
        Angles in (0, pi) between the boundary, anticlockwise, and the paths that leave the joint (radians).
    gamma, delta : ndarray, shape (T,)
        The points of these paths. gamma does not fall, delta does not rise.
    """

    _FIGURES = ("symbol-plane",)

    stadium: Stadium
    curved: bool
    angle: Floats
    gamma: Floats
    delta: Floats

    @classmethod
    def of(cls, stadium: Stadium, curved: bool) -> "Front":
        """Return the front of a stadium at `ANGLES` angles."""
        angle = np.arange(0.5, ANGLES) * np.float64(math.pi / ANGLES)
        gamma, delta = points_of_joint(stadium, angle, curved)
        return cls(stadium, curved, angle, np.maximum.accumulate(gamma), np.minimum.accumulate(delta))

    def below(self, gamma: Floats, delta: Floats) -> Marks:
        """Tell which points, shape (N,), are below the front.

        A point is below the front if a point of the front has both a larger gamma and a larger delta. It is
        beyond the front if one has both smaller. If neighbouring angles decide neither, they are bisected.
        Points on the front are not below it, nor are points where the front jumps in both coordinates; the
        geometric rules forbid those.
        """
        angle, gammas, deltas = (
            np.concatenate([[first], values, [last]])
            for first, values, last in (
                (0.0, self.angle, math.pi), (-np.inf, self.gamma, np.inf), (np.inf, self.delta, -np.inf)
            )
        )  # fmt: skip
        after = np.searchsorted(gammas, gamma, side="right")
        below = deltas[after] > delta
        before = np.searchsorted(gammas, gamma, side="left") - 1
        left = np.flatnonzero(~below & (deltas[before] >= delta))
        low, high = angle[before[left]], angle[after[left]]
        for _ in range(_BISECTIONS):
            if not len(left):
                break
            middle = (low + high) / 2
            new_gamma, new_delta = points_of_joint(self.stadium, middle, self.curved)
            right, lower = new_gamma > gamma[left], new_delta < delta[left]
            below[left] = right & (new_delta > delta[left])
            low, high = np.where(right, low, middle), np.where(right, middle, high)
            still = right == lower
            left, low, high = left[still], low[still], high[still]
        return below

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        return (self,), f"pruning front at a = {format_float(self.stadium.a)}"


class PruningFront:
    """The fronts of a stadium, and the words that they allow.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium, or its half length.

    Attributes
    ----------
    stadium : Stadium
    walls, semicircles : Front
        The fronts of the bounces on straight walls and of those on semicircles.
    notes : tuple of str
        That the front forbids some orbits, if the stadium is too short for it.

    Notes
    -----
    The front is computed in double precision, and nothing about it is proved. From a = 0.05 on, it agrees
    with every certified status that was compared, but use the status. Below, it forbids some orbits, because
    runs have points too close to it: 8 of 1364 classes up to period 9 at a = 0.001.

    Examples
    --------
    >>> from orbitdb.symbols.words import from_strings
    >>> PruningFront(1.6).allows(from_strings(["01133", "01132"])).tolist()
    [True, False]
    """

    def __init__(self, stadium: Stadium | float) -> None:
        self.stadium = as_stadium(stadium)
        self.walls, self.semicircles = (Front.of(self.stadium, curved) for curved in (False, True))
        below = (
            f"below a = {LEAST_A}, the pruning front forbids some orbits: their points are too close to it"
        )
        self.notes = (below,) if self.stadium.a < LEAST_A else ()

    def __repr__(self) -> str:
        return f"<pruning front at a = {format_float(self.stadium.a)}>"

    def allows(self, words: Words) -> Marks:
        """Tell which admissible words, shape (N, p), have all points inside the fronts, shape (N,).

        A word whose path runs through a joint has a point on a front, and is not allowed.

        Raises
        ------
        WordError
            If the argument is not an array of admissible words.
        """
        inside = self.allows_points(symbol_plane(words), PIECE[words] % 2 == 1)
        return np.all(inside, axis=1)

    def allows_points(self, points: Floats, curved: Marks) -> Marks:
        """Tell which points are inside the fronts, both the upper and the lower one.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            gamma and delta.
        curved : ndarray of bool, shape (...)
            Whether the points belong to bounces on semicircles.
        """
        allowed = np.empty(curved.shape, dtype=np.bool_)
        for front in (self.walls, self.semicircles):
            chosen = curved == front.curved
            gamma, delta = points[chosen].T
            allowed[chosen] = front.below(gamma, delta) & front.below(1 - gamma, 1 - delta)
        return allowed


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
    """Yield the letters of paths that leave a bounce, an array of shape (N,) for each bounce, without end."""
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
