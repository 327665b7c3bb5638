"""Enclose orbits in ball arithmetic, with proof, if doubles cannot decide a word (docs/proof.md).

If a ball does not separate a slack from zero, the precision is increased until the slack is smaller than it
can be for any orbit that shadows one through a joint. Then `joins` may prove that it is zero. Otherwise the
word stays unresolved.

No ball can show that a number is zero. For that, balls suggest a field Q(gamma), where gamma is a real root
of a polynomial f, and elements of this field for the cosine and sine of every leg direction and half turn.
Identities between these are then checked modulo f; balls only tell an angle from its shifts by pi.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from flint import arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz_mat

from orbitdb.arrays import Floats, Words
from orbitdb.billiard.arithmetic import ball_precision
from orbitdb.billiard.legs import Legs, centre_directions, cut, direction_limits
from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.ball_path import BallPath, Balls, Condition
from orbitdb.orbits.error_bounds import enclosed_areas
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.status import Status

PRECISION, MAX_PRECISION = 128, 16384
"""Initial and maximum number of bits of the arithmetic."""

_DOUBLE = 53
"""Precision, in bits, of the distance between a ball and a double."""

_ENOUGH = 1024
"""A word stays unresolved after this many bits in addition to those that lambda requires."""
_BITS_IN_MEMORY = 1 << 27
"""Limit on the number of legs times bits, which keeps the memory to about half a gigabyte."""
_CLOSE = 32
"""A proof that a slack is zero is tried if the slack is this many bits below e^-lambda."""


@dataclass(frozen=True)
class Enclosure:
    """The stationary point of a word, enclosed in balls, with the status of the word."""

    status: Status  # `Status.BOUNDARY` if some slacks are proved to be 0 and the others positive
    precision: int  # number of bits of the arithmetic that decided it
    coordinates: Balls  # in the order of the word
    length: arb
    lyapunov: arb  # lambda
    area: arb  # enclosed area, anticlockwise positive
    margin: arb  # least distance from a joint, in coordinate units
    steps: int  # number of Newton steps taken


def enclose(word: Words, stadium: Stadium, precision: int = PRECISION) -> Enclosure:
    """Enclose the stationary point of one admissible word, shape (p,), as `enclose_all` does."""
    ((_, legs),) = cut(word[None, :])
    (enclosure,) = enclose_all(legs, stadium, precision=precision)
    return enclosure


def enclose_all(
    legs: Legs, stadium: Stadium, start: Floats | None = None, precision: int = PRECISION
) -> Iterator[Enclosure]:
    """Enclose the stationary points of N words, in order, with the precision that their status needs.

    Parameters
    ----------
    stadium : Stadium
        Its half length is taken as exactly the value of the double.
    start : ndarray, shape (m, N), optional
        Directions near the maxima, such as those from `orbitdb.orbits.newton.newton`; they only save time.
    precision : int, optional
        Initial number of bits. It is doubled, up to `MAX_PRECISION`, until the status is decided or lambda
        shows that more bits will not help.
    """
    low, high = (limit.T.tolist() for limit in direction_limits(legs, stadium.a))
    if start is None:
        start = centre_directions(legs, stadium.a)
    for column, directions in enumerate(start.T.tolist()):
        between = list(zip(low[column], high[column], strict=True))
        path = BallPath(legs, column, stadium.a, between)
        yield _enclosed(path, legs, [arb(x) for x in directions], precision)


def _enclosed(path: BallPath, legs: Legs, start: Balls, precision: int) -> Enclosure:
    conditions = path.conditions()
    while True:
        with ball_precision(precision):
            path.go_to(start)
            steps = path.climb()
            start = path.alpha
            path.widen()
            slack, distance = path.slacks(conditions)
            status = _status(path, conditions, slack)
            if status is not Status.UNRESOLVED or 2 * precision > _most_bits(path):
                margin, coordinates = reduce(arb.min, distance), path.coordinates(legs)
                area = path.area(legs.words[:, path.column].tolist(), coordinates)
                return Enclosure(
                    status, precision, coordinates, path.length(), path.exponent(), area, margin, steps
                )
        precision *= 2


def _status(path: BallPath, conditions: list[Condition], slack: Balls) -> Status:
    """Return the status that is proved by the slacks at the enclosed maximum."""
    if any(x < 0 for x in slack):
        return Status.DYNAMICAL
    if not all(low < x < high for x, (low, high) in zip(path.alpha, path.limits, strict=True)):
        return Status.UNRESOLVED
    touching = [(condition, x) for condition, x in zip(conditions, slack, strict=True) if not x > 0]
    if not touching:
        return Status.ORBIT
    close = arb(2) ** -_CLOSE * (-path.exponent()).exp()
    if all(abs(x) < close for _, x in touching) and joins(path, touching):
        return Status.BOUNDARY
    return Status.UNRESOLVED


def _most_bits(path: BallPath) -> int:
    """Return the bits after which a word stays unresolved: more for larger lambda, fewer for more legs."""
    hope = path.exponent().abs_upper() / arb.const_log2()
    bits = _ENOUGH + float(hope) if hope.is_finite() else MAX_PRECISION
    return int(max(min(bits, MAX_PRECISION, _BITS_IN_MEMORY / path.m), 2 * PRECISION))


def true_errors(orbits: Orbits, enclosures: Sequence[Enclosure]) -> Floats:
    """Return the true errors of N orbits, given their enclosures, shape (5, N).

    These are the largest error of a coordinate, and the errors of the length, of lambda, of the area and of
    the margin: the largest distance of a number from any point of its ball, rounded up.
    """
    pairs = zip(enclosures, orbits.coordinates.tolist(), strict=True)
    errors = [[max(map(distance, enclosure.coordinates, row)) for enclosure, row in pairs]]
    for name in ("length", "lyapunov", "area", "margin"):
        balls = (getattr(enclosure, name) for enclosure in enclosures)
        errors.append(list(map(distance, balls, getattr(orbits, name).tolist())))
    return np.array(errors)


def distance(ball: arb, value: float) -> float:
    """Return the largest distance of a number from any point of a ball, rounded up."""
    with ball_precision(_DOUBLE):
        return math.nextafter(float((ball - value).abs_upper()), math.inf)


def as_orbits(words: Words, stadium: Stadium, enclosures: Sequence[Enclosure]) -> Orbits:
    """Return N >= 1 enclosures as orbits rounded to doubles; their error bounds include the rounding."""
    coordinates, errors = _rounded([enclosure.coordinates for enclosure in enclosures])
    length, length_error = _rounded([[enclosure.length] for enclosure in enclosures])
    lyapunov, lyapunov_error = _rounded([[enclosure.lyapunov] for enclosure in enclosures])
    status = np.array([enclosure.status.value for enclosure in enclosures])
    error = errors.max(axis=1)
    area, area_error = enclosed_areas(stadium, words, coordinates, error)
    return Orbits(
        words=words,
        status=status,
        coordinates=coordinates,
        length=length[:, 0],
        lyapunov=lyapunov[:, 0],
        margin=np.where(status == Status.BOUNDARY.value, 0.0, [float(ball.margin) for ball in enclosures]),
        residual=np.abs(forces(stadium, words, coordinates)).max(axis=1),
        error=error,
        length_error=length_error[:, 0],
        lyapunov_error=lyapunov_error[:, 0],
        area=area,
        area_error=area_error,
        iterations=np.array([enclosure.steps for enclosure in enclosures]),
    )


def _rounded(rows: Sequence[Balls]) -> tuple[Floats, Floats]:
    """Return the midpoints of balls as doubles, and their largest distances from any point of the balls."""
    values = [[float(x) for x in row] for row in rows]
    errors = [list(map(distance, *pair)) for pair in zip(rows, values, strict=True)]
    return np.array(values), np.array(errors)


_DEGREES = (1, 2, 3, 4, 6, 8)
_SPARE = 24
"""Number of bits by which the coefficients of a relation must be shorter than the numbers."""

_ALIKE = 20
"""Number of digits that two numbers must share to be considered equal."""
_GENERATORS = 16

Turn = tuple[fmpq_poly, fmpq_poly]
"""Cosine and sine of an angle, as elements of the field."""

_ZERO = fmpq_poly([])
_HALF_TURN: Turn = fmpq_poly([-1]), _ZERO


@dataclass(frozen=True)
class NumberField:
    """The field of rational numbers extended by a real number gamma."""

    f: fmpq_poly  # a polynomial with the root gamma, which need not be irreducible
    gamma: arb  # a ball in which f changes its sign

    def ball(self, x: fmpq_poly) -> arb:
        """Return a ball that contains the given element."""
        return arb_poly(x)(self.gamma)

    def angle(self, x: Turn) -> arb:
        """Return a ball that contains the given angle, in (-pi, pi]."""
        return arb.atan2(self.ball(x[1]), self.ball(x[0]))

    def sum(self, x: Turn, y: Turn) -> Turn:
        """Return the sum of two angles."""
        return (x[0] * y[0] - x[1] * y[1]) % self.f, (x[0] * y[1] + x[1] * y[0]) % self.f

    def times(self, n: int, x: Turn) -> Turn:
        """Return n times an angle."""
        total, step = (fmpq_poly([1]), fmpq_poly([])), x if n >= 0 else (x[0], -x[1])
        for bit in f"{abs(n):b}":
            total = self.sum(total, total)
            if bit == "1":
                total = self.sum(total, step)
        return total


@dataclass(frozen=True)
class ExactPath:
    """A path with exact angles, as suggested by the enclosed path of the same word."""

    path: BallPath  # the enclosed path, with the word, the stadium and the limits
    field: NumberField
    alpha: list[Turn]  # directions of the legs
    half: list[Turn]  # half turns of the runs

    def arriving(self, run: int) -> Turn:
        """Return the direction, at its end, of the leg before a run."""
        return self.field.times(self.path.parity[run - 1], self.alpha[run - 1])

    def is_maximum(self) -> bool:
        """Tell whether the angles are proved to belong to the maximum of the length."""
        one, f, limits = fmpq_poly([1]), self.field.f, self.path.limits
        circle = all((cos * cos + sin * sin - one) % f == _ZERO for cos, sin in self.alpha + self.half)
        inside = all(
            low < self.field.angle(x) < high for x, (low, high) in zip(self.alpha, limits, strict=True)
        )
        legs = range(self.path.m)
        return circle and inside and all(self._turns(i) and self._is_level(i) for i in legs)

    def _turns(self, i: int) -> bool:
        """Tell whether 2 k half equals pi - d (in + out), given that both are in (0, 2 pi)."""
        path, field = self.path, self.field
        both = field.sum(self.arriving(i), self.alpha[i])
        turned = field.sum(field.times(2 * path.k[i], self.half[i]), field.times(path.d[i], both))
        slope = path.parity[i - 1] * field.angle(self.alpha[i - 1]) + field.angle(self.alpha[i])
        excess = 2 * path.k[i] * field.angle(self.half[i]) + path.d[i] * slope - arb.pi()
        return turned == _HALF_TURN and bool(abs(excess) < 1)

    def _is_level(self, i: int) -> bool:
        """Tell whether the derivative of the length with respect to direction i is zero."""
        path, (cos, sin), after = self.path, self.alpha[i], (i + 1) % self.path.m
        a = fmpq(*float(path.a).as_integer_ratio())
        pull, next_pull = (-path.d[run] * self.half[run][0] for run in (i, after))
        slope = 2 * path.n[i] * path.s[i] * cos - 2 * a * sin + pull + path.parity[i] * next_pull
        return bool(slope % self.field.f == _ZERO)

    def is_zero(self, condition: Condition, slack: arb) -> bool:
        """Tell whether a slack, enclosed by the given ball, is proved to be zero at the maximum."""
        path, field, run = self.path, self.field, condition.run
        middle = field.sum(self.arriving(run), field.times(-1, self.alpha[run]))
        spread = field.times(2 * condition.end * path.d[run] * (path.k[run] - 1), self.half[run])
        twice_t = field.times(condition.sign, field.sum(middle, spread))
        turned = field.sum(twice_t, field.times(4 * condition.tilt, self.alpha[condition.leg]))
        return turned == _HALF_TURN and bool(abs(slack) < 1)


def joins(path: BallPath, touching: Sequence[tuple[Condition, arb]]) -> bool:
    """Tell whether the given slacks are proved to be exactly zero at the maximum of the length.

    The path encloses its maximum, and each slack comes with its enclosure.
    """
    numbers = [part for x in [*path.alpha, *path.half] for part in (x.cos(), x.sin())]
    for field, elements in _suggestions(numbers):
        turns = list(zip(elements[::2], elements[1::2], strict=True))
        exact = ExactPath(path, field, turns[: path.m], turns[path.m :])
        if exact.is_maximum() and all(exact.is_zero(*pair) for pair in touching):
            return True
    return False


def _suggestions(numbers: list[arb]) -> Iterator[tuple[NumberField, list[fmpq_poly]]]:
    """Yield fields that seem to contain the given numbers, with the numbers as their elements.

    The generator of a field is one of the numbers, or a sum of multiples of all of them.
    """
    bits = min(_bits(x) for x in numbers)
    keys = [str(abs(x).mid().str(_ALIKE, radius=False)) for x in numbers]
    distinct = {key: abs(x) for key, x in zip(keys, numbers, strict=True)}
    generators = list(distinct.values())[:_GENERATORS]
    mixed = sum(((place + 2) * x for place, x in enumerate(generators)), arb(0))
    for gamma in [*generators, mixed]:
        field = _field(gamma, bits)
        if field is not None and (elements := _elements(distinct, gamma, field.f.degree(), bits)):
            signed = (
                elements[key] if x > 0 else -elements[key] for key, x in zip(keys, numbers, strict=True)
            )
            yield field, list(signed)


def _elements(numbers: dict[str, arb], gamma: arb, degree: int, bits: int) -> dict[str, fmpq_poly] | None:
    """Return the numbers as polynomials in gamma, or None if one of them does not seem to be a polynomial."""
    powers, elements = [gamma**i for i in range(degree)], {}
    for key, x in numbers.items():
        relation = _relation([x, *powers], bits)
        if relation is None or not relation[0]:
            return None
        elements[key] = fmpq_poly([fmpq(-c, relation[0]) for c in relation[1:]])
    return elements


def _field(gamma: arb, bits: int) -> NumberField | None:
    """Return the field that a number seems to generate, or None if no polynomial is found."""
    width = arb(2) ** (-bits // 2)
    for degree in _DEGREES:
        relation = _relation([gamma**i for i in range(degree + 1)], bits)
        if relation is not None:
            f, middle = fmpq_poly(relation), gamma.mid()
            crosses = bool(arb_poly(f)(middle - width) * arb_poly(f)(middle + width) < 0)
            return NumberField(f, middle + arb(0, 2 * width)) if crosses else None
    return None


def _relation(numbers: Sequence[arb], bits: int) -> list[int] | None:
    """Return small integer coefficients, not all zero, with which the sum of the numbers seems to vanish.

    LLL finds them; the result is None if they are not small enough.
    """
    size = len(numbers)
    rows = [[int(i == j) for j in range(size)] for i in range(size)]
    for row, x in zip(rows, numbers, strict=True):
        mantissa, exponent = (int(part) for part in x.mid().man_exp())
        shift = exponent + bits
        row.append(mantissa << shift if shift > 0 else mantissa >> -shift)
    *coefficients, off = (int(x) for x in fmpz_mat(rows).lll().tolist()[0])
    short = sum(abs(c).bit_length() for c in coefficients) + abs(off).bit_length() + _SPARE < bits
    return coefficients if short else None


def _bits(x: arb) -> int:
    """Return the number of accurate binary places of a ball, at most a little less than the precision.

    The result is 0 for an exact ball, which no cosine or sine of a path is.
    """
    mantissa, exponent = x.rad().man_exp()
    return min(-int(exponent) - int(mantissa).bit_length(), ctx.prec - 16)
