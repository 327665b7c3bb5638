"""Wave functions of levels, and how strongly orbits scar them.

A wave is given at the nodes of the elements of a quarter stadium and interpolated by their polynomials.
The integral of psi^2 over the whole stadium is 1. The scar strength of an orbit is

    S = (area / L) * integral of psi^2 along the orbit.

Its mean over the levels of a parity is 1, or 2 or 0 for an orbit on an axis.

Sources: E. J. Heller, Phys. Rev. Lett. 53 (1984) 1515; E. B. Bogomolny, Physica D 31 (1988) 169;
A. Baecker, S. Fuerstberger, R. Schubert, Phys. Rev. E 70 (2004) 036204 (Husimi functions on the boundary).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.errors import InputError
from orbitdb.extras import drawn
from orbitdb.numerals import exact
from orbitdb.quantum.amplitudes import Parity
from orbitdb.quantum.elements import eigenvectors, nodes
from orbitdb.quantum.levels import parities_of, windows

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from orbitdb.orbits.orbit import Orbit


_NEAREST = 12
"""Number of nodes near a point whose cells are searched for it."""
_NEWTON, _SETTLED = 20, 1e-12
_BLOCK = 1 << 13
"""Number of points evaluated together, so that their data stay in the cache."""
_INSIDE = 1e-7
"""Distance outside a cell, in its coordinates, at which a point still counts as inside."""
_MORE_NODES = 24
"""Extra nodes of the quadrature along a chord, in addition to k times its length."""


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
        psi at the nodes of the cells.
    """

    stadium: Stadium
    parity: Parity
    k: float
    values: Floats
    _cells: "_Cells" = field(repr=False)

    def __repr__(self) -> str:
        return f"<wave {self.parity} at k = {self.k:.6g}, a = {exact(self.stadium.a)}>"

    def psi(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Return psi at points of the stadium, in units of 1/radius; NaN outside.

        Parameters
        ----------
        x, y : array-like
            Coordinates from the centre, in units of the radius; their shapes must be compatible.
        """
        x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        sign = np.where(x < 0, self.parity.signs[0], 1) * np.where(y < 0, self.parity.signs[1], 1)
        points = np.stack([np.abs(x).ravel(), np.abs(y).ravel()], axis=-1)
        beyond = np.maximum(points[:, 0] - self.stadium.a, 0.0)
        inside = beyond**2 + points[:, 1] ** 2 <= 1 + _INSIDE
        found = np.full(len(points), np.nan)
        known = points[inside]
        parts = (known[first : first + _BLOCK] for first in range(0, len(known), _BLOCK))
        found[inside] = np.concatenate(
            [np.zeros(0), *(self._cells.at(part).values(self.values) for part in parts)]
        )
        return sign * found.reshape(x.shape)

    def normal_derivative(self, s: ArrayLike) -> Floats:
        """Return the outward normal derivative of psi at places of the boundary.

        Parameters
        ----------
        s : array-like
            Arc length anticlockwise from the left end of the bottom wall, in units of the radius.
        """
        points, normal = boundary(self.stadium, np.asarray(s, np.float64))
        signs = np.where(points < 0, self.parity.signs, 1).prod(axis=-1)
        slopes = self._cells.at(np.abs(points.reshape(-1, 2))).slopes(self.values).reshape(points.shape)
        return signs * (slopes * np.abs(normal)).sum(axis=-1)

    def strength(self, orbit: "Orbit") -> float:
        """Return the scar strength of an orbit: the mean of psi^2 along it times the area.

        Raises
        ------
        InputError
            If the word is not an orbit, or belongs to another stadium.
        """
        return float(self.strengths([orbit])[0])

    def strengths(self, orbits: "list[Orbit]") -> Floats:
        """Return the strengths of several orbits (`strength`)."""
        places, weights, count = [], [], []
        for orbit in orbits:
            if orbit.points is None or orbit.a != self.stadium.a:
                raise InputError(f"{orbit.code} is not an orbit at a = {exact(self.stadium.a)}: use another")
            nodes, weight = _along(orbit.points, self.k)
            places.append(nodes)
            weights.append(weight / weight.sum())
            count.append(len(weight))
        square = self.psi(*np.concatenate(places).T) ** 2
        starts = np.cumsum([0, *count[:-1]])
        mean: Floats = np.add.reduceat(square * np.concatenate(weights), starts)
        return self.stadium.area * mean

    def husimi(self, s: ArrayLike, sine: ArrayLike) -> Floats:
        """Return the Husimi function of the normal derivative, shape (S, P), scaled to a maximum of 1.

        Parameters
        ----------
        s : array-like, shape (S,)
            Arc lengths, as in `normal_derivative`.
        sine : array-like, shape (P,)
            Sines of the angles to the normal.
        """
        whole = self.stadium.perimeter
        count = 2 * math.ceil(2 * self.k * whole) + 128  # even, to keep the symmetry of the stadium
        place = (np.arange(count) + 0.5) * whole / count
        slope = self.normal_derivative(place)
        away = place - np.asarray(s, np.float64)[:, None]
        away -= whole * np.round(away / whole)
        packet = np.exp(-self.k * away**2 / 2) * slope
        waves = np.exp(-1j * self.k * np.asarray(sine, np.float64)[:, None, None] * away)
        found = np.abs((waves * packet).sum(axis=-1).T) ** 2
        return found / found.max()

    def plot(self, ax: "Axes | None" = None, orbit: "Orbit | None" = None) -> "Axes":
        """Draw psi^2 with matplotlib, with an orbit on top if one is given.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw on; by default those of a new figure.
        orbit : Orbit, optional
        """
        title = f"k = {self.k:.6g}, {self.parity}, a = {exact(self.stadium.a)}"
        return drawn("waves.draw_wave", (self, orbit), title, ax)


def waves(stadium: Stadium | float, low: float, high: float, parity: Parity | str) -> Iterator[Wave]:
    """Yield the waves of all levels of one parity with low <= k < high, in rising order.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium or its half length.
    low, high : float
        The range of k, in 1/radius.
    parity : str
        ``ee``, ``eo``, ``oe`` or ``oo``: even or odd in x, then in y.

    Raises
    ------
    InputError
        If the stadium or the range is outside what has been tested (`orbitdb.quantum.levels.windows`).
    """
    at, (of,) = as_stadium(stadium), parities_of([parity])
    for task in windows(at, of, low, high):
        grid = task.grid()
        _, values, vectors = eigenvectors(grid.root, task.low**2, task.high**2)
        cells = _Cells(grid.points)
        for k, function in zip(np.sqrt(values).tolist(), grid.functions(vectors), strict=True):
            yield Wave(at, of, k, function / 2, cells)


def boundary(stadium: Stadium, s: Floats) -> tuple[Floats, Floats]:
    """Return the points and outward normals of the boundary at arc lengths s, shape (..., 2) each."""
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


def _along(points: Floats, k: float) -> tuple[Floats, Floats]:
    """Return nodes and weights of a quadrature along a closed path, fine enough for psi^2."""
    places, weights = [], []
    for one, other in pairwise([*points, points[0]]):
        length = float(np.hypot(*(other - one)))
        x, weight = leggauss(math.ceil(k * length) + _MORE_NODES)
        places.append(one + (x[:, None] + 1) / 2 * (other - one))
        weights.append(weight * length / 2)
    return np.concatenate(places), np.concatenate(weights)


@dataclass(frozen=True, eq=False)
class _Cells:
    """The cells shared by the waves of a window; `points` has shape (E, n, n, 2)."""

    points: Floats

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self.points.reshape(-1, 2))

    def at(self, points: Floats) -> "_Places":
        """Find the cells of points, shape (N, 2), and their coordinates there by Newton's method."""
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
            beyond[beyond < _INSIDE] = 0.0
            better = beyond < closest[open_]
            rows = open_[better]
            cell[rows], inside[rows], closest[rows] = which[better], place[better], beyond[better]
        return _Places(cell, inside, self.points)

    def _newton(self, points: Floats, which: NDArray[np.intp], place: Floats, slope: Floats) -> Floats:
        place, moving = place.copy(), np.arange(len(points))
        for _ in range(_NEWTON):
            at = _Places(which[moving], place[moving], self.points)
            off = points[moving] - at.interpolated(self.points[at.cell])
            step = np.linalg.solve(at.jacobian(), off[..., None])[..., 0]
            place[moving] = np.clip(at.inside + step, -1.5, 1.5)
            moving = moving[np.abs(step).max(axis=-1) > _SETTLED]
            if not len(moving):
                break
        return place


@dataclass(frozen=True, eq=False)
class _Places:
    """Points given by their cells, shape (N,), and their coordinates in -1..1 there, shape (N, 2)."""

    cell: NDArray[np.intp]
    inside: Floats
    points: Floats

    @cached_property
    def _bases(self) -> tuple[Floats, Floats]:
        order = self.points.shape[1] - 1
        return _lagrange(self.inside[:, 0], order), _lagrange(self.inside[:, 1], order)

    def interpolated(self, nodal: Floats) -> Floats:
        """Interpolate nodal values, shape (N, n, n, ...), at the points."""
        one, other = self._bases
        return _contracted(one, other, nodal)

    def jacobian(self) -> Floats:
        """Return the derivatives of x, y with respect to the coordinates, shape (N, 2, 2)."""
        return np.stack(self._derivatives(self.points[self.cell]), axis=-1)

    def _derivatives(self, nodal: Floats) -> tuple[Floats, Floats]:
        slope = nodes(self.points.shape[1] - 1)[2]
        one, other = self._bases
        return _contracted(one @ slope, other, nodal), _contracted(one, other @ slope, nodal)

    def values(self, function: Floats) -> Floats:
        """Return a function, shape (E, n, n), at the points."""
        return self.interpolated(function[self.cell])

    def slopes(self, function: Floats) -> Floats:
        """Return the gradient of a function at the points, shape (N, 2)."""
        by = np.stack(self._derivatives(function[self.cell]), axis=-1)
        found = np.linalg.solve(np.swapaxes(self.jacobian(), -1, -2), by[..., None])[..., 0]
        return np.asarray(found, np.float64)


def _contracted(one: Floats, other: Floats, nodal: Floats) -> Floats:
    """Return the sum of one_i other_j nodal_ij for each point, shape (N, ...)."""
    found: Floats = np.einsum("pi,pi...->p...", one, np.einsum("pj,pij...->pi...", other, nodal))
    return found


def _lagrange(x: Floats, order: int) -> Floats:
    """Return the Lagrange polynomials of the nodes at x, shape (N, n), by the barycentric formula."""
    at, _, _ = nodes(order)
    weights = 1 / np.where(np.eye(order + 1, dtype=bool), 1.0, at[:, None] - at).prod(axis=1)
    off = x[:, None] - at
    exactly = off == 0
    terms = weights / np.where(exactly, 1.0, off)
    found: Floats = np.asarray(terms / terms.sum(axis=1, keepdims=True), np.float64)
    rows = exactly.any(axis=1)
    found[rows] = exactly[rows]
    return found
