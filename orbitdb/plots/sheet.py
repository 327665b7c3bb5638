"""A sheet of orbits: many small drawings, labelled with code, length and lambda per bounce."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots.style import BLUE, INK
from orbitdb.symbols.words import run_notation

_HIGH, _BESIDE = 3.5, 0.6
"""Height of a drawing including its label, and extra width beside the stadium, in units of the radius."""
_UNIT = 0.26
"""Size of the radius in a separate figure, in inches."""
_LONGEST = 24


def columns_of(count: int, a: float) -> int:
    """Return the number of columns that gives a sheet of `count` drawings a suitable shape."""
    return max(1, math.ceil(math.sqrt(0.8 * count * _HIGH / _width(a))))


def size_of(count: int, a: float) -> tuple[float, float]:
    """Return the width and height, in inches, of a figure with `count` orbits."""
    columns = columns_of(count, a)
    return max(4.0, columns * _width(a) * _UNIT), math.ceil(count / columns) * _HIGH * _UNIT + 0.6


def draw_sheet(ax: Axes, orbits: Sequence[Orbit]) -> None:
    """Draw orbits of the same stadium row by row.

    Parameters
    ----------
    ax : Axes
    orbits : sequence of Orbit
        The orbits in the order in which to draw them; each must have coordinates.
    """
    a = orbits[0].a
    wide, columns = _width(a), columns_of(len(orbits), a)
    rows = math.ceil(len(orbits) / columns)
    outline, walls, closed = Stadium(a).outline(24), [], []
    for k, orbit in enumerate(orbits):
        assert orbit.points is not None
        place = x, y = k % columns * wide, -(k // columns) * _HIGH
        walls.append(outline + place)
        closed.append(np.concatenate([orbit.points, orbit.points[:1]]) + place)
        ax.annotate(_label(orbit), (x, y - 1.12), ha="center", va="top", fontsize=6, color=INK)
    ax.add_collection(LineCollection(walls, colors=INK, linewidths=0.7))
    ax.add_collection(LineCollection(closed, colors=BLUE, linewidths=0.8, joinstyle="round"))
    ax.plot(*np.concatenate([path[:-1] for path in closed]).T, "o", color=BLUE, markersize=1.6)
    ax.set(xlim=(-wide / 2, (columns - 0.5) * wide), ylim=(-(rows - 1) * _HIGH - 2.15, 1.25), aspect="equal")
    ax.axis("off")


def _width(a: float) -> float:
    return 2 * (a + 1) + _BESIDE


def _label(orbit: Orbit) -> str:
    code = orbit.code if len(orbit.code) <= _LONGEST else f"{run_notation(orbit.code)[:_LONGEST]}..."
    return f"{code}\n$L = {orbit.length:.4f}$, $\\lambda_d = {orbit.lambda_d:.4f}$"
