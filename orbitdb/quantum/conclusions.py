"""What follows for a list: the number of its first level, and where levels are missing or spurious.

The number of levels missing between two neighbours is certain enough if it has a probability of 0.9. Where it
is less certain, because one may be missing here or there, neighbouring gaps are taken together. In a crowded
list (`orbitdb.quantum.level_paths.CROWDED`) no gap can be named: a range has as many levels as the orbits
resolve, and what is known is how many more are missing than spurious in it.
"""

import math
from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.judging import Judgement
from orbitdb.quantum.level_paths import BACK, CROWDED

_CERTAIN = 0.9
_OF_GAPS, _OF_GAPS_MIXED, _OF_FIRST, _LEAST = 0.75, 0.5, 0.9, 0.5
"""Powers of the probabilities of the model, which is a little too certain: for named gaps, and those of
lists of all parities; for the first number of a crowded list, where the search is less exact, at most and at
least."""
_BY_MISSING, _BY_HIDDEN, _SOME = 2.0, 0.15, 0.005
"""By how much the power for the first number is less: times the rate of missing levels; and if missing and
spurious levels are both more frequent than the third number, because they hide each other. All are from
tests/benchmarks/bench_levels.py."""
_MOST, _MOST_MIXED = 0.999, 0.98
"""Largest probability that is stated, because 300 paths tell no more; and for gaps in lists of all parities,
because in tests the model was surer of 123 such gaps and right about 113."""
_NEGLIGIBLE = 0.005
_ACTIVE = 0.5
"""Probability that levels of a crowded list are missing or spurious here, above which a row says so."""
_LARGE = 6
"""Ranges in a crowded list are cut beyond this many times the number of levels that the orbits resolve."""
_TRIED = 100
"""Number of paths whose missing levels are compared."""

_Value = TypeVar("_Value", bound=Hashable)


class LevelGap(NamedTuple):
    """Two neighbours of the list, None at its ends, and the probability of each number of missing levels."""

    after: float | None
    before: float | None
    missing: dict[str, float]


class Gap(NamedTuple):
    """A place in a list where levels are missing or spurious.

    Attributes
    ----------
    after, before : float or None
        The levels of the list on either side, in 1/radius; None at the beginning or end of the list.
    levels : int
        Number of levels of the list between the two: it is in doubt next to which of them levels are missing,
        or which of them are spurious.
    missing : int
        Number of missing levels between the two; in a crowded list, less the spurious ones.
    spurious : int or None
        Number of spurious or duplicate levels between the two; None in a crowded list, where it is not known.
    probability : float
        Probability that both numbers are right.
    gaps : list of LevelGap
        The single gaps between the two; none in a crowded list.
    """

    after: float | None
    before: float | None
    levels: int
    missing: int
    spurious: int | None
    probability: float
    gaps: list[LevelGap]

    def place(self) -> str:
        """Describe where the gap is, for example ``12.65 to 12.99``."""
        digits = 4 if self.spurious is not None else 6
        if self.before is None:
            where = f"after {self.after:.{digits}g}"
        elif self.after is None:
            where = f"below {self.before:.{digits}g}"
        else:
            where = f"{self.after:.{digits}g} to {self.before:.{digits}g}"
        return where if self.spurious is not None else f"{self.counts()} among the {self.levels} {where}"

    def counts(self) -> str:
        """Return how many levels are missing and spurious, for example ``+2, -1``."""
        return ", ".join(f"{count:+d}" for count in (self.missing, -(self.spurious or 0)) if count)


@dataclass(frozen=True)
class Conclusions:
    """The most probable numbers of a list.

    Attributes
    ----------
    gaps : list of Gap
        Where levels are missing or spurious.
    places : ndarray
        Places of the missing levels, in 1/radius.
    number : ndarray of int, shape (n,)
        True number of each level; 0 for a spurious level.
    probability : ndarray, shape (n,)
        Probability of this number.
    first, first_probability : int, float
        True number of the first true level, and its probability.
    missing, spurious : ndarray of int, shape (paths,)
        Number of missing and of spurious levels in each of the paths.
    whole : float
        Probability that the list neither lacks a level nor has a spurious one.
    """

    gaps: list[Gap]
    places: Floats
    number: Integers
    probability: Floats
    first: int
    first_probability: float
    missing: Integers
    spurious: Integers
    whole: float


class _Paths:
    """The drawn paths: missing levels before each level, spurious levels, true numbers; shape (n, paths)."""

    def __init__(self, judged: Judgement) -> None:
        steps, drawn = judged.steps, judged.posterior.drawn
        missing = steps.missing.astype(np.int16)[drawn]  # small integers: there are many paths
        self.k, self.spurious = judged.compared.k, missing < 0
        self.drawn, self.low = drawn, steps.low
        self.number = np.cumsum(missing + np.int16(1), axis=0, dtype=np.int32)
        self.number += judged.posterior.first.astype(np.int32)
        self.number[self.spurious] = 0
        self.missing = np.maximum(missing, 0, out=missing)

    def __len__(self) -> int:
        return self.missing.shape[1]

    def end(self, i: int) -> float | None:
        """Return the i-th level; None for -1 and n, beyond the ends."""
        return float(self.k[i]) if 0 <= i < len(self.k) else None

    def places(self, rows: slice, paths: Sequence[int]) -> Floats:
        """Return the places of the levels missing before the levels in `rows`, one row a path.

        The paths must have the same number of missing levels there.
        """
        m = self.missing[rows, paths].T.ravel()
        below = self.low[self.drawn[rows, paths]].T.ravel()
        above = np.tile(self.k[rows], len(paths))
        j = np.arange(m.sum()) - np.repeat(np.cumsum(m) - m, m) + 1
        found = np.repeat(below, m) + np.repeat((above - below) / (m + 1), m) * j
        return np.asarray(found.reshape(len(paths), -1))


class _Range(NamedTuple):
    """A range of gaps: what is missing and spurious on its most probable path, and what is said of it."""

    rows: slice
    between: slice
    missing: Integers
    spurious: NDArray[np.bool_]
    places: Floats
    gap: Gap | None


def conclude(judged: Judgement) -> Conclusions:
    """Return the places where levels are missing or spurious, and the most probable numbers."""
    paths, n = _Paths(judged), len(judged.compared.k)
    crowded = judged.compared.crowded
    clear = int(np.searchsorted(crowded, CROWDED))  # the density increases with k
    mixed = judged.compared.error.mixed
    most, power = (_MOST_MIXED, _OF_GAPS_MIXED) if mixed else (_MOST, _OF_GAPS)
    found = [_range(paths, low, high, most, power, named=True) for low, high in _doubtful(judged, clear)]
    found += [_range(paths, low, high, most, 1.0, named=False) for low, high in _cells(paths, crowded, clear)]
    missing, spurious = np.zeros(n, np.int64), np.zeros(n, bool)
    for each in found:
        missing[each.rows], spurious[each.between] = each.missing, each.spurious
    lost, added = paths.missing.sum(axis=0), paths.spurious.sum(axis=0)
    hidden = min(lost.mean(), added.mean()) / n > _SOME
    firsts = _tempered(Counter(_firsts(paths.number).tolist()), _MOST, _power(judged, hidden))
    first = next(iter(firsts))
    number = np.where(spurious, 0, np.arange(n) + np.cumsum(missing) - np.cumsum(spurious))
    true = np.flatnonzero(~spurious)
    if len(true):
        number[true] += first - number[true[0]]
    whole = ~(paths.missing.any(axis=0) | paths.spurious.any(axis=0))
    return Conclusions(
        gaps=[each.gap for each in found if each.gap is not None],
        places=np.concatenate([*(each.places for each in found), np.empty(0)]),
        number=number,
        probability=np.minimum((paths.number == number[:, None]).mean(axis=1), _MOST),
        first=first,
        first_probability=firsts[first],
        missing=lost,
        spurious=added,
        whole=min(float(whole.mean()), _MOST),
    )


def _range(paths: _Paths, low: int, high: int, most: float, power: float, named: bool) -> _Range:
    """Return what is said about the gaps from `low` to `high` - 1; gap i is the one before level i.

    If they are not `named`, only how many more levels are missing than spurious counts.
    """
    rows = slice(low, min(high, len(paths.k)))
    between = slice(low, high - 1)  # the levels between the two ends
    counts = np.stack([paths.missing[rows].sum(axis=0), paths.spurious[between].sum(axis=0)])
    pairs, net = list(zip(*counts.tolist(), strict=True)), (counts[0] - counts[1]).tolist()
    chances = _tempered(Counter(pairs if named else net), most, power)
    likeliest, probability = next(iter(chances.items()))
    own = [path for path, value in enumerate(pairs if named else net) if value == likeliest]
    same = [path for path in own if pairs[path] == pairs[own[0]]][:_TRIED]
    places = paths.places(rows, same)
    best = same[int(np.abs(places - np.median(places, axis=0)).sum(axis=1).argmin())]
    ends = paths.end(low - 1), paths.end(high - 1), high - 1 - low
    gap = None
    if named and any(pairs[best]):
        single = [_single(paths, i, most, power) for i in range(low, rows.stop)]
        gap = Gap(*ends, pairs[best][0], pairs[best][1], probability, single)
    elif not named and net[best]:
        gap = Gap(*ends, net[best], None, probability, [])
    return _Range(
        rows,
        between,
        paths.missing[rows, best],
        paths.spurious[between, best],
        np.median(places, axis=0),
        gap,
    )


def _power(judged: Judgement, hidden: bool) -> float:
    """Return the power of the probabilities of the first number; some levels may be `hidden` by others."""
    if judged.compared.crowded[0] < CROWDED:
        return 1.0
    less = _BY_MISSING * judged.rates.missing + _BY_HIDDEN * hidden
    return max(_OF_FIRST - less, _LEAST)


def _tempered(counts: "Counter[_Value]", most: float, power: float) -> dict[_Value, float]:
    """Return the probabilities of values from their counts, the most probable first."""
    total = sum(count**power for count in counts.values())
    return {value: min(count**power / total, most) for value, count in counts.most_common()}


def _doubtful(judged: Judgement, stop: int) -> list[tuple[int, int]]:
    """Return ranges of gaps that are not certain, and single gaps in which levels are certainly missing.

    Gap i is the one before level i; the last one, n, is after the list. Only gaps before level `stop` count,
    unless this is n.
    """
    steps, probability = judged.steps, judged.posterior.probability
    n = len(judged.compared.k)
    certain = np.append((steps.missing >= 0) & (steps.back == 1) & (probability >= _CERTAIN), False)
    sure, none = np.zeros(n + 1, bool), np.zeros(n + 1, bool)
    rows = np.flatnonzero(certain)
    sure[steps.level[rows]], none[steps.level[rows]] = True, steps.missing[rows] == 0
    last = slice(int(steps.start[BACK * (n - 1)]), None)
    sure[n] = none[n] = probability[last][steps.missing[last] >= 0].sum() >= _CERTAIN
    end = n + 1 if stop == n else stop
    found, i = [], 0
    while i < end:
        high = i + 1
        while not sure[i] and high < end and not sure[high]:
            high += 1
        if not none[i]:
            found.append((i, high))
        i = high
    return found


def _cells(paths: _Paths, crowded: Floats, start: int) -> list[tuple[int, int]]:
    """Return the ranges of gaps, from level `start` on, in which levels are probably missing or spurious.

    Where the orbits resolve only groups of n levels, they cannot tell in which of n gaps a level is missing,
    so no single gap is probable. Where levels are missing everywhere, ranges end where fewest are missing.
    """
    n = len(crowded)
    if start == n:
        return []
    size = math.ceil(crowded[start])
    changed = np.zeros((n + 1, len(paths)), np.uint8)
    changed[start:n] = (paths.missing[start:] > 0) | paths.spurious[start:]
    near = maximum_filter1d(changed, 2 * (size // 2) + 1, axis=0, mode="constant")
    active, share = near.mean(axis=1) > _ACTIVE, changed.mean(axis=1)
    active[:start] = False
    edges = np.flatnonzero(np.diff(np.concatenate([[False], active, [False]]).astype(np.int8)))
    found: list[tuple[int, int]] = []
    for low, high in edges.reshape(-1, 2).tolist():
        low, high = max(low - size // 4, found[-1][1] if found else start), min(high + size // 4, n)
        while high - low > _LARGE * size:
            middle = slice(low + _LARGE // 2 * size, low + (_LARGE - 1) * size)
            cut = middle.start + int(share[middle].argmin())
            found.append((low, cut))
            low = cut
        if high > low:
            found.append((low, high))
    return found


def _single(paths: _Paths, i: int, most: float, power: float) -> LevelGap:
    """Return the probabilities of the numbers of levels missing before level i."""
    chances = _tempered(Counter(paths.missing[i].tolist()), most, power)
    likely = {str(m): round(p, 3) for m, p in sorted(chances.items()) if p >= _NEGLIGIBLE}
    return LevelGap(paths.end(i - 1), paths.end(i), likely)


def _firsts(number: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the number of the first true level on each path."""
    return number[(number > 0).argmax(axis=0), np.arange(number.shape[1])]
