"""An orbit followed as the half length changes: where the next step leads, and a bar of where it exists."""

import math
from collections.abc import Sequence

from orbitdb.billiard.stadium import MAX_A, MIN_A

Lives = Sequence[tuple[float, float | None]]

STEP = 0.02
"""Of ln a, at a key."""
_BESIDE = 1e-9
_SAME = 1e-12
"""Steps up and down again end so near to where they began."""
_LEAST, _MOST = 0.05, 20.0
"""The ends of the bar."""
_ALIVE, _DEAD, _HERE = "━", "·", "┃"


def next_a(lives: Lives, a: float, up: bool, home: float | None = None) -> float:
    """Return the a that follows in steps of `STEP`; a birth or death in between is a stop on both sides.

    So an orbit is seen with its last margin before it is gone. Nor is ``home`` passed over.
    """
    new = _next_of(lives, a, up)
    way = 1 if up else -1
    if home is not None and way * (home - a) > 0 and way * (new - home) > -_SAME * home:
        return home
    return new


def _next_of(lives: Lives, a: float, up: bool) -> float:
    way = 1 if up else -1
    new = min(max(a * math.exp(way * STEP), MIN_A), MAX_A)
    ends = sorted((end for life in lives for end in life if end), reverse=not up)
    for end in ends:
        near, far = end * (1 - way * _BESIDE), end * (1 + way * _BESIDE)
        if way * (far - a) > 0 and way * (new - end) > 0:
            return near if way * (near - a) > 0 else far
    return new


def told(lives: Lives, before: float, after: float) -> str | None:
    """Say what happened to an orbit between two values of a; None if nothing did."""
    low, high = sorted((before, after))
    for born, dies in lives:
        for end, begins in ((born, True), (dies, False)):
            if end and low < end < high:
                verb = "born" if begins is (after > before) else "gone"
                return f"{verb} at a = {end:.12g}"
    return None


def bar(lives: Lives, a: float, width: int) -> str:
    """Return a bar over ln a, from 0.05 to 20, that shows where an orbit exists, and a."""
    scale = math.log(_MOST / _LEAST)
    places = [_LEAST * math.exp(scale * (i + 0.5) / width) for i in range(width)]
    drawn = [_ALIVE if _lives_at(lives, place) else _DEAD for place in places]
    here = int(width * math.log(a / _LEAST) / scale)
    if 0 <= here < width:
        drawn[here] = _HERE
    return "".join(drawn)


def _lives_at(lives: Lives, a: float) -> bool:
    return any(born < a and (dies is None or a < dies) for born, dies in lives)
