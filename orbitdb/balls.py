"""Ball arithmetic: orbits enclosed with proof, for what doubles cannot decide.

Every number is an interval that holds the true value (Arb, through python-flint). The formulas of
`orbitdb.legs` are written here a second time, word by word and at any precision. That an orbit exists
inside the enclosure and nowhere else follows from the bound of `orbitdb.certify`, evaluated on balls:
L is strictly concave between the direction limits, and sum of D_i delta_i^2 <= 4 sum of g_i^2 / D_i
holds for its maximum.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, ctx
from numpy.typing import NDArray

from orbitdb.legs import Legs, centre_directions, cut, direction_limits
from orbitdb.orbits import Orbits, Status
from orbitdb.stability import forces
from orbitdb.stadium import Stadium

DIGITS = 60
"""Decimal digits to which a bounce must agree with a joint to be taken to lie on it."""

_PRECISIONS = (128, 256, 512, 1024, 2048)
_MAX_STEPS = 100
_SMALL = 1e-8

Balls = list[arb]


@dataclass(frozen=True)
class Enclosure:
    """One word's orbit in balls.

    Attributes
    ----------
    status : Status
        `Status.BOUNDARY` where a slack holds 0 and is narrower than 10^-`DIGITS`.
    precision : int
        Bits of the arithmetic that decided it.
    coordinates : list of arb
        In the order of the word.
    length, lyapunov, margin : arb
        Length, lambda, and least distance from a joint in coordinate units.
    steps : int
        Newton steps taken.
    """

    status: Status
    precision: int
    coordinates: Balls
    length: arb
    lyapunov: arb
    margin: arb
    steps: int


def enclose(word: NDArray[np.uint8], stadium: Stadium) -> Enclosure:
    """Enclose the stationary point of one admissible word, with the precision that its status takes.

    Parameters
    ----------
    word : ndarray of uint8, shape (p,)
        An admissible word.
    stadium : Stadium
        Its a is taken as the exact value of the double.
    """
    ((_, legs),) = cut(word[None, :])
    start = [arb(float(x)) for x in centre_directions(legs, stadium.a)[:, 0]]
    for precision in _PRECISIONS:
        with ctx.workprec(precision):
            path = _Path(legs, arb(stadium.a), [x.mid() for x in start])
            steps = path.climb(stadium.a)
            start = path.alpha
            found = path.enclosure(precision, steps)
            if found.status is not Status.UNRESOLVED:
                break
    return found


def as_orbits(word: NDArray[np.uint8], stadium: Stadium, found: Enclosure) -> Orbits:
    """Return an enclosure rounded to doubles, the rounding counted in its error bounds."""
    places = [_rounded(x) for x in found.coordinates]
    coordinates = np.array([[value for value, _ in places]])
    length, length_error = _rounded(found.length)
    exponent, exponent_error = _rounded(found.lyapunov)
    return Orbits(
        words=word[None, :],
        status=np.array([found.status.value]),
        coordinates=coordinates,
        length=np.array([length]),
        lyapunov=np.array([exponent]),
        margin=np.array([_rounded(found.margin)[0]]),
        residual=np.abs(forces(stadium, word[None, :], coordinates)).max(axis=1),
        error=np.array([max(error for _, error in places)]),
        length_error=np.array([length_error]),
        lyapunov_error=np.array([exponent_error]),
        iterations=np.array([found.steps]),
    )


def _rounded(x: arb) -> tuple[float, float]:
    value = float(x.mid())
    return value, float((x - value).abs_upper()) * (1 + 2**-50)


def _clip(x: arb, low: float, high: float) -> arb:
    return arb(low) if x < low else arb(high) if x > high else x


class _Path:
    """The unfolded path of one word, its directions in balls."""

    def __init__(self, legs: Legs, a: arb, alpha: Balls) -> None:
        self.legs = legs
        self.a = a
        self.alpha = alpha
        self.k, self.d, self.n, self.s = (
            [int(x) for x in part[:, 0]] for part in (legs.k, legs.d, legs.n, legs.s)
        )
        self.parity = [(-1) ** n for n in self.n]
        self.m = len(self.k)

    def evaluate(self) -> None:
        """Compute the turns, the gradient and the curvatures at the present directions."""
        self.arriving = [g * x for g, x in zip(self.parity, self.alpha, strict=True)]
        pi = arb.pi()
        turned = [
            (pi - d * (self.arriving[i - 1] + self.alpha[i])) / (2 * k)
            for i, (d, k) in enumerate(zip(self.d, self.k, strict=True))
        ]
        self.half = turned
        pull = [-d * h.cos() for d, h in zip(self.d, turned, strict=True)]
        self.stiffness = [h.sin() / (2 * k) for h, k in zip(turned, self.k, strict=True)]
        self.beyond, self.gradient = [], []
        for i, x in enumerate(self.alpha):
            across, along = x.sin_cos()
            lift, base = 2 * self.n[i] * self.s[i], 2 * self.a
            self.beyond.append(base * along + lift * across)
            ahead = self.parity[i] * pull[(i + 1) % self.m]
            self.gradient.append(lift * along - base * across + pull[i] + ahead)

    def climb(self, a: float) -> int:
        """Move the directions to the maximum by Newton's method between their limits.

        A step that does not lengthen the path is halved until it does: with the concavity of L this
        brings every word to its maximum, those outside the stadium included.
        """
        low, high = self.limits = [limit[:, 0].tolist() for limit in direction_limits(self.legs, a)]
        target = arb(2) ** (16 - ctx.prec)
        self.evaluate()
        steps = 0
        while steps < _MAX_STEPS:
            steps += 1
            origin, best = self.alpha, self.length().mid()
            change = self.newton_step(low, high)
            size = max(abs(dx).mid() for dx in change)
            while True:
                self.alpha = [
                    _clip((x + dx).mid(), lo, hi)
                    for x, dx, lo, hi in zip(origin, change, low, high, strict=True)
                ]
                self.evaluate()
                if size < _SMALL or self.length().mid() > best:
                    break
                change = [dx / 2 for dx in change]
                size /= 2
            if max(abs(x - y).mid() for x, y in zip(self.alpha, origin, strict=True)) < target:
                break
        self.press(low, high)
        return steps

    def press(self, low: Sequence[float], high: Sequence[float]) -> None:
        """Note which directions stand at a limit that the gradient pushes against."""
        self.pressed = [
            bool((x <= lo and g < 0) or (x >= hi and g > 0))
            for x, g, lo, hi in zip(self.alpha, self.gradient, low, high, strict=True)
        ]

    def newton_step(self, low: Sequence[float], high: Sequence[float]) -> Balls:
        """Solve the cyclic tridiagonal system for the step; pressed directions stay."""
        self.press(low, high)
        m, w, zero = self.m, self.stiffness, arb(0)
        diagonal = [(self.beyond[i] + w[i] + w[(i + 1) % m]).mid() for i in range(m)]
        beside = [
            zero if self.pressed[i] or self.pressed[i - 1] else (w[i] * self.parity[i - 1]).mid()
            for i in range(m)
        ]
        g = [zero if p else x.mid() for x, p in zip(self.gradient, self.pressed, strict=True)]
        column = [zero] * (m - 1)
        column[0] += beside[0]
        column[-1] += beside[-1]
        plain, through = g[:-1], column[:]
        pivots = diagonal[:-1]
        for i in range(1, m - 1):
            factor = beside[i] / pivots[i - 1]
            pivots[i] -= factor * beside[i]
            plain[i] -= factor * plain[i - 1]
            through[i] -= factor * through[i - 1]
        for i in range(m - 2, -1, -1):
            if i < m - 2:
                plain[i] -= beside[i + 1] * plain[i + 1]
                through[i] -= beside[i + 1] * through[i + 1]
            plain[i] /= pivots[i]
            through[i] /= pivots[i]
        top = g[-1] - sum((c * x for c, x in zip(column, plain, strict=True)), zero)
        bottom = diagonal[-1] - sum((c * x for c, x in zip(column, through, strict=True)), zero)
        last = top / bottom
        return [x - y * last for x, y in zip(plain, through, strict=True)] + [last]

    def widen(self) -> None:
        """Give the directions the radius inside which the maximum is proved to lie."""
        self.evaluate()
        total = arb(0)
        for g, beyond, pressed in zip(self.gradient, self.beyond, self.pressed, strict=True):
            total += arb(0) if pressed else g.abs_upper() ** 2 / beyond
        size = 2 * total.sqrt()
        self.alpha = [
            x + arb(0, (size / beyond.sqrt()).abs_upper())
            for x, beyond in zip(self.alpha, self.beyond, strict=True)
        ]
        self.evaluate()

    def ends(self) -> tuple[Balls, Balls]:
        """Return the angles of the first and the last bounce of each run."""
        first, last = [], []
        for i in range(self.m):
            middle = (self.arriving[i - 1] - self.alpha[i]) / 2
            spread = self.d[i] * (self.k[i] - 1) * self.half[i]
            first.append(middle - spread)
            last.append(middle + spread)
        return first, last

    def slacks(self) -> tuple[Balls, Balls]:
        """Return the slacks in radians and the same in coordinate units."""
        first, last = self.ends()
        half_pi = arb.pi() / 2
        slack = [half_pi - abs(t) for t in first + last]
        distance = slack[:]
        for i, (n, s, x) in enumerate(zip(self.n, self.s, self.alpha, strict=True)):
            if n:
                ahead = -s * self.parity[i] * first[(i + 1) % self.m]
                for t in (s * last[i], ahead):
                    slack.append(half_pi - t - 2 * s * x)
                    width = 2 * (half_pi / 2 + t / 2).cos() / (s * x).sin()
                    distance.append(width * (slack[-1] / 2).sin())
        return slack, distance

    def coordinates(self) -> Balls:
        """Return the coordinates of all bounces, in the order of the word."""
        first, last = self.ends()
        legs, found = self.legs, []
        for run, place, straight in zip(legs.run[:, 0], legs.place[:, 0], legs.straight[:, 0], strict=True):
            if not straight:
                found.append(first[run] + self.d[run] * 2 * int(place) * self.half[run])
                continue
            after = first[(run + 1) % self.m]
            start_y = last[run].sin()
            dy = self.parity[run] * after.sin() + 2 * self.n[run] * self.s[run] - start_y
            dx = 2 * self.a + last[run].cos() + after.cos()
            height = self.s[run] * (2 * int(place) + 1) - start_y
            x = height * dx / dy - last[run].cos() - self.a
            found.append(x if run % 2 == 0 else -x)
        return found

    def length(self) -> arb:
        """Return L at the directions."""
        total = arb(0)
        for i, x in enumerate(self.alpha):
            total += 2 * self.a * x.cos() + 2 * self.n[i] * self.s[i] * x.sin()
            total += 4 * self.k[i] ** 2 * self.stiffness[i]
        return total

    def exponent(self) -> arb:
        """Return lambda from the product of drifts and kicks."""
        p = [arb(1), arb(0), arb(0), arb(1)]
        for drift, stiffness in zip(self.beyond, self.stiffness, strict=True):
            p[0], p[2] = p[0] + p[1] / stiffness, p[2] + p[3] / stiffness
            p[1], p[3] = p[0] * drift + p[1], p[2] * drift + p[3]
        half_trace = (p[0] + p[3]) / 2
        return (half_trace + ((half_trace - 1) * (half_trace + 1)).sqrt()).log()

    def enclosure(self, precision: int, steps: int) -> Enclosure:
        """Prove what can be proved at the present directions."""
        self.widen()
        slack, distance = self.slacks()
        width = max(x.rad() for x in slack)
        if any(x < 0 for x in slack):
            status = Status.DYNAMICAL
        elif not all(lo < x < hi for x, lo, hi in zip(self.alpha, *self.limits, strict=True)):
            status = Status.UNRESOLVED
        elif all(x > 0 for x in slack):
            status = Status.ORBIT
        elif width < arb(10) ** -DIGITS:
            status = Status.BOUNDARY
        else:
            status = Status.UNRESOLVED
        margin = distance[0]
        for x in distance[1:]:
            margin = margin.min(x)
        return Enclosure(status, precision, self.coordinates(), self.length(), self.exponent(), margin, steps)
