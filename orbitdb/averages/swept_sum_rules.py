"""Sum rules of periods of which there are only sums.

The orbits up to `EXACT` are found anew in a second; of each longer period there are the coefficients of
`orbitdb.averages.tilt_moments` around the tilts of all lower periods. So what a sweep adds up over a period
depends on what it has added up before.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.exact_means import ExactMeans, exact_means
from orbitdb.averages.fixed_points import ClassRows
from orbitdb.averages.leg_sums import LegSums, terms_of_legs
from orbitdb.averages.sum_rules import SumRules, averages_by_period, tilts_by_period
from orbitdb.averages.tilt_moments import TiltedOrbits, TiltedSums, TiltMoments
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.sums import Exponents, exponents
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import least_words
from orbitdb.symbols.symmetry import SIZES

Floats = NDArray[np.float64]
Moments = Mapping[int, TiltMoments]
"""By level (`orbitdb.averages.sum_rules`)."""

EXACT = 13
"""The highest period whose orbits are found anew."""

_MOST_MISSING = 1e-4
"""Share of the weights that the series may lack: it moves the averages by a hundredth of that."""

_SMALL = 1e-20
_MOST_STEPS = 60
_LEAST_FRACTION = 1e-6
_ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class Beginning(ByValue):
    """The orbits up to some period, and their tilts.

    Attributes
    ----------
    orbits : TiltedOrbits
        With all three quantities.
    found : ndarray, shape (3, last - 1)
        What the tilts of each period come to (`orbitdb.averages.sum_rules.tilts_by_period`).
    tilts : dict of int to ndarray
        Those of the last period, by level.
    """

    orbits: TiltedOrbits
    found: Floats
    tilts: dict[int, Floats]


def tilted_orbits(parts: Iterable[tuple[NDArray[np.int64], Exponents]], means: ExactMeans) -> TiltedOrbits:
    """Return what tilts need of orbits.

    Parameters
    ----------
    parts : iterable of (ndarray of int, Exponents)
        The sizes of the classes of the orbits, and the orbits.
    means : ExactMeans
    """
    columns = [np.zeros((6, 0))]
    columns += [np.stack([size, part.lyapunov, *terms_of_legs(part.slopes)]) for size, part in parts]
    size, lyapunov, legs, *terms = np.concatenate(columns, axis=1)
    held = np.stack([term - mean.value * legs for term, mean in zip(terms, means.terms, strict=True)])
    return TiltedOrbits(np.log(size) - lyapunov, held, lyapunov - np.sum(terms, axis=0), legs)


@lru_cache(maxsize=4)
def beginning(a: float, last: int) -> Beginning:
    """Find the orbits up to a period and their tilts."""
    means, parts, periods = exact_means(a), [], []
    for p in range(2, last + 1):
        for words in least_words(Span.whole(p)):
            for part in exponents(words.codes, p, Stadium(a)):
                parts.append((SIZES[words.stabiliser[part.orbits]], part))
                periods.append(np.full(len(part.orbits), p))
    size, period = np.concatenate([size for size, _ in parts]), np.concatenate(periods)
    length, lyapunov = (
        np.concatenate([getattr(part, name) for _, part in parts]) for name in ("length", "lyapunov")
    )
    sums = np.concatenate([terms_of_legs(part.slopes) for _, part in parts], axis=1)
    rows = ClassRows(period, size, length, lyapunov, np.zeros(len(size), dtype=np.bool_))
    found, tilts = tilts_by_period(rows, LegSums(*sums), last, means)
    return Beginning(tilted_orbits(parts, means), found, tilts)


def next_tilts(a: float, moments: Sequence[Moments]) -> dict[int, Floats]:
    """Return the tilts, by level, of all orbits up to the highest period of which there are moments.

    Parameters
    ----------
    a : float
    moments : sequence of Moments
        Of the periods `EXACT` + 1, ... without a gap.
    """
    return _tilts(beginning(a, EXACT), moments)[1]


def sum_rules_beyond(a: float, moments: Sequence[Moments], highest: int) -> SumRules:
    """Return the averages of all orbits up to period p, p = 2 .. highest.

    NaN beyond the highest period of which there are moments; the parameters are those of `next_tilts`. The
    levels are those that the orbits up to `EXACT` have.
    """
    last = min(highest, EXACT)
    start = beginning(a, last)
    found = np.full((3, highest - 1), np.nan)
    found[:, : last - 1] = start.found
    beyond = _tilts(start, moments[: highest - last])[0]
    found[:, last - 1 : last - 1 + beyond.shape[1]] = beyond
    return averages_by_period(found, exact_means(a))


def _tilts(start: Beginning, moments: Sequence[Moments]) -> tuple[Floats, dict[int, Floats]]:
    """Return what the tilts of the periods behind `EXACT` come to, and the last ones."""
    known, found = dict(start.tilts), np.full((3, len(moments)), np.nan)
    for place in range(len(moments)):
        values = {}
        for level in sorted(known):
            if any(level not in each for each in moments[: place + 1]):
                del known[level]
                continue
            parts: list[TiltedOrbits | TiltMoments] = [start.orbits.held(level)]
            parts += [each[level] for each in moments[: place + 1]]
            solved = _solved(parts, known[level])
            if solved is None:
                del known[level]
                continue
            known[level], sums = solved
            values[level] = sums.rest / sums.legs
        if values:
            found[:2, place] = max(values), values[max(values)]
            found[2, place] = values.get(max(values) - 1, np.nan)
    return found, known


def _solved(parts: Sequence[TiltedOrbits | TiltMoments], start: Floats) -> tuple[Floats, TiltedSums] | None:
    """Return the tilt with which all quantities have the mean 0, and the sums there; None if none is found.

    Newton's method with step halving, as in `orbitdb.averages.tilted`.
    """
    mu, here = start, _total(parts, start)
    for _ in range(_MOST_STEPS):
        slope = here.slope / here.total
        try:
            step = -np.linalg.solve(here.spread / here.total - np.outer(slope, slope), slope)
        except np.linalg.LinAlgError:
            return None
        drop, fraction = -float(slope @ step), 1.0
        if drop < _SMALL:
            return (mu, here) if here.missing < _MOST_MISSING * here.total else None
        while True:
            there = _total(parts, mu + fraction * step)
            least = here.total * (1 - fraction * drop / 4 + _ROUNDING)
            if 0 < there.total <= least or fraction < _LEAST_FRACTION:
                break
            fraction /= 2
        mu, here = mu + fraction * step, there
    return None


def _total(parts: Sequence[TiltedOrbits | TiltMoments], mu: Floats) -> TiltedSums:
    return TiltedSums(*(sum(of) for of in zip(*(part.at(mu) for part in parts), strict=True)))
