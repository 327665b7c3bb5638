"""Exact proof that an orbit passes through a joint of wall and semicircle (docs/proof.md).

No ball can show that a number is zero. But every double is rational, and at rational a the directions of the
orbits through joints that occur have algebraic sines and cosines of low degree. Balls suggest a field
Q(gamma), where gamma is a real root of a polynomial f, and elements of this field for the cosine and sine of
every leg direction and half turn. The following identities are then checked modulo f:

    cos^2 + sin^2 = 1                         for each of these angles,
    e^{2 k i half} = -e^{-i d (in + out)}     for every run,
    dL/dalpha = 0                             for every leg,
    e^{2 i slack} = 1                         for every slack that should be zero.

Beyond this, balls are only needed to distinguish an angle from its shifts by multiples of pi.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from flint import arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz_mat

from orbitdb.orbits.balls.path import BallPath, Condition

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
class Field:
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
        found, step = (fmpq_poly([1]), fmpq_poly([])), x if n >= 0 else (x[0], -x[1])
        for bit in f"{abs(n):b}":
            found = self.sum(found, found)
            if bit == "1":
                found = self.sum(found, step)
        return found


@dataclass(frozen=True)
class ExactPath:
    """A path with exact angles, as suggested by the enclosed path of the same word."""

    path: BallPath  # the enclosed path, with the word, the stadium and the limits
    field: Field
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
    for field, found in _suggestions(numbers):
        turns = list(zip(found[::2], found[1::2], strict=True))
        exact = ExactPath(path, field, turns[: path.m], turns[path.m :])
        if exact.is_maximum() and all(exact.is_zero(*each) for each in touching):
            return True
    return False


def _suggestions(numbers: list[arb]) -> Iterator[tuple[Field, list[fmpq_poly]]]:
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
        if field is not None and (found := _elements(distinct, gamma, field.f.degree(), bits)):
            yield field, [found[key] if x > 0 else -found[key] for key, x in zip(keys, numbers, strict=True)]


def _elements(numbers: dict[str, arb], gamma: arb, degree: int, bits: int) -> dict[str, fmpq_poly] | None:
    """Return the numbers as polynomials in gamma, or None if one of them does not seem to be a polynomial."""
    powers, found = [gamma**i for i in range(degree)], {}
    for key, x in numbers.items():
        relation = _relation([x, *powers], bits)
        if relation is None or not relation[0]:
            return None
        found[key] = fmpq_poly([fmpq(-c, relation[0]) for c in relation[1:]])
    return found


def _field(gamma: arb, bits: int) -> Field | None:
    """Return the field that a number seems to generate, or None if no polynomial is found."""
    width = arb(2) ** (-bits // 2)
    for degree in _DEGREES:
        relation = _relation([gamma**i for i in range(degree + 1)], bits)
        if relation is not None:
            f, middle = fmpq_poly(relation), gamma.mid()
            crosses = bool(arb_poly(f)(middle - width) * arb_poly(f)(middle + width) < 0)
            return Field(f, middle + arb(0, 2 * width)) if crosses else None
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
    *found, off = (int(x) for x in fmpz_mat(rows).lll().tolist()[0])
    short = sum(abs(c).bit_length() for c in found) + abs(off).bit_length() + _SPARE < bits
    return found if short else None


def _bits(x: arb) -> int:
    """Return the number of accurate binary places of a ball, at most a little less than the precision.

    The result is 0 for an exact ball, which no cosine or sine of a path is.
    """
    mantissa, exponent = x.rad().man_exp()
    return min(-int(exponent) - int(mantissa).bit_length(), ctx.prec - 16)
