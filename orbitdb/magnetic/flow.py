"""Which stationary points are orbits: bounces on their own walls, arcs inside the stadium; and stability.

The stadium is convex, but an arc between two points of its boundary can leave it: through a wall if it is
highest or lowest in between and that point is outside, or through a semicircle if the distance from its
centre has a maximum in between. This maximum is greater than the radius of the arc, and so than 1.
"""

import numpy as np

from orbitdb.arrays import Floats, Marks, Words
from orbitdb.billiard.legs import following, preceding
from orbitdb.billiard.stability import product_of
from orbitdb.billiard.stadium import ANTICLOCKWISE, HALF_PI, STRAIGHT, Stadium
from orbitdb.magnetic.action import ArcPaths, stretch

AT_JOINT = 1e-9
"""A bounce closer than this to a joint of wall and semicircle counts as at the joint (radius, rad)."""

_OUTSIDE = 1e-11
"""An arc leaves through a wall if it is outside by more than this; less is rounding (radius)."""


def at_joints(stadium: Stadium, symbols: Words, coordinates: Floats) -> Marks:
    """Tell which words have a bounce at or beyond the end of its wall or semicircle, shape (N,)."""
    ends = np.where(STRAIGHT[symbols], stadium.a, HALF_PI)
    return np.any(np.abs(coordinates) > ends - AT_JOINT, axis=0)


def leave_stadium(stadium: Stadium, paths: ArcPaths) -> Marks:
    """Tell which words have an arc that meets the boundary before it reaches the next bounce, shape (N,)."""
    left = np.where(paths.kappa < 0, -1.0, 1.0)  # -1 if the arcs turn right
    (start_x, start_y), (end_x, end_y) = paths.directions
    to_x, to_y = following(paths.x), following(paths.y)
    outside = np.zeros(paths.x.shape, np.bool_)
    for way in (-1.0, 1.0):
        peaks = (way * start_y > 0) & (way * end_y < 0)
        with np.errstate(divide="ignore", invalid="ignore"):  # straight paths have no peaks
            rise = start_y**2 / (1 - way * left * start_x) / np.abs(paths.kappa)
        outside |= peaks & (way * paths.y + rise > 1 + _OUTSIDE)
        end = way * stadium.a
        recedes = (paths.x - end) * start_x + paths.y * start_y > 0
        returns = (to_x - end) * end_x + to_y * end_y < 0
        # the maximum is in the direction of the circle's centre, as seen from that of the semicircle
        beyond = way * (np.abs(paths.kappa) * (paths.x - end) - left * start_y) > 0
        outside |= recedes & returns & beyond
    return np.any(outside, axis=0)


def bounce_factors(symbols: Words, paths: ArcPaths) -> Floats:
    """Return the monodromy matrix of the arc before each bounce and of the bounce, shape (2, 2, p, N).

    They act on (distance across the path, its rate of change along the path):
    -[[1, 0], [K, 1]] [[cos kl, sin kl / k], [-k sin kl, cos kl]], where k is the curvature of the path, l the
    length of the arc, K = -(2 / sin theta) (1 - k n) on a semicircle and (2 / sin theta) k n on a wall, and n
    the component of the outgoing direction along the boundary, anticlockwise positive.
    """
    kappa, outgoing = paths.kappa, paths.outgoing
    turn = preceding(paths.chord * stretch(paths.sine)) * kappa
    drift = preceding(paths.chord * stretch(paths.sine)) * np.sinc(turn / np.pi)
    curvature = np.where(STRAIGHT[symbols], 0.0, 1.0) - kappa * ANTICLOCKWISE[symbols] * outgoing
    with np.errstate(divide="ignore", invalid="ignore"):  # a path along the boundary is no orbit
        kick = -2 * curvature / np.sqrt(1 - outgoing**2)
    top = np.cos(turn), drift
    bottom = kick * top[0] - kappa * np.sin(turn), kick * top[1] + top[0]
    return -np.stack([np.stack(top), np.stack(bottom)])


def stability(symbols: Words, paths: ArcPaths) -> tuple[Floats, Floats]:
    """Return the trace of the monodromy matrix and lambda, the ln of its largest eigenvalue, each (N,).

    Lambda is 0 for an elliptic orbit, |tr M| <= 2. Traces beyond the range of doubles are infinite.
    """
    product, doublings = product_of(bounce_factors(symbols, paths))
    trace = product[0, 0] + product[1, 1]
    half = np.maximum(np.abs(trace) / 2, 1.0)
    of_large = np.log(2 * half) + doublings * np.log(2.0)
    with np.errstate(over="ignore"):
        return np.ldexp(trace, doublings), np.where(doublings > 0, of_large, np.arccosh(half))
