"""Number a list of levels with probabilities, and estimate how often levels are missing and spurious."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import entr

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.comparison import Comparison, Rates
from orbitdb.quantum.level_paths import BACK, CROWDED, Beam, Data, Posterior, Steps, backward, forward
from orbitdb.quantum.staircase_errors import deviations

FITS = 1.0
"""Largest misfit of a list that fits the stadium."""
_SHORTFALL, _SHORTFALL_MIXED, _SHORTFALL_CROWDED = 0.65, 1.6, 3.2
"""Shortfall of ln P for each grid point at which the misfit is 1: of lists of one parity, of all, and of
crowded lists, here over the root of the number of points. See tests/benchmarks/bench_levels.py."""
_EXPLAINED, _FREQUENT = 0.85, 0.22
"""Missing levels that are as frequent as the second number explain this share of the shortfall of a list that
does not fit, unless it is crowded; the limit is lower by it."""
_TYPICAL = 0.7
"""Variance of the deviations of lists that fit."""
PATHS = 300
"""Number of paths that are drawn."""
_PASSES = 3
_RARE = 0.003
"""Least rate of missing and of spurious levels of the first pass."""
_BEAM, _WIDE_BEAM = Beam(18.0, 300), Beam(120.0, 3000)
_LEAST_TAU2, _WIDER_FROM, HOPELESS = 1.5, 0.6, 2.0
"""Least variance of the deviations, and the misfits between which the beam is widened: a lost path is the
main cause of false certainty."""
_LONG = 3000
"""Number of levels of a list beyond which the search makes one pass and keeps fewer paths."""
_LONG_BEAM = Beam(12.0, 100)
_STRETCH = 500
"""Number of levels of a long list that give the rates for all of it."""
_LARGEST = 16.0
"""Largest square of a deviation that counts in their variance."""
_TRIED = 10
"""Number of drawn paths whose deviations are averaged."""


@dataclass(frozen=True)
class Judgement:
    """A list, the steps that were tried, their probabilities, and the rates and the misfit that follow."""

    compared: Comparison
    steps: Steps
    posterior: Posterior
    rates: Rates
    misfit: float


def judge(compared: Comparison) -> Judgement:
    """Number the levels; estimate the rates in at most three passes.

    The misfit is that of the first passes, with given rates: adapted to a list that does not belong to the
    stadium, they explain everything by missing and spurious levels.
    """
    if len(compared.k) > _LONG:
        return _judge_long(compared)
    judged, beam = _first(compared, _first_rates(compared))
    misfit = judged.misfit
    if misfit > FITS:
        return judged
    for _ in range(_PASSES - 1):
        before = judged.rates
        judged = _once(compared, before, beam, judged)
        if _close(before, judged.rates):
            break
    return replace(judged, misfit=misfit)


def _first(compared: Comparison, rates: Rates) -> tuple[Judgement, Beam]:
    """Return the judgement of the first passes, which keep the first rates, and the beam to go on with."""
    judged = _once(compared, rates, _BEAM)
    if not _WIDER_FROM < judged.misfit < HOPELESS:
        return judged, _BEAM
    judged = _once(compared, rates, _WIDE_BEAM)
    if not _WIDER_FROM < judged.misfit < HOPELESS:
        return judged, _WIDE_BEAM
    # it is now known where the places of missing levels are uncertain; new rates would explain anything
    again = _once(compared, rates, _WIDE_BEAM, judged)
    return replace(again, misfit=min(judged.misfit, again.misfit)), _WIDE_BEAM


def _first_rates(compared: Comparison) -> Rates:
    """Return rates that explain by how much the difference rises or falls along the list.

    In a crowded list, one more missing level and one more spurious one may hide each other.
    """
    n, d = len(compared.k), compared.difference
    rise = float(np.median(d[-4:-1]) - (np.median(d[1:4]) if compared.window else 0.0))
    hidden = float(compared.crowded[0] > CROWDED)
    missing = (max(rise, 0.0) + 1) / (n + max(rise, 0.0) + 1)
    spurious = (max(-rise, 0.0) + hidden) / (n + hidden)
    return Rates(min(max(missing, _RARE), 0.3), min(max(spurious, _RARE), 0.1), 1.5)


def _judge_long(compared: Comparison) -> Judgement:
    """Number the levels of a long list in one pass, with the rates of a stretch."""
    stretch = judge(compared.stretch((len(compared.k) - _STRETCH) // 2, _STRETCH))
    judged = _once(compared, stretch.rates, _LONG_BEAM)
    return replace(judged, misfit=max(judged.misfit, stretch.misfit))


def _once(compared: Comparison, rates: Rates, beam: Beam, before: Judgement | None = None) -> Judgement:
    """Number the levels with some rates; the result has the rates that follow.

    `before` knows more about where levels are missing.
    """
    steps = compared.steps(rates)
    known = None if before is None else _carried(before.steps, before.posterior.probability, steps)
    data = compared.data(steps, known, rates.tau2)
    passed = forward(data, steps, compared.firsts(compared.difference), beam)
    posterior = backward(passed, steps, PATHS, np.random.default_rng(1))
    new = _estimated(compared, steps, data, posterior)
    return Judgement(
        compared, steps, posterior, new, _misfit(compared, steps, data, posterior, passed.log_evidence, rates)
    )


def _misfit(
    compared: Comparison,
    steps: Steps,
    data: Data,
    posterior: Posterior,
    log_evidence: float,
    rates: Rates,
) -> float:
    """Return how much less probable the deviations and the missing levels are than expected; limit 1.

    In a list from the stadium, deviations have variance 1, and the log-probability of the missing levels,
    given the spacings, is about minus their entropy. In other lists it is lower.
    """
    n, points = len(data.k), len(data.grid)
    true = (steps.missing >= 0) & (steps.back == 1)
    of_spacings = np.full(n, -np.inf)
    np.logaddexp.at(of_spacings, steps.level[true], steps.log_weight[true])
    surprise = of_spacings[steps.level] - steps.log_weight
    entropy = float((np.exp(-surprise[true]) * surprise[true]).sum()) + n * float(entr(rates.spurious))
    expected = -float(data.white.log_scale.sum())
    expected -= points * (math.log(data.tau2) + _TYPICAL / data.tau2) / 2
    told = entropy - posterior.entropy  # information that the difference gives about the numbers missing
    shortfall = (expected + float(of_spacings.sum()) - log_evidence - told) / points
    if compared.crowded[0] > CROWDED:
        return max(0.0, shortfall) / min(_SHORTFALL_CROWDED / math.sqrt(points), 1.0)
    limit = _SHORTFALL_MIXED if compared.error.mixed else _SHORTFALL
    return max(0.0, shortfall) / (limit * (1 - _EXPLAINED * min(rates.missing / _FREQUENT, 1.0)))


def _close(one: Rates, other: Rates) -> bool:
    """Return whether another pass would change little."""
    return (
        abs(math.log(one.missing / other.missing)) < 0.2
        and abs(math.log(one.spurious / other.spurious)) < 1
        and abs(one.tau2 - other.tau2) < 0.1
    )


def _estimated(compared: Comparison, steps: Steps, data: Data, posterior: Posterior) -> Rates:
    """Return the rates that follow from the probabilities."""
    n, points = len(compared.k), len(compared.grid)
    within = np.where(steps.low > 0, np.clip(steps.missing, 0, 2), 0)
    missing = float(posterior.probability @ within)
    spurious = float(posterior.probability[steps.missing < 0].sum())
    paths = zip(posterior.drawn.T[:_TRIED], posterior.first[:_TRIED].tolist(), strict=True)
    off = [deviations(data.white, compared.residual(steps, drawn, first)) for drawn, first in paths]
    squares = float(np.minimum(np.square(off), _LARGEST).sum()) / len(off)
    return Rates(
        min(max((missing + 0.5) / (n + 25), 0.004), 0.3),
        min(max((spurious + 0.1) / (n + 50), 0.0005), 0.1),
        max((squares + 10) / (points + 10), _LEAST_TAU2),
    )


def _carried(old: Steps, probability: Floats, new: Steps) -> Floats:
    """Return the probabilities of old steps for the same steps in another table; 0 for those not in it."""

    def key(steps: Steps) -> Integers:
        most = max(int(old.missing.max()), int(new.missing.max())) + 2
        return (steps.level * BACK + steps.back - 1) * most + np.where(
            steps.missing < 0, most - 1, steps.missing
        )

    of_old, of_new = key(old), key(new)
    at = np.minimum(np.searchsorted(of_old, of_new), len(of_old) - 1)
    return np.where(of_old[at] == of_new, probability[at], 0.0)
