"""Count orbits by period at any a, and count the rows of a subset by the values, or bins, of columns."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.arrays import Floats, Integers
from orbitdb.equality import ByValue
from orbitdb.numerals import exact
from orbitdb.store.fills import Fill
from orbitdb.store.lives import counts_at
from orbitdb.store.moment import Moment
from orbitdb.store.selection import Selection, SelectionError, written_periods
from orbitdb.store.where import never

if TYPE_CHECKING:
    from orbitdb.orbits.exponents import Tally

_COUNTS = ("n_t", "n_c", "classes", "boundary", "unresolved")
"""The columns of a fill that make up a `Tally`, in the order of its fields."""

_FINEST = 1e-12
"""Smallest relative width of a bin; edges closer than this would look the same in print."""

_DECADES = 1000.0
"""Bins are logarithmic if the largest value is more than this many times the smallest."""

Key = tuple[Any, ...]


@dataclass(frozen=True)
class Counted:
    """Counts of the words and orbits of complete periods at a given a.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    known : dict of int to Tally
        Counts by period, including periods that are not chosen but are needed in sums over divisors.
    chosen : tuple of int
        The chosen periods in `known`.
    from_births, from_sweeps : tuple of int
        The chosen periods that are not filled and were counted from births, or by a sweep, instead.
    """

    a: float
    known: Mapping[int, "Tally"]
    chosen: tuple[int, ...]
    from_births: tuple[int, ...]
    from_sweeps: tuple[int, ...] = ()

    @property
    def without_rows(self) -> tuple[int, ...]:
        """The chosen periods that were counted without a fill."""
        return self.from_sweeps + self.from_births

    def cycles(self) -> Integers:
        """Return the number of orbits of each period from 0 to the highest chosen one; 0 where unknown."""
        found = np.zeros(max(self.chosen) + 1, dtype=np.int64)
        for p in self.chosen:
            found[p] = self.known[p].n_c
        return found

    def describe(self) -> str | None:
        """Return a line that says how the periods without a fill were counted; None if there are none."""
        sources = {"counted by a sweep, without stored rows": self.from_sweeps,
                   "counted from births, without a fill": self.from_births}  # fmt: skip
        told = [
            f"{written_periods(periods)} at a = {exact(self.a)}: {source}"
            for source, periods in sources.items()
            if periods
        ]
        return "; ".join(told) or None


def count(moment: Moment, selection: Selection) -> Counted:
    """Return the counts of each chosen period: from its fill, else from a sweep, else from births."""
    known = {fill.p: _tally(fill) for fill in moment.fills(selection.a) if fill.whole}
    swept = {each.p: each.tally for each in moment.sweeps(selection.a) if each.whole and each.p not in known}
    known |= swept
    born = [each.p for each in moment.birth_fills() if each.whole and each.p not in known]
    wanted = [p for p in born if selection.includes(p)]
    chosen = sorted(p for p in (*known, *wanted) if selection.includes(p))
    needed = {p for p in born if any(multiple % p == 0 for multiple in chosen)}
    known.update((p, counts_at(moment.connection, selection.a, p)) for p in needed)
    return Counted(selection.a, dict(sorted(known.items())), tuple(chosen), tuple(wanted),
                   tuple(p for p in swept if selection.includes(p)))  # fmt: skip


def need_periods_alone(chosen: Selection) -> None:
    """Raise `SelectionError` if a selection has criteria other than ``a`` and periods."""
    if chosen != Selection(chosen.a, chosen.periods):
        raise SelectionError(
            "a table counts all words of its periods: give only a and p, or count the rows of a subset "
            "with select(...).table()"
        )


def _tally(fill: Fill) -> "Tally":
    """Return the counts of a filled period."""
    from orbitdb.orbits.exponents import Tally

    return Tally(*(getattr(fill, name) for name in _COUNTS))


@dataclass(frozen=True, eq=False)
class Histogram(ByValue):
    """Numbers of rows in the bins of a column.

    Attributes
    ----------
    edges : ndarray, shape (bins + 1,)
        In ascending order; a value on an edge belongs to the bin above it.
    counts : ndarray of int64, shape (bins,)
    without : int
        Number of rows without a value.
    logarithmic : bool
        Whether the bins have equal widths in the logarithm of the value.
    """

    edges: Floats
    counts: Integers
    without: int
    logarithmic: bool


def tally(
    moment: Moment,
    selection: Selection,
    columns: Sequence[str],
    cancelled: Callable[[], bool] = never,
) -> dict[Key, int]:
    """Count the rows of a subset for each combination of values of some columns of the view ``class``."""
    chosen = moment.choose(selection, columns=columns, cancelled=cancelled)
    found: Counter[Key] = Counter()
    values = (chosen.values[name].tolist() for name in columns)
    for *key, count in zip(*values, chosen.counts.tolist(), strict=True):
        found[tuple(None if value != value else value for value in key)] += count
    return dict(found)


def histogram(
    moment: Moment,
    selection: Selection,
    column: str,
    bins: int,
    cancelled: Callable[[], bool] = never,
) -> Histogram | None:
    """Count the rows of a subset in at most `bins` bins of a numeric column.

    The edges are round numbers, or evenly spaced in the logarithm. Return None if no row has a value.
    """
    chosen = moment.choose(selection, columns=(column,), cancelled=cancelled)
    values, rows = chosen.values[column].astype(np.float64), chosen.counts.astype(np.int64)
    known = ~np.isnan(values)
    if not known.any():
        return None
    low, high = float(values[known].min()), float(values[known].max())
    logarithmic = low > 0 and high > _DECADES * low
    edges = np.geomspace(low, high, bins + 1) if logarithmic else _round_edges(low, high, bins)
    places = np.searchsorted(edges[1:-1], values[known], side="right")
    counts = np.zeros(len(edges) - 1, dtype=np.int64)
    np.add.at(counts, places, rows[known])
    return Histogram(edges, counts, int(rows[~known].sum()), logarithmic)


def _round_edges(low: float, high: float, bins: int) -> Floats:
    """Return successive multiples of a round number, such as 0.2 or 2.5, from below `low` to above `high`."""
    width = max((high - low) / bins, _FINEST * abs(high))
    decade = 10.0 ** math.floor(math.log10(width)) if low < high else 1.0
    steps = (decade * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0))
    return next(edges for edges in (_multiples(low, high, step) for step in steps) if len(edges) <= bins + 1)


def _multiples(low: float, high: float, step: float) -> Floats:
    first, last = math.floor(low / step), math.floor(high / step) + 1
    # 3 * 0.1 is an ulp above the 0.3 that a user would type
    return np.asarray([float(f"{step * n:.15g}") for n in range(first, last + 1)])


def marginal(counts: Mapping[Key, int], place: int) -> dict[Any, int]:
    """Return the counts of a `tally` by the values of its column `place` alone."""
    found: Counter[Any] = Counter()
    for key, count in counts.items():
        found[key[place]] += count
    return dict(found)
