"""The unfolded path of a single word in ball arithmetic.

Every number is an interval that contains the true value (Arb, through python-flint). The formulas are those
of `orbitdb.billiard.legs`, for one word at any precision.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from flint import arb, ctx

from orbitdb.billiard.legs import Chain, Legs
from orbitdb.billiard.stability import solve_cyclic
from orbitdb.billiard.stadium import SIDE, STRAIGHT

Balls = list[arb]

_MAX_STEPS = 100
_SMALL = 1e-8


class Condition(NamedTuple):
    """A slack pi/2 - sign t - 2 tilt alpha, where t is the angle at one end of a run."""

    run: int
    end: int  # the end of the run: -1 for its first bounce, +1 for its last
    sign: int  # +1 or -1
    leg: int = 0
    tilt: int = 0  # +1 or -1, the first wall of the leg; 0 for a bounce on the semicircle


def _largest(change: Balls) -> arb:
    return max(abs(x).mid() for x in change)


class BallPath:
    """The unfolded path of one word of a batch; its directions are balls.

    Parameters
    ----------
    legs : Chain
        Words cut into runs and legs; runs may be infinitely long.
    column : int
        The index of the word.
    a : float
        The half length, taken as exact.
    limits : sequence of (float, float)
        Lower and upper limit of each direction (`orbitdb.billiard.legs.direction_limits`).
    """

    def __init__(self, legs: Chain, column: int, a: float, limits: Sequence[tuple[float, float]]) -> None:
        self.column, self.a = column, arb(a)
        self.limits = limits
        self.k, self.d, self.n, self.s, self.parity = (
            [int(x) if x < math.inf else x for x in part[:, column].tolist()]
            for part in (legs.k, legs.d, legs.n, legs.s, legs.parity)
        )
        self.m = len(self.k)

    def arriving(self, run: int) -> arb:
        """Return the direction, at its end, of the leg before a run."""
        return self.alpha[run - 1] if self.parity[run - 1] > 0 else -self.alpha[run - 1]

    def half_turn(self, run: int) -> arb:
        """Return psi / 2k of the given run."""
        turned = self.arriving(run) + self.alpha[run]
        return (arb.pi() - turned if self.d[run] > 0 else arb.pi() + turned) / (2 * self.k[run])

    def go_to(self, alpha: Balls) -> None:
        """Set the directions, and compute the half turns, the gradient and the curvatures there."""
        self.alpha, base = alpha, 2 * self.a
        self.half, pull, self.stiffness = [], [], []
        for run, (d, k) in enumerate(zip(self.d, self.k, strict=True)):
            half = self.half_turn(run)
            sin, cos = half.sin_cos()
            self.half.append(half)
            self.stiffness.append(sin / (2 * k))
            pull.append(-cos if d > 0 else cos)
        pull.append(pull[0])
        self.between_centres, self.gradient = [], []
        for i, x in enumerate(alpha):
            across, along = x.sin_cos()
            beyond, lean = base * along, -base * across
            if self.n[i]:
                lift = 2 * self.n[i] * self.s[i]
                beyond += lift * across
                lean += lift * along
            self.between_centres.append(beyond)
            self.gradient.append(lean + pull[i] + (pull[i + 1] if self.parity[i] > 0 else -pull[i + 1]))

    def climb(self) -> int:
        """Move the directions to the maximum by Newton's method, within the limits; return the steps taken.

        A long step that does not lengthen the path is halved until it does. Because L is concave, every word
        then reaches its maximum, even outside the stadium. The iteration stops after a step that changes only
        the last half of the digits, because the next step would be only rounding.
        """
        target = arb(2) ** (8 - ctx.prec // 2)
        steps = 0
        while steps < _MAX_STEPS:
            steps += 1
            origin, change = self.alpha, self.newton_step()
            best = None if _largest(change) < _SMALL else self.length().mid()
            self.go_to(self.between_limits(origin, change))
            while best is not None and _largest(change) > _SMALL and not self.length().mid() > best:
                change = [dx / 2 for dx in change]
                self.go_to(self.between_limits(origin, change))
            if _largest([x - y for x, y in zip(self.alpha, origin, strict=True)]) < target:
                break
        return steps

    def between_limits(self, origin: Balls, change: Balls) -> Balls:
        """Return the midpoints of origin + change, kept between the limits."""
        moved = [(x + dx).mid() for x, dx in zip(origin, change, strict=True)]
        return [
            x if low < x < high else arb(low) if x <= low else arb(high)
            for x, (low, high) in zip(moved, self.limits, strict=True)
        ]

    def pressed(self) -> list[bool]:
        """Tell which directions are at a limit and surely pushed against it by the gradient."""
        return [
            bool((x <= low and g < 0) or (x >= high and g > 0))
            for x, g, (low, high) in zip(self.alpha, self.gradient, self.limits, strict=True)
        ]

    def newton_step(self) -> Balls:
        """Solve the cyclic tridiagonal system for Newton's step; pressed directions do not move."""
        m, w, pressed = self.m, self.stiffness, self.pressed()
        held = [pressed[i] or pressed[i - 1] for i in range(m)]
        rows = [
            [(self.between_centres[i] + w[i] + w[(i + 1) % m]).mid() for i in range(m)],
            [arb(0) if held[i] else (w[i] * self.parity[i - 1]).mid() for i in range(m)],
            [arb(0) if p else x.mid() for x, p in zip(self.gradient, pressed, strict=True)],
        ]
        diagonal, beside, gradient = np.array(rows, dtype=object)[:, :, None]
        return solve_cyclic(diagonal, beside, gradient[None])[0, :, 0].tolist()

    def widen(self) -> None:
        """Widen the directions to balls that are proved to contain the maximum."""
        total = arb(0)
        for g, beyond, pressed in zip(self.gradient, self.between_centres, self.pressed(), strict=True):
            total += arb(0) if pressed else g.abs_upper() ** 2 / beyond
        size = 2 * total.sqrt()
        self.go_to([
            x + arb(0, (size / beyond.sqrt()).abs_upper())
            for x, beyond in zip(self.alpha, self.between_centres, strict=True)
        ])  # fmt: skip

    def ends(self) -> tuple[Balls, Balls]:
        """Return the angles of the first and the last bounce of each run."""
        first, last = [], []
        for i in range(self.m):
            middle = (self.arriving(i) - self.alpha[i]) / 2
            spread = self.d[i] * (self.k[i] - 1) * self.half[i]
            first.append(middle - spread)
            last.append(middle + spread)
        return first, last

    def conditions(self) -> list[Condition]:
        """Return the conditions that each end of a run or leg is on its semicircle or wall."""
        every = [Condition(i, end, sign) for i in range(self.m) for end in (-1, 1) for sign in (-1, 1)]
        for i, (n, s, parity) in enumerate(zip(self.n, self.s, self.parity, strict=True)):
            if n:
                every.append(Condition(i, 1, s, i, s))
                every.append(Condition((i + 1) % self.m, -1, -s * parity, i, s))
        return every

    def slacks(self, conditions: Sequence[Condition]) -> tuple[Balls, Balls]:
        """Return the slacks of the conditions, in radians and in coordinate units."""
        first, last = self.ends()
        half_pi, slack, distance = arb.pi() / 2, [], []
        for condition in conditions:
            t = (last if condition.end > 0 else first)[condition.run]
            t = t if condition.sign > 0 else -t
            if not condition.tilt:
                slack.append(half_pi - t)
                distance.append(slack[-1])
                continue
            x = condition.tilt * self.alpha[condition.leg]
            slack.append(half_pi - t - 2 * x)
            width = 2 * (half_pi / 2 + t / 2).cos() / x.sin()
            distance.append(width * (slack[-1] / 2).sin())
        return slack, distance

    def coordinates(self, legs: Legs) -> Balls:
        """Return the coordinates of all bounces in the order of the word.

        `legs` must have the word in the same column.
        """
        first, last = self.ends()
        turned = [2 * d * half for d, half in zip(self.d, self.half, strict=True)]
        on_walls = [self._on_walls(i, first, last) if n else (arb(0), arb(0)) for i, n in enumerate(self.n)]
        coordinates = []
        bounces = (part[:, self.column].tolist() for part in legs.bounces)
        for run, place, straight in zip(*bounces, strict=True):
            start, step = on_walls[run] if straight else (first[run], turned[run])
            coordinates.append(start + place * step if place else start)
        return coordinates

    def area(self, symbols: Sequence[int], coordinates: Balls) -> arb:
        """Return the area that the path encloses, given its word and the coordinates of all bounces.

        The path is a polygon, so the area is half the sum of the cross products of successive bounces.
        """
        corners = []
        for symbol, place in zip(symbols, coordinates, strict=True):
            if STRAIGHT[symbol]:
                corners.append((place, arb(symbol - 1)))
            else:
                sin, cos = place.sin_cos()
                corners.append((int(SIDE[symbol]) * (self.a + cos), sin))
        total = arb(0)
        for (x, y), (x_next, y_next) in zip(corners, [*corners[1:], corners[0]], strict=True):
            total += x * y_next - x_next * y
        return total / 2

    def _on_walls(self, leg: int, first: Balls, last: Balls) -> tuple[arb, arb]:
        """Return the coordinate of the first wall bounce of a leg, and the step from each to the next."""
        start_y, start_x = last[leg].sin_cos()
        end_y, end_x = first[(leg + 1) % self.m].sin_cos()
        lean = (2 * self.a + start_x + end_x) / (
            self.parity[leg] * end_y + 2 * self.n[leg] * self.s[leg] - start_y
        )
        x = (self.s[leg] - start_y) * lean - start_x - self.a
        step = 2 * self.s[leg] * lean
        return (x, step) if leg % 2 == 0 else (-x, -step)

    def length(self) -> arb:
        """Return the length L at the directions."""
        total = arb(0)
        for k, beyond, stiffness in zip(self.k, self.between_centres, self.stiffness, strict=True):
            total += beyond + 4 * k**2 * stiffness
        return total

    def exponent(self) -> arb:
        """Return lambda, from the product of drifts and kicks."""
        p = [arb(1), arb(0), arb(0), arb(1)]
        for drift, stiffness in zip(self.between_centres, self.stiffness, strict=True):
            p[0], p[2] = p[0] + p[1] / stiffness, p[2] + p[3] / stiffness
            p[1], p[3] = p[0] * drift + p[1], p[2] * drift + p[3]
        half_trace = (p[0] + p[3]) / 2
        return (half_trace + ((half_trace - 1) * (half_trace + 1)).sqrt()).log()
