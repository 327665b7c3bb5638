"""Openings of the boundary: how they are written, and what they leave of each wall and semicircle."""

import math
import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import HALF_PI, Stadium
from orbitdb.errors import InputError
from orbitdb.symbols.symmetry import MIRROR_X, MIRROR_Y, REVERSE
from orbitdb.text import format_float

WALLS = ("top", "bottom", "left", "right")
"""The parts of the boundary; the coordinate is x on the first two, the angle on the other two."""

_FORM = (
    "write WALL:LOW:HIGH, such as top:-0.3:0.3, or top::0.3 from the end of the wall on, with WALL one of "
    "top, bottom (x), left, right (angle)"
)
_TEXT = re.compile(r"\s*(\w+)\s*:\s*([^:\s]*)\s*:\s*([^:\s]*)\s*")

_ROUNDED = 5e-6
"""Ends this close to the end of a wall or semicircle lie there: 1.5708 is pi/2."""

Span = tuple[float, float]
"""The least and the greatest coordinate of an interval."""


class OpeningError(InputError):
    """An opening cannot be read, or does not fit on the boundary; the message says how to write it."""


class Opening(NamedTuple):
    """An interval of the boundary through which trajectories escape.

    Attributes
    ----------
    wall : str
        ``top`` or ``bottom``, or ``left`` or ``right`` for a semicircle.
    low, high : float
        Its ends, as x on a straight wall, or as the angle from the outward horizontal on a semicircle
        (radians); -inf and inf are the ends of the wall itself.
    """

    wall: str
    low: float
    high: float

    @classmethod
    def parse(cls, text: Any) -> "Opening":
        """Read an opening such as ``top:-0.3:0.3``; without LOW or HIGH, it extends to the end of the wall.

        Raises
        ------
        OpeningError
            If the text has another form, or the interval is empty or reversed.
        """
        found = _TEXT.fullmatch(text) if isinstance(text, str) else None
        if found is None or found[1] not in WALLS:
            raise OpeningError(f"opening {text!r:.40}: {_FORM}")
        try:
            low = float(found[2]) if found[2] else -math.inf
            high = float(found[3]) if found[3] else math.inf
        except ValueError:
            raise OpeningError(f"opening {text!r:.40}: {_FORM}") from None
        if not low < high:
            what = "is empty" if low == high else "is reversed" if low > high else "has no numbers"
            raise OpeningError(f"opening {text!r:.40} {what}: LOW must be less than HIGH")
        return cls(found[1], low, high)

    def __str__(self) -> str:
        ends = ("" if math.isinf(end) else format_float(end) for end in (self.low, self.high))
        return ":".join((self.wall, *ends))


def parse_openings(texts: Any) -> tuple[Opening, ...]:
    """Read one opening or several, as texts or as `Opening`, and sort them; each is kept once."""
    each: Any = (texts,) if isinstance(texts, str | Opening) else texts
    if not isinstance(each, Iterable):
        raise OpeningError(f"opening {texts!r:.40}: {_FORM}")
    read = {one if isinstance(one, Opening) else Opening.parse(one) for one in each}
    return tuple(sorted(read, key=lambda one: (WALLS.index(one.wall), one.low, one.high)))


def spans_on(stadium: Stadium, openings: Iterable[Opening]) -> dict[str, list[Span]]:
    """Return the open intervals of each part of the boundary, in ascending order, joined where they overlap.

    Raises
    ------
    OpeningError
        If an opening goes beyond its wall or semicircle, or if nothing of the boundary is left.
    """
    spans: dict[str, list[Span]] = {wall: [] for wall in WALLS}
    for opening in sorted(openings, key=lambda one: one.low):
        low, high = _fitted(stadium, opening)
        own = spans[opening.wall]
        if own and low <= own[-1][1]:
            low, high = own[-1][0], max(high, own.pop()[1])
        own.append((low, high))
    if sum(map(_width, spans.values())) >= stadium.perimeter * (1 - _ROUNDED):
        raise OpeningError("all of the boundary is open: leave a part of it closed")
    return spans


def end_of(stadium: Stadium, wall: str) -> float:
    """Return the greatest coordinate on a part of the boundary; the least one is its negative."""
    return stadium.a if wall in ("top", "bottom") else HALF_PI


def _fitted(stadium: Stadium, opening: Opening) -> Span:
    """Return the ends of an opening; raise `OpeningError` if it goes beyond its wall or semicircle."""
    end = end_of(stadium, opening.wall)
    ends = [min(max(value, -end), end) if math.isinf(value) else value for value in opening[1:]]
    ends = [math.copysign(end, value) if abs(abs(value) - end) <= _ROUNDED * end else value for value in ends]
    if any(abs(value) > end for value in ends) or not ends[0] < ends[1]:
        name = (
            f"wall, where x is from {-end:.6g} to {end:.6g}"
            if end == stadium.a and opening.wall in ("top", "bottom")
            else f"semicircle, where angles are from {-end:.6f} to {end:.6f}"
        )
        raise OpeningError(f"opening {opening} goes beyond its {name} at a = {format_float(stadium.a)}")
    return ends[0], ends[1]


def _width(spans: Iterable[Span]) -> float:
    return sum(high - low for low, high in spans)


def measure(stadium: Stadium, openings: Iterable[Opening]) -> float:
    """Return the share of the perimeter that is open, mu."""
    return sum(map(_width, spans_on(stadium, openings).values())) / stadium.perimeter


_WALL_OF = {"0": "bottom", "2": "top", "1": "left", "4": "left", "3": "right", "5": "right"}
_MIRRORED = {MIRROR_X: {"left": "right", "right": "left"}, MIRROR_Y: {"top": "bottom", "bottom": "top"}}


def elements_through(word: str, coordinates: Iterable[float], openings: Iterable[Opening]) -> int:
    """Return the elements (bits) that lead from an orbit to images with a bounce in an opening.

    Instead of the orbit, the openings are mirrored. Time reversal leaves the bounces where they are.
    """
    bounces = [(_WALL_OF[symbol], place) for symbol, place in zip(word, coordinates, strict=True)]
    found, images = 0, {0: [*openings]}
    for mirror in (MIRROR_X, MIRROR_Y):
        images |= {held | mirror: [_mirrored(mirror, one) for one in own] for held, own in images.items()}
    for element, spans in images.items():
        if any(low <= place <= high for wall, low, high in spans for at, place in bounces if at == wall):
            found |= 1 << element | 1 << (element | REVERSE)
    return found


def _mirrored(mirror: int, opening: Opening) -> Opening:
    """Return the image of an opening under one of the two mirrors."""
    wall, low, high = opening
    walls = _MIRRORED[mirror]
    return Opening(walls[wall], low, high) if wall in walls else Opening(wall, -high, -low)


SYMBOL_OF = {"bottom": 0, "right": 3, "top": 2, "left": 1}
"""The symbol of a single bounce on each part of the boundary."""

_STEPS = 64


def outline_parts(stadium: Stadium, openings: Iterable[Opening], steps: int = _STEPS) -> list[Floats]:
    """Return the boundary as paths with gaps at the openings, each semicircle or wall with some steps."""
    openings = tuple(openings)
    if not openings:
        return [stadium.outline(steps)]
    spans, parts = spans_on(stadium, openings), []
    for wall, symbol in SYMBOL_OF.items():
        for low, high in rest(spans[wall], end_of(stadium, wall)):
            coordinates = np.linspace(low, high, steps)
            parts.append(stadium.points(np.full(steps, symbol, np.uint8), coordinates))
    return parts


def rest(spans: Iterable[Span], end: float) -> list[Span]:
    """Return what intervals, ascending and disjoint, leave of the interval from -end to end."""
    left, low = [], -end
    for start, stop in spans:
        if start > low:
            left.append((low, start))
        low = max(low, stop)
    return [*left, (low, end)] if low < end else left
