"""Averages from zeta functions truncated by stability: all pseudo-cycles up to a cut, without listing them.

A pseudo-cycle is a product of different cycles. Its term in 1/zeta is the product of the weights of these
cycles, with a factor -1 for each. If pruning makes an expansion by period irregular, it can be better to cut
by the multipliers (the expanding eigenvalues e^lambda) instead.

Sources: Dahlqvist and Russberg, J. Phys. A 24 (1991) 4763; Dettmann and Morriss, Phys. Rev. Lett. 78
(1997) 4201.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Batch, Floats, Indices, Integers
from orbitdb.averages.by_period import Weight
from orbitdb.averages.zeta import Expansion, ZetaAverages
from orbitdb.orbits.exponents import OrbitClasses

CHUNK = 1 << 16


@dataclass(frozen=True, eq=False)
class Factors(Batch):
    """The N different factors (1 - t z^p)^count of 1/zeta."""

    period: Integers  # shape (N,)
    count: Integers  # shape (N,)
    cost: Floats  # logarithm of the multiplier, to which the cut applies; positive, shape (N,)
    weight: Floats  # t, including its sign, shape (N,)
    observables: Floats  # the k quantities to be averaged, shape (k, N)

    def __len__(self) -> int:
        return len(self.period)


def expand_by_stability(
    factors: Factors,
    cut: float,
    highest: int | None = None,
    progress: Callable[[float], object] | None = None,
    chunk: int = CHUNK,
) -> Expansion:
    """Return the sum of all terms of 1/zeta whose product of multipliers is at most e^cut.

    Parameters
    ----------
    factors : Factors
    cut : float
        Maximum sum of the costs of a term (pseudo-cycle).
    highest : int, optional
        Maximum order of a term; unlimited by default.
    progress : callable, optional
        Called periodically with an estimate of the fraction of the work done, which never decreases.
    chunk : int, optional
        Approximate number of pseudo-cycles built at a time, which limits the memory.

    Notes
    -----
    The sum is exact and far cheaper than listing the pseudo-cycles. Factors are sorted by cost, and
    pseudo-cycles are built by adding ever costlier factors. The candidates for the last factor are
    consecutive among the sorted factors of a period, so prefix sums give their total. Only pseudo-cycles that
    could take another copy of their costliest factor within the cut are listed. Equal cycles are one factor
    with a count; its m-th power has a binomial coefficient.
    """
    factors = factors.rows(np.flatnonzero(factors.cost <= cut))
    factors = factors.rows(np.argsort(factors.cost, kind="stable"))
    degree = _degree(factors, cut, highest)
    sums = np.zeros((len(factors.observables) + 1, degree + 1))
    sums[0, 0] = 1.0
    ladders = list(_ladders(factors))
    done, stack = 0.0, [(1.0, _Terms.root(len(factors.observables)))]
    while stack:
        share, terms = stack.pop()
        room = terms.room(factors, cut)
        if len(terms) > 1 and room.sum() > chunk:
            stack += _shared(share, terms.halves(), factors, cut)
            continue
        for ladder in ladders:
            _add(sums, *ladder.products(terms, cut, degree))
        again = terms.repeated(factors, cut, degree)
        _add(sums, again.period, again.totals())
        parts = [part for part in (again, terms.followed(factors, room, degree)) if len(part)]
        stack += _shared(share, parts, factors, cut)
        if not parts:
            done += share
            if progress is not None:
                progress(done)
    return Expansion(sums[0], sums[1:])


def _shared(
    share: float, parts: "list[_Terms]", factors: Factors, cut: float
) -> "list[tuple[float, _Terms]]":
    """Divide a share of the work among parts, in proportion to how many terms can follow from each part."""
    sizes = [len(part) + int(part.room(factors, cut).sum()) for part in parts]
    return [(share * size / sum(sizes), part) for size, part in zip(sizes, parts, strict=True)]


def _degree(factors: Factors, cut: float, highest: int | None) -> int:
    """Return an order that no term within the cut exceeds, or `highest` if it is lower."""
    most = int((factors.period / factors.cost).max() * cut) if len(factors) else 0
    return most if highest is None else min(most, highest)


def _add(sums: Floats, period: Integers, totals: Floats) -> None:
    for row, values in zip(sums, totals, strict=True):
        row += np.bincount(period, values, minlength=len(row))


@dataclass(frozen=True, eq=False)
class _Terms(Batch):
    """Pseudo-cycles, each with its costliest factor, the multiplicity of that factor, and its products."""

    last: Integers
    times: Integers
    period: Integers
    cost: Floats
    value: Floats
    observables: Floats

    @classmethod
    def root(cls, k: int) -> "_Terms":
        """Return the empty pseudo-cycle."""
        zero = np.zeros(1, np.int64)
        return cls(zero - 1, zero, zero, np.zeros(1), np.ones(1), np.zeros((k, 1)))

    def __len__(self) -> int:
        return len(self.last)

    def totals(self) -> Floats:
        """Return the products of the weights and their derivatives in the exponents, shape (k + 1, N)."""
        return np.concatenate([self.value[None], self.value * self.observables])

    def halves(self) -> "list[_Terms]":
        middle = len(self) // 2
        return [self.rows(slice(None, middle)), self.rows(slice(middle, None))]

    def repeated(self, factors: Factors, cut: float, degree: int) -> "_Terms":
        """Multiply each term by its costliest factor once more, where the count and the cuts allow it."""
        begun = self.rows(self.last >= 0)
        fits = begun.times < factors.count[begun.last]
        fits &= begun.cost + factors.cost[begun.last] <= cut
        terms = begun.rows(fits & (begun.period + factors.period[begun.last] <= degree))
        more = (factors.count[terms.last] - terms.times) / (terms.times + 1)
        return terms._times(factors, terms.last, terms.times + 1, more)

    def room(self, factors: Factors, cut: float) -> Integers:
        """Return for each term the number of costlier factors that fit into the remaining cost twice."""
        end = np.searchsorted(factors.cost, (cut - self.cost) / 2, side="right")
        return np.maximum(end - self.last - 1, 0)

    def followed(self, factors: Factors, room: Integers, degree: int) -> "_Terms":
        """Multiply each term by each of the costlier factors counted in `room`, up to the order `degree`."""
        terms = self.rows(np.repeat(np.arange(len(self)), room))
        start = np.repeat(self.last + 1 - (room.cumsum() - room), room)
        new = start + np.arange(len(start))
        fits = terms.period + factors.period[new] <= degree
        terms, new = terms.rows(fits), new[fits]
        return terms._times(factors, new, np.ones_like(new), factors.count[new].astype(float))

    def _times(self, factors: Factors, new: Integers, times: Integers, multiple: Floats) -> "_Terms":
        return _Terms(
            new,
            times,
            self.period + factors.period[new],
            self.cost + factors.cost[new],
            -self.value * multiple * factors.weight[new],
            self.observables + factors.observables[:, new],
        )


@dataclass(frozen=True)
class _Ladder:
    """The factors of one period in ascending order of cost, with their prefix sums."""

    period: int
    place: Indices
    cost: Floats
    sums: Floats

    def products(self, terms: _Terms, cut: float, degree: int) -> tuple[Integers, Floats]:
        """Multiply terms by every costlier factor of this period, within the cut and the degree.

        Returns the periods of the products and the sums of their values, for the terms that have any.
        """
        start = np.searchsorted(self.place, terms.last, side="right")
        end = np.searchsorted(self.cost, cut - terms.cost, side="right")
        some = (end > start) & (terms.period + self.period <= degree)
        totals = self.sums[:, end[some]] - self.sums[:, start[some]]
        totals[1:] += terms.observables[:, some] * totals[0]
        return terms.period[some] + self.period, -terms.value[some] * totals


def _ladders(factors: Factors) -> Iterator[_Ladder]:
    for p in np.unique(factors.period):
        place = np.flatnonzero(factors.period == p)
        part = factors.rows(place)
        total = part.count * part.weight
        rungs = np.concatenate([total[None], total * part.observables]).cumsum(axis=1)
        yield _Ladder(int(p), place, part.cost, np.pad(rungs, ((0, 0), (1, 0))))


def lyapunov_by_stability(
    rows: OrbitClasses,
    cut: float,
    highest: int | None = None,
    weight: Weight = Weight.EXPONENTIAL,
    progress: Callable[[float], object] | None = None,
) -> ZetaAverages:
    """Return the Lyapunov averages from all pseudo-cycles whose multiplier is at most e^cut.

    Parameters
    ----------
    rows : OrbitClasses
        All orbits with lambda <= cut. If only the periods up to a certain period are complete, pass this
        period as `highest`, to leave out products that would cancel against missing orbits.
    cut : float
        Maximum sum of lambda over the orbits of a pseudo-cycle.
    highest : int, optional
        Maximum sum of the periods of a pseudo-cycle; unlimited by default.
    weight : Weight, optional
        With `Weight.DETERMINANT`, an orbit has the factors (1 - t e^(-k lambda) z^p)^(k+1),
        k = 0, 1, .., with multipliers e^((k+1) lambda). The cut applies to all of them.
    progress : callable, optional
        As for `expand_by_stability`.
    """
    levels = 1
    if weight is Weight.DETERMINANT and len(rows):
        levels = max(1, int(cut / rows.lyapunov.min()))
    series = expand_by_stability(_factors(rows, levels, cut), cut, highest, progress)
    kept = rows.rows((rows.lyapunov <= cut) & (rows.p <= (highest or rows.p)))
    if not len(kept):
        return ZetaAverages.none(f"(no orbit has a lambda of at most {cut:g})")
    return ZetaAverages.within(series, kept.ranges())


def largest_cut(rows: OrbitClasses, cut: float, most: int) -> float:
    """Return the cut, or a smaller cut of two digits if the determinant would have more than `most` factors.

    The number of factors of a class is the cut divided by its lambda, rounded down.
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


def _factors(rows: OrbitClasses, levels: int, cut: float) -> Factors:
    """Return the factors of the zeta function (one level) or of the Fredholm determinant (several)."""
    parts = [rows.rows((k + 1) * rows.lyapunov <= cut) for k in range(levels)]
    cost = [(k + 1) * part.lyapunov for k, part in enumerate(parts)]
    signs = [np.where(part.negative & (k % 2 == 1), -1.0, 1.0) for k, part in enumerate(parts)]
    return Factors(
        period=np.concatenate([part.p for part in parts]),
        count=np.concatenate([(k + 1) * part.words for k, part in enumerate(parts)]),
        cost=np.concatenate(cost),
        weight=np.concatenate(signs) * np.exp(-np.concatenate(cost)),
        observables=np.concatenate([np.stack([part.lyapunov, part.length]) for part in parts], axis=1),
    )
