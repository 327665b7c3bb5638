"""Sums over tilted orbits as power series in the tilt, so that the orbits themselves need not be stored.

The tilt mu that makes the means exact (`orbitdb.averages.tilted`) is only known when all orbits are known,
but it changes little from one period to the next. Let c be the tilt of all shorter periods. The sums of
w e^(mu x), alone or times other quantities, are expanded in powers of mu - c up to degree `DEGREE`. The
coefficients are sums of w e^(c x) times powers of x. The term of the highest degree is a sum of positive
numbers; it serves as an estimate of the remainder.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations_with_replacement
from typing import NamedTuple, Self

import numpy as np

from orbitdb.arrays import Floats, Integers
from orbitdb.equality import Batch, ByValue

HELD = ((), (1,), (0, 1), (0, 1, 2))
"""For each level, the indices of the quantities whose means are exact: 0 is ln D, 1 is ln K, 2 is c2."""

DEGREE = 8
"""Degree of the power series. It is even, so that the sum of the terms of this degree is positive."""

_CHUNK = 1 << 11
"""Number of orbits processed together, small enough for their powers to stay in the cache."""


class TiltedSums(NamedTuple):
    """Sums over orbits with the weights w e^(mu x)."""

    total: float  # sum of 1
    slope: Floats  # sum of x, the gradient of the total with respect to mu, shape (k,)
    spread: Floats  # sum of x x^T, shape (k, k)
    rest: float  # sum of the remainder of lambda, which is averaged over orbits
    legs: float  # sum of the numbers of legs
    missing: float  # approximate upper limit of the truncation error of the total


@dataclass(frozen=True, eq=False)
class TiltedOrbits(Batch):
    """The weights and other quantities of N individual orbits."""

    log_weights: Floats  # ln w, shape (N,)
    x: Floats  # the quantities whose means the tilt reduces to 0, shape (k, N)
    rest: Floats  # the remainder of lambda, which is averaged over orbits, shape (N,)
    legs: Floats  # number of legs, shape (N,)

    @classmethod
    def joined(cls, parts: Iterable[Self]) -> Self:
        """Join orbits with all three quantities; return no orbits if there are no parts."""
        return super().joined([cls(*(np.zeros(shape) for shape in (0, (3, 0), 0, 0))), *parts])

    def held(self, level: int) -> "TiltedOrbits":
        """Return the same orbits with only those quantities x whose means are exact at the given level."""
        return replace(self, x=self.x[list(HELD[level])])

    def at(self, mu: Floats) -> TiltedSums:
        """Return the sums over the orbits with the weights w e^(mu x)."""
        w = np.exp(self.log_weights + mu @ self.x)
        spread = (self.x * w) @ self.x.T
        return TiltedSums(w.sum(), self.x @ w, spread, float(w @ self.rest), float(w @ self.legs), 0.0)


@dataclass(frozen=True, eq=False)
class TiltMoments(ByValue):
    """The moments of a set of orbits: the coefficients of the power series of their sums."""

    centre: Floats  # the tilt c around which the sums are expanded, shape (k,)
    # sums of w e^(c x) x^n for each power n up to the degree `DEGREE`: alone (row 0), times the remainder of
    # lambda (row 1), and times the number of legs (row 2); shape (3, n)
    sums: Floats

    @classmethod
    def none(cls, centre: Floats) -> "TiltMoments":
        """Return the moments of an empty set of orbits, which are all 0."""
        return cls(centre, np.zeros((3, len(_powers(len(centre)).exponents))))

    @classmethod
    def of(cls, centre: Floats, orbits: TiltedOrbits) -> "TiltMoments":
        """Compute the moments of the given orbits."""
        powers = _powers(len(centre))
        sums = []
        for start in range(0, len(orbits.legs), _CHUNK):
            here = slice(start, start + _CHUNK)
            x, w = orbits.x[:, here], np.exp(orbits.log_weights[here] + centre @ orbits.x[:, here])
            terms = np.empty((len(powers.exponents), x.shape[1]))
            terms[0] = w
            for place, (lower, factor) in enumerate(powers.made_of, 1):
                np.multiply(terms[lower], x[factor], out=terms[place])
            sums.append(
                [terms.sum(axis=1), *((terms * of[here]).sum(axis=1) for of in (orbits.rest, orbits.legs))]
            )
        return cls(centre, np.array(sums).sum(axis=0) if sums else cls.none(centre).sums)

    @classmethod
    def joined(cls, parts: "Sequence[TiltMoments]") -> "TiltMoments":
        """Add the moments of parts with the same centre exactly, and round only the result."""
        columns = zip(*(part.sums.ravel().tolist() for part in parts), strict=True)
        return cls(parts[0].centre, np.array([math.fsum(of) for of in columns]).reshape(3, -1))

    def at(self, mu: Floats) -> TiltedSums:
        """Return the sums with the weights w e^(mu x), from the power series."""
        powers = _powers(len(self.centre))
        shares = np.prod((mu - self.centre) ** powers.exponents, axis=1) / powers.factorials
        moments, rest, legs = self.sums
        spread = len(mu), len(mu)
        lower, lowest = (powers.exponents.sum(axis=1) <= DEGREE - less for less in (1, 2))
        once = [powers.times[lower, i] for i in range(len(mu))]
        twice = [[powers.times[place[lowest[lower]], j] for j in range(len(mu))] for place in once]
        return TiltedSums(
            float(shares @ moments),
            np.array([shares[lower] @ moments[place] for place in once]),
            np.array([[shares[lowest] @ moments[place] for place in row] for row in twice]).reshape(spread),
            float(shares @ rest),
            float(shares @ legs),
            float(shares[~lower] @ moments[~lower]),
        )


class _Powers(NamedTuple):
    """The monomials in k variables up to `DEGREE`; each but the constant is a lower one times a variable."""

    exponents: Integers
    factorials: Floats
    made_of: list[tuple[int, int]]
    times: Integers


@cache
def _powers(k: int) -> _Powers:
    factors = [each for d in range(DEGREE + 1) for each in combinations_with_replacement(range(k), d)]
    place = {each: number for number, each in enumerate(factors)}
    exponents = np.array([[each.count(i) for i in range(k)] for each in factors]).reshape(len(factors), k)
    times = np.full((len(factors), k), -1)
    for number, each in enumerate(factors):
        for i in range(k):
            times[number, i] = place.get(tuple(sorted((*each, i))), -1)
    factorials = np.array([math.prod(map(math.factorial, row)) for row in exponents.tolist()], dtype=float)
    return _Powers(exponents, factorials, [(place[each[:-1]], each[-1]) for each in factors[1:]], times)


def to_bytes(moments: Mapping[int, TiltMoments]) -> bytes:
    """Return the moments of each level as the bytes of little-endian doubles."""
    parts = [
        part for level, each in sorted(moments.items()) for part in ([level], each.centre, each.sums.ravel())
    ]
    return np.concatenate([np.zeros(0), *parts]).astype("<f8").tobytes()


def from_bytes(numbers: bytes) -> dict[int, TiltMoments]:
    """Reconstruct the moments of each level from the bytes that `to_bytes` returned.

    Raises
    ------
    ValueError
        If the bytes do not represent moments.
    """
    values, found = np.frombuffer(numbers, dtype="<f8").astype(float), {}
    if not np.isfinite(values).all():
        raise ValueError("moments must be finite")
    while len(values):
        level = int(values[0])
        if level not in range(len(HELD)):
            raise ValueError(f"moments have levels from 0 to 3, not {level}")
        k = len(HELD[level])
        end = 1 + k + 3 * len(_powers(k).exponents)
        if len(values) < end:
            raise ValueError(f"{len(values)} numbers are not enough for the moments of level {level}")
        found[level] = TiltMoments(values[1 : 1 + k], values[1 + k : end].reshape(3, -1))
        values = values[end:]
    return found
