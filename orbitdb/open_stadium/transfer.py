"""Escape rates from the transfer matrix of the leg map.

A leg begins with the first bounce of a run on one semicircle and ends before the first bounce on the other
one. The matrix leads from cells of equal measure, in the angle and the sine of reflection of first bounces,
to cells on the other semicircle; with patterns, a cell has a copy for each state of their automaton. Points
of each cell are followed for one leg, and those that escape on it are left out:

    M(x, y) = sum of e^(x n + y L) / number of points of the cell,

where n is the number of bounces of the leg and L its length. M leads from one side to the other, so vectors
are iterated two steps at a time.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Indices
from orbitdb.open_stadium.flight import Flights, OpenStadium
from orbitdb.trajectories.ensemble import Arcs, arcs_at, stays

_POINTS = 6
"""Points of a cell along each coordinate, one at random in each square of a finer grid."""

_SETTLED = 1e-7
_MOST_STEPS = 2000
_CHUNK = 1 << 15


class GridLegs(NamedTuple):
    """Legs that begin in the cells of a grid and do not escape, in order of their sources; shape (N,)."""

    source: Indices
    target: Indices
    share: Floats  # 1 / number of points of the source
    bounces: Floats
    path: Floats
    size: int  # number of cells, counted once for each state
    lost: int  # number of points that escape

    @classmethod
    def of(cls, stadium: OpenStadium, grid: int) -> "GridLegs":
        """Follow legs from all cells, in every state in which one may begin."""
        cells, states, parts, lost = 2 * grid**2, [0], [], 0
        for state in states:  # grows while it is read
            for source, share, arcs in _points(grid):
                kept, target, after, bounces, path = _followed(stadium, arcs, state, grid)
                lost += len(source) - len(kept)
                states += sorted({*np.unique(after).tolist()} - {*states})
                place = np.zeros(max(states) + 1, dtype=np.intp)
                place[states] = np.arange(len(states))
                source = source[kept] + cells * states.index(state)
                parts.append((source, target + cells * place[after], share[kept], bounces, path))
        source, *columns = (np.concatenate(column) for column in zip(*parts, strict=True))
        order = np.argsort(source, kind="stable")
        target, share, bounces, path = (column[order] for column in columns)
        return cls(source[order], target, share, bounces, path, cells * len(states), lost)

    def growth(self, weights: Floats | float, vector: Floats) -> tuple[float, Floats]:
        """Return ln rho of the matrix whose terms have these factors, and its vector, from a first guess."""
        from scipy.sparse import csr_array

        ends = np.searchsorted(self.source, np.arange(self.size + 1))
        matrix = csr_array((self.share * weights, self.target, ends), shape=(self.size, self.size))
        size, before = 0.0, math.inf
        for _ in range(_MOST_STEPS):
            vector = matrix @ (matrix @ vector)
            size = float(vector.sum())
            if size == 0:
                return -math.inf, vector
            vector = vector / size
            if abs(size - before) <= _SETTLED * size:
                break
            before = size
        return math.log(size) / 2, vector


def _points(grid: int) -> Iterator[tuple[Indices, Floats, Arcs]]:
    """Yield points of the cells that are first bounces of runs: their cells, shares and the points."""
    fine, rng = grid * _POINTS, np.random.default_rng(grid)
    rows = max(1, _CHUNK // (fine * _POINTS)) * _POINTS
    for number, side in enumerate((-1.0, 1.0)):
        for row in range(0, fine, rows):
            high = np.arange(row, min(row + rows, fine))
            shape = len(high), fine
            angle = np.pi * ((high[:, None] + rng.random(shape)) / fine - 0.5)
            sine = 2 * (np.arange(fine) + rng.random(shape)) / fine - 1
            cell = number * grid**2 + high[:, None] // _POINTS * grid + np.arange(fine) // _POINTS
            sides = np.full(angle.size, side)
            back = arcs_at(sides, angle.ravel(), -sine.ravel())
            first = np.flatnonzero(~stays(back))
            arcs = arcs_at(sides[first], angle.ravel()[first], sine.ravel()[first])
            source = cell.ravel()[first]
            yield source, 1 / np.bincount(source)[source], arcs


def _followed(stadium: OpenStadium, arcs: Arcs, state: int, grid: int) -> tuple[Any, ...]:
    """Follow legs from their first bounces; return those that do not escape: which, and where they end.

    An opening at the end of a leg is left to the next one, because it may cut the cell there.
    """
    n = len(arcs.side)
    no = np.zeros(n, dtype=np.bool_)
    flights = Flights(arcs, ~no, no, no, np.full(n, state))
    left = np.flatnonzero(~stadium.escaped_at(flights))
    flights = flights.taken(left)
    bounces, path = np.zeros((2, len(left)))
    ended: list[tuple[Any, ...]] = []
    while len(left) or not ended:
        way = stadium.onward(flights)
        bounces, path = bounces + way.bounces, path + way.path
        there = way.crossed & (way.fatal >= way.bounces)
        end = way.flights.taken(there)
        ended.append((left[there], _cells(end.arcs, grid), end.state, bounces[there], path[there]))
        going = ~way.crossed & (way.fatal == np.inf)
        flights, left, bounces, path = way.flights.taken(going), left[going], bounces[going], path[going]
    return tuple(np.concatenate(column) for column in zip(*ended, strict=True))


def _cells(arcs: Arcs, grid: int) -> Indices:
    """Return the numbers of the cells of bounces."""
    angle = np.arctan2(arcs.y, np.abs(arcs.x)) / np.pi + 0.5
    sine = (arcs.x * arcs.vy - arcs.y * arcs.vx + 1) / 2
    row, column = (np.clip(part * grid, 0, grid - 1).astype(np.intp) for part in (angle, sine))
    return np.where(arcs.side > 0, grid**2, 0) + row * grid + column
