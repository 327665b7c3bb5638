"""Lyapunov averages from all pseudo-cycles up to a stability, whatever their periods."""

import math
from collections.abc import Callable

import numpy as np

from orbitdb.averages.fixed_points import ClassRows, Weight
from orbitdb.averages.pseudocycles import Factors, expand_by_stability
from orbitdb.averages.zeta import ZetaAverages


def lyapunov_by_stability(
    rows: ClassRows,
    cut: float,
    highest: int | None = None,
    weight: Weight = Weight.EXPONENTIAL,
    progress: Callable[[float], None] | None = None,
) -> ZetaAverages:
    """Return the Lyapunov averages with every pseudo-cycle of multiplier up to e^cut.

    Parameters
    ----------
    rows : ClassRows
        All orbits with lambda <= cut. Where longer ones are missing, the products of shorter ones
        that should cancel against them must go too: give the period up to which all are known.
    cut : float
        Largest sum of lambda over the orbits of a pseudo-cycle.
    highest : int, optional
        Largest sum of periods; by default any.
    weight : Weight, optional
        With `Weight.DETERMINANT`, an orbit has the factors (1 - t e^(-k lambda) z^p)^(k+1),
        k = 0, 1, .. with multipliers e^((k+1) lambda), all subject to the cut.
    progress : callable, optional
        Called now and then with the share that is done, as far as it can be guessed.
    """
    levels = 1
    if weight is Weight.DETERMINANT and len(rows):
        levels = max(1, int(cut / rows.lyapunov.min()))
    series = expand_by_stability(_factors(rows, levels, cut), cut, highest, progress)
    kept = rows.rows((rows.lyapunov <= cut) & (rows.period <= (highest or rows.period)))
    if not len(kept):
        return ZetaAverages.none(f"(no orbit has a lambda up to {cut:g})")
    return ZetaAverages.within(series, kept.ranges())


def largest_cut(rows: ClassRows, cut: float, most: int) -> float:
    """Return the cut, or a smaller one if the determinant has more than so many factors within it.

    The factors of a class are as many as its lambda goes into the cut. What is smaller has two digits.
    """

    def fits(value: float) -> bool:
        return float(np.floor(value / rows.lyapunov).sum()) <= most

    low, high = 0.0, cut
    if fits(high):
        return cut
    while high - low > 1e-3 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    unit = 10.0 ** (math.floor(math.log10(low)) - 1)
    return float(f"{math.floor(low / unit) * unit:.2g}")


def _factors(rows: ClassRows, levels: int, cut: float) -> Factors:
    """Return the factors of the zeta function (one level) or of the Fredholm determinant."""
    parts = [rows.rows((k + 1) * rows.lyapunov <= cut) for k in range(levels)]
    cost = [(k + 1) * part.lyapunov for k, part in enumerate(parts)]
    signs = [np.where(part.inverse & (k % 2 == 1), -1.0, 1.0) for k, part in enumerate(parts)]
    return Factors(
        period=np.concatenate([part.period for part in parts]),
        count=np.concatenate([(k + 1) * part.size for k, part in enumerate(parts)]),
        cost=np.concatenate(cost),
        weight=np.concatenate(signs) * np.exp(-np.concatenate(cost)),
        observables=np.concatenate([np.stack([part.lyapunov, part.length]) for part in parts], axis=1),
    )
