"""Figures of orbits in their stadium."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, Locator
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.svg import number_labels
from orbitdb.plots.style import BLUE, FAINT, INK

Floats = NDArray[np.float64]

MOST_NUMBERED = 24
_MOST_MARKED = 60
_MOST_ARROWS = 12
_AWAY, _BESIDE = 12, 0.3
"""How far numbers of bounces stand from a wall, in points, and the axes go beyond it, in inches."""
_CONTINUED = "walls and circles, continued"
_ALONG = 0.65
"""Where on a link its arrow is: two that lie on each other, of an orbit that retraces its path, differ."""
_DIGIT = 0.63
"""How wide a digit of a label is, in units of the size of its font."""


def draw_orbit(ax: Axes, stadium: Stadium, points: Floats, colour: str = BLUE) -> None:
    """Draw an orbit in its stadium, as in the paper's Fig. 1.

    Parameters
    ----------
    ax : Axes
    stadium : Stadium
    points : ndarray, shape (p, 2)
        The bounces in their order; they are numbered from 1 if there are `MOST_NUMBERED` or fewer.
    colour : str, optional
        Of the path.
    """
    _draw_stadium(ax, stadium)
    closed = np.concatenate([points, points[:1]])
    many = len(points) > _MOST_MARKED
    ax.plot(*closed.T, color=colour, linewidth=0.6 if many else 1.3, zorder=3)
    if not many:
        ax.plot(*points.T, "o", color=colour, markersize=4, zorder=4)
    _draw_arrows(ax, points, colour)
    if len(points) <= MOST_NUMBERED:
        for place, (right, up), text in number_labels(stadium, points):
            halo = [withStroke(linewidth=3, foreground="white")]
            ax.annotate(text, place, (_AWAY * right, _AWAY * up), textcoords="offset points", ha="center",
                        va="center", fontsize=9, color=INK, path_effects=halo, zorder=5)  # fmt: skip


def _draw_arrows(ax: Axes, points: Floats, colour: str) -> None:
    """Draw the direction on the links: on each, or on the first where there are many."""
    ahead = np.roll(points, -1, axis=0) - points
    links = range(len(points) if len(points) <= _MOST_ARROWS else 1)
    for start, step in zip(points[links], ahead[links], strict=True):
        tip = start + _ALONG * step
        tail = tip - 1e-3 * step / math.hypot(*step)
        ax.annotate(
            "", tip, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 13}, zorder=4
        )


def _draw_stadium(ax: Axes, stadium: Stadium) -> None:
    """Draw the stadium, faintly its continued walls and circles, and ticks at the ends of its walls."""
    a, turn = stadium.a, np.linspace(0, 2 * math.pi, 200)
    across, up = _room(ax, a, equal := a < 20)
    for centre in (-a, a):
        ax.plot(centre + np.cos(turn), np.sin(turn), color=FAINT, linewidth=0.7, zorder=1)
    beyond = a + 1 + across
    ax.hlines([-1, 1], -beyond, beyond, color=FAINT, linewidth=0.7, zorder=1, label=_CONTINUED)
    ax.plot(*stadium.outline().T, color=INK, linewidth=1.8, zorder=2)
    ax.grid(False)
    ax.spines[["left", "bottom"]].set_visible(False)
    ax.set(xlim=(-beyond, beyond), ylim=(-1 - up, 1 + up), xlabel="$x/R$", ylabel="$y/R$")
    ax.set_yticks([-1, 0, 1])
    ax.xaxis.set_major_locator(_AtWalls(a))
    ax.xaxis.set_major_formatter(FuncFormatter(_tick_label))
    ax.set_aspect("equal" if equal else "auto")


def _room(ax: Axes, a: float, equal: bool) -> tuple[float, float]:
    """Return how far axes go beyond a stadium, across and up: `_BESIDE` of them, for numbers of bounces."""
    box, dpi = ax.get_window_extent(), ax.figure.dpi
    sizes = np.array([box.width, box.height]) / dpi
    unit = np.array([2 * (a + 1), 2]) / np.maximum(sizes - 2 * _BESIDE, sizes / 2)
    across, up = (_BESIDE * (np.full(2, unit.max()) if equal else unit)).tolist()
    return across, up


class _AtWalls(Locator):
    """Ticks at the ends of the stadium and of its straight walls, or fewer where labels would touch."""

    def __init__(self, a: float) -> None:
        self._choices: tuple[list[float], ...] = ([-a - 1, -a, 0, a, a + 1], [-a - 1, 0, a + 1])

    def __call__(self) -> list[float]:
        """Return the places of the ticks, on the axis as wide as it is by now."""
        return next(filter(self._fit, self._choices), [0.0])

    def _fit(self, places: list[float]) -> bool:
        """Tell whether the labels at some places, rising, stand a digit apart."""
        assert self.axis is not None
        low, high = self.axis.get_view_interval()
        scale = 3 * self.axis.get_tick_space() / (high - low)  # it counts labels three times as wide as high
        return all(
            (right - left) * scale > _DIGIT * (len(_tick_label(left) + _tick_label(right)) / 2 + 1)
            for left, right in pairwise(places)
        )


def _tick_label(x: float, _place: int | None = None) -> str:
    return f"{x:.3f}".rstrip("0").rstrip(".").replace("-", "\N{MINUS SIGN}")


def draw_sheet(
    ax: Axes,
    stadium: Stadium,
    paths: Sequence[Floats],
    labels: Sequence[str],
    columns: int,
) -> None:
    """Draw many orbits on one sheet, each in its stadium, in rows from the top left.

    Parameters
    ----------
    ax : Axes
    stadium : Stadium
    paths : sequence of ndarray, shape (p, 2) each
        The bounces of each orbit.
    labels : sequence of str
        What stands under each.
    columns : int
        How many stand in a row.
    """
    wide, high = cell_size(stadium)
    places = [(k % columns * wide, -(k // columns) * high) for k in range(len(paths))]
    outline = stadium.outline(24)
    walls = LineCollection([outline + place for place in places], colors=INK, linewidths=0.7)
    closed = [np.concatenate([path, path[:1]]) + place for path, place in zip(paths, places, strict=True)]
    ax.add_collection(walls)
    ax.add_collection(LineCollection(closed, colors=BLUE, linewidths=0.8, joinstyle="round"))
    dots = np.concatenate([path + place for path, place in zip(paths, places, strict=True)])
    ax.plot(*dots.T, "o", color=BLUE, markersize=1.6)
    for label, (x, y) in zip(labels, places, strict=True):
        ax.annotate(label, (x, y - 1.12), ha="center", va="top", fontsize=7, color=INK)
    rows = math.ceil(len(paths) / columns)
    ax.set_xlim(-wide / 2, (columns - 0.5) * wide)
    ax.set_ylim(-(rows - 1) * high - 1.75, 1.25)
    ax.set_aspect("equal")
    ax.axis("off")


def cell_size(stadium: Stadium) -> tuple[float, float]:
    """Return the width and height of one orbit on a sheet, in units of the radius."""
    return 2 * (stadium.a + 1) + 0.6, 3.1
