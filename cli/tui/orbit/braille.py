"""Draw with braille dots: from points in the plane to character cells, independent of the terminal.

A cell holds 2 x 4 dots, which are square if a cell is twice as high as wide, as in nearly all fonts.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats

Dots = NDArray[np.int64]

DOTS_X, DOTS_Y = 2, 4
_BLANK = 0x2800
_BITS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])


@dataclass(frozen=True)
class Frame:
    """A window on the plane around a centre, and its cells; the scale is in dots per unit."""

    columns: int
    rows: int
    scale: tuple[float, float]
    centre: tuple[float, float]

    @classmethod
    def around(
        cls, low: tuple[float, float], high: tuple[float, float], columns: int, rows: int, square: bool = True
    ) -> "Frame":
        """Return the frame that holds a box of the plane, with one scale for x and y if it is square."""
        spans = [max(end - start, 1e-300) for start, end in zip(low, high, strict=True)]
        x, y = (DOTS_X * columns - 1) / spans[0], (DOTS_Y * rows - 1) / spans[1]
        scale = (min(x, y), min(x, y)) if square else (x, y)
        return cls(columns, rows, scale, ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2))

    def dots(self, points: Floats) -> Dots:
        """Return the dots, shape (N, 2), counted from the upper left corner, of points, shape (N, 2)."""
        middle = np.array([DOTS_X * self.columns - 1, DOTS_Y * self.rows - 1]) / 2
        placed = middle + (points - self.centre) * (self.scale[0], -self.scale[1])
        far = 4 * max(DOTS_X * self.columns, DOTS_Y * self.rows)
        dots: Dots = np.rint(np.clip(placed, -far, far)).astype(np.int64)
        return dots


def polyline(frame: Frame, points: Floats) -> Dots:
    """Return the dots of the straight pieces between successive points, shape (N, 2)."""
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
    """Dots of one style."""

    style: str
    dots: Dots


class Mark(NamedTuple):
    """One character, in the cell of a dot."""

    style: str
    dot: tuple[int, int]
    text: str


class Picture(NamedTuple):
    """Characters and the name of each one's style ('' for none), both of shape (rows, columns)."""

    text: NDArray[np.str_]
    styles: NDArray[np.object_]

    def runs(self, row: int) -> list[tuple[str, str]]:
        """Return a row as (text, style) pairs, with neighbours of one style joined."""
        cells = zip(self.text[row], self.styles[row], strict=True)
        return [("".join(text for text, _ in run), style) for style, run in groupby(cells, itemgetter(1))]


def draw(frame: Frame, layers: Iterable[Layer], marks: Iterable[Mark] = ()) -> Picture:
    """Draw layers of dots, and characters over them; a cell has the style of its last layer.

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
