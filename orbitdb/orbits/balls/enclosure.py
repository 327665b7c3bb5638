"""Enclose orbits in ball arithmetic, with proof, if doubles cannot decide a word (docs/proof.md).

If a ball does not separate a slack from zero, the precision is increased until the slack is smaller than it
can be for any orbit that shadows one through a joint. Then `orbitdb.orbits.balls.joints` may prove that it is
zero. Otherwise the word stays unresolved.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, ctx

from orbitdb.arrays import Floats, Words
from orbitdb.billiard.legs import Legs, centre_directions, cut, direction_limits
from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.balls.path import BallPath, Balls, Condition
from orbitdb.orbits.batch import Orbits
from orbitdb.orbits.status import Status

PRECISION, MAX_PRECISION = 128, 16384
"""Initial and maximum number of bits of the arithmetic."""

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
    margin: arb  # least distance from a joint, in coordinate units
    steps: int  # number of Newton steps taken


def enclose(word: Words, stadium: Stadium, precision: int = PRECISION) -> Enclosure:
    """Enclose the stationary point of one admissible word, shape (p,), as `enclose_all` does."""
    ((_, legs),) = cut(word[None, :])
    (found,) = enclose_all(legs, stadium, precision=precision)
    return found


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
        with ctx.workprec(precision):
            path.go_to(start)
            steps = path.climb()
            start = path.alpha
            path.widen()
            slack, distance = path.slacks(conditions)
            status = _status(path, conditions, slack)
            if status is not Status.UNRESOLVED or 2 * precision > _most_bits(path):
                margin = distance[0]
                for x in distance[1:]:
                    margin = margin.min(x)
                numbers = path.coordinates(legs), path.length(), path.exponent()
                return Enclosure(status, precision, *numbers, margin, steps)
        precision *= 2


def _status(path: BallPath, conditions: list[Condition], slack: Balls) -> Status:
    """Return the status that is proved by the slacks at the enclosed maximum."""
    if any(x < 0 for x in slack):
        return Status.DYNAMICAL
    if not all(low < x < high for x, (low, high) in zip(path.alpha, path.limits, strict=True)):
        return Status.UNRESOLVED
    touching = [each for each in zip(conditions, slack, strict=True) if not each[1] > 0]
    if not touching:
        return Status.ORBIT
    close = arb(2) ** -_CLOSE * (-path.exponent()).exp()
    if all(abs(x) < close for _, x in touching):
        from orbitdb.orbits.balls.joints import joins

        if joins(path, touching):
            return Status.BOUNDARY
    return Status.UNRESOLVED


def _most_bits(path: BallPath) -> int:
    """Return the bits after which a word stays unresolved: more for larger lambda, fewer for more legs."""
    hope = path.exponent().abs_upper() / arb.const_log2()
    bits = _ENOUGH + float(hope) if hope.is_finite() else MAX_PRECISION
    return int(max(min(bits, MAX_PRECISION, _BITS_IN_MEMORY / path.m), 2 * PRECISION))


def true_errors(orbits: Orbits, found: Sequence[Enclosure]) -> tuple[Floats, Floats, Floats]:
    """Return the true errors of N orbits, given their enclosures, as three arrays of shape (N,).

    These are the largest error of a coordinate, and the errors of the length and of lambda: the largest
    distance of a number from any point of its ball, rounded up.
    """
    coordinates = [
        max(distance(ball, x) for ball, x in zip(each.coordinates, row, strict=True))
        for each, row in zip(found, orbits.coordinates.tolist(), strict=True)
    ]
    length = [distance(each.length, x) for each, x in zip(found, orbits.length.tolist(), strict=True)]
    lyapunov = [distance(each.lyapunov, x) for each, x in zip(found, orbits.lyapunov.tolist(), strict=True)]
    return np.array(coordinates), np.array(length), np.array(lyapunov)


def distance(ball: arb, value: float) -> float:
    """Return the largest distance of a number from any point of a ball, rounded up."""
    return math.nextafter(float((ball - value).abs_upper()), math.inf)


def as_orbits(words: Words, stadium: Stadium, found: Sequence[Enclosure]) -> Orbits:
    """Return N >= 1 enclosures as orbits rounded to doubles; their error bounds include the rounding."""
    coordinates, errors = _rounded([each.coordinates for each in found])
    length, length_error = _rounded([[each.length] for each in found])
    lyapunov, lyapunov_error = _rounded([[each.lyapunov] for each in found])
    return Orbits(
        words=words,
        status=np.array([each.status.value for each in found]),
        coordinates=coordinates,
        length=length[:, 0],
        lyapunov=lyapunov[:, 0],
        margin=np.array([0.0 if each.status is Status.BOUNDARY else float(each.margin) for each in found]),
        residual=np.abs(forces(stadium, words, coordinates)).max(axis=1),
        error=errors.max(axis=1),
        length_error=length_error[:, 0],
        lyapunov_error=lyapunov_error[:, 0],
        iterations=np.array([each.steps for each in found]),
    )


def _rounded(rows: Sequence[Balls]) -> tuple[Floats, Floats]:
    """Return the midpoints of balls as doubles, and their largest distances from any point of the balls."""
    values = [[float(x) for x in row] for row in rows]
    errors = [list(map(distance, *pair)) for pair in zip(rows, values, strict=True)]
    return np.array(values), np.array(errors)
