"""Single trajectories, bounce by bounce: as arrays, and as symbols with the certainty of each bounce."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.arrays import Floats, Words
from orbitdb.billiard.arithmetic import EPSILON
from orbitdb.billiard.stadium import HALF_PI, Stadium, as_stadium, written
from orbitdb.display import Drawn, Table, data_frame
from orbitdb.errors import InputError, as_floats, check_int
from orbitdb.text import format_float, several
from orbitdb.trajectories.rays import Rays, bounce

if TYPE_CHECKING:
    import pandas

BOUNCES = 60
"""Default number of bounces in each direction; rounding errors may allow fewer."""

MOST_BOUNCES = 1000
MOST_FOLLOWED = 100_000
"""Largest number of bounces of a trajectory as arrays, which takes some seconds."""

_LEAST_POINTS = 3
_ROUNDED = 1e-6
"""Allowed distance of a start outside the stadium, because it may be given with only six digits."""

_ROUNDING = 8 * EPSILON
"""Rounding error of a start and of one bounce, in units of 1 + a."""

_LOST = 1e20
"""Upper limit on the growth of an error, so that numbers stay finite."""

_LARGE = 1e8
"""Tangent vectors that have grown more than this are scaled down."""

_MOST_LOST = 100.0
"""Larger logarithms of the growth give errors above `_LOST` and would overflow."""

_EXACT = 1e-9
"""A bounce whose error is below this counts as on a joint if the joint is no farther away than the error."""


@dataclass(frozen=True, eq=False, repr=False)
class Bounces(Table, Drawn):
    """Successive bounces of one trajectory, as arrays of shape (T,).

    `plot` draws the path from the first bounce to the last one in its stadium.

    Attributes
    ----------
    stadium : Stadium
    x, y : ndarray
        The points of the bounces, from the centre of the stadium, in units of the radius.
    angle : ndarray
        Direction of the path after each bounce, from the x axis, in (-pi, pi] (radians).
    symbol : ndarray of uint8
        The symbols 0 to 5. In a run on one semicircle, they say whether it goes up or down.
    path : ndarray
        Length of the path to each bounce from the one before, or from the start, in units of the radius.
    error : ndarray
        Estimated error of each point, due to rounding, in units of the radius. It grows by about e^0.9 with
        every bounce at a = 1.6; once it is about 1, the trajectory is one of the billiard, but no longer
        that of the start.
    lyapunov : ndarray
        Logarithm of the stretching from the start to just after each bounce: of the largest factor by which
        a small change of the start has grown, an offset across the path in units of the radius together with
        a change of direction in radians. Divided by the number of bounces, or by the length of the path so
        far, it is the finite-time Lyapunov exponent.
    """

    stadium: Stadium
    x: Floats
    y: Floats
    angle: Floats
    symbol: Words
    path: Floats
    error: Floats
    lyapunov: Floats

    def __len__(self) -> int:
        return len(self.x)

    def __str__(self) -> str:
        return f"<{several(len(self), 'bounce')} at a = {format_float(self.stadium.a)}>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with one row per bounce (extra ``pandas``)."""
        return data_frame(self._columns_shown())

    def _columns_shown(self) -> dict[str, Any]:
        names = ("x", "y", "angle", "symbol", "path", "error", "lyapunov")
        return {name: getattr(self, name) for name in names}

    _FIGURES = ("path",)

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        title = f"{several(len(self), 'bounce')} at a = {format_float(self.stadium.a)}"
        return (self.stadium, np.stack([self.x, self.y], axis=1)), title


def trajectory(
    stadium: Stadium | float,
    x: float | None = None,
    y: float | None = None,
    angle: float | None = None,
    bounces: int = BOUNCES,
    *,
    seed: int | np.random.Generator | None = None,
) -> Bounces:
    """Follow a trajectory, bounce by bounce, from a given start or from a random one.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium, or its half length.
    x, y : float, optional
        The start, inside the stadium or on its boundary, from the centre, in units of the radius.
    angle : float, optional
        Direction of the path at the start, from the x axis (radians).
    bounces : int, optional
        Number of bounces to follow, from 1 to `MOST_FOLLOWED`.
    seed : int or numpy.random.Generator, optional
        Instead of x, y and angle: draw the start from the Liouville measure, so that all positions in the
        stadium and all directions are equally likely. The same seed gives the same start.

    Returns
    -------
    Bounces
        The bounces after the start, which is not one of them.

    Raises
    ------
    StadiumError
        If the half length is not valid.
    InputError
        If the start is not three finite numbers or is outside the stadium, `bounces` is out of range, or
        there is neither a start nor a seed, or both.

    Examples
    --------
    >>> from orbitdb import trajectory
    >>> path = trajectory(1.6, 0, 0, 1.2, bounces=3)
    >>> path.symbol.tolist(), path.x.round(6).tolist()
    ([2, 0, 3], [0.38878, 1.166339, 1.923052])
    >>> path = trajectory(1.6, bounces=10_000, seed=3)
    >>> print((path.lyapunov[-1] / len(path)).round(2))
    0.91
    """
    stadium = as_stadium(stadium)
    number: Any = bounces
    whole = isinstance(number, Integral) and not isinstance(number, bool)
    if not whole or not 1 <= number <= MOST_FOLLOWED:
        raise InputError(f"bounces {bounces}: give 1 to {MOST_FOLLOWED}")
    given = [value for value in (x, y, angle) if value is not None]
    if len(given) != (3 if seed is None else 0):
        raise InputError("give the start as x, y and angle, or a seed for a random start")
    start = given if seed is None else random_start(stadium, seed)
    rays, error, path, lyapunov = _follow(stadium, _both_ways(stadium, start), int(bounces))
    # the bounce before the start tells the sense of a run
    joined = [np.append(row[1, 0], row[0])[None] for row in (rays.x, rays.y, rays.side)]
    (symbols,), _ = written(stadium, *joined)
    own_x, own_y, vx, vy, _, error, path, lyapunov = (row[0, :-1] for row in (*rays, error, path, lyapunov))
    return Bounces(stadium, own_x, own_y, np.arctan2(vy, vx), symbols, path, error, lyapunov)


def random_start(stadium: Stadium, seed: int | np.random.Generator) -> tuple[float, float, float]:
    """Draw x, y and the angle of a trajectory from the Liouville measure, uniform in all three.

    Raises
    ------
    InputError
        If the seed is neither a whole number from 0 on nor a generator.
    """
    if not isinstance(seed, np.random.Generator):
        check_int("seed", seed, 0)
    rng = np.random.default_rng(seed)
    while True:
        x, y = rng.uniform(-1 - stadium.a, 1 + stadium.a), rng.uniform(-1, 1)
        if math.hypot(max(abs(x) - stadium.a, 0), y) < 1:
            return x, y, rng.uniform(-math.pi, math.pi)


@dataclass(frozen=True, eq=False)
class Trace:
    """The bounces of one trajectory."""

    first: int  # number of the first bounce; bounce 1 is the first bounce after a start, or the first point
    symbols: Words  # shape (T,)
    points: Floats  # Cartesian, from the centre of the stadium, in units of the radius, shape (T, 2)

    def __len__(self) -> int:
        return len(self.symbols)


def trace_start(
    stadium: Stadium, start: Sequence[float], tolerance: float, bounces: int | None = None
) -> Trace:
    """Follow a trajectory from its start, forward and backward, until rounding makes its bounces uncertain.

    Parameters
    ----------
    stadium : Stadium
    start : (float, float, float)
        x and y from the centre of the stadium, and the angle of the path from the x axis (radians).
    tolerance : float
        Largest estimated error of a bounce that is accepted.
    bounces : int, optional
        Maximum number of bounces in each direction; `BOUNCES` by default.

    Raises
    ------
    InputError
        If the start is not three finite numbers or is outside the stadium, `bounces` is out of range, no
        bounce is within the tolerance, or the path runs through a joint of wall and semicircle.
    """
    if bounces is not None and not 1 <= bounces <= MOST_BOUNCES:
        raise InputError(f"bounces {bounces}: give 1 to {MOST_BOUNCES}")
    ray = _both_ways(stadium, start)
    rays, error, _, _ = _follow(stadium, ray, bounces or BOUNCES)
    rows = (rays.x, rays.y, rays.side)
    joined = [np.concatenate([row[1, ::-1], row[0]])[None] for row in rows]  # in order of time
    symbols, coordinates = written(stadium, *joined)
    ahead, back = (
        _known(stadium, [row[n] for row in (*rows, error)], tolerance, way) for n, way in ((0, 1), (1, -1))
    )
    if not ahead + back:
        raise InputError(
            f"rounding makes every bounce uncertain by more than {tolerance:g}: give a larger tolerance"
        )
    middle = rays.x.shape[1] - 1
    kept = slice(middle - back, middle + ahead)
    points = stadium.points(symbols, coordinates)
    return Trace(1 - back, symbols[0, kept], points[0, kept])


def _both_ways(stadium: Stadium, start: Sequence[float]) -> Rays:
    """Return the rays that leave a start forward and backward."""
    values = _numbers(start, "give the start as x,y,angle, such as 0,0.5,1.2")
    if values.shape != (3,):
        raise InputError("give the start as three numbers x,y,angle, such as 0,0.5,1.2")
    x, y, angle = values.tolist()
    centre = min(max(x, -stadium.a), stadium.a)
    off = math.hypot(x - centre, y)
    if off > 1 + _ROUNDED:
        raise InputError(
            f"the start ({x:g}, {y:g}) lies {off - 1:.2g} outside the stadium at a = "
            f"{format_float(stadium.a)}: measure x and y from its centre, in units of the radius"
        )
    scale = 1 / max(1.0, off)
    xs, ys = np.full(2, centre + (x - centre) * scale), np.full(2, y * scale)
    way = np.array([1.0, -1.0])
    return Rays(xs, ys, way * math.cos(angle), way * math.sin(angle), np.zeros(2))


def _numbers(values: Any, help: str) -> Floats:
    """Return values as an array of finite numbers; raise `InputError` with the help text if they are not."""
    numbers = as_floats(values, help)
    if not np.isfinite(numbers).all():
        raise InputError(f"{help}; nan and inf are not coordinates")
    return numbers


def _follow(stadium: Stadium, rays: Rays, bounces: int) -> tuple[Rays, Floats, Floats, Floats]:
    """Follow N rays for a number of bounces and one more.

    Returns the rays after every bounce, estimates of the errors of their positions along the boundary, the
    lengths of the paths to them, and the logarithms of the stretching so far (`Bounces`); every array has
    shape (N, `bounces` + 1).

    Notes
    -----
    An initial error across the path and an initial error of its direction grow like tangent vectors
    (`orbitdb.trajectories.ensemble.follow_arcs`), which are the columns of a 2 x 2 matrix. Errors added by
    later bounces grow less. The stretching is the largest singular value of that matrix.
    """
    offset, slope = np.eye(2)[:, :, None] * np.ones(len(rays.x))
    scale = np.zeros(len(rays.x))  # the matrix is e^scale times (offset, slope)
    rows, matrices = [], []
    for _ in range(bounces + 1):
        hit = bounce(rays, stadium.a)
        rays = hit.rays
        offset = offset + hit.path * slope
        slope = slope - np.minimum(hit.kick, _LOST) * offset
        matrix = np.stack([offset, slope])
        rows.append((*rays, hit.path, hit.kick, scale))
        matrices.append(matrix)
        size = np.abs(matrix).max(axis=(0, 1))
        if (size > _LARGE).any():
            offset, slope, scale = offset / size, slope / size, scale + np.log(size)
    *after, path, kick, scale = (np.stack(part, axis=1) for part in zip(*rows, strict=True))
    rays, stretched = Rays(*after), np.moveaxis(np.array(matrices), -1, 0)
    steepness = np.where(rays.side == 0, np.abs(rays.vy), 2 / np.maximum(kick, 2.0))
    grown = np.abs(stretched[:, :, 0]).sum(axis=-1) * np.exp(np.minimum(scale, _MOST_LOST))
    grown = np.minimum(grown / np.maximum(steepness, _ROUNDING), _LOST)
    lyapunov = scale + np.log(np.linalg.norm(stretched, ord=2, axis=(-2, -1)))
    return rays, _ROUNDING * (1 + stadium.a) * (1 + grown), path, lyapunov


def _known(stadium: Stadium, rows: list[Floats], tolerance: float, way: int) -> int:
    """Return how many bounces in one direction are certain, not counting the last bounce followed.

    The direction `way` is 1 for forward, -1 for backward. A trajectory through a joint raises `InputError`.
    """
    x, y, side, error = rows
    angle = np.arctan2(y, side * x - stadium.a)
    room = np.where(side == 0, stadium.a - np.abs(x), HALF_PI - np.abs(angle))
    ends = np.flatnonzero((error > tolerance) | (room <= error))
    count = int(ends[0]) if len(ends) else len(x)
    if count < len(x) and room[count] <= error[count] < _EXACT:
        number = count + 1 if way > 0 else -count
        fewer = f", or follow fewer than {count} bounces" if count > 1 else ""
        raise InputError(
            f"the trajectory runs through a joint of wall and semicircle at bounce {number}, where its "
            f"symbol is not defined: move the start{fewer}"
        )
    return min(count, len(x) - 1)


def trace_points(stadium: Stadium, points: Any, tolerance: float) -> Trace:
    """Translate measured bounces into symbols.

    Parameters
    ----------
    stadium : Stadium
    points : array-like, shape (N, 2)
        x and y of N >= 3 successive bounces; the last may repeat the first to close a polygon.
    tolerance : float
        Maximum distance of a point from the boundary.

    Raises
    ------
    InputError
        If the points do not have this shape, are not on the boundary, or repeat a bounce.
    """
    bounces = _numbers(points, "give points as pairs x,y, one per bounce")
    if bounces.size == 0:
        raise InputError("there are no points: give x,y of at least three bounces, one pair per line")
    if bounces.ndim != 2 or bounces.shape[1] != 2:
        raise InputError("give points as pairs x,y, one per bounce")
    if not _LEAST_POINTS <= len(bounces) <= MOST_BOUNCES:
        many = "few" if len(bounces) < _LEAST_POINTS else "many"
        raise InputError(
            f"too {many} points ({len(bounces)}): give {_LEAST_POINTS} to {MOST_BOUNCES}, one per bounce"
        )
    _check_on_boundary(stadium, bounces, tolerance)
    same = np.flatnonzero((bounces[1:] == bounces[:-1]).all(axis=1))
    if len(same):
        raise InputError(f"points {same[0] + 1} and {same[0] + 2} are the same: give each bounce once")
    if math.dist(bounces[0], bounces[-1]) <= tolerance:
        bounces = bounces[:-1]
    x, y = bounces.T
    side = np.where(np.abs(x) > stadium.a, np.sign(x), 0.0)
    y = np.where(side == 0, np.copysign(1.0, y), y)
    alone = [np.pad(row, 1)[None] for row in (x, y, side)]  # a straight bounce at each end ends all runs
    return Trace(1, written(stadium, *alone)[0][0], bounces)


def _check_on_boundary(stadium: Stadium, points: Floats, tolerance: float) -> None:
    x, y = points.T
    off = np.hypot(np.maximum(np.abs(x) - stadium.a, 0), y) - 1
    worst = int(np.abs(off).argmax())
    if abs(off[worst]) > tolerance:
        where = "outside" if off[worst] > 0 else "inside"
        raise InputError(
            f"point {worst + 1}, ({x[worst]:g}, {y[worst]:g}), lies {abs(off[worst]):.2g} {where} the "
            f"stadium at a = {format_float(stadium.a)}, more than the tolerance {tolerance:g}: give only "
            "bounces"
        )
