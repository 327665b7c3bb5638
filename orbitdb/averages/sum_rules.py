"""Lyapunov exponents from all orbits up to a period, constrained by the exact means of the stadium.

Per leg, lambda contains the terms ln D, ln K and c2, whose means are known exactly
(`orbitdb.averages.exact_means`). Only the small remainder is averaged over orbits:

    lambda_l = E[ln D] + E[ln K] + E[c2] + sum w (lambda - ln D - ln K - c2) / sum w m,

where m is the number of legs of an orbit. The weights w are the class size times e^-lambda, tilted so that as
many of the three means as possible are exact (`orbitdb.averages.tilting`). If not all three can be exact, c2
is dropped first, then ln D, then ln K.

Such conditions on finite sets of orbits are known as sum rules (Nielsen, Dahlqvist and Cvitanovic,
J. Phys. A 32 (1999) 6757).

If longer periods have been swept, the orbits up to `ENUMERATED_TO` are computed again, which takes a second. Each
longer period has stored moments (`orbitdb.averages.tilting`) around the tilts of all shorter periods. So
the moments of a swept period depend on those of the shorter periods.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Integers, Words
from orbitdb.averages.exact_means import ExactMeans, exact_means
from orbitdb.averages.tilting import HELD, Tilted, TiltedOrbits, TiltedSums, TiltMoments, solve_tilt, tilt
from orbitdb.billiard.legs import Derivatives, cut, derivatives, preceding
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.exponents import ClassifiedBatch, exponents
from orbitdb.orbits.newton import newton
from orbitdb.symbols.enumeration import Span, least_words
from orbitdb.symbols.symmetry import SIZES

Moments = Mapping[int, TiltMoments]
"""The moments of a period for each level (`HELD`)."""

ENUMERATED_TO = 13
"""The highest period whose orbits are computed again if longer periods have been swept."""

_MOST_MISSING = 1e-4
"""Fraction of the weights that the power series may miss; the averages change by a hundredth of this."""

_SMALL = 1e-20

_LOOK_BACK = 4
_CHANGES = np.array([3.0, 3.0, 3.0, 0.0])
_RANGES = np.array([3.0, 3.0, 3.0, 2.0])
"""For each level, the factors of two parts of the error estimate: the change due to the last mean made exact,
and the range of the recent averages. They were found by trial; bench_sum_rules.py counts how often the
estimates hold. Below the highest level, the averages drift slowly. At the highest level, the change describes
the level below rather than the error: at a = 0.1, it is thirty times too large."""

_OF_THE_REST = 0.03


@dataclass(frozen=True, eq=False)
class SumRules:
    """Lyapunov averages by period; all arrays have the same shape as p, with NaN where there is no orbit."""

    p: Integers  # 2, 3, .. up to the highest period
    # number of exact means that the weights reproduce: 0, 1 (ln K), 2 (ln K and ln D) or 3 (all)
    level: Integers
    lambda_l: Floats  # lambda per leg
    lambda_l_below: Floats  # lambda per leg at the level below, with one exact mean fewer
    # Estimated error of lambda_l, the sum of three parts: twice the range of lambda_l over the last five
    # periods; 3 % of the average over orbits (the limits are off by up to 1.5 % of it); the error of the
    # exact means. Below level 3, the range is multiplied by three instead of two, and three times the largest
    # difference between lambda_l and lambda_l_below in the last four periods is added. The estimate is at
    # most the width of `ExactMeans.bounds`, and equal to it for the first few periods.
    lambda_l_error: Floats
    # lambda per bounce and per unit length, with errors
    lambda_d_sum_rule: Floats
    lambda_d_sum_rule_error: Floats
    lambda_c_sum_rule: Floats
    lambda_c_sum_rule_error: Floats


def orbits_of_words(words: Words, size: Integers, lyapunov: Floats, a: float) -> TiltedOrbits:
    """Return the orbits of admissible words, shape (N, p), given their class sizes and their lambdas.

    The legs are solved by Newton's method, which is faster than reading coordinates from a database.
    """
    terms = np.empty((4, len(words)))
    for rows, legs in cut(words):
        terms[:, rows] = _terms(derivatives(legs, a, newton(legs, a).alpha))
    return _orbits(size, lyapunov, terms, a)


def orbits_of_exponents(size: Integers, solved: ClassifiedBatch, a: float) -> TiltedOrbits:
    """Return orbits that have already been solved, given the sizes of their classes."""
    return _orbits(size, solved.lyapunov, _terms(solved.slopes), a)


def _orbits(size: Integers, lyapunov: Floats, terms: Floats, a: float) -> TiltedOrbits:
    legs, *sums = terms
    means = exact_means(a).terms
    held = np.stack([term - mean.value * legs for term, mean in zip(sums, means, strict=True)])
    return TiltedOrbits(np.log(size) - lyapunov, held, lyapunov - np.sum(sums, axis=0), legs)


def _terms(slopes: Derivatives) -> Floats:
    """Return the number of legs and the sums of ln D, ln K and c2 for N words of m runs, shape (4, N)."""
    drift, kick = slopes.between_centres, 1 / slopes.stiffness
    coupling = np.log1p((1 / drift + 1 / preceding(drift)) / kick)
    m = np.full(drift.shape[1], float(len(drift)))
    return np.stack([m, np.log(drift).sum(axis=0), np.log(kick).sum(axis=0), coupling.sum(axis=0)])


class Beginning(NamedTuple):
    """The orbits up to a given period, with their tilts and averages."""

    orbits: TiltedOrbits  # with all three quantities: ln D, ln K and c2
    # for each period, shape (3, last - 1): the highest level with a tilt, the average over orbits
    # sum w (lambda - ln D - ln K - c2) / sum w m at that level, and the average at the level below
    columns: Floats
    tilts: dict[int, Floats]  # the tilt at the last period for each level

    @classmethod
    def of(cls, parts: Iterable[tuple[int, TiltedOrbits]], last: int) -> "Beginning":
        """Tilt all orbits up to each period 2 .. last, given (period, orbits) in ascending order."""
        given = list(parts)
        orbits = TiltedOrbits.joined(part for _, part in given)
        upto = [sum(len(part.legs) for p, part in given if p <= end) for end in range(2, last + 1)]
        scale = orbits.legs.mean() if len(orbits.legs) else 1.0
        x, columns, tilts = (
            orbits.x / scale,
            np.full((3, last - 1), np.nan),
            dict[int, tuple[Floats, Floats]](),
        )
        for place, count in enumerate(upto):
            if count:
                tilts = _highest_two(orbits.log_weights[:count], x[:, :count], tilts)
                rest, legs = orbits.rest[:count], orbits.legs[:count]
                values = [float(w @ rest / (w @ legs)) for _, w in tilts.values()]
                columns[:, place] = max(tilts), values[-1], values[-2] if len(values) > 1 else np.nan
        return cls(orbits, columns, {level: mu / scale for level, (mu, _) in tilts.items()})


@lru_cache(maxsize=4)
def beginning(a: float, last: int) -> Beginning:
    """Compute the orbits up to a given period, and their tilts."""
    parts = (
        (p, orbits_of_exponents(SIZES[words.stabiliser[part.orbits]], part, a))
        for p in range(2, last + 1)
        for words in least_words(Span.of_period(p))
        for part in exponents(words.codes, p, Stadium(a))
    )
    return Beginning.of(parts, last)


def sum_rules(a: float, parts: Iterable[tuple[int, TiltedOrbits]], highest: int) -> SumRules:
    """Return the averages over all orbits up to each period 2 .. highest; `parts` is as in `Beginning.of`."""
    return _averages(Beginning.of(parts, highest).columns, exact_means(a))


def swept_sum_rules(a: float, moments: Sequence[Moments], highest: int) -> SumRules:
    """Return the averages over all orbits up to each period 2 .. highest, from the moments of swept periods.

    The moments belong to the periods `ENUMERATED_TO` + 1, `ENUMERATED_TO` + 2, ... without gaps. The averages of periods
    beyond the last moments are NaN. No level can be higher than the highest level of the orbits up to
    `ENUMERATED_TO`.
    """
    last = min(highest, ENUMERATED_TO)
    start = beginning(a, last)
    columns = np.full((3, highest - 1), np.nan)
    columns[:, : last - 1] = start.columns
    beyond = _tilts(start, moments[: highest - last])[0]
    columns[:, last - 1 : last - 1 + beyond.shape[1]] = beyond
    return _averages(columns, exact_means(a))


def next_tilts(a: float, moments: Sequence[Moments]) -> dict[int, Floats]:
    """Return, for each level, the tilt of all orbits up to the highest period that has moments."""
    return _tilts(beginning(a, ENUMERATED_TO), moments)[1]


def _highest_two(
    log_weights: Floats, held: Floats, before: Mapping[int, tuple[Floats, Floats]]
) -> dict[int, tuple[Floats, Floats]]:
    """Return the tilts of the two highest levels at which a tilt exists, in ascending order of level.

    The convex hull grows with the number of orbits, so a tilt that existed at shorter periods still exists.
    Only rounding can lose it, if the terms hardly scatter (at very large a).
    """
    tilts = {}
    for level in range(min(before, default=0), len(HELD)):
        tilted = tilt(log_weights, held[list(HELD[level])], before[level][0] if level in before else None)
        if tilted is None:
            break
        tilts[level] = tilted
    if not tilts:
        return _highest_two(log_weights, held, {})
    return {level: tilts[level] for level in sorted(tilts)[-2:]}


def _tilts(start: Beginning, moments: Sequence[Moments]) -> tuple[Floats, dict[int, Floats]]:
    """Return the columns of `Beginning.columns` for periods beyond `ENUMERATED_TO`, and the tilts at the last one."""
    tilts, columns = dict(start.tilts), np.full((3, len(moments)), np.nan)
    for place in range(len(moments)):
        values = {}
        for level in sorted(tilts):
            if any(level not in by_level for by_level in moments[: place + 1]):
                del tilts[level]
                continue
            parts: list[TiltedOrbits | TiltMoments] = [start.orbits.held(level)]
            parts += [by_level[level] for by_level in moments[: place + 1]]
            solved = _solved(parts, tilts[level])
            if solved is None:
                del tilts[level]
                continue
            tilts[level], sums = solved
            values[level] = sums.rest / sums.legs
        if values:
            columns[:2, place] = max(values), values[max(values)]
            columns[2, place] = values.get(max(values) - 1, np.nan)
    return columns, tilts


def _solved(parts: Sequence[TiltedOrbits | TiltMoments], start: Floats) -> tuple[Floats, TiltedSums] | None:
    """Return the tilt at which all means are 0, and the sums there; None if no such tilt is found."""

    def total(mu: Floats) -> TiltedSums:
        return TiltedSums(*(sum(of) for of in zip(*(part.at(mu) for part in parts), strict=True)))

    def at(mu: Floats) -> Tilted:
        sums = total(mu)
        means = sums.slope / sums.total
        log_sum = math.log(sums.total) if sums.total > 0 else math.inf  # a truncated series may be negative
        return Tilted(log_sum, means, sums.spread / sums.total - np.outer(means, means))

    # sweeps store sums around this tilt, so it has to be more accurate than the result of `tilt`
    mu = solve_tilt(at, start, _SMALL)
    if mu is None or (sums := total(mu)).missing >= _MOST_MISSING * sums.total:
        return None
    return mu, sums


def _averages(columns: Floats, means: ExactMeans) -> SumRules:
    """Return the averages that follow from `Beginning.columns`, with estimates of their errors."""
    rest, below = columns[1:]
    level = np.where(np.isfinite(rest), columns[0], 0).astype(np.int64)
    growth = means.growth
    error = _CHANGES[level] * _recent(np.abs(rest - below), _LOOK_BACK, np.max)
    error += _RANGES[level] * _recent(rest, _LOOK_BACK + 1, np.ptp)
    error += _OF_THE_REST * np.abs(rest) + growth.error
    low, high = means.bounds
    error = np.fmin(error, high - low)
    stadium = Stadium(means.a)
    per_bounce, per_length = stadium.legs_per_bounce, stadium.legs_per_length
    return SumRules(
        p=np.arange(2, len(rest) + 2),
        level=level,
        lambda_l=growth.value + rest,
        lambda_l_below=growth.value + below,
        lambda_l_error=error,
        lambda_d_sum_rule=(growth.value + rest) * per_bounce,
        lambda_d_sum_rule_error=error * per_bounce,
        lambda_c_sum_rule=(growth.value + rest) * per_length,
        lambda_c_sum_rule_error=error * per_length,
    )


def _recent(values: Floats, count: int, function: Callable[[Floats], float]) -> Floats:
    """Apply a function to each value and the `count` - 1 values before it; NaN if there are fewer values."""
    parts = [values[max(0, end - count) : end] for end in range(1, len(values) + 1)]
    return np.array([function(part) if len(part) == count else np.nan for part in parts])
