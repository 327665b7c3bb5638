"""Pictures made of braille dots: an orbit in its stadium, bounces in phase space, curves against the period.

A character cell contains 2 x 4 dots. Their grid is square if a cell is twice as high as it is wide, which is
so in nearly all fonts.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbit import Orbit

Dots = NDArray[np.int64]

DOTS_X, DOTS_Y = 2, 4
_BLANK = 0x2800
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])


@dataclass(frozen=True)
class Frame:
    """A window on the plane, made of columns x rows cells around a centre; the scale is in dots per unit."""

    columns: int
    rows: int
    scale: tuple[float, float]
    centre: tuple[float, float]

    @classmethod
    def around(
        cls, low: tuple[float, float], high: tuple[float, float], columns: int, rows: int, square: bool = True
    ) -> "Frame":
        """Return the frame that contains a box of the plane, with the same scale in x and y if `square`."""
        spans = [max(end - start, 1e-300) for start, end in zip(low, high, strict=True)]
        x, y = (DOTS_X * columns - 1) / spans[0], (DOTS_Y * rows - 1) / spans[1]
        scale = (min(x, y), min(x, y)) if square else (x, y)
        return cls(columns, rows, scale, ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2))

    def dots(self, points: Floats) -> Dots:
        """Return the dots at the given points, both of shape (N, 2), counted from the upper left corner."""
        middle = np.array([DOTS_X * self.columns - 1, DOTS_Y * self.rows - 1]) / 2
        placed = middle + (points - self.centre) * (self.scale[0], -self.scale[1])
        far = 4 * max(DOTS_X * self.columns, DOTS_Y * self.rows)
        dots: Dots = np.rint(np.clip(placed, -far, far)).astype(np.int64)
        return dots


def polyline(frame: Frame, points: Floats) -> Dots:
    """Return the dots, shape (K, 2), of the line segments that join successive points, shape (N, 2)."""
    ends = frame.dots(points)
    if len(ends) < 2:
        return ends
    steps = np.diff(ends, axis=0)
    counts = np.abs(steps).max(axis=1) + 1
    piece = np.repeat(np.arange(len(steps)), counts)
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    share = place / np.maximum(counts - 1, 1)[piece]
    dots: Dots = np.rint(ends[piece] + steps[piece] * share[:, None]).astype(np.int64)
    return dots


class Layer(NamedTuple):
    """Dots that are drawn in the same style."""

    style: str
    dots: Dots


class Mark(NamedTuple):
    """A character, drawn in the cell that contains a dot."""

    style: str
    dot: tuple[int, int]
    text: str


class Picture(NamedTuple):
    """Characters and the names of their styles ('' for none), both of shape (rows, columns)."""

    text: NDArray[np.str_]
    styles: NDArray[np.object_]

    def runs(self, row: int) -> list[tuple[str, str]]:
        """Return a row as (text, style) pairs, with neighbouring cells of the same style joined."""
        cells = zip(self.text[row], self.styles[row], strict=True)
        return [("".join(text for text, _ in run), style) for style, run in groupby(cells, itemgetter(1))]


def draw(frame: Frame, layers: Iterable[Layer], marks: Iterable[Mark] = ()) -> Picture:
    """Draw layers of dots with characters on top; each cell takes the style of the last layer drawn in it.

    Dots and marks outside the frame are left out.
    """
    codes = np.zeros((frame.rows, frame.columns), dtype=np.int64)
    styles = np.full((frame.rows, frame.columns), "", dtype=object)
    for layer in layers:
        x, y = layer.dots[_inside(frame, layer.dots)].T
        np.bitwise_or.at(codes, (y // DOTS_Y, x // DOTS_X), _BITS[y % DOTS_Y, x % DOTS_X])
        styles[y // DOTS_Y, x // DOTS_X] = layer.style
    text = np.where(codes > 0, codes + _BLANK, ord(" ")).astype(np.uint32).view("U1")
    for mark in marks:
        if _inside(frame, np.array([mark.dot]))[0]:
            cell = mark.dot[1] // DOTS_Y, mark.dot[0] // DOTS_X
            text[cell], styles[cell] = mark.text, mark.style
    return Picture(text, styles)


def _inside(frame: Frame, dots: Dots) -> NDArray[np.bool_]:
    size = (DOTS_X * frame.columns, DOTS_Y * frame.rows)
    return np.asarray(((dots >= 0) & (dots < size)).all(axis=1))


MOST_DRAWN = 5000
"""Maximum number of bounces to draw; more would only blacken the picture."""

COLOURS = ("one", "two", "three", "four", "five", "six")
"""Styles of curves, in order."""

_ARROWS = "→↗↑↖←↙↓↘"
_DOTS_OF_HEIGHT = 12
_TRAIL = 0.06


def path_of(orbit: Orbit | None) -> Floats:
    """Return the closed path of an orbit, shape (p + 1, 2), whose last point repeats the first.

    A path of more than `MOST_DRAWN` bounces is cut there and left open. Without coordinates, it is empty.
    """
    if orbit is None or orbit.points is None:
        return np.zeros((0, 2))
    points = orbit.points[:MOST_DRAWN]
    return np.concatenate([points, points[:1]]) if orbit.p <= MOST_DRAWN else points


def along(path: Floats, share: float) -> Floats:
    """Return the point, shape (2,), at a fraction of the length of a path; the fraction is taken modulo 1."""
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    place = (share % 1.0) * way[-1]
    return np.array([np.interp(place, way, path[:, axis]) for axis in (0, 1)])


def draw_orbit(
    a: float, path: Floats, columns: int, rows: int, particle: float | None = None
) -> tuple[Picture, bool]:
    """Draw a path, shape (N, 2), in its stadium; return the picture and whether it is to scale.

    If the stadium is so long that it would look like a line, its height is stretched. An empty path gives the
    stadium alone. `particle` is the position of a particle, as a fraction of the path.
    """
    stadium = Stadium(a)
    frame = Frame.around((-a - 1, -1), (a + 1, 1), columns, rows)
    true = 2 * frame.scale[1] >= min(_DOTS_OF_HEIGHT, DOTS_Y * rows - 1)
    if not true:
        frame = Frame.around((-a - 1, -1), (a + 1, 1), columns, rows, square=False)
    layers = [Layer("wall", polyline(frame, stadium.outline(4 * (columns + rows))))]
    marks = []
    if len(path):
        layers.append(Layer("path", polyline(frame, path)))
        step = path[1] - path[0]  # the path runs in the direction of the word
        arrow = _ARROWS[round(math.atan2(step[1], step[0]) / (math.pi / 4)) % 8]
        marks = _marks(frame, "bounce", path, "•") + _marks(frame, "arrow", [path[0] + 0.4 * step], arrow)
        marks += _marks(frame, "start", path[:1], "◆")
    if particle is not None and len(path):
        tail = np.array([along(path, particle - _TRAIL * k / 24) for k in range(25)])
        layers.append(Layer("trail", polyline(frame, tail)))
        marks += _marks(frame, "particle", tail[:1], "●")
    return draw(frame, layers, marks), true


def _marks(frame: Frame, style: str, points: ArrayLike, text: str) -> list[Mark]:
    return [Mark(style, (x, y), text) for x, y in frame.dots(np.asarray(points)).tolist()]


def phase_points(orbit: Orbit | None) -> Floats:
    """Return the bounces of an orbit in phase space, shape (p, 2): arclength and sine, as in `birkhoff`."""
    if orbit is None or orbit.arclength is None or orbit.sine is None:
        return np.zeros((0, 2))
    return np.stack([orbit.arclength, orbit.sine], axis=1)


def draw_phase(a: float, points: Floats, columns: int, rows: int) -> Picture:
    """Draw the `phase_points` of an orbit, with the names of the walls below."""
    stadium = Stadium(a)
    length = stadium.perimeter
    frame = Frame.around((0, -1), (length, 1), columns, max(rows - 1, 1), square=False)
    joints = [0.0, 2 * a, 2 * a + math.pi, 4 * a + math.pi, length]
    high = np.linspace(-1, 1, 2 * rows)
    grid = [np.stack([np.full_like(high, s), high], axis=1) for s in joints]
    middle = np.linspace(0, length, columns // 2)
    grid.append(np.stack([middle, np.zeros_like(middle)], axis=1))
    layers = [Layer("wall", frame.dots(np.concatenate(grid)))]
    picture = draw(frame, layers, _marks(frame, COLOURS[0], points, "●"))
    return _with_row(picture, (_wall_names(frame, joints), "label"))


def _wall_names(frame: Frame, joints: Sequence[float]) -> str:
    """Return a line of text with the name of each wall below its part of the axis."""
    line = [" "] * frame.columns
    for name, (low, high) in zip(("0 bottom", "3 right", "2 top", "1 left"), pairwise(joints), strict=True):
        middle = int(frame.dots(np.array([[(low + high) / 2, 0.0]]))[0, 0]) // DOTS_X
        width = int((high - low) * frame.scale[0] / DOTS_X)
        text = name if len(name) <= width else name[: min(1, width)]
        start = middle - len(text) // 2
        line[start : start + len(text)] = text
    return "".join(line[: frame.columns])


def _with_row(picture: Picture, *pieces: tuple[str, str]) -> Picture:
    """Add a row made of (text, style) pairs, cut or padded to the width of the picture."""
    columns = picture.text.shape[1]
    signs = [(sign, style) for text, style in pieces for sign in text] + [(" ", "")] * columns
    text = np.array([[sign for sign, _ in signs[:columns]]])
    styles = np.array([[style for _, style in signs[:columns]]], dtype=object)
    return Picture(np.concatenate([picture.text, text]), np.concatenate([picture.styles, styles]))


class Curve(NamedTuple):
    """Values against the period. Each point is drawn as `marker`; if that is empty, a line joins the points.

    The legend leaves out curves without a name.
    """

    style: str
    name: str
    x: Floats
    y: Floats
    marker: str = ""


def draw_curves(curves: Sequence[Curve], columns: int, rows: int) -> Picture:
    """Draw curves, with an axis on the left, and the periods and a legend below."""
    drawn = [np.stack([curve.x, curve.y], axis=1)[np.isfinite(curve.y)] for curve in curves]
    every, margin = np.concatenate([np.zeros((0, 2)), *drawn]), 7
    legend = _folded([(f" {c.marker or '─'} {c.name} ", c.style) for c in curves if c.name], columns)
    below = 1 + len(legend)
    if not len(every) or columns < margin + 8 or rows < below + 3:
        return Picture(np.full((rows, columns), " "), np.full((rows, columns), "", dtype=object))
    (first, low), (last, high) = every.min(axis=0).tolist(), every.max(axis=0).tolist()
    pad = 0.05 * (high - low) or 0.5
    low, high, last = low - pad, high + pad, max(last, first + 1)
    frame = Frame.around((first, low), (last, high), columns - margin, rows - below, square=False)
    layers, marks = [], []
    for curve, points in zip(curves, drawn, strict=True):
        if curve.marker:
            marks += _marks(frame, curve.style, points, curve.marker)
        else:
            layers.append(Layer(curve.style, polyline(frame, points)))
    plot = draw(frame, layers, marks)
    axis = np.full((rows - below, margin), " ")
    for share in (0.0, 0.5, 1.0):
        label = f"{high - share * (high - low):>z{margin - 1}.3f}"
        axis[round(share * (rows - below - 1))] = list(label[: margin - 1] + "┤")
    text = np.concatenate([axis, plot.text], axis=1)
    styles = np.concatenate([np.full(axis.shape, "label", dtype=object), plot.styles], axis=1)
    ticks = list("p".center(margin).ljust(columns))
    for period in range(math.ceil(first), math.floor(last) + 1):
        if last - first < columns / 4 or period % 2 == 0:
            place = margin + int(frame.dots(np.array([[period, low]]))[0, 0]) // DOTS_X + 1
            ticks[place - len(str(period)) : place] = str(period)
    picture = _with_row(Picture(text, styles), ("".join(ticks), "label"))
    for line in legend:
        picture = _with_row(picture, *line)
    return picture


def _folded(pieces: Iterable[tuple[str, str]], columns: int) -> list[list[tuple[str, str]]]:
    """Return (text, style) pairs in as many lines of the given width as they need, at least one."""
    lines: list[list[tuple[str, str]]] = [[]]
    for piece in pieces:
        if lines[-1] and sum(len(text) for text, _ in (*lines[-1], piece)) > columns:
            lines.append([])
        lines[-1].append(piece)
    return lines
