"""Pictures made of braille dots and characters, and curves against the period.

A character cell contains 2 x 4 dots. Their grid is square if a cell is twice as high as it is wide, which is
so in nearly all fonts.
"""

import math
from collections.abc import Iterable, Sequence
from itertools import groupby
from operator import itemgetter
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from rich.style import Style
from rich.text import Text
from textual.reactive import reactive
from textual.widget import Widget

from orbitdb.arrays import Floats

Dots = NDArray[np.int64]
Pair = tuple[float, float]
Line = list[tuple[str, str]]
"""A line of a picture as pairs of a text and the name of its style, '' for none."""

DOTS = 2, 4
_BLANK = 0x2800
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])


class Canvas:
    """A picture of columns x rows cells that shows a box of the plane, from `low` to `high`.

    If `square`, the scale, in dots per unit, is the same in x and y. The box leaves a margin of columns and
    rows free on each side. A cell takes the style of what is drawn in it last; characters are on top of dots.
    What lies outside is left out.
    """

    def __init__(
        self,
        columns: int,
        rows: int,
        low: ArrayLike,
        high: ArrayLike,
        square: bool = True,
        margin: tuple[int, int] = (0, 0),
    ) -> None:
        low, high = np.asarray(low, float), np.asarray(high, float)
        self.columns, self.rows = columns, rows
        self._size = np.array([DOTS[0] * columns, DOTS[1] * rows])
        inner = np.maximum(self._size - 2 * np.multiply(DOTS, margin), 2)
        scale = (inner - 1) / np.maximum(high - low, 1e-300)
        self.scale = np.full(2, scale.min()) if square else scale
        self._centre = (low + high) / 2
        self._codes = np.zeros((rows, columns), np.int64)
        self._styles = np.full((rows, columns), "", dtype=object)
        self._signs: list[tuple[str, int, int, str]] = []

    def dots(self, points: ArrayLike) -> Dots:
        """Return the dots at the given points, both of shape (N, 2), counted from the upper left corner."""
        placed = (self._size - 1) / 2 + (np.asarray(points) - self._centre) * (self.scale * (1, -1))
        far = 4 * self._size.max()
        dots: Dots = np.rint(np.clip(placed, -far, far)).astype(np.int64)
        return dots

    def _inside(self, dots: Dots) -> Dots:
        return dots[((dots >= 0) & (dots < self._size)).all(axis=1)]

    def put(self, style: str, dots: Dots) -> None:
        x, y = self._inside(dots).T
        cells = y // DOTS[1], x // DOTS[0]
        np.bitwise_or.at(self._codes, cells, _BITS[y % DOTS[1], x % DOTS[0]])
        self._styles[cells] = style

    def line(self, style: str, points: Floats) -> None:
        """Draw the line segments that join successive points, shape (N, 2)."""
        self.put(style, joined(self.dots(points)))

    def mark(self, style: str, points: ArrayLike, sign: str) -> None:
        """Draw a character in the cell of each point, shape (N, 2)."""
        for x, y in self._inside(self.dots(points)).tolist():
            self._signs.append((style, y // DOTS[1], x // DOTS[0], sign))

    def label(self, style: str, point: Pair, outward: Pair, sign: str) -> None:
        """Draw a character beside the cell of a point, or one cell further on if another one is there."""
        [[x, y]], (right, up) = self.dots([point]) // DOTS, np.asarray(outward) * (DOTS[1], -DOTS[0])
        step = np.rint(np.array([right, up]) / max(abs(right), abs(up))).astype(int)
        for far in (1, 2):
            column, row = (np.array([x, y]) + far * step).tolist()
            taken = {other for _, *place, other in self._signs if place == [row, column]}
            if taken <= {sign} and 0 <= column < self.columns and 0 <= row < self.rows:
                self._signs.append((style, row, column, sign))
                return

    def lines(self) -> list[Line]:
        """Return the picture, with neighbouring cells of the same style joined."""
        codes = np.where(self._codes > 0, self._codes + _BLANK, ord(" "))
        text, styles = codes.astype(np.uint32).view("U1"), self._styles.copy()
        for style, row, column, sign in self._signs:
            text[row, column], styles[row, column] = sign, style
        rows = (zip(*cells, strict=True) for cells in zip(text, styles, strict=True))
        return [
            [("".join(sign for sign, _ in run), style) for style, run in groupby(row, itemgetter(1))]
            for row in rows
        ]


def joined(ends: Dots) -> Dots:
    """Return the dots, shape (K, 2), of the line segments that join successive dots, shape (N, 2)."""
    if len(ends) < 2:
        return ends
    steps = np.diff(ends, axis=0)
    counts = np.abs(steps).max(axis=1) + 1
    piece = np.repeat(np.arange(len(steps)), counts)
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    share = place / np.maximum(counts - 1, 1)[piece]
    dots: Dots = np.rint(ends[piece] + steps[piece] * share[:, None]).astype(np.int64)
    return dots


_LEAST = 4, 3
"""Least columns and rows of a picture."""


class PictureWidget(Widget):
    """A widget whose content is a picture; its styles are component classes ``picture--NAME``."""

    COMPONENT_CLASSES: ClassVar[set[str]] = {
        f"picture--{name}"
        for name in ("wall", "path", "bounce", "start", "arrow", "trail", "particle", "label",
                     "grid", "one", "two", "three", "four", "five", "six")
    }  # fmt: skip

    def picture(self, columns: int, rows: int) -> list[Line]:
        raise NotImplementedError

    def render(self) -> Text:
        """Return the picture as text, or an empty text if there is no room for it."""
        if self.size.width < _LEAST[0] or self.size.height < _LEAST[1]:
            return Text()
        lines = self.picture(*self.size)
        return Text("\n").join(
            Text.assemble(*((text, self._style(name)) for text, name in line)) for line in lines
        )

    def _style(self, name: str) -> Style:
        return self.get_component_rich_style(f"picture--{name}") if name else Style.null()


class Curve(NamedTuple):
    """Values against the period. Each point is drawn as `marker`; if that is empty, a line joins the points.

    The legend leaves out curves without a name.
    """

    style: str
    name: str
    x: Floats
    y: Floats
    marker: str = ""


_MARGIN = 8
"""Columns of the axis on the left."""
_ROWS_PER_TICK = 4
_ROUNDING = 1e-12
"""Relative difference up to which values count as equal."""


def draw_curves(curves: Sequence[Curve], columns: int, rows: int) -> list[Line]:
    """Draw curves, with an axis on the left, and the periods and a legend below; nothing without room.

    The later half of the periods sets the range, so that one can see whether the curves converge. Points
    outside it become arrows at the edge.
    """
    drawn = [np.stack([curve.x, curve.y], axis=1)[np.isfinite(curve.y)] for curve in curves]
    points = np.concatenate([np.zeros((0, 2)), *drawn])
    legend = _folded([(f" {c.marker or '─'} {c.name} ", c.style) for c in curves if c.name], columns)
    height = rows - 1 - len(legend)
    if not len(points) or columns < _MARGIN + 8 or height < 3:
        return []
    first, last = float(points[:, 0].min()), float(points[:, 0].max())
    later = points[points[:, 0] >= (first + last) / 2, 1]
    low, high, last = float(later.min()), float(later.max()), max(last, first + 1)
    pad = 0.05 * (high - low) if high - low > _ROUNDING * max(abs(low), abs(high)) else 0.5
    low, high = low - pad, high + pad
    canvas = Canvas(columns - _MARGIN, height, (first, low), (last, high), square=False)
    axis = [" " * _MARGIN] * height
    for tick in round_ticks(low, high, max(2, height // _ROWS_PER_TICK)):
        [[_, y]] = canvas.dots([[first, tick]])
        axis[y // DOTS[1]] = f"{tick:>{_MARGIN - 1}g} "
        canvas.put("grid", np.array([(x, y) for x in range(0, DOTS[0] * canvas.columns, 3 * DOTS[0])]))
    for curve, values in zip(curves, drawn, strict=True):
        for x, y in values.tolist():
            if curve.name and not low <= y <= high:
                canvas.mark(curve.style, [(x, high if y > high else low)], "↑" if y > high else "↓")
    for curve, values in zip(curves, drawn, strict=True):
        if curve.marker:
            canvas.mark(curve.style, values, curve.marker)
        else:
            canvas.line(curve.style, values)
    ticks = list("p".center(_MARGIN).ljust(columns))
    for period in range(math.ceil(first), math.floor(last) + 1):
        if last - first < columns / 4 or period % 2 == 0:
            place = _MARGIN + int(canvas.dots([[period, low]])[0, 0]) // DOTS[0] + 1
            ticks[place - len(str(period)) : place] = str(period)
    lines = [[(label, "label"), *line] for label, line in zip(axis, canvas.lines(), strict=True)]
    return [*lines, [("".join(ticks), "label")], *legend]


def round_ticks(low: float, high: float, most: int) -> list[float]:
    """Return the multiples of a round number between two values, `most` at most."""
    decade = 10.0 ** math.floor(math.log10((high - low) / most))
    steps = (factor * decade for factor in (1, 2, 5, 10, 20))
    spans = ((step, math.ceil(low / step), math.floor(high / step)) for step in steps)
    step, begin, end = next(span for span in spans if span[2] - span[1] < most)
    return [float(f"{n * step:.12g}") for n in range(begin, end + 1)]


def _folded(pieces: Iterable[tuple[str, str]], columns: int) -> list[Line]:
    """Return (text, style) pairs in as many lines of the given width as they need, at least one."""
    lines: list[Line] = [[]]
    for piece in pieces:
        if lines[-1] and sum(len(text) for text, _ in (*lines[-1], piece)) > columns:
            lines.append([])
        lines[-1].append(piece)
    return lines


class Plot(PictureWidget):
    """Curves against the period."""

    curves: reactive[Sequence[Curve]] = reactive((), always_update=True)

    def picture(self, columns: int, rows: int) -> list[Line]:
        return draw_curves(self.curves, columns, rows)
