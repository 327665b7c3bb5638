"""Tallies: how many rows of a subset have each value of some columns, or lie in each bin of a column."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.store.asking.confinement import never
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue

_FINEST = 1e-12
"""Least width of a bin, of the value: edges that are nearer are written alike."""

_DECADES = 1000.0
"""Bins are even in the logarithm where the greatest value is so many times the least."""

Key = tuple[Any, ...]


@dataclass(frozen=True, eq=False)
class Histogram(ByValue):
    """How many rows lie in each bin of a column.

    Attributes
    ----------
    edges : ndarray, shape (bins + 1,)
        In rising order; a value on an edge is in the bin above it.
    counts : ndarray of int64, shape (bins,)
    without : int
        Rows without a value.
    logarithmic : bool
        Whether the bins are even in the logarithm.
    """

    edges: NDArray[np.float64]
    counts: NDArray[np.int64]
    without: int
    logarithmic: bool


def tally(
    catalogue: "Catalogue",
    selection: Selection,
    columns: Sequence[str],
    cancelled: Callable[[], bool] = never,
) -> dict[Key, int]:
    """Return how many rows of a subset have each combination of values of some columns of the view ``class``.

    `cancelled` is asked now and then whether to stop.
    """
    chosen = catalogue.choose(selection, columns=columns, cancelled=cancelled)
    found: Counter[Key] = Counter()
    values = (chosen.values[name].tolist() for name in columns)
    for *key, count in zip(*values, chosen.counts.tolist(), strict=True):
        found[tuple(None if value != value else value for value in key)] += count
    return dict(found)


def histogram(
    catalogue: "Catalogue",
    selection: Selection,
    column: str,
    bins: int,
    cancelled: Callable[[], bool] = never,
) -> Histogram | None:
    """Return how many rows of a subset lie in each bin of a column of numbers of classes.

    The edges of the bins, of which there are `bins` at most, are round numbers, or else even in the
    logarithm. None if no row has a value.
    """
    chosen = catalogue.choose(selection, columns=(column,), cancelled=cancelled)
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


def _round_edges(low: float, high: float, bins: int) -> NDArray[np.float64]:
    """Return multiples of a round number, such as 0.2 or 2.5, around two values, at most some bins apart."""
    width = max((high - low) / bins, _FINEST * abs(high))
    decade = 10.0 ** math.floor(math.log10(width)) if low < high else 1.0
    steps = (decade * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0))
    return next(edges for edges in (_multiples(low, high, step) for step in steps) if len(edges) <= bins + 1)


def _multiples(low: float, high: float, step: float) -> NDArray[np.float64]:
    first, last = math.floor(low / step), math.floor(high / step) + 1
    # 3 * 0.1 is an ulp above 0.3, which somebody who asks for the same bin types
    return np.asarray([float(f"{step * n:.15g}") for n in range(first, last + 1)])


def marginal(counts: Mapping[Key, int], place: int) -> dict[Any, int]:
    """Return how many rows have each value of one of the columns of a `tally`."""
    found: Counter[Any] = Counter()
    for key, count in counts.items():
        found[key[place]] += count
    return dict(found)
