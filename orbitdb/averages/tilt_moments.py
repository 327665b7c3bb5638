"""Sums over tilted orbits as power series in the tilt, so that no orbit has to be kept.

The tilt mu that makes means exact (`orbitdb.averages.tilted`) is known only after all orbits are. But it
changes little from period to period. Around the tilt c of all lower periods, the sums of w e^(mu x), alone or
times other quantities, are power series in mu - c. Their coefficients are sums of w e^(c x) times powers of
x. They are truncated at `DEGREE`. The last term is a sum of positive terms and estimates the remainder.
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
"""Indices of the terms whose means are exact at each level; 0 is ln D, 1 is ln K, 2 is c2."""

DEGREE = 8
"""Even, so that the sum of the terms of this degree is positive."""

_CHUNK = 1 << 11
"""Number of orbits at a time, so that their powers stay in the cache."""


class TiltedSums(NamedTuple):
    """Sums over orbits with the weights w e^(mu x)."""

    total: float  # sum of 1
    slope: Floats  # sum of x, the gradient of the total in mu, shape (k,)
    spread: Floats  # sum of x x^T, shape (k, k)
    rest: float  # sum of the rest of lambda that is averaged over orbits
    legs: float  # sum of the numbers of legs
    missing: float  # approximate limit of the truncation error of the total


@dataclass(frozen=True, eq=False)
class TiltedOrbits(Batch):
    """The weights and quantities of N orbits, one by one."""

    log_weights: Floats  # shape (N,)
    x: Floats  # the quantities whose means the tilt makes 0, shape (k, N)
    rest: Floats  # the rest of lambda that is averaged over orbits, shape (N,)
    legs: Floats  # the number of legs, shape (N,)

    @classmethod
    def joined(cls, parts: Iterable[Self]) -> Self:
        """Return several with all three quantities as one; without any, no orbits."""
        return super().joined([cls(*(np.zeros(shape) for shape in (0, (3, 0), 0, 0))), *parts])

    def held(self, level: int) -> "TiltedOrbits":
        """Keep only the quantities of a level."""
        return replace(self, x=self.x[list(HELD[level])])

    def at(self, mu: Floats) -> TiltedSums:
        """Return the sums at a tilt."""
        w = np.exp(self.log_weights + mu @ self.x)
        spread = (self.x * w) @ self.x.T
        return TiltedSums(w.sum(), self.x @ w, spread, float(w @ self.rest), float(w @ self.legs), 0.0)


@dataclass(frozen=True, eq=False)
class TiltMoments(ByValue):
    """Coefficients of the power series of the sums over some orbits."""

    centre: Floats  # the tilt c, shape (k,)
    # sums of w e^(c x) x^n for each power n of x up to degree `DEGREE`, alone, times rest, and times legs,
    # shape (3, n)
    sums: Floats

    @classmethod
    def none(cls, centre: Floats) -> "TiltMoments":
        """Return the sums over no orbits, which are 0."""
        return cls(centre, np.zeros((3, len(_powers(len(centre)).exponents))))

    @classmethod
    def of(cls, centre: Floats, orbits: TiltedOrbits) -> "TiltMoments":
        """Add up over orbits."""
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
        """Add up parts with the same centre exactly, then round once."""
        columns = zip(*(part.sums.ravel().tolist() for part in parts), strict=True)
        return cls(parts[0].centre, np.array([math.fsum(of) for of in columns]).reshape(3, -1))

    def at(self, mu: Floats) -> TiltedSums:
        """Return the sums at a tilt."""
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
    """The powers of k variables up to `DEGREE`; each after the first is a lower one times a variable."""

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
    """Return moments by level as little-endian doubles."""
    parts = [
        part for level, each in sorted(moments.items()) for part in ([level], each.centre, each.sums.ravel())
    ]
    return np.concatenate([np.zeros(0), *parts]).astype("<f8").tobytes()


def from_bytes(numbers: bytes) -> dict[int, TiltMoments]:
    """Return the moments that `to_bytes` wrote.

    Raises
    ------
    ValueError
        If the bytes are not moments.
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
