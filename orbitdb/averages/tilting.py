"""Weights of orbits, tilted so that chosen means are exact.

With the weights w = e^-lambda, a finite set of orbits gives inexact means, because the long orbits are
missing. With the tilted weights w e^(mu x), the means of the quantities x are 0 for at most one tilt mu, at
which the convex function ln sum w e^(mu x) has its minimum. This tilt exists if 0 is inside the convex hull
of the points x, and Newton's method finds it.

The sums over tilted orbits can be kept as power series in the tilt (`TiltMoments`), so that the orbits
themselves need not be stored. The tilt mu that makes the means exact is only known when all orbits are known,
but it changes little from one period to the next. Let c be the tilt of all shorter periods. The sums of
w e^(mu x), alone or times other quantities, are expanded in powers of mu - c up to degree `DEGREE`. The
coefficients are sums of w e^(c x) times powers of x. The term of the highest degree is a sum of positive
numbers; it serves as an estimate of the remainder.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations_with_replacement
from typing import NamedTuple, Self

import numpy as np

from orbitdb.arrays import Batch, Floats, Integers

_SMALL = 1e-16
"""Square of the Newton step, in the metric of the spread, below which a step is only a rounding error."""

_MOST_STEPS = 60
_LEAST_FRACTION = 1e-6
_ROUNDING = 1e-14


class Tilted(NamedTuple):
    """The logarithm of the tilted sum, and its derivatives with respect to mu."""

    log_sum: float  # ln sum w e^(mu x)
    means: Floats  # the gradient, which consists of the means of the quantities x, shape (k,)
    spread: Floats  # the Hessian, which consists of the covariances of x, shape (k, k)


def solve_tilt(at: Callable[[Floats], Tilted | None], start: Floats, small: float = _SMALL) -> Floats | None:
    """Return the mu at which all means are 0, shape (k,), or None if Newton's method with step halving fails.

    `at` returns the tilted sum at mu, or None if mu x < 0 for all orbits, which proves that no tilt exists.
    The iteration ends when the square of the Newton step, in the metric of the spread, is below `small`.
    """
    mu, now = start, at(start)
    for _ in range(_MOST_STEPS):
        if now is None:
            return None
        try:
            step = -np.linalg.solve(now.spread, now.means)
        except np.linalg.LinAlgError:  # the points x do not span all directions
            return None
        drop, fraction = -float(now.means @ step), 1.0
        if drop < small:
            return mu
        slack = _ROUNDING * (1 + abs(now.log_sum))
        while (there := at(mu + fraction * step)) is not None and fraction > _LEAST_FRACTION:
            if there.log_sum <= now.log_sum - fraction * drop / 4 + slack:
                break
            fraction /= 2
        mu, now = mu + fraction * step, there
    return None


def tilt(log_weights: Floats, x: Floats, start: Floats | None = None) -> tuple[Floats, Floats] | None:
    """Tilt weights, shape (N,), so that the means of the quantities x, shape (k, N), are 0; k may be 0.

    Newton's method starts from mu = 0 by default. The result is mu, shape (k,), and the tilted weights, whose
    sum is 1. It is None if no tilt is found, for example because some linear combination of the quantities is
    positive for all orbits.
    """

    def at(mu: Floats) -> Tilted | None:
        if (exponents := mu @ x).max() < 0:
            return None
        log_sum, weights = _log_sum(log_weights, exponents)
        means = x @ weights
        return Tilted(log_sum, means, (x * weights) @ x.T - np.outer(means, means))

    mu = solve_tilt(at, np.zeros(len(x)) if start is None else start)
    return None if mu is None else (mu, _log_sum(log_weights, mu @ x)[1])


def _log_sum(log_weights: Floats, exponents: Floats) -> tuple[float, Floats]:
    """Return the logarithm of the sum of w e^x, and each term as a fraction of the sum."""
    total = log_weights + exponents
    most = total.max()
    terms = np.exp(total - most)
    scale = terms.sum()
    return float(most + np.log(scale)), terms / scale


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
class TiltMoments:
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
            rows = slice(start, start + _CHUNK)
            x, w = orbits.x[:, rows], np.exp(orbits.log_weights[rows] + centre @ orbits.x[:, rows])
            terms = np.empty((len(powers.exponents), x.shape[1]))
            terms[0] = w
            for place, (lower, factor) in enumerate(powers.made_of, 1):
                np.multiply(terms[lower], x[factor], out=terms[place])
            sums.append(
                [terms.sum(axis=1), *((terms * of[rows]).sum(axis=1) for of in (orbits.rest, orbits.legs))]
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
    factors = [factor for d in range(DEGREE + 1) for factor in combinations_with_replacement(range(k), d)]
    place = {factor: number for number, factor in enumerate(factors)}
    exponents = np.array([[factor.count(i) for i in range(k)] for factor in factors]).reshape(len(factors), k)
    times = np.full((len(factors), k), -1)
    for number, factor in enumerate(factors):
        for i in range(k):
            times[number, i] = place.get(tuple(sorted((*factor, i))), -1)
    factorials = np.array([math.prod(map(math.factorial, row)) for row in exponents.tolist()], dtype=float)
    return _Powers(exponents, factorials, [(place[factor[:-1]], factor[-1]) for factor in factors[1:]], times)


def to_bytes(moments: Mapping[int, TiltMoments]) -> bytes:
    """Return the moments of each level as the bytes of little-endian doubles."""
    parts = ([level, *part.centre, *part.sums.ravel()] for level, part in sorted(moments.items()))
    return np.concatenate([np.zeros(0), *parts]).astype("<f8").tobytes()


def from_bytes(numbers: bytes) -> dict[int, TiltMoments]:
    """Reconstruct the moments of each level from the bytes that `to_bytes` returned.

    Raises
    ------
    ValueError
        If the bytes do not represent moments.
    """
    values, moments = np.frombuffer(numbers, dtype="<f8").astype(float), {}
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
        moments[level] = TiltMoments(values[1 : 1 + k], values[1 + k : end].reshape(3, -1))
        values = values[end:]
    return moments
