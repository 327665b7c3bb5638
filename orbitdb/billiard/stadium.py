"""The stadium: two straight walls of length 2a and two semicircles of radius 1.

The coordinate of a bounce on a straight wall (symbols 0 bottom, 2 top) is the Cartesian x in (-a, a). On a
semicircle (1 and 4 left, 3 and 5 right) it is the angle t in (-pi/2, pi/2) from the outward horizontal, so
that y = sin t on both sides.
"""

import math
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from numbers import Real
from typing import Any

import numpy as np

from orbitdb.arrays import Floats, Words
from orbitdb.billiard import USUAL_A
from orbitdb.errors import InputError

Pair = tuple[Floats, Floats]

MIN_A, MAX_A = 1e-6, 1e6
HALF_PI = math.pi / 2

STRAIGHT = np.array([True, False, True, False, False, False])
ANTICLOCKWISE = np.array([1.0, -1.0, -1.0, 1.0, -1.0, 1.0])
"""For each symbol, +1 if the coordinate increases anticlockwise along the boundary, -1 if clockwise."""
_WALL_Y = np.array([-1.0, 0.0, 1.0, 0.0, 0.0, 0.0])
_SEGMENT = np.array([0, 1, 2, 3, 1, 3])
SIDE = np.array([0.0, -1.0, 0.0, 1.0, -1.0, 1.0])
"""For each symbol, -1 on the left semicircle, +1 on the right one, 0 on a straight wall."""


class StadiumError(InputError):
    """The half length is not a number in the supported range."""


def _half_length(a: Any) -> float:
    """Return a half length as a float; raise `StadiumError` if it is not valid."""
    number = math.nan
    wrong = isinstance(a, bool) or not isinstance(a, Real | Decimal)
    narrow = isinstance(a, np.floating) and a.dtype != np.float64
    with suppress(ValueError, OverflowError):
        if not wrong:
            number = float(str(a)) if narrow else float(a)  # 1.6 in single precision stands for 1.6, too
    if MIN_A <= number <= MAX_A:
        return number
    given = f"{a!r:.40}" if isinstance(a, str) else f"{a!s:.40}"  # quotes show that it is a string
    raise StadiumError(f"a = {given} is not a half length: give a number from {MIN_A:g} to {MAX_A:g}")


@dataclass(frozen=True)
class Stadium:
    """A stadium of radius 1.

    Attributes
    ----------
    a : float
        Half the length of a straight wall, in units of the radius.

    Raises
    ------
    StadiumError
        If a is not a number from `MIN_A` to `MAX_A`.
    """

    a: float = USUAL_A

    def __post_init__(self) -> None:
        object.__setattr__(self, "a", _half_length(self.a))

    @property
    def area(self) -> float:
        """Area, in units of the radius squared."""
        return math.pi + 4 * self.a

    @property
    def perimeter(self) -> float:
        """Perimeter, in units of the radius."""
        return 2 * math.pi + 4 * self.a

    @property
    def mean_free_path(self) -> float:
        """Mean length of the path between bounces, pi Area / Perimeter, in the invariant measure."""
        return math.pi * self.area / self.perimeter

    @property
    def legs_per_bounce(self) -> float:
        """Mean number of legs per bounce: a leg and its run have a + pi/2 bounces on average."""
        return 1 / (self.a + HALF_PI)

    @property
    def legs_per_length(self) -> float:
        """Mean number of legs per unit length: the mean path from run to run is pi Area / 4."""
        return 4 / (math.pi * self.area)

    def points(self, symbols: Words, coordinates: Floats) -> Floats:
        """Return the Cartesian points of bounces, shape (..., 2).

        Symbols and coordinates have the same shape. Walls and circles are continued beyond their ends.
        """
        return np.stack(self.frames(symbols, coordinates)[0], axis=-1)

    def tangents(self, symbols: Words, coordinates: Floats) -> Floats:
        """Return the unit tangents at bounces, shape (..., 2), in the direction of increasing coordinate."""
        return np.stack(self.frames(symbols, coordinates)[1], axis=-1)

    def frames(self, symbols: Words, coordinates: Floats) -> tuple[Pair, Pair]:
        """Return the x and y components of `points` and of `tangents`, each of the symbols' shape."""
        straight, outward = STRAIGHT[symbols], SIDE[symbols]
        cos, sin = np.cos(coordinates), np.sin(coordinates)
        point = (
            np.where(straight, coordinates, outward * (self.a + cos)),
            np.where(straight, _WALL_Y[symbols], sin),
        )
        tangent = (np.where(straight, 1.0, -outward * sin), np.where(straight, 0.0, cos))
        return point, tangent

    def arclength(self, symbols: Words, coordinates: Floats) -> Floats:
        """Return the arc lengths of bounces along the boundary, in units of the radius.

        They increase anticlockwise from 0 at the left end of the bottom wall to the perimeter, in the order
        bottom, right, top, left; the joints are at 0, 2a, 2a + pi and 4a + pi. Symbols, coordinates and the
        result have the same shape.
        """
        a = self.a
        middle = np.array([a, 4 * a + 1.5 * math.pi, 3 * a + math.pi, 2 * a + HALF_PI])
        return middle[_SEGMENT[symbols]] + ANTICLOCKWISE[symbols] * coordinates

    def outline(self, n: int = 64) -> Floats:
        """Return the boundary as a closed polygon with n points per semicircle, shape (2n + 1, 2)."""
        angles = np.linspace(-HALF_PI, HALF_PI, n)
        right = np.stack([self.a + np.cos(angles), np.sin(angles)], axis=1)
        return np.concatenate([right, -right, right[:1]])


def as_stadium(stadium: Stadium | float) -> Stadium:
    """Return the given stadium, or the stadium with the given half length.

    Raises
    ------
    StadiumError
        If it is neither a stadium nor a valid half length.
    """
    return stadium if isinstance(stadium, Stadium) else Stadium(stadium)


def written(stadium: Stadium, x: Floats, y: Floats, side: Floats) -> tuple[Words, Floats]:
    """Return symbols and coordinates of bounces, shape (N, p), except the first and last bounce of each row.

    Parameters
    ----------
    x, y, side : ndarray, shape (N, p + 2)
        The points, and the side that each is on: -1 for the left semicircle, +1 for the right one, 0 for a
        straight wall with y = -1 or 1.
    """
    coordinates = np.where(side == 0, x, np.arctan2(y, side * x - stadium.a))
    same = (side[:, 1:] == side[:, :-1]) & (side[:, 1:] != 0)
    falls = same & (coordinates[:, 1:] < coordinates[:, :-1])
    down = falls[:, 1:] | falls[:, :-1]
    side, height = side[:, 1:-1], y[:, 1:-1]
    curved = np.where(side < 0, 1 + 3 * down, 3 + 2 * down)
    return np.where(side == 0, 1 + height, curved).astype(np.uint8), coordinates[:, 1:-1]
