"""Figures of the symbol plane: points of words, the pruning fronts, and what they and the rules forbid."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from orbitdb.answers.subset import Subset
from orbitdb.arrays import Floats, Marks
from orbitdb.errors import InputError
from orbitdb.orbits.status import Status
from orbitdb.plots.registry import gaps, nothing
from orbitdb.plots.style import BLUE, GREY, INK, INKS, NARROW, ORANGE, SMALL, Picture, figure, width_or
from orbitdb.selection import Selection
from orbitdb.symbols.plane import PIECE
from orbitdb.symbols.plane import symbol_plane as points_of
from orbitdb.symbols.words import from_strings
from orbitdb.text import format_float
from orbitdb.trajectories.pruning_front import Front, PruningFront

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

_FORBIDDEN, _RULED_OUT, _INSIDE = "#fbe3d6", "#e8e8e8", "#f2b48c"
"""Colours of what a front forbids, of what the rules forbid, and of pruned words inside the front."""

_STEP = 2e-3
"""Distance in the plane below which points of a front are drawn as one."""

_CELLS, _FINENESS = (80, 500), 1.4
"""Least and largest number of cells along an axis of the image of the points, and its ratio to their root."""

_SMALLEST = 2.2
"""On smaller axes, in inches, the names are shorter: two of them are drawn side by side in one column."""

_NEXT = {
    False: ("right\n3, 5", "top\n2", "left\n1, 4"),
    True: ("up\n3", "top\n2", "left\n1, 4", "bottom\n0", "down\n5"),
}
_BEFORE = {False: _NEXT[False], True: ("down\n5", *_NEXT[True][1:-1], "up\n3")}
"""Names of the intervals of gamma and of delta, which are equal, for walls and for semicircles."""

_TITLES = {
    False: "Bounces on the bottom wall\n(top wall: turned by half a turn)",
    True: "Bounces on the right semicircle\n(left semicircle: turned by half a turn)",
}
_SHORT_TITLES = {False: "Bottom wall", True: "Right semicircle"}
_RULES = {False: (1 / 2, "rules 4, 6"), True: (1 / 5, "rule 5")}
"""Side of the two squares that the geometric rules forbid, and their name."""

MOST_WORDS = 1_000_000
"""The plane tells the points of at most this many words apart."""

_WITH_POINTS = (Status.ORBIT, Status.DYNAMICAL)
_SIZE, _BETWEEN, _LAYOUTS = (7.2, 4.75), 0.06, 3
"""Width and height of a figure, in inches, the gap between its planes as a part of its width, and rounds."""
_STACKED = 2.0
"""Height of a narrow figure, whose planes are one below the other, in units of its width."""


class Points(NamedTuple):
    """Bounces of words in the symbol plane."""

    plane: Floats  # gamma and delta, shape (N, 2)
    curved: Marks  # whether the bounce is on a semicircle, shape (N,)
    orbit: Marks  # whether the word is an orbit, or else dynamically pruned, shape (N,)


def symbol_plane(catalogue: "Catalogue", *chosen: Selection) -> Picture:
    """Draw the points of orbits and of dynamically pruned words, and the pruning front, in both planes.

    If there are several a, only their fronts are drawn. The planes are side by side, or one below the other
    in a figure that is higher than wide.

    Raises
    ------
    EmptyFigureError
        If no word is chosen.
    InputError
        If more than `MOST_WORDS` are chosen, if no chosen word has points, or for words at several a.
    """
    if len(chosen) > 1:
        return _fronts(chosen)
    statuses = tuple(status for status in _WITH_POINTS if status in (chosen[0].statuses or _WITH_POINTS))
    if not statuses:
        raise InputError("only orbits and dynamically pruned words have points: `status='orbit,dynamical'`")
    shown = replace(chosen[0], statuses=statuses)
    if (total := catalogue.count(shown)) > MOST_WORDS:
        raise InputError(f"{total} words: draw at most {MOST_WORDS}, such as `p='2-12'`")
    if not total:
        raise nothing(catalogue, shown)
    front, points = PruningFront(shown.a), _points(catalogue.select(shown))
    with figure(*_size(), shown.describe(), [*gaps(catalogue, shown), *front.notes]) as made:
        for ax, each in zip(_two_planes(made), (front.walls, front.semicircles), strict=True):
            draw_plane(ax, each)
            draw_points(ax, each, Points(*(part[points.curved == each.curved] for part in points)))
    return _settled(made)


def _points(subset: Subset) -> Points:
    """Return the bounces of orbits and of dynamically pruned words."""
    parts = []
    for p in np.unique(subset.p).tolist():
        rows = np.flatnonzero(subset.p == p)
        words = from_strings(subset.code[rows].tolist())
        orbit = np.repeat(subset.status[rows] == Status.ORBIT.value, p)
        parts.append(Points(points_of(words).reshape(-1, 2), (PIECE[words] % 2 == 1).ravel(), orbit))
    return Points(*map(np.concatenate, zip(*parts, strict=True)))


def _fronts(chosen: Sequence[Selection]) -> Picture:
    """Draw the fronts of several stadiums in both planes."""
    if any(replace(each, statuses=()) != Selection(each.a) for each in chosen):
        raise InputError("several a show the fronts alone: leave out the options that choose words")
    title = f"pruning fronts at a = {', '.join(format_float(each.a) for each in chosen)}"
    fronts = [PruningFront(each.a) for each in chosen]
    notes = dict.fromkeys(note for front in fronts for note in front.notes)
    with figure(*_size(), title, notes) as made:
        first, second = _two_planes(made)
        for front, colour in zip(fronts, cycle(INKS.values()), strict=False):
            label = f"$a = {format_float(front.stadium.a)}$"
            _draw_front(first, front.walls, colour, label)
            _draw_front(second, front.semicircles, colour, label)
        for ax, curved in ((first, False), (second, True)):
            _draw_frame(ax, curved)
    return _settled(made)


def _size() -> tuple[float, float]:
    """Return the width and height of a figure, in inches."""
    wide = width_or(_SIZE[0])
    return (wide, _STACKED * wide) if wide < NARROW else _SIZE


def _two_planes(made: Figure) -> list[Axes]:
    wide, high = made.get_size_inches()
    made.set_layout_engine("compressed", wspace=_BETWEEN)  # the planes are square
    return list(made.subplots(1, 2) if wide >= high else made.subplots(2, 1))


def _settled(made: Picture) -> Picture:
    """Repeat the layout, which at first leaves too little room for the title and the legend of squares."""
    for _ in range(_LAYOUTS):
        made.draw_without_rendering()
    return made


def draw_plane(ax: Axes, front: Front) -> None:
    """Draw a plane with its two fronts, shaded where they forbid points."""
    _draw_frame(ax, front.curved)
    for corner, curve in ((1, _steps(front)), (0, 1 - _steps(front))):
        ax.fill(*np.concatenate([curve, [[corner, corner]]]).T, color=_FORBIDDEN, linewidth=0, zorder=0.5)
    _draw_front(ax, front, INK, "pruning front")


def draw_points(ax: Axes, front: Front, points: Points) -> None:
    """Draw points as an image, whose cells are smaller the more points there are.

    A point of a pruned word beyond a front covers one of an orbit, and this one a point inside the fronts.
    """
    gamma, delta = points.plane.T
    inside = front.below(gamma, delta) & front.below(1 - gamma, 1 - delta)
    size = int(np.clip(_FINENESS * len(gamma) ** 0.5, *_CELLS))
    column, row = (np.minimum((values * size).astype(np.intp), size - 1) for values in (gamma, delta))
    image = np.zeros((size, size, 4))
    for chosen, colour, label in (
        (~points.orbit & inside, _INSIDE, "pruned, inside"),
        (points.orbit, BLUE, "orbits"),
        (~points.orbit & ~inside, ORANGE, "pruned, beyond"),
    ):
        if chosen.any():
            image[row[chosen], column[chosen]] = to_rgba(colour)
            ax.plot([], [], "s", markersize=4, color=colour, label=label)
    ax.imshow(image, extent=(0, 1, 0, 1), origin="lower", interpolation="none", zorder=2)


def _draw_frame(ax: Axes, curved: bool) -> None:
    """Draw the axes with the names of the next and the previous bounce, and the squares of the rules.

    On small axes the bounces have only their symbols, and the squares no names.
    """
    count, (side, name) = len(_NEXT[curved]), _RULES[curved]
    extent = ax.get_window_extent()
    small = min(extent.width, extent.height) < _SMALLEST * ax.figure.dpi
    middles = (np.arange(count) + 0.5) / count
    for corner, middle in ((0, middles[0]), (1 - side, middles[-1])):
        ax.add_patch(Rectangle((corner, corner), side, side, color=_RULED_OUT, linewidth=0, zorder=0.6))
        if not small:
            ax.text(middle, middle, name, ha="center", va="center", color=GREY, fontsize=SMALL, zorder=3)
    following, before = (
        [each.rpartition("\n")[-1] if small else each for each in names[curved]] for names in (_NEXT, _BEFORE)
    )
    ax.set_xticks(middles, following)
    ax.set_yticks(middles, before, rotation=90, va="center", multialignment="center")
    size = max(SMALL, 0.85 * rcParams["font.size"])
    ax.tick_params(length=0, labelsize=size)
    ax.grid(False)
    for border in np.arange(1, count) / count:
        ax.axhline(border, color=GREY, linewidth=0.4, zorder=0.7)
        ax.axvline(border, color=GREY, linewidth=0.4, zorder=0.7)
    ax.spines[["top", "right"]].set_visible(True)
    ax.set(xlim=(0, 1), ylim=(0, 1), aspect="equal")
    future, past, bounce = ("", "", "") if small else (" (future)", " (past)", " bounce")
    ax.set_xlabel(rf"$\gamma${future}: next{bounce}", fontsize="medium")
    ax.set_ylabel(rf"$\delta${past}: previous{bounce}", fontsize="medium")
    ax.set_title((_SHORT_TITLES if small else _TITLES)[curved], fontsize=size)


def _draw_front(ax: Axes, front: Front, colour: str, label: str) -> None:
    curve = _steps(front)
    ax.plot(*curve.T, color=colour, linewidth=1, label=label, zorder=4, clip_on=False)
    ax.plot(*(1 - curve).T, color=colour, linewidth=1, zorder=4, clip_on=False)


def _steps(front: Front) -> Floats:
    """Return the upper front as a staircase from the upper to the right edge of the plane, shape (M, 2).

    A front that jumps, as that of the walls does at the right angle, runs along the points that it forbids.
    """
    points = np.round(np.stack([front.gamma, front.delta], axis=1) / _STEP) * _STEP
    kept = np.concatenate([[True], (points[1:] != points[:-1]).any(axis=1)])
    gamma, delta = points[kept].T
    return np.stack([np.append(np.repeat(gamma, 2), 1.0), np.insert(np.repeat(delta, 2), 0, 1.0)], axis=1)
