"""Fit the radius together with the numbers of the levels.

A wrong radius multiplies every level by the same factor, the scale. ln P of the list is computed on a grid of
scales, first for the lowest levels, which allow few scales, then for more. Results are averaged over all
scales, so that their probabilities and the error of the radius allow for the scales with another number.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.errors import InputError
from orbitdb.quantum.comparison import Comparison, Rates
from orbitdb.quantum.judging import FITS, HOPELESS, PATHS, Judgement, judge
from orbitdb.quantum.level_paths import Beam, Posterior, backward, forward

WIDEST, _AT_LIMIT = 0.005, 0.98
"""Largest relative change of the radius, if its error is not given, and the share that is at the limit."""
_SIGMAS = 4.0
"""Largest change in units of the standard error, if it is given."""
_STEP, _FINER = 0.2, 4
"""Step of the scale, in numbers of the last level, and the factor by which a round refines it in the end."""
_MOST = 520
"""Maximum number of scales on the grid for the whole list: 0.5 % up to level 5 000."""
_ROUNDS, _RESOLVED = 5, 0.4
"""Maximum number of rounds, and the probability of the best scale below which the grid is fine enough."""
_NONE = 1e-300
_FIRST, _MORE = 100, 4
"""Number of levels to which the first grid is fitted, and the factor by which it then grows."""
_BEAM, _COARSE = Beam(14.0, 150), Beam(8.0, 40)
"""Beams for the refined and the coarse grids."""
_LEAST, _LEAST_SHARE, _AVERAGED = 1e-4, 0.01, 50
"""Least probability of the scales that are refined; least probability, relative to the best, of those that
are averaged over, and how many."""

_FEW, _STEEP = 5, 0.3
"""Number of scales that look most likely, and the change of the difference that is taken for a step."""


class Fitted(NamedTuple):
    """A judgement averaged over scales; the best scale, its standard error, and whether it is at a limit."""

    judged: Judgement
    scale: float
    error: float
    at_limit: bool


def widest(error: float | None) -> float:
    """Return the largest relative change of a radius with a given relative standard error."""
    return WIDEST if error is None else _SIGMAS * error


def step_of(compared: Comparison) -> float:
    """Return the step of the scale for a list."""
    return _STEP / (2 * float(compared.smooth(compared.k[-1])))


def fit(compared: Comparison, error: float | None) -> Fitted:
    """Fit the scale of a list whose radius has a relative standard error; None for any within `WIDEST`.

    Raises
    ------
    InputError
        If the list is so high up that many radii would fit.
    """
    if 2 * widest(error) > _MOST * step_of(compared):
        known = _MOST * step_of(compared) / (2 * _SIGMAS)
        raise InputError(
            "so high up, too many radii fit to find the right one: for a fit, give its standard error, at "
            f"most {100 * known:.1g} % (--radius 0.2+-ERROR, in Python radius_error)"
        )
    scales, chance = _coarse_grid(compared, error)
    best, step = float(scales[chance.argmax()]), float(scales[1] - scales[0])
    for _ in range(0 if _misfit(compared, best) > HOPELESS else _ROUNDS):
        # the best scale may lie between two cells
        near = np.convolve(chance > _LEAST, np.ones(3), "same") > 0
        scales = (scales[near, None] + step * (np.arange(_FINER) / _FINER - 0.5 + 0.5 / _FINER)).ravel()
        step /= _FINER
        chance = _chances(compared, scales, error, _BEAM)
        best = _summit(scales, chance, step)
        if chance.max() < _RESOLVED:
            break
    judged = judge(compared.scaled(best))
    spread = math.sqrt(float(chance @ (scales - best) ** 2) + step**2 / 12)
    at_limit = error is None and abs(best - 1) > _AT_LIMIT * WIDEST
    if judged.misfit <= FITS:
        judged = _averaged(judged, best, scales, chance)
    return Fitted(judged, best, spread, at_limit)


def _coarse_grid(compared: Comparison, error: float | None) -> tuple[Floats, Floats]:
    """Return evenly spaced scales around the likely ones, and the probability of each.

    The grid is for the whole list, or for its lowest levels if neither they nor all of them fit.
    """
    n = len(compared.k)
    count = min(n, _FIRST)
    low, high = 1 - widest(error), 1 + widest(error)
    while True:
        part = compared if count == n else compared.part(count)
        scales = np.linspace(low, high, max(math.ceil((high - low) / step_of(part)), 2) + 1)
        chance = _chances(part, scales, error, _COARSE)
        best = float(scales[chance.argmax()])
        if count == n or (_misfit(part, best) > FITS and _misfit(compared, best) > HOPELESS):
            return scales, chance
        likely, step = scales[chance > _LEAST], float(scales[1] - scales[0])
        low, high = likely[0] - step, likely[-1] + step
        count = min(n, count * _MORE)


def _misfit(compared: Comparison, scale: float) -> float:
    return judge(compared.scaled(scale)).misfit


def _summit(scales: Floats, chance: Floats, step: float) -> float:
    """Return the scale at the top of the parabola through ln P at the best scale and at those beside it."""
    top = int(chance.argmax())
    if not 0 < top < len(scales) - 1:
        return float(scales[top])
    below, at, above = np.log(np.maximum(chance[top - 1 : top + 2], _NONE)).tolist()
    bend = below - 2 * at + above
    return float(scales[top]) + (step * (below - above) / (2 * bend) if bend else 0.0)


def _chances(compared: Comparison, scales: Floats, error: float | None, beam: Beam) -> Floats:
    """Return the probability of each scale."""
    rates = Rates()
    steps = compared.steps(rates)
    data = compared.data(steps, None, rates.tau2)
    logs = np.empty(len(scales))
    for n, scale in enumerate(scales.tolist()):
        difference = compared.excess(compared.grid, scale)
        passed = forward(data._replace(difference=difference), steps, compared.firsts(difference), beam)
        logs[n] = passed.log_evidence
    if error is not None:
        logs -= ((scales - 1) / error) ** 2 / 2
    chance = np.exp(logs - logs.max())
    return np.asarray(chance / chance.sum())


def _averaged(judged: Judgement, best: float, scales: Floats, chance: Floats) -> Judgement:
    """Return the judgement with the best scale, with numbers that are averaged over the other scales."""
    at_best, steps = judged.compared, judged.steps
    likeliest = np.sort(chance)[-_AVERAGED:][0]
    shares = np.where(chance >= max(likeliest, _LEAST_SHARE * chance.max()), chance, 0.0)
    data = at_best.data(steps, judged.posterior.probability, judged.rates.tau2)
    probability, drawn, first, rng = np.zeros(len(steps.level)), [], [], np.random.default_rng(1)
    for scale, share in zip(scales.tolist(), (shares / shares.sum()).tolist(), strict=True):
        if not share:
            continue
        difference = at_best.excess(at_best.grid, scale / best)
        passed = forward(data._replace(difference=difference), steps, at_best.firsts(difference), _BEAM)
        posterior = backward(passed, steps, max(1, round(PATHS * share)), rng)
        probability += share * posterior.probability
        drawn.append(posterior.drawn)
        first.append(posterior.first)
    both = Posterior(probability, np.concatenate(drawn, axis=1), np.concatenate(first))
    return replace(judged, posterior=both)


def likely_scales(compared: Comparison) -> Floats:
    """Return the few scales, within `WIDEST`, with which a list looks most like levels, the best first.

    With the right scale, the difference changes from one point of the grid to the next by less than the
    fluctuations of the levels, apart from missing ones.
    """
    step = step_of(compared)
    scales = 1 + step * np.arange(-math.floor(WIDEST / step), math.floor(WIDEST / step) + 1)
    rough = [_roughness(compared.excess(compared.grid, scale)) for scale in scales.tolist()]
    return np.asarray(scales[np.argsort(rough)[:_FEW]], np.float64)


def likely_grid_step(compared: Comparison) -> float | None:
    """Return the step h with which finite differences may have given a list; None if it does not look like
    it.

    On a square grid, the eigenvalue of a plane wave is k^2 - h^2 (k_x^4 + k_y^4) / 12, in the mean over
    directions k^2 - h^2 k^4 / 16: levels are too low by k^3 h^2 / 32. Their number then exceeds that from the
    orbits by as much times the density.
    """
    k = compared.grid
    shift = compared.density(k) * k**3 / 32
    square = -float(shift @ compared.difference) / float(shift @ shift)
    return math.sqrt(square) if square > 0 else None


def without_grid(k: Floats, step: float) -> Floats:
    """Return levels from finite differences with a step without its effect to second order."""
    return np.asarray(k * (1 + (step * k) ** 2 / 32))


def _roughness(difference: Floats) -> float:
    """Return the mean square change from one point to the next; a step of a missing level counts little."""
    return float((np.minimum(np.abs(np.diff(difference)), _STEEP) ** 2).mean())
