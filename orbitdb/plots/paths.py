"""Paths in the stadium: of an orbit, of a trajectory, and sheets of many orbits."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.open_stadium.openings import Opening, outline_parts
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots.style import (
    BLUE,
    FAINT,
    GREY,
    INK,
    SMALL,
    Colours,
    closed,
    inches_wide,
    look,
    short,
    titled,
    width_or,
    wrapped,
)
from orbitdb.svg import MOST_LABELLED, symbol_labels

_MOST_MARKED = 60
_MOST_ARROWS = 12
_SMALL = 2.2
"""Width, in inches, below which axes show only the outline, the path and small symbols."""
_BESIDE = 0.3
"""Distance from the wall to the edge of the axes, in inches; the symbol of a bounce is in between."""
_ALONG = 0.65
"""Position of the arrow along a chord, off-centre so that the two arrows of a retraced chord differ."""
_DIGIT = 0.09
"""Width of a digit in the label of a tick, in inches."""


def draw_orbit(
    ax: Axes,
    stadium: Stadium,
    points: Floats,
    symbols: str,
    colour: str = BLUE,
    opening: Sequence[Opening] = (),
) -> None:
    """Draw an orbit in the stadium, as in the paper's Fig. 1, given its bounces in order, shape (p, 2).

    Up to `MOST_LABELLED` bounces carry their symbols. The dot of the first is open, so that one can read the
    code from there on, along the arrows. Openings are gaps in the wall.
    """
    small = inches_wide(ax) < _SMALL
    font = rcParams["font.size"]
    away, size = (6, SMALL) if small else (1.2 * font, 0.9 * font)
    draw_stadium(ax, stadium, small, opening)
    many = len(points) > _MOST_MARKED
    ax.plot(*closed(points).T, color=colour, linewidth=0.6 if many or small else 1.3, zorder=3)
    if not many:
        ax.plot(
            *points.T,
            "o",
            color=colour,
            markersize=2 if small else 0.8 * rcParams["lines.markersize"],
            zorder=4,
        )
    if not small:
        _draw_arrows(ax, points, colour)
    if len(points) <= MOST_LABELLED:
        if not small:
            ax.plot(*points[0], "o", color=colour, markerfacecolor="white", zorder=5)
        for place, (right, up), text in symbol_labels(stadium, points, symbols):
            ground = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"}
            ax.annotate(text, place, (away * right, away * up), textcoords="offset points", ha="center",
                        va="center", fontsize=size, color=INK, bbox=ground, zorder=6)  # fmt: skip


def draw_path(ax: Axes, stadium: Stadium, points: Floats, colour: str = BLUE) -> None:
    """Draw the path of a trajectory through its bounces, shape (T, 2), in the stadium."""
    draw_stadium(ax, stadium, inches_wide(ax) < _SMALL)
    ax.plot(*points.T, color=colour, linewidth=0.6 if len(points) > _MOST_MARKED else 1.3, zorder=3)
    ax.plot(*points[0], "o", color=colour, markersize=4, zorder=4)


def _draw_arrows(ax: Axes, points: Floats, colour: str) -> None:
    """Draw an arrow on every chord, or only on the first chord if there are many."""
    ahead, size = np.roll(points, -1, axis=0) - points, 1.3 * rcParams["font.size"]
    links = range(len(points) if len(points) <= _MOST_ARROWS else 1)
    for start, step in zip(points[links], ahead[links], strict=True):
        tip = start + _ALONG * step
        tail = tip - 1e-3 * step / math.hypot(*step)
        ax.annotate(
            "", tip, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": size}, zorder=4
        )


def draw_outline(
    ax: Axes, stadium: Stadium, width: float, opening: Sequence[Opening] = ()
) -> list[PathPatch]:
    """Draw the boundary, with gaps at openings; a whole one is a closed path, which shows no corner."""
    paths = [Path(part, closed=not opening) for part in outline_parts(stadium, opening)]
    patches = [
        PathPatch(path, fill=False, edgecolor=INK, linewidth=width, joinstyle="round", zorder=2)
        for path in paths
    ]
    for patch in patches:
        ax.add_patch(patch)
    return patches


def draw_stadium(ax: Axes, stadium: Stadium, small: bool, opening: Sequence[Opening] = ()) -> None:
    """Draw the outline and, unless the axes are small, ticks and faint continuations of walls and circles."""
    a, turn = stadium.a, np.linspace(0, 2 * math.pi, 200)
    if small:
        draw_outline(ax, stadium, 1, opening)
        ax.set(xlim=(-a - 1.5, a + 1.5), ylim=(-1.6, 1.6), aspect="equal" if a < 20 else "auto")
        ax.axis("off")
        return
    across, up = _room(ax, a, equal := a < 20)
    for centre in (-a, a):
        ax.plot(centre + np.cos(turn), np.sin(turn), color=FAINT, linewidth=0.7, zorder=1)
    beyond = a + 1 + across
    ax.hlines([-1, 1], -beyond, beyond, color=FAINT, linewidth=0.7, zorder=1)
    draw_outline(ax, stadium, 1.3 * rcParams["lines.linewidth"], opening)
    ax.grid(False)
    ax.spines[["left", "bottom"]].set_visible(False)
    ax.set(xlim=(-beyond, beyond), ylim=(-1 - up, 1 + up))
    mark_stadium(ax, stadium)
    ax.set_aspect("equal" if equal else "auto")
    if not equal:
        ax.text(0.5, 0.02, "not to scale", transform=ax.transAxes, ha="center", color=GREY, fontsize=SMALL)


def mark_stadium(ax: Axes, stadium: Stadium) -> None:
    """Label the axes of a stadium at its centre, its ends and, if there is room, its joints."""
    a = stadium.a
    ax.set(xlabel="$x/R$", ylabel="$y/R$", yticks=[-1, 0, 1])
    ends, walls = [-a - 1, 0, a + 1], [-a - 1, -a, 0, a, a + 1]
    labels = {x: f"{x:.3f}".rstrip("0").rstrip(".").replace("-", "\N{MINUS SIGN}") for x in walls}
    inches = min(a, 1) / np.ptp(ax.get_xlim()) * inches_wide(ax)
    ticks = walls if inches > _DIGIT * (max(map(len, labels.values())) + 1) else ends
    ax.set_xticks(ticks, [labels[x] for x in ticks])


def _room(ax: Axes, a: float, equal: bool) -> tuple[float, float]:
    """Return the room beside and above the stadium for symbols, `_BESIDE` inches, in units of the radius."""
    box, dpi = ax.get_window_extent(), ax.figure.dpi
    sizes = np.array([box.width, box.height]) / dpi
    unit = np.array([2 * (a + 1), 2]) / np.maximum(sizes - 2 * _BESIDE, sizes / 2)
    across, up = (_BESIDE * (np.full(2, unit.max()) if equal else unit)).tolist()
    return across, up


_NAMED_ABOVE = ("draw_phase_space", "draw_husimi")
"""Functions that name the walls above the axes, where the title would be."""


def draw_titled(draw: Callable[..., object], what: Sequence[Any], title: str, ax: Axes | None) -> Axes:
    """Draw with a title and in our style on the given axes, or on those of a new figure; return the axes."""
    from matplotlib import pyplot  # imported late because it looks for a display

    # The figure is made before `look` is entered. Making it loads the backend, which in a notebook changes a
    # setting so that figures are shown; leaving `look` would undo that change.
    figure = ax.figure if ax else pyplot.figure(layout="constrained")
    with look():
        axes = ax or figure.subplots()
        drawn = draw(axes, *what)
        if ax is None and isinstance(drawn, Colours):
            drawn.add_bar(axes)
        room = inches_wide(axes)
        shown = axes.set_title(
            titled(wrapped(title, room)), pad=20 if draw.__name__ in _NAMED_ABOVE else None
        )
        if room < _SMALL:
            shown.set_fontsize(SMALL)
        if len(axes.get_legend_handles_labels()[0]) > 1:
            below: dict[str, Any] = (
                {"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "ncols": 2} if ax is None else {}
            )
            axes.legend(fontsize="small", **below)  # below new axes, where it covers no points
    return axes


_HIGH, _GAP = 3.5, 0.6
"""Height of a drawing including its label, and extra width beside the stadium, in units of the radius."""
_UNIT = 0.29
"""Size of the radius in a separate figure, in inches."""
_LONGEST = 24


_LABEL, _LABEL_LINE = 1.45, 0.12
"""Width of a label under a drawing, and height of one of its lines, in inches."""


def columns_of(count: int, a: float, shape: float) -> int:
    """Return the number of columns with which `count` drawings are largest, given width over height."""
    high, wide = _HIGH, _width(a)
    return max(
        range(1, count + 1),
        key=lambda columns: min(shape / (columns * wide), 1 / (math.ceil(count / columns) * high)),
    )


_PAGE = 9.0
"""Greatest height of a sheet with a given width, in inches; the drawings of a longer one are smaller."""


def size_of(count: int, a: float) -> tuple[float, float]:
    """Return the width and height, in inches, of a figure with `count` orbits."""
    columns, column = max(1, math.ceil(math.sqrt(0.8 * count * _HIGH / _width(a)))), _column(a)
    usual = max(4.0, columns * column)
    if (width := width_or(usual)) == usual:
        return usual, math.ceil(count / columns) * _HIGH * _UNIT + 0.6
    rows = math.ceil(count / max(1, int(width / column)))
    return width, min(rows * _HIGH * _UNIT + 0.6, _PAGE)


def _column(a: float) -> float:
    """Return the width of a drawing with its label in a separate figure, in inches."""
    return max(_width(a) * _UNIT, _LABEL)


def draw_sheet(ax: Axes, orbits: Sequence[Orbit]) -> None:
    """Draw orbits of the same stadium, which have coordinates, in as many columns as fill the axes best."""
    a = orbits[0].a
    box = ax.get_window_extent()
    wide, columns = _width(a), columns_of(len(orbits), a, box.width / box.height)
    rows = math.ceil(len(orbits) / columns)
    unit = min(box.width / (columns * wide), box.height / (rows * _HIGH)) / ax.figure.dpi
    lines = min(int((_HIGH - 2.2) * unit / _LABEL_LINE), 2 if wide * unit > _LABEL else 1)
    outline, walls, drawn = Stadium(a).outline(24), [], []
    for k, orbit in enumerate(orbits):
        assert orbit.points is not None
        place = x, y = k % columns * wide, -(k // columns) * _HIGH
        walls.append(outline + place)
        drawn.append(closed(orbit.points) + place)
        ax.annotate(
            "\n".join(_label(orbit)[:lines]), (x, y - 1.12), ha="center", va="top", fontsize=SMALL, color=INK
        )
    ax.add_collection(PolyCollection(walls, facecolors="none", edgecolors=INK, linewidths=0.7))
    ax.add_collection(LineCollection(drawn, colors=BLUE, linewidths=0.8, joinstyle="round"))
    ax.plot(*np.concatenate([path[:-1] for path in drawn]).T, "o", color=BLUE, markersize=1.6)
    ax.set(xlim=(-wide / 2, (columns - 0.5) * wide), ylim=(-(rows - 1) * _HIGH - 2.15, 1.25), aspect="equal")
    ax.axis("off")


def _width(a: float) -> float:
    return 2 * (a + 1) + _GAP


def _label(orbit: Orbit) -> list[str]:
    """Return the lines of a label, the most important first."""
    return [
        short(orbit.code, _LONGEST),
        f"$L = {orbit.length:.4f}$, $\\lambda_d = {orbit.lambda_d:.4f}$",
    ]
