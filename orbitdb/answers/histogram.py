"""How often each value of a column occurs in a subset: `Catalogue.count` and `Catalogue.histogram`."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from orbitdb.answers.completeness import Coverage
from orbitdb.answers.results import Result
from orbitdb.arrays import Floats, Integers
from orbitdb.columns import IN_CATALOGUE
from orbitdb.criteria import unknown_column
from orbitdb.display import columns_of
from orbitdb.errors import SelectionError, check_int
from orbitdb.selection import Selection
from orbitdb.store.select import WORDS, Words, arrays_of, counts_by
from orbitdb.store.sqlite import Connection

_NAMES = ("a", "cycle", "representative", "code", "element", "area")

COUNTABLE = tuple(column.name for column in IN_CATALOGUE if column.name not in _NAMES)
"""The columns to count by: those that all words of a class share, without those that name a class."""

MEASURED = tuple(
    column.name for column in IN_CATALOGUE if column.name in COUNTABLE and column.kind == "number"
)
"""The columns to count in bins: those with real numbers."""

_FINEST = 1e-12
"""Smallest relative width of a bin; edges closer than this would look the same in print."""

_DECADES = 1000.0
"""Bins are logarithmic if the largest value is more than this many times the smallest."""


class Histogram(NamedTuple):
    """Numbers of words in the bins of a column; a value on an edge is in the bin above.

    Attributes
    ----------
    edges : ndarray, shape (bins + 1,)
        The edges of the bins, ascending, in the unit of the column; without any value, there are no bins.
    counts : ndarray, shape (bins,)
        The number of words in each bin.
    without : int
        The number of words without a value.
    logarithmic : bool
        Whether the bins have equal widths in the logarithm; otherwise the edges are round numbers.
    """

    edges: Floats
    counts: Integers
    without: int
    logarithmic: bool


def count_by(connection: Connection, selection: Selection, by: Sequence[str]) -> Result:
    """Count the words and classes of a subset by the values of some columns (`Catalogue.count`)."""
    for name in by:
        if name == "a":
            raise SelectionError("column 'a': it comes first if you ask for several a, such as `a='all'`")
        if name not in COUNTABLE:
            raise unknown_column(name, COUNTABLE)
    if twice := [name for place, name in enumerate(by) if name in by[:place]]:
        raise SelectionError(f"column {twice[0]!r} is named twice")
    rows = [row for row in counts_by(connection, selection, by) if row[-1]]
    rows.sort(key=lambda row: [(value is None, value) for value in row[:-2]])  # missing values come last
    coverage = Coverage(connection, selection)
    notes = filter(None, [*coverage.gaps(by), "" if rows else coverage.nothing()])
    columns = columns_of((*by, "words", "classes"), rows)
    return Result(selection, columns, (selection.describe(),) if rows else (), tuple(notes))


def histogram(connection: Connection, selection: Selection, column: str, bins: int) -> Histogram:
    """Count the words of a subset in bins of a column (`Catalogue.histogram`)."""
    if column not in MEASURED:
        raise unknown_column(column, MEASURED)
    most = check_int("bins", bins)
    read = arrays_of(connection, Words(selection, by_class=True), (column, WORDS))
    values, rows = read[column], read[WORDS]
    present = ~np.isnan(values)
    if not present.any():
        return Histogram(np.zeros(0), np.zeros(0, np.int64), int(rows.sum()), False)
    low, high = float(values[present].min()), float(values[present].max())
    logarithmic = low > 0 and high > _DECADES * low
    # a single bin is two joined, because values of both signs are never between multiples of a round number
    edges = np.geomspace(low, high, most + 1) if logarithmic else _round_edges(low, high, max(most, 2))
    edges = edges[[0, -1]] if most == 1 else edges
    # the outer edges are rounded, so a value may lie an ulp outside
    counts, _ = np.histogram(np.clip(values[present], edges[0], edges[-1]), edges, weights=rows[present])
    return Histogram(edges, counts, int(rows[~present].sum()), logarithmic)


def _round_edges(low: float, high: float, bins: int) -> Floats:
    """Return successive multiples of a round number, such as 0.2 or 2.5, from below `low` to above `high`."""
    width = max((high - low) / bins, _FINEST * abs(high))
    decade = 10.0 ** math.floor(math.log10(width)) if low < high else 1.0
    steps = (decade * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0))
    spans = ((step, math.floor(low / step), math.floor(high / step) + 1) for step in steps)
    step, first, last = next(span for span in spans if span[2] - span[1] <= bins)
    # 3 * 0.1 is an ulp above the 0.3 that a user would type
    return np.asarray([float(f"{step * n:.15g}") for n in range(first, last + 1)])
