"""The algebraic tails of survival, in closed form.

Survival of n bounces, from the invariant measure of the bounces, tends to c1/n + c2/n^2, and survival of a
time t, from the Liouville measure, to d1/t. The first term comes from trajectories near bouncing balls, the
second one from runs along a semicircle. The constants are derived, and checked against trajectories, but not
proved.

Near a bouncing ball, a trajectory drifts with a small slope towards an end of its gap between openings. At an
open end it escapes. At a joint, it comes back with v times the slope, where v is uniformly distributed in
(1/3, 3): by a single reflection near one joint, with E[1/v] = ln 3 / 4, or by one at each joint, in either
order with ln 3 / 8. For one opening in a wall, c1 is the constant of Dettmann and Georgiou (Physica D 238,
2395, 2009).
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

from orbitdb.billiard.stadium import HALF_PI, Stadium
from orbitdb.open_stadium.openings import Opening, Span, rest, spans_on
from orbitdb.open_stadium.patterns import Patterns

_SINGLE, _DOUBLE = math.log(3) / 4, math.log(3) / 8

_WAYS_BACK = {
    "left": (
        ("010", _SINGLE, "top"),
        ("212", _SINGLE, "bottom"),
        ("2110", _DOUBLE, "both"),
        ("0442", _DOUBLE, "both"),
    ),
    "right": (
        ("030", _SINGLE, "top"),
        ("232", _SINGLE, "bottom"),
        ("2330", _DOUBLE, "both"),
        ("0552", _DOUBLE, "both"),
    ),
}
"""The ways back from each end of the walls: symbols, E[1/v], and the joints that they need."""

_HITS = {"0": "02", "2": "20"}
"""The walls that alternate before a bounce on a wall."""


class Tails(NamedTuple):
    """What never escapes, and the tails of survival that it causes.

    Attributes
    ----------
    gaps : tuple of (float, float)
        The x between which bouncing balls are left, in ascending order.
    returns : (float, float)
        The sum of E[1/v] over the ways back that are left, at the left and at the right end of the walls.
    c1, c2, d1 : float
        The constants of c1/n + c2/n^2 and of d1/t.
    uncut : bool
        Whether bouncing balls drift all the way from one semicircle to the other.
    """

    gaps: tuple[Span, ...]
    returns: tuple[float, float]
    c1: float
    c2: float
    d1: float
    uncut: bool

    @property
    def continuum(self) -> float:
        """Share of the trajectories near bouncing balls that each leg leaves, if the family is not cut."""
        return math.sqrt(self.returns[0] * self.returns[1])


def tails(stadium: Stadium, openings: Iterable[Opening], patterns: Patterns | None = None) -> Tails:
    """Return the tails of survival in a stadium with openings, without patterns of symbols.

    Raises
    ------
    OpeningError
        If an opening does not fit on the boundary, or nothing is left of it.

    Examples
    --------
    >>> from orbitdb.open_stadium.openings import parse_openings
    >>> left = tails(Stadium(1.6), parse_openings("top:-0.3:0.3"))
    >>> left.gaps, round(left.c1, 5), round(left.d1, 5)
    (((-1.6, -0.3), (0.3, 1.6)), 0.24304, 0.41133)
    """
    a, perimeter = stadium.a, stadium.perimeter
    spans = spans_on(stadium, openings)
    cut = patterns is not None and patterns.forbid("02", "", "02")
    gaps = [] if cut else rest(sorted(spans["top"] + spans["bottom"]), a)
    left, right = (_returns(side, spans[side], patterns) for side in ("left", "right"))
    c1 = 0.0
    for low, high in gaps:
        r, s = left * (low == -a), right * (high == a)
        c1 += (high - low) ** 2 * (1 + r) * (1 + s) / (1 - r * s) / (2 * perimeter)
    d1 = 4 * perimeter * c1 / (math.pi * stadium.area)
    c2 = sum(_runs(side, spans[side], patterns) for side in ("left", "right")) / (48 * perimeter)
    return Tails(tuple(gaps), (left, right), c1, c2, d1, gaps == [(-a, a)])


def _returns(side: str, spans: list[Span], patterns: Patterns | None) -> float:
    """Return the sum of E[1/v] over the ways back from one end of the walls."""
    open_joints = {"top" if end > 0 else "bottom" for span in spans for end in span if abs(end) == HALF_PI}
    return sum(
        weight
        for symbols, weight, joint in _WAYS_BACK[side]
        if not (open_joints if joint == "both" else open_joints & {joint})
        and (patterns is None or not patterns.forbid(_HITS[symbols[0]], symbols, _HITS[symbols[-1]][::-1]))
    )


def _runs(side: str, spans: list[Span], patterns: Patterns | None) -> float:
    """Return the sum of psi^3 over the free arcs psi of a semicircle and the senses that are left."""
    senses = "14" if side == "left" else "35"
    left = sum(patterns is None or not patterns.forbid(symbol, "", symbol) for symbol in senses)
    return left * sum((high - low) ** 3 for low, high in rest(spans, HALF_PI))
