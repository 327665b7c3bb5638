"""What follows for a list: the number of its first level, and where levels are missing or spurious.

The number of levels missing between two neighbours is certain enough if it has a probability of 0.9. Where it
is less certain, because one may be missing here or there, neighbouring gaps are taken together.
"""

from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np

from orbitdb.arrays import Floats, Integers
from orbitdb.quantum.judging import Judgement
from orbitdb.quantum.level_paths import BACK

_CERTAIN = 0.9
_TEMPER = 0.75
"""Power of the probabilities: those of the model are a little too certain."""
_MOST, _MOST_MIXED = 0.999, 0.98
"""Largest probability that is stated, because 300 paths tell no more; and for gaps in lists of all parities,
because in tests the model was surer of 123 such gaps and right about 113."""
_NEGLIGIBLE = 0.005
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
    missing, spurious : int
        Number of missing levels, and of spurious or duplicate levels, between the two.
    probability : float
        Probability that both numbers are right.
    gaps : list of LevelGap
        The single gaps between the two.
    """

    after: float | None
    before: float | None
    levels: int
    missing: int
    spurious: int
    probability: float
    gaps: list[LevelGap]

    def place(self) -> str:
        """Describe where the gap is, for example ``12.65 to 12.99``."""
        if self.before is None:
            return f"after {self.after:.4g}"
        return f"below {self.before:.4g}" if self.after is None else f"{self.after:.4g} to {self.before:.4g}"


@dataclass(frozen=True)
class Ranges:
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
    missing : ndarray of int, shape (paths,)
        Number of missing levels in each of the paths.
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
    whole: float


class _Paths:
    """The drawn paths: missing levels before each level, spurious levels, true numbers; shape (n, paths)."""

    def __init__(self, judged: Judgement) -> None:
        steps, drawn = judged.steps, judged.posterior.drawn
        missing = steps.missing.astype(np.int32)[drawn]
        self.k, self.spurious, self.missing = judged.compared.k, missing < 0, np.maximum(missing, 0)
        self.low = steps.low[drawn]
        net = judged.posterior.first + np.cumsum(missing, axis=0, dtype=np.int32)
        place = np.arange(1, len(self.k) + 1, dtype=np.int32)[:, None]
        self.number = np.where(self.spurious, 0, place + net)

    def end(self, i: int) -> float | None:
        """Return the i-th level; None for -1 and n, beyond the ends."""
        return float(self.k[i]) if 0 <= i < len(self.k) else None

    def places(self, low: int, high: int, paths: list[int]) -> Floats:
        """Return the places of the levels missing before the levels from `low` to `high`, one row a path.

        The paths must have the same number of missing levels there.
        """
        m = self.missing[low:high, paths].T.ravel()
        below = self.low[low:high, paths].T.ravel()
        above = np.tile(self.k[low:high], len(paths))
        j = np.arange(m.sum()) - np.repeat(np.cumsum(m) - m, m) + 1
        found = np.repeat(below, m) + np.repeat((above - below) / (m + 1), m) * j
        return np.asarray(found.reshape(len(paths), -1))


def ranges(judged: Judgement) -> Ranges:
    """Return the places where levels are missing or spurious, and the most probable numbers."""
    paths, n = _Paths(judged), len(judged.compared.k)
    most = _MOST_MIXED if judged.compared.mixed else _MOST
    every = np.arange(n)
    missing, spurious = np.zeros(n, np.int64), np.zeros(n, bool)
    gaps, found = [], []
    for low, high in _doubtful(judged):
        # the gap before level i belongs to level i; levels from low to high - 2 lie between the two ends
        rows = slice(low, min(high, n))
        between = slice(low, high - 1)
        totals = list(
            zip(
                paths.missing[rows].sum(axis=0).tolist(),
                paths.spurious[between].sum(axis=0).tolist(),
                strict=True,
            )
        )
        chances = _tempered(Counter(totals), most)
        total = next(iter(chances))
        with_it = [path for path, each in enumerate(totals) if each == total]
        places = paths.places(low, min(high, n), with_it[:_TRIED])
        off = np.abs(places - np.median(places, axis=0)).sum(axis=1)
        best = with_it[int(off.argmin())]
        missing[rows], spurious[between] = paths.missing[rows, best], paths.spurious[between, best]
        if any(total):
            found.append(np.median(places, axis=0))
            single = [_single(paths, i, most) for i in range(low, min(high, n))]
            gaps.append(
                Gap(paths.end(low - 1), paths.end(high - 1), high - 1 - low, *total, chances[total], single)
            )
    firsts = _tempered(Counter(_firsts(paths.number).tolist()), _MOST, 1.0)
    first = next(iter(firsts))
    true = np.flatnonzero(~spurious)
    number = np.where(spurious, 0, every + np.cumsum(missing) - np.cumsum(spurious))
    if len(true):
        number[true] += first - number[true[0]]
    whole = ~(paths.missing.any(axis=0) | paths.spurious.any(axis=0))
    return Ranges(
        gaps,
        np.concatenate([*found, np.empty(0)]),
        number,
        np.minimum((paths.number == number[:, None]).mean(axis=1), _MOST),
        first,
        firsts[first],
        paths.missing.sum(axis=0),
        min(float(whole.mean()), _MOST),
    )


def _tempered(counts: "Counter[_Value]", most: float, power: float = _TEMPER) -> dict[_Value, float]:
    """Return the probabilities of values from their counts, the most probable first."""
    total = sum(count**power for count in counts.values())
    return {value: min(count**power / total, most) for value, count in counts.most_common()}


def _doubtful(judged: Judgement) -> list[tuple[int, int]]:
    """Return ranges of gaps that are not certain, and single gaps in which levels are certainly missing.

    Gap i is the one before level i; the last one, n, is after the list.
    """
    steps, probability = judged.steps, judged.posterior.probability
    n = len(judged.compared.k)
    certain = np.append((steps.missing >= 0) & (steps.back == 1) & (probability >= _CERTAIN), False)
    sure, none = np.zeros(n + 1, bool), np.zeros(n + 1, bool)
    rows = np.flatnonzero(certain)
    sure[steps.level[rows]], none[steps.level[rows]] = True, steps.missing[rows] == 0
    last = slice(int(steps.start[BACK * (n - 1)]), None)
    sure[n] = none[n] = probability[last][steps.missing[last] >= 0].sum() >= _CERTAIN
    found, i = [], 0
    while i <= n:
        high = i + 1
        while not sure[i] and high <= n and not sure[high]:
            high += 1
        if not none[i]:
            found.append((i, high))
        i = high
    return found


def _single(paths: _Paths, i: int, most: float) -> LevelGap:
    """Return the probabilities of the numbers of levels missing before level i."""
    chances = _tempered(Counter(paths.missing[i].tolist()), most)
    likely = {str(m): round(p, 3) for m, p in sorted(chances.items()) if p >= _NEGLIGIBLE}
    return LevelGap(paths.end(i - 1), paths.end(i), likely)


def _firsts(number: Integers) -> Integers:
    """Return the number of the first true level on each path."""
    return np.asarray(number[(number > 0).argmax(axis=0), np.arange(number.shape[1])])
