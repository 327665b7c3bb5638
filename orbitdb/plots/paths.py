"""Figures of orbits: their paths, sheets of many paths, bounces in phase space, and numbers by length."""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers
from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots.style import BLUE, FAINT, GREY, INK, look, short, wrapped
from orbitdb.plots.svg import number_labels

Period = tuple[NDArray[np.uint8], Floats, Floats]
"""The orbits of one period: symbols and coordinates, shape (N, p), and lambda per bounce, shape (N,)."""

MOST_NUMBERED = 24
_MOST_MARKED = 60
_MOST_ARROWS = 12
_SMALL = 2.2
"""Width, in inches, below which axes show only the outline, the path and small numbers."""
_AWAY, _BESIDE = 12, 0.3
"""Distance from the wall to the number of a bounce, in points, and to the edge of the axes, in inches."""
_CONTINUED = "walls and circles, continued"
_ALONG = 0.65
"""Position of the arrow along a chord, off-centre so that the two arrows of a retraced chord differ."""
_DIGIT = 0.09
"""Width of a digit in the label of a tick, in inches."""


def draw_orbit(ax: Axes, stadium: Stadium, points: Floats, colour: str = BLUE) -> None:
    """Draw an orbit in the stadium, as in the paper's Fig. 1, given its bounces in order, shape (p, 2).

    The bounces are numbered from 1 if there are at most `MOST_NUMBERED`.
    """
    small = ax.get_window_extent().width < _SMALL * ax.figure.dpi
    away, size = (_AWAY / 2, 5) if small else (_AWAY, 9)
    draw_stadium(ax, stadium, small)
    closed = np.concatenate([points, points[:1]])
    many = len(points) > _MOST_MARKED
    ax.plot(*closed.T, color=colour, linewidth=0.6 if many or small else 1.3, zorder=3)
    if not many:
        ax.plot(*points.T, "o", color=colour, markersize=2 if small else 4, zorder=4)
    if not small:
        _draw_arrows(ax, points, colour)
    if len(points) <= MOST_NUMBERED:
        for place, (right, up), text in number_labels(stadium, points):
            ground = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"}
            ax.annotate(text, place, (away * right, away * up), textcoords="offset points", ha="center",
                        va="center", fontsize=size, color=INK, bbox=ground, zorder=5)  # fmt: skip


def draw_path(ax: Axes, stadium: Stadium, points: Floats, colour: str = BLUE) -> None:
    """Draw the path of a trajectory through its bounces, shape (T, 2), in the stadium."""
    draw_stadium(ax, stadium, ax.get_window_extent().width < _SMALL * ax.figure.dpi)
    ax.plot(*points.T, color=colour, linewidth=0.6 if len(points) > _MOST_MARKED else 1.3, zorder=3)
    ax.plot(*points[0], "o", color=colour, markersize=4, zorder=4)


def _draw_arrows(ax: Axes, points: Floats, colour: str) -> None:
    """Draw an arrow on every chord, or only on the first chord if there are many."""
    ahead = np.roll(points, -1, axis=0) - points
    links = range(len(points) if len(points) <= _MOST_ARROWS else 1)
    for start, step in zip(points[links], ahead[links], strict=True):
        tip = start + _ALONG * step
        tail = tip - 1e-3 * step / math.hypot(*step)
        ax.annotate(
            "", tip, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 13}, zorder=4
        )


def draw_stadium(ax: Axes, stadium: Stadium, small: bool) -> None:
    """Draw the outline and, unless the axes are small, ticks and faint continuations of walls and circles."""
    a, turn = stadium.a, np.linspace(0, 2 * math.pi, 200)
    if small:
        ax.plot(*stadium.outline().T, color=INK, linewidth=1, zorder=2)
        ax.set(xlim=(-a - 1.5, a + 1.5), ylim=(-1.6, 1.6), aspect="equal" if a < 20 else "auto")
        ax.axis("off")
        return
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
    ends, walls = [-a - 1, 0, a + 1], [-a - 1, -a, 0, a, a + 1]
    labels = {x: f"{x:.3f}".rstrip("0").rstrip(".").replace("-", "\N{MINUS SIGN}") for x in walls}
    inches = min(a, 1) / (2 * beyond) * ax.get_window_extent().width / ax.figure.dpi
    ticks = walls if inches > _DIGIT * (max(map(len, labels.values())) + 1) else ends
    ax.set_xticks(ticks, [labels[x] for x in ticks])
    ax.set_aspect("equal" if equal else "auto")


def _room(ax: Axes, a: float, equal: bool) -> tuple[float, float]:
    """Return the room beside and above the stadium for numbers, `_BESIDE` inches, in units of the radius."""
    box, dpi = ax.get_window_extent(), ax.figure.dpi
    sizes = np.array([box.width, box.height]) / dpi
    unit = np.array([2 * (a + 1), 2]) / np.maximum(sizes - 2 * _BESIDE, sizes / 2)
    across, up = (_BESIDE * (np.full(2, unit.max()) if equal else unit)).tolist()
    return across, up


def draw_phase_space(ax: Axes, stadium: Stadium, periods: Iterable[Period]) -> Any:
    """Draw bounces in phase space: tangential momentum against position along the boundary.

    The position is the arc length (`Stadium.arclength`). The momentum is the sine of the angle from the
    inward normal to the outgoing path, positive anticlockwise. The colour of a bounce shows the lambda per
    bounce of its orbit. Return the dots, to which a colour bar can be added.
    """
    drawn = [
        (*birkhoff(stadium, symbols, coordinates), np.repeat(lambda_d, symbols.shape[1]))
        for symbols, coordinates, lambda_d in periods
    ]
    place, sine, colour = (
        np.concatenate([part.ravel() for part in parts]) for parts in zip(*drawn, strict=True)
    )
    size = float(np.clip(6e4 / len(place), 0.3, 12))
    low, high = np.percentile(colour, [2, 98])
    dots = ax.scatter(
        place, sine, c=colour, s=size, cmap="viridis", vmin=low, vmax=high, linewidths=0, rasterized=True
    )
    joints = np.cumsum([0, 2 * stadium.a, np.pi, 2 * stadium.a, np.pi])
    for joint in joints[1:-1]:
        ax.axvline(joint, color=GREY, linewidth=0.8)
    for middle, name in zip(
        (joints[1:] + joints[:-1]) / 2, ("0: bottom", "3, 5: right", "2: top", "1, 4: left"), strict=True
    ):
        ax.annotate(name, (middle, 1.02), xycoords=("data", "axes fraction"), ha="center", color=GREY)
    ax.set(xlim=(0, stadium.perimeter), ylim=(-1, 1), xlabel="arc length $s/R$", ylabel=r"$\sin\alpha$")
    ax.grid(False)
    return dots


def draw_staircase(
    ax: Axes, length: Floats, count: Integers, colour: str = BLUE, label: str | None = None
) -> None:
    """Draw the number of orbits up to each length, given how many orbits have each one, shape (n,).

    The lengths are in units of the radius and in any order; `label` is the name of the line in the legend.
    """
    order = np.argsort(length, kind="stable")
    ax.step(length[order], np.cumsum(count[order]), where="post", color=colour, label=label)
    ax.set(yscale="log", xlabel="length $L/R$", ylabel="orbits no longer than $L$")


def draw_titled(draw: Callable[..., object], what: Sequence[Any], title: str, ax: Axes | None) -> Axes:
    """Draw with a title and in our style on the given axes, or on those of a new figure; return the axes."""
    from matplotlib import pyplot  # imported late because it looks for a display

    # The figure is made before `look` is entered. Making it loads the backend, which in a notebook changes a
    # setting so that figures are shown; leaving `look` would undo that change.
    figure = ax.figure if ax else pyplot.figure(layout="constrained")
    with look():
        axes = ax or figure.subplots()
        draw(axes, *what)
        room = axes.get_window_extent().width / axes.figure.dpi
        shown = axes.set_title(wrapped(title, room), pad=20 if draw is draw_phase_space else None)
        if room < _SMALL:
            shown.set_fontsize(7)
        if len(axes.get_legend_handles_labels()[0]) > 1:
            axes.legend(fontsize="small")
    return axes


_HIGH, _GAP = 3.5, 0.6
"""Height of a drawing including its label, and extra width beside the stadium, in units of the radius."""
_UNIT = 0.26
"""Size of the radius in a separate figure, in inches."""
_LONGEST = 24


def columns_of(count: int, a: float, shape: float) -> int:
    """Return the number of columns with which `count` drawings are largest, given width over height."""
    high, wide = _HIGH, _width(a)
    return max(
        range(1, count + 1),
        key=lambda columns: min(shape / (columns * wide), 1 / (math.ceil(count / columns) * high)),
    )


def size_of(count: int, a: float) -> tuple[float, float]:
    """Return the width and height, in inches, of a figure with `count` orbits."""
    columns = max(1, math.ceil(math.sqrt(0.8 * count * _HIGH / _width(a))))
    return max(4.0, columns * _width(a) * _UNIT), math.ceil(count / columns) * _HIGH * _UNIT + 0.6


def draw_sheet(ax: Axes, orbits: Sequence[Orbit]) -> None:
    """Draw orbits of the same stadium, which have coordinates, in as many columns as fill the axes best."""
    a = orbits[0].a
    box = ax.get_window_extent()
    wide, columns = _width(a), columns_of(len(orbits), a, box.width / box.height)
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
    return 2 * (a + 1) + _GAP


def _label(orbit: Orbit) -> str:
    return f"{short(orbit.code, _LONGEST)}\n$L = {orbit.length:.4f}$, $\\lambda_d = {orbit.lambda_d:.4f}$"
