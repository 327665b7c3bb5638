"""One window in ball arithmetic: what its letters and a alone prove of its marked junction.

The window is cut into runs and legs, its ends are pushed, and the clamped problem is written here a second
time, as `orbitdb.orbits.balls.path` does it for whole orbits; nothing of `orbitdb.entropy.windows` or
`orbitdb.entropy.clamped` enters. What is given outside, pi/2 and arctan(max(q - 1.0625, 0) / (a + 1)), are
balls.

Directions from elsewhere only say where to look. They are taken as exact numbers; one at a limit of the box,
or close to it, is replaced by the limit itself, as a ball. So the start is in the box, here that of the exact
arctangents, not of their doubles. The gradient g and the curvatures D there, in balls, give the clamped
directions to within max |g_i| / (D_i / 2), those that press against a limit left out; that is the radius they
are given. The verdict is proved if f of the marked junction, computed from these, has its sign.
"""

import re
from dataclasses import dataclass
from functools import cache

from flint import arb

from orbitdb.entropy.verdicts import Verdict

Limits = tuple[arb, arb]
Leg = tuple[int, int]
"""Walls of a leg, and the sign of its direction (0 without walls); of a cut leg, those in the window."""

_PIECES = re.compile(r"[UD]+|X|[abwv]*[AB]|[abwv]+")
_WALL = {"X": 0, "a": 1, "b": -1, "v": 1, "w": -1, "A": 1, "B": -1}
"""The wall of a leg's outer letter; with w and v, where the last letter leads."""

_NONE: Leg = (0, 0)
_WIDER = arb(17) / 16
_NEAR = 1e-12
"""As near to a limit as this, a direction begins at it: doubles tell no closer."""

_ENDLESS = 0
"""Bounces of an endless run: it stands for k = infinity."""


@cache
def _limits(leg: Leg, a: float) -> Limits:
    """Return the limits of a complete leg's direction, as exact numbers: no rounding widens the box."""
    walls, sign = leg
    if not walls:
        steep = (_WIDER / a).atan()
        return -steep, steep
    flat, steep = _flattest(walls, a), (arb(2 * (walls + 1)) / a).atan()
    return (flat, steep) if sign > 0 else (-steep, -flat)


@cache
def _flattest(walls: int, a: float) -> arb:
    """Return the least slope of a leg of so many walls or more, as an angle without its sign."""
    return ((walls - _WIDER) / (arb(a) + 1)).atan() if walls > 1 else arb(0)


@dataclass(frozen=True, slots=True)
class _Push:
    """Runs and given legs of a window whose ends are pushed."""

    k: list[int]
    d: list[int]
    left: arb
    right: arb


class BallWindow:
    """A window of runs 0 to m and, between them, the complete legs 0 to m - 1.

    Parameters
    ----------
    letters : str
        Its edges.
    mark : int
        Number of letters before the marked junction.
    a : float
        Half length of a straight wall, taken as exact.
    """

    def __init__(self, letters: str, mark: int, a: float) -> None:
        self.a = a
        self.k, self.d = [1], [1]
        self.legs: list[Leg] = []
        self.cut: list[Leg | None] = [None, None]
        self.marked = -1
        place = 0
        for piece in _PIECES.findall(letters):
            if 0 < place == mark and piece[0] in "Xab":
                self.marked = len(self.legs)
            if piece[0] in "UD":
                self.k[-1], self.d[-1] = 1 + len(piece), 1 if piece[0] == "U" else -1
            elif piece[0] not in "Xab":  # from its last wall the path goes away
                self.cut[0] = len(piece), -_WALL[piece[-1]]
            elif piece[-1] not in "XAB":
                self.cut[1] = len(piece), _WALL[piece[0]]
            else:
                self.legs.append((len(piece) - 1, _WALL[piece[0]]))
                self.k.append(1)
                self.d.append(1)
            place += len(piece)
        self.leg = [*self.legs, self.cut[1] or _NONE][self.marked]
        if self.k[self.marked] == 1 and self.leg[0]:
            self.d[self.marked] = self.leg[1]  # one bounce has no sense: its name suits the condition

    def proves(self, verdict: Verdict, start: list[float]) -> bool:
        """Tell whether a verdict, allowed or forbidden, is proved.

        Parameters
        ----------
        verdict : Verdict
        start : list of float, length m
            Directions near the clamped ones, of the corner that the verdict asks for.
        """
        if not self._has_condition():
            return False
        walls, sign = self.leg
        sense = self.d[self.marked]
        lean = -sign if walls else sense
        way = 1 if verdict is Verdict.FORBIDDEN else -1
        pushed = self._push(way * sense, way * lean)
        widened = self._enclosed(pushed, start)
        if widened is None:
            return False
        f = self._half(pushed, widened, self.marked) + lean * [*widened, pushed.right][self.marked]
        return bool(f < 0 if verdict is Verdict.FORBIDDEN else f > 0)

    def _has_condition(self) -> bool:
        """Tell whether the mark stands where a run ends of which something is known, and a leg begins."""
        return self.marked >= 0 and (self.leg[0] > 0 or self.k[self.marked] > 1)

    def _push(self, left: int, right: int) -> _Push:
        """Push the ends so that the marked direction rises (+1) or falls (-1) with each."""
        sigma = [1]
        for walls, _ in self.legs:
            sigma.append(sigma[-1] if walls % 2 else -sigma[-1])
        upright = sigma[self.marked]
        k, d, given = self.k[:], self.d[:], [arb(0), arb(0)]
        pushes = (-sigma[0] * upright * left, sigma[-1] * upright * right)
        for end, (run, push) in enumerate(zip((0, -1), pushes, strict=True)):
            leg = self.cut[end]
            if leg is not None:
                walls, sign = leg
                given[end] = sign * (arb.pi() / 2 if push * sign > 0 else _flattest(walls, self.a))
            elif self.k[run] == 1:
                k[run], d[run] = _ENDLESS, push
            elif push * d[run] > 0:
                k[run] = _ENDLESS
            else:
                given[end] = -d[run] * arb.pi() / 2
        return _Push(k, d, *given)

    def _half(self, pushed: _Push, alpha: list[arb], run: int) -> arb:
        """Return h = psi/2k of a run."""
        k = pushed.k[run]
        if k == _ENDLESS:
            return arb(0)
        incoming = pushed.left
        if run:
            incoming = -alpha[run - 1] if self.legs[run - 1][0] % 2 else alpha[run - 1]
        outgoing = alpha[run] if run < len(alpha) else pushed.right
        return (arb.pi() - pushed.d[run] * (incoming + outgoing)) / (2 * k)

    def _enclosed(self, pushed: _Push, start: list[float]) -> list[arb] | None:
        """Return balls that hold the clamped directions, or None where the bound's conditions fail.

        They start inside the box, or at its limit itself, as a ball. The bound is max |g| / F with
        F = D / 2, as in `orbitdb.orbits.error_bounds`.
        """
        if len(start) != len(self.legs):
            return None
        alpha, below, above = [], [], []
        for x, leg in zip(start, self.legs, strict=True):
            low, high = _limits(leg, self.a)
            inside = bool(low + _NEAR < x < high - _NEAR)
            down = not inside and abs(x - low) < abs(x - high)
            alpha.append(arb(x) if inside else low if down else high)
            below.append(not inside and down)
            above.append(not inside and not down)
        pull = [-d * self._half(pushed, alpha, run).cos() for run, d in enumerate(pushed.d)]
        radius = arb(0)
        for i, (walls, sign) in enumerate(self.legs):
            across, along = alpha[i].sin_cos()
            rise, base = 2 * walls * sign, 2 * arb(self.a)
            beyond = base * along + rise * across
            g = rise * along - base * across + pull[i] + (-pull[i + 1] if walls % 2 else pull[i + 1])
            if not beyond > 0:
                return None
            if not ((below[i] and g < 0) or (above[i] and g > 0)):
                radius = radius.max(2 * abs(g) / beyond)
        if not radius.is_finite():
            return None
        return [x + arb(0, radius.abs_upper()) for x in alpha]
