"""Wave functions of levels, and how strongly orbits scar them.

A wave psi is given at the nodes of spectral elements on a quarter of the stadium and interpolated from them.
The integral of psi^2 over the entire stadium is 1. In a wave, an orbit of length L has the scar strength

    S = (area / L) * integral of psi^2 along the orbit.

The mean of S over the levels of one parity is 1, or, for an orbit on an axis, 2 or 0 depending on the parity.
The bouncing balls fill the rectangle |x| < a. Their strength is the mean of psi^2 there, times the area.

Sources: E. J. Heller, Phys. Rev. Lett. 53 (1984) 1515; E. B. Bogomolny, Physica D 31 (1988) 169;
A. Baecker, S. Fuerstberger, R. Schubert, Phys. Rev. E 70 (2004) 036204 (Husimi functions on the boundary).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.display import drawn, figure_name
from orbitdb.errors import InputError, as_reals
from orbitdb.orbits.status import Status
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.condensation import eigenfunctions, one_thread
from orbitdb.quantum.elements import nodes
from orbitdb.quantum.exact_levels import LevelTask, level_tasks
from orbitdb.quantum.weyl import Parity, Wavenumbers, k_range, one_parity, weyl
from orbitdb.text import format_float

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from orbitdb.orbits.orbit import Orbit


_NEAREST = 12
"""Number of nearest nodes whose cells are tried in the search for the cell that contains a point."""
_NEWTON, _SETTLED = 20, 1e-12
INSIDE = 1e-7
"""Maximum distance outside a cell, in the coordinates of the cell, at which a point counts as inside."""
_BLOCK = 1 << 13
"""Number of points evaluated together, small enough for their data to stay in the cache."""
_MORE_NODES = 24
"""Number of quadrature nodes along a chord in excess of k times its length."""


@dataclass(frozen=True, eq=False, repr=False)
class Wave:
    """The wave function of one level.

    Attributes
    ----------
    stadium : Stadium
    parity : Parity
    k : float
        The level, in 1/radius.
    values : ndarray, shape (E, n, n)
        Values of psi at the nodes of the cells.
    """

    stadium: Stadium
    parity: Parity
    k: float
    values: Floats
    _cells: "Cells" = field(repr=False)

    def __repr__(self) -> str:
        return f"<wave {self.parity} at k = {self.k:.6g}, a = {format_float(self.stadium.a)}>"

    def psi(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Return psi at the given points, in units of 1/radius; NaN outside the stadium.

        Parameters
        ----------
        x, y : array-like
            Coordinates from the centre of the stadium, in units of the radius. The shapes of x and y are
            broadcast against each other.
        """
        x, y = np.broadcast_arrays(*(as_reals(of, "x and y: give numbers") for of in (x, y)))
        sign = np.where(x < 0, self.parity.signs[0], 1) * np.where(y < 0, self.parity.signs[1], 1)
        points = np.stack([np.abs(x).ravel(), np.abs(y).ravel()], axis=-1)
        beyond = np.maximum(points[:, 0] - self.stadium.a, 0.0)
        inside = beyond**2 + points[:, 1] ** 2 <= 1 + INSIDE
        psi = np.full(len(points), np.nan)
        points_inside = points[inside]
        parts = (points_inside[first : first + _BLOCK] for first in range(0, len(points_inside), _BLOCK))
        psi[inside] = np.concatenate(
            [np.zeros(0), *(self._cells.at(part).values(self.values) for part in parts)]
        )
        return sign * psi.reshape(x.shape)

    def normal_derivative(self, s: ArrayLike) -> Floats:
        """Return the outward normal derivative of psi at points on the boundary.

        Parameters
        ----------
        s : array-like
            Arc lengths, anticlockwise from the left end of the bottom wall, in units of the radius.
        """
        points, normal = boundary(self.stadium, as_reals(s, "s: give arc lengths"))
        signs = np.where(points < 0, self.parity.signs, 1).prod(axis=-1)
        slopes = self._cells.at(np.abs(points.reshape(-1, 2))).slopes(self.values).reshape(points.shape)
        return signs * (slopes * np.abs(normal)).sum(axis=-1)

    def strength(self, orbit: "Orbit") -> float:
        """Return the scar strength of an orbit, the mean of psi^2 along the orbit times the area.

        Raises
        ------
        InputError
            If the word is neither an orbit nor the family 02, or if it was solved in another stadium.
        """
        return float(self.strengths([orbit])[0])

    def strengths(self, orbits: "Sequence[Orbit]") -> Floats:
        """Return the scar strengths of several orbits, as in `strength`."""
        nodes, weights, starts = _quadrature(self.stadium, orbits, self.k)
        mean: Floats = np.add.reduceat(self.psi(*nodes.T) ** 2 * weights, starts)
        return self.stadium.area * mean

    def husimi(self, s: ArrayLike, sine: ArrayLike) -> Floats:
        """Return the Husimi function of the normal derivative, shape (S, P), scaled to a maximum of 1.

        Parameters
        ----------
        s : array-like, shape (S,)
            Arc lengths along the boundary, as in `normal_derivative`.
        sine : array-like, shape (P,)
            Sines of the angles between path and normal.
        """
        whole = self.stadium.perimeter
        count = 2 * math.ceil(2 * self.k * whole) + 128  # even, so that the points are symmetric
        place = (np.arange(count) + 0.5) * whole / count
        slope = self.normal_derivative(place)
        away = place - as_reals(s, "s: give arc lengths")[:, None]
        away -= whole * np.round(away / whole)
        packet = np.exp(-self.k * away**2 / 2) * slope
        sines = as_reals(sine, "sine: give numbers")
        waves = np.exp(-1j * self.k * sines[:, None, None] * away)
        density = np.abs((waves * packet).sum(axis=-1).T) ** 2
        return density / density.max()

    def plot(self, kind: str | None = None, ax: "Axes | None" = None, orbit: "Orbit | None" = None) -> "Axes":
        """Draw psi^2 or the Husimi function with matplotlib; if an orbit is given, draw it on top.

        Parameters
        ----------
        kind : str, optional
            ``wave`` for psi^2, as by default, or ``husimi``.
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default, the axes of a new figure.
        orbit : Orbit, optional
            Orbit to draw on top: its path, or its bounces.
        """
        title = f"k = {self.k:.6g}, {self.parity}, a = {format_float(self.stadium.a)}"
        return drawn(figure_name(kind, ("wave", "husimi")), (self, orbit), title, ax)


def waves(stadium: Stadium | float, k: Wavenumbers, parity: Parity | str) -> Iterator[Wave]:
    """Yield the waves of all levels of one parity with low <= k < high, in ascending order of k.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium or its half length.
    k : float or (float, float)
        The range of wavenumbers, in 1/radius; a single number is its upper end.
    parity : Parity or str
        ``ee``, ``eo``, ``oe`` or ``oo``, for even or odd in x and then in y.

    Raises
    ------
    InputError
        If the half length or the range is outside the tested limits (`exact_levels.level_tasks`).
    """
    at, of, (low, high) = as_stadium(stadium), one_parity(parity), k_range(k)
    if of is None:
        raise InputError("waves have one parity: name it, such as 'ee'")
    for task in level_tasks(at, of, low, high):
        cells, levels = _functions(task)
        for level, function in levels:
            yield Wave(at, of, level, function, cells)


def nearest_wave(stadium: Stadium | float, k: float, parity: Parity | str) -> Wave:
    """Return the wave of the level of one parity that is nearest to a given k, in 1/radius."""
    at, of = as_stadium(stadium), one_parity(parity)
    spacing, width = 1 / max(float(weyl(at, of).deriv()(k)), 0.2), 0.0
    near: list[Wave] = []
    while not near:
        width += 2 * spacing
        near = list(waves(at, (max(k - width, 0.0), k + width), parity))
    return min(near, key=lambda wave: abs(wave.k - k))


def _functions(task: LevelTask) -> "tuple[Cells, Iterator[tuple[float, Floats]]]":
    """Return the cells of a window, and each of its levels with the values of its wave at their nodes."""
    with one_thread():
        elements = task.elements()
        _, values, functions = eigenfunctions(elements, task.fixed, task.low**2, task.high**2)
    return Cells(elements.grid.points), zip(np.sqrt(values).tolist(), functions / 2, strict=True)


def scar_strengths(
    stadium: Stadium, low: float, high: float, parity: Parity, orbits: "Sequence[Orbit]", tell: Tell = nobody
) -> tuple[Floats, Floats]:
    """Return the N levels of one parity with low <= k < high, and scar strengths, shape (N, orbits).

    All waves of a window share the search for the cells in which the points of the orbits lie.
    """
    levels: list[float] = []
    strengths: list[Floats] = []
    tasks = list(level_tasks(stadium, parity, low, high))
    for done, task in enumerate(tasks):
        tell(done, len(tasks), f"waves {parity} from k = {task.low:.4g}")
        nodes, weights, starts = _quadrature(stadium, orbits, task.high)
        cells, functions = _functions(task)
        blocks = [np.abs(nodes[at : at + _BLOCK]) for at in range(0, len(nodes), _BLOCK)]
        places = [cells.at(block) for block in blocks]
        for k, function in functions:
            psi = np.concatenate([place.values(function) for place in places])
            levels.append(k)
            strengths.append(stadium.area * np.add.reduceat(psi**2 * weights, starts))
    return np.array(levels), np.array(strengths).reshape(-1, len(orbits))


def boundary(stadium: Stadium, s: Floats) -> tuple[Floats, Floats]:
    """Return the points of the boundary at arc lengths s, shape (..., 2), and the outward normals there."""
    a = stadium.a
    s = np.mod(s, stadium.perimeter)
    right, top, left = 2 * a, 2 * a + math.pi, 4 * a + math.pi
    angle = np.where(s < top, s - right - math.pi / 2, s - left + math.pi / 2)
    round_end = ((s >= right) & (s < top)) | (s >= left)
    centre = np.where(s < top, a, -a)
    flat_x = np.where(s < right, s - a, a - (s - top))
    flat_y = np.where(s < right, -1.0, 1.0)
    normal = np.stack(
        [np.where(round_end, np.cos(angle), 0.0), np.where(round_end, np.sin(angle), flat_y)], axis=-1
    )
    x = np.where(round_end, centre + normal[..., 0], flat_x)
    return np.stack([x, normal[..., 1]], axis=-1), normal


def _quadrature(
    stadium: Stadium, orbits: "Sequence[Orbit]", k: float
) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Return nodes on all orbits, shape (n, 2), fine enough for psi^2 at k, with weights and first nodes."""
    parts = []
    for orbit in orbits:
        if orbit.status is Status.FAMILY:
            parts.append(_across(stadium, k))
        elif orbit.points is None or orbit.a != stadium.a:
            raise InputError(f"{orbit.code} is not an orbit at a = {format_float(stadium.a)}: use another")
        else:
            parts.append(_along(orbit.points, k))
    starts = np.cumsum([0, *(len(weights) for _, weights in parts[:-1])])
    nodes, weights = (np.concatenate(part) for part in zip(*parts, strict=True))
    return nodes, weights, starts


def _along(points: Floats, k: float) -> tuple[Floats, Floats]:
    """Return nodes along a closed path, and weights whose sum is 1."""
    places, weights = [], []
    for start, end in pairwise([*points, points[0]]):
        length = float(np.hypot(*(end - start)))
        x, weight = leggauss(math.ceil(k * length) + _MORE_NODES)
        places.append(start + (x[:, None] + 1) / 2 * (end - start))
        weights.append(weight * length / 2)
    weight = np.concatenate(weights)
    return np.concatenate(places), weight / weight.sum()


def _across(stadium: Stadium, k: float) -> tuple[Floats, Floats]:
    """Return nodes in a quarter of the rectangle that the bouncing balls fill, and weights whose sum is 1."""
    (x, along), (y, across) = (leggauss(math.ceil(k * side) + _MORE_NODES) for side in (stadium.a, 1.0))
    points = np.stack(np.meshgrid((x + 1) / 2 * stadium.a, (y + 1) / 2, indexing="ij"), axis=-1)
    return points.reshape(-1, 2), (along[:, None] * across).ravel() / 4


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells that all waves of a window share, given by their nodes `points`, shape (E, n, n, 2)."""

    points: Floats

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points.reshape(-1, 2))

    def at(self, points: Floats) -> "CellPoints":
        """Find the cell that contains each point, shape (N, 2), and the point's coordinates in the cell."""
        n = self.points.shape[1]
        x, _, slope = nodes(n - 1)
        _, near = self._tree.query(points, k=_NEAREST)
        cell, inside = np.full(len(points), -1), np.zeros((len(points), 2))
        closest = np.full(len(points), np.inf)
        for nearest in near.T:
            open_ = np.flatnonzero(closest > 0)
            if not len(open_):
                break
            which, node = np.divmod(nearest[open_], n * n)
            place = np.stack([x[node // n], x[node % n]], axis=-1)
            place = self._newton(points[open_], which, place, slope)
            beyond = np.maximum(np.abs(place).max(axis=-1) - 1, 0.0)
            beyond[beyond < INSIDE] = 0.0
            better = beyond < closest[open_]
            rows = open_[better]
            cell[rows], inside[rows], closest[rows] = which[better], place[better], beyond[better]
        return CellPoints(cell, inside, self.points)

    def _newton(self, points: Floats, which: NDArray[np.intp], place: Floats, slope: Floats) -> Floats:
        place, moving = place.copy(), np.arange(len(points))
        for _ in range(_NEWTON):
            at = CellPoints(which[moving], place[moving], self.points)
            off = points[moving] - at.interpolated(self.points[at.cell])
            step = np.linalg.solve(at.jacobian(), off[..., None])[..., 0]
            place[moving] = np.clip(at.inside + step, -1.5, 1.5)
            moving = moving[np.abs(step).max(axis=-1) > _SETTLED]
            if not len(moving):
                break
        return place


@dataclass(frozen=True, eq=False)
class CellPoints:
    """N points, each given by its cell and by its coordinates in that cell, which run from -1 to 1."""

    cell: NDArray[np.intp]
    inside: Floats
    points: Floats

    @cached_property
    def _bases(self) -> tuple[Floats, Floats]:
        order = self.points.shape[1] - 1
        return _lagrange(self.inside[:, 0], order), _lagrange(self.inside[:, 1], order)

    def interpolated(self, nodal: Floats) -> Floats:
        """Interpolate at each point, given the nodal values of its cell, shape (N, n, n, ...)."""
        one, other = self._bases
        return _contracted(one, other, nodal)

    def jacobian(self) -> Floats:
        """Return the Jacobian of x and y with respect to the coordinates in the cell, shape (N, 2, 2)."""
        return np.stack(self._derivatives(self.points[self.cell]), axis=-1)

    def _derivatives(self, nodal: Floats) -> tuple[Floats, Floats]:
        slope = nodes(self.points.shape[1] - 1)[2]
        one, other = self._bases
        return _contracted(one @ slope, other, nodal), _contracted(one, other @ slope, nodal)

    def values(self, function: Floats) -> Floats:
        """Return the values of a function at the points, given its nodal values, shape (E, n, n)."""
        return self.interpolated(function[self.cell])

    def slopes(self, function: Floats) -> Floats:
        """Return the gradient of a function at the points, shape (N, 2), given its nodal values."""
        by = np.stack(self._derivatives(function[self.cell]), axis=-1)
        return np.asarray(np.linalg.solve(np.swapaxes(self.jacobian(), -1, -2), by[..., None])[..., 0])


def _contracted(one: Floats, other: Floats, nodal: Floats) -> Floats:
    """Return the sum of one_i other_j nodal_ij for each point, shape (N, ...)."""
    return np.asarray(np.einsum("pi,pi...->p...", one, np.einsum("pj,pij...->pi...", other, nodal)))


def _lagrange(x: Floats, order: int) -> Floats:
    """Return the Lagrange polynomials of the nodes at each x, shape (N, n), from Legendre polynomials."""
    return legvander(x, order) @ np.linalg.inv(legvander(nodes(order)[0], order))
