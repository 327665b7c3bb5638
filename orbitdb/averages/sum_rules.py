"""Lyapunov exponents from all orbits up to a period, constrained by the exact means of the stadium.

Per leg, lambda contains the terms ln D, ln K and c2, whose means are known exactly
(`orbitdb.averages.exact_means`). Only the small remainder is averaged over orbits:

    lambda_l = E[ln D] + E[ln K] + E[c2] + sum w (lambda - ln D - ln K - c2) / sum w m,

where m is the number of legs of an orbit. The weights w are the class size times e^-lambda, tilted so that as
many of the three means as possible are exact (`orbitdb.averages.tilting`). If not all three can be exact, c2
is dropped first, then ln D, then ln K.

Such conditions on finite sets of orbits are known as sum rules (Nielsen, Dahlqvist and Cvitanovic,
J. Phys. A 32 (1999) 6757).
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats, Integers, Words
from orbitdb.averages.exact_means import ExactMeans, exact_means
from orbitdb.averages.tilting import HELD, TiltedOrbits, tilt
from orbitdb.billiard.legs import Derivatives, cut, derivatives, preceding
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import newton

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
    count, *sums = terms
    means = exact_means(a).terms
    held = np.stack([term - mean.value * count for term, mean in zip(sums, means, strict=True)])
    return TiltedOrbits(np.log(size) - lyapunov, held, lyapunov - np.sum(sums, axis=0), count)


def _terms(slopes: Derivatives) -> Floats:
    """Return the number of legs and the sums of ln D, ln K and c2 for N words of m runs, shape (4, N)."""
    drift, kick = slopes.between_centres, 1 / slopes.stiffness
    coupling = np.log1p((1 / drift + 1 / preceding(drift)) / kick)
    m = np.full(drift.shape[1], float(len(drift)))
    return np.stack([m, np.log(drift).sum(axis=0), np.log(kick).sum(axis=0), coupling.sum(axis=0)])


def sum_rules(a: float, parts: Iterable[tuple[int, TiltedOrbits]], last: int, highest: int) -> SumRules:
    """Return the averages over all orbits up to each period 2 .. highest, NaN above `last`.

    `parts` are the periods and their orbits up to `last`, in ascending order.
    """
    columns = np.full((3, highest - 1), np.nan)
    columns[:, : last - 1] = _of_orbits(parts, last)
    return _averages(columns, exact_means(a))


def _of_orbits(parts: Iterable[tuple[int, TiltedOrbits]], last: int) -> Floats:
    """Tilt all orbits up to each period 2 .. last.

    Returns, for each period, shape (3, last - 1): the highest level with a tilt, the average over orbits
    sum w (lambda - ln D - ln K - c2) / sum w m at that level, and the average at the level below.
    """
    given = list(parts)
    orbits = TiltedOrbits.joined(part for _, part in given)
    upto = [sum(len(part.legs) for p, part in given if p <= end) for end in range(2, last + 1)]
    x = orbits.x / (orbits.legs.mean() if len(orbits.legs) else 1.0)
    columns, tilts = np.full((3, last - 1), np.nan), dict[int, tuple[Floats, Floats]]()
    for place, count in enumerate(upto):
        if count:
            tilts = _highest_two(orbits.log_weights[:count], x[:, :count], tilts)
            rest, legs = orbits.rest[:count], orbits.legs[:count]
            values = [float(w @ rest / (w @ legs)) for _, w in tilts.values()]
            columns[:, place] = max(tilts), values[-1], values[-2] if len(values) > 1 else np.nan
    return columns


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


def _averages(columns: Floats, means: ExactMeans) -> SumRules:
    """Return the averages that follow from the columns of `_of_orbits`, with estimates of their errors."""
    rest, below = columns[1:]
    level = np.where(np.isfinite(rest), columns[0], 0).astype(np.int64)
    growth = means.growth
    error = _CHANGES[level] * _recent(np.abs(rest - below), _LOOK_BACK, np.max)
    error += _RANGES[level] * _recent(rest, _LOOK_BACK + 1, np.ptp)
    error += _OF_THE_REST * np.abs(rest) + growth.error
    low, high = means.bounds
    error = np.where(np.isfinite(rest), np.fmin(error, high - low), np.nan)
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
