"""Lyapunov exponents from all orbits up to a period, held to the exact means of the stadium.

Of lambda a leg, ln D, ln K and c2 have means that are known exactly (`orbitdb.averages.exact_means`), and
only the small rest is left to the orbits:

    lambda_l = E[ln D] + E[ln K] + E[c2] + sum w (lambda - ln D - ln K - c2) / sum w m,

m the number of legs. The weights are those of the class sizes and e^-lambda, tilted so that as many
of the three means as possible are exact with them, too (`orbitdb.averages.tilted`): where no weights have
all three, first c2 is let go, then ln D, then all.

Conditions of this kind on finite sets of orbits are known as sum rules (Nielsen, Dahlqvist and Cvitanovic,
J. Phys. A 32 (1999) 6757).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.exact_means import ExactMeans
from orbitdb.averages.fixed_points import ClassRows
from orbitdb.averages.leg_sums import LegSums
from orbitdb.averages.tilted import Tilt, tilt
from orbitdb.equality import ByValue

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

HELD = ((), (1,), (0, 1), (0, 1, 2))
"""The terms that are held at each level: of ln D, ln K, c2."""

_LOOK_BACK = 4
_CHANGES = np.array([3.0, 3.0, 3.0, 0.0])
_RANGES = np.array([3.0, 3.0, 3.0, 2.0])
"""By level, how much what the last mean has changed, and the range of the averages, count in the estimate.
Where a mean had to be let go the averages creep. Where none had to, the change tells of the level below and
not of what is left: at a = 0.1 it is thirty times as much. Found by trial: bench_sum_rules.py counts how
often the estimates hold."""

_OF_THE_REST = 0.03


@dataclass(frozen=True, eq=False)
class SumRules(ByValue):
    """Lyapunov averages by period; all arrays have the shape of p, and NaN where there is no orbit.

    Attributes
    ----------
    p : ndarray of int
        2, 3, .. to the highest period.
    level : ndarray of int
        Number of exact means that the weights are held to, 0 to 3: none, ln K, with ln D, with c2.
    lambda_l : ndarray
        lambda of a leg.
    lambda_l_below : ndarray
        lambda of a leg with weights held to one mean less.
    lambda_l_error : ndarray
        An estimate of its error: twice the range of lambda_l in the last five periods, three hundredths
        of what is left to the orbits (the averages settle at values that are off by up to 1.5 % of it),
        and the error of the exact means. Where a mean had to be let go, three times that range and
        three times the most that the last mean has changed lambda_l by in the last four periods. While
        there are not so many periods, and at most, the width of `ExactMeans.bounds`.
    lambda_d_sum_rule, lambda_c_sum_rule, lambda_d_sum_rule_error, lambda_c_sum_rule_error : ndarray
        The same per bounce and per length.
    """

    p: Integers
    level: Integers
    lambda_l: Floats
    lambda_l_below: Floats
    lambda_l_error: Floats
    lambda_d_sum_rule: Floats
    lambda_d_sum_rule_error: Floats
    lambda_c_sum_rule: Floats
    lambda_c_sum_rule_error: Floats


def sum_rules(rows: ClassRows, sums: LegSums, highest: int, means: ExactMeans) -> SumRules:
    """Return the averages of all orbits up to period p, p = 2 .. highest.

    Parameters
    ----------
    rows : ClassRows
        All classes of orbits up to the highest period.
    sums : LegSums
        The sums along them, in the same order.
    highest : int
    means : ExactMeans
        Those of the same stadium.
    """
    return averages_by_period(tilts_by_period(rows, sums, highest, means)[0], means)


def tilts_by_period(
    rows: ClassRows, sums: LegSums, highest: int, means: ExactMeans
) -> tuple[Floats, dict[int, Floats]]:
    """Return what the tilts of each period come to, and the last tilts.

    Returns
    -------
    ndarray, shape (3, highest - 1)
        The highest level, sum w (lambda - ln D - ln K - c2) / sum w m there, and at the level below.
    dict of int to ndarray
        By level, mu of the sums less their means, not scaled.
    """
    order = np.argsort(rows.period, kind="stable")
    upto = np.searchsorted(rows.period[order], np.arange(2, highest + 1), side="right")
    terms = np.stack([sums.log_drift, sums.log_kick, sums.coupling])[:, order]
    legs = sums.legs[order]
    held = terms - np.array([mean.value for mean in means.terms])[:, None] * legs
    scale = legs.mean() if len(legs) else 1.0
    held /= scale
    log_weights = np.log(rows.size[order]) - rows.lyapunov[order]
    rest = rows.lyapunov[order] - terms.sum(axis=0)
    found = np.full((3, highest - 1), np.nan)
    known: dict[int, Tilt] = {}
    for place, count in enumerate(upto):
        if count:
            known = _highest_two(log_weights[:count], held[:, :count], known)
            values = [
                float(one.weights @ rest[:count] / (one.weights @ legs[:count])) for one in known.values()
            ]
            found[:, place] = max(known), values[-1], values[-2] if len(values) > 1 else np.nan
    return found, {level: one.mu / scale for level, one in known.items()}


def _highest_two(log_weights: Floats, held: Floats, before: dict[int, Tilt]) -> dict[int, Tilt]:
    """Return the tilts of the highest level that exists and of the one below, by rising level.

    With more orbits the convex hull grows: what existed with those of lower periods, exists, and may
    only be lost in rounding, where the terms hardly scatter (at huge a).
    """
    tilts: dict[int, Tilt] = {}
    for level in range(min(before, default=0), len(HELD)):
        start = before[level].mu if level in before else None
        found = tilt(log_weights, held[list(HELD[level])], start)
        if found is None:
            break
        tilts[level] = found
    if not tilts:
        return _highest_two(log_weights, held, {})
    return {level: tilts[level] for level in sorted(tilts)[-2:]}


def averages_by_period(found: Floats, means: ExactMeans) -> SumRules:
    """Return the averages that tilts come to (`tilts_by_period`), with estimates of their errors."""
    rest, below = found[1:]
    level = np.where(np.isfinite(rest), found[0], 0).astype(np.int64)
    growth = means.growth
    error = _CHANGES[level] * _recent(np.abs(rest - below), _LOOK_BACK, np.max)
    error += _RANGES[level] * _recent(rest, _LOOK_BACK + 1, np.ptp)
    error += _OF_THE_REST * np.abs(rest) + growth.error
    low, high = means.bounds
    error = np.fmin(error, high - low)
    return SumRules(
        p=np.arange(2, len(rest) + 2),
        level=level,
        lambda_l=growth.value + rest,
        lambda_l_below=growth.value + below,
        lambda_l_error=error,
        lambda_d_sum_rule=(growth.value + rest) * means.per_bounce,
        lambda_d_sum_rule_error=error * means.per_bounce,
        lambda_c_sum_rule=(growth.value + rest) * means.per_length,
        lambda_c_sum_rule_error=error * means.per_length,
    )


def _recent(values: Floats, count: int, function: Callable[[Floats], float]) -> Floats:
    """Return a function of each value and those before it, so many in all; NaN where there are fewer."""
    parts = [values[max(0, end - count) : end] for end in range(1, len(values) + 1)]
    return np.array([function(part) if len(part) == count else np.nan for part in parts])
