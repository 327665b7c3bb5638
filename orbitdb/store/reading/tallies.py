"""Tallies: how many rows of a subset have each value of some columns, or lie in each bin of one.

They are counted by class where that is the same, as in `orbitdb.store.reading.class_first`, and always in
SQL: no row is read.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.conditions import Columns, answering, conditions_of
from orbitdb.store.asking.confinement import Patience, never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_first import goes_by_class, orders_with_pruned, ragged_periods
from orbitdb.store.reading.class_view import class_view
from orbitdb.store.reading.reader import Reader

_DECADES = 1000.0
"""Bins are even in the logarithm where the greatest value is so many times the least."""

Key = tuple[Any, ...]
Keys = Callable[[Columns], list[sa.ColumnElement[Any]]]


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
    reader: Reader,
    selection: Selection,
    columns: Sequence[str],
    cancelled: Callable[[], bool] = never,
) -> dict[Key, int]:
    """Return how many rows of a subset have each combination of values of some columns.

    Parameters
    ----------
    reader : Reader
    selection : Selection
    columns : sequence of str
        Of the view ``catalogue``.
    cancelled : callable, optional
        Asked now and then, while there is a free expression, whether to stop.

    Raises
    ------
    SelectionError
        If ``where`` is refused, or stopped.
    """
    with reader.reading() as connection:
        asked = _Asked(connection, selection, cancelled, columns)
        found = asked.count(lambda known: [known[name] for name in columns])
        pruned = {"status": Status.GEOMETRIC.value}
        for p, count in asked.pruned():
            found[tuple((pruned | {"p": p}).get(name) for name in columns)] += count
    return dict(found)


def histogram(
    reader: Reader,
    selection: Selection,
    column: str,
    bins: int,
    cancelled: Callable[[], bool] = never,
) -> Histogram | None:
    """Return how many rows of a subset lie in each bin of a column of numbers that orbits or classes have.

    Parameters
    ----------
    reader, selection, cancelled : optional
        As in `tally`.
    column : str
    bins : int
        At most; their edges are round numbers, or else even in the logarithm.

    Returns
    -------
    Histogram or None
        None if no row has a value.
    """
    with reader.reading() as connection:
        asked = _Asked(connection, selection, cancelled, (column,))
        low, high = asked.ends(column)
        if low is None or high is None:
            return None
        logarithmic = low > 0 and high > _DECADES * low
        edges = _even_edges(low, high, bins) if logarithmic else _round_edges(low, high, bins)
        inner = [float(edge) for edge in edges[1:-1]]
        found = asked.count(lambda known: [_bin(known[column], inner)])
        without = found.pop((None,), 0) + sum(count for _, count in asked.pruned())
    counts = np.zeros(len(edges) - 1, dtype=np.int64)
    for (place,), count in found.items():
        counts[place] += count
    return Histogram(edges, counts, without, logarithmic)


def _even_edges(low: float, high: float, bins: int) -> NDArray[np.float64]:
    """Return edges between two values that are even in the logarithm."""
    return np.asarray(np.geomspace(low, high, bins + 1), dtype=np.float64)


def _round_edges(low: float, high: float, bins: int) -> NDArray[np.float64]:
    """Return multiples of a round number, such as 0.2 or 2.5, around two values, at most some bins apart."""
    decade = 10.0 ** math.floor(math.log10((high - low) / bins)) if low < high else 1.0
    steps = (decade * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0))
    return next(edges for edges in (_multiples(low, high, step) for step in steps) if len(edges) <= bins + 1)


def _multiples(low: float, high: float, step: float) -> NDArray[np.float64]:
    first, last = math.floor(low / step), math.floor(high / step) + 1
    # 3 * 0.1 is an ulp above 0.3, which somebody who asks for the same bin types
    return np.asarray([float(f"{step * n:.15g}") for n in range(first, last + 1)])


def _bin(value: sa.ColumnElement[Any], inner: Sequence[float]) -> sa.ColumnElement[Any]:
    """Return the number of the bin of a value: how many inner edges are not above it."""
    passed: sa.ColumnElement[Any] = sa.case((value.is_(None), None), else_=0)
    for edge in inner:
        passed = passed + sa.cast(value >= edge, sa.Integer)
    return passed


class _Asked:
    """One question about a subset, in its parts: classes, words of ragged periods, pruned words."""

    def __init__(
        self,
        connection: sa.Connection,
        selection: Selection,
        cancelled: Callable[[], bool],
        columns: Sequence[str],
    ) -> None:
        self._connection, self._selection = connection, selection
        self._patience = Patience(cancelled=cancelled)
        self._classes = class_view().c
        known = all(name in self._classes for name in columns)
        self._by_class = known and goes_by_class(connection, selection)
        self._ragged = ragged_periods(connection) if self._by_class else []

    @contextmanager
    def _answering(self) -> Iterator[sa.Connection]:
        with answering(self._connection, self._selection, self._patience):
            yield self._connection

    def _parts(self) -> Iterator[tuple[Columns, sa.ColumnElement[int], list[Any]]]:
        """Yield what to count from: columns, the number of rows of each, and conditions."""
        if not self._by_class:
            yield view.c, sa.func.count(), conditions_of(self._selection)
            return
        whole = [*conditions_of(self._selection, self._classes), self._classes.p.not_in(self._ragged)]
        yield self._classes, sa.func.sum(self._classes.class_size), whole
        if self._ragged:
            yield view.c, sa.func.count(), [*conditions_of(self._selection), view.c.p.in_(self._ragged)]

    def count(self, keys: Keys) -> Counter[Key]:
        """Return how many rows have each key, but for what `pruned` tells."""
        found: Counter[Key] = Counter()
        for columns, number, conditions in self._parts():
            labelled = [key.label(f"key{place}") for place, key in enumerate(keys(columns))]
            query = sa.select(*labelled, number).where(*conditions)
            query = query.group_by(*(sa.literal_column(key.name) for key in labelled))
            with self._answering() as connection:
                for *key, count in connection.execute(query):
                    found[tuple(key)] += count
        return found

    def ends(self, column: str) -> tuple[float | None, float | None]:
        """Return the least and the greatest value of a column."""
        found: list[float] = []
        for columns, _, conditions in self._parts():
            query = sa.select(sa.func.min(columns[column]), sa.func.max(columns[column])).where(*conditions)
            with self._answering() as connection:
                found += [end for end in connection.execute(query).one() if end is not None]
        return min(found, default=None), max(found, default=None)

    def pruned(self) -> Iterator[tuple[int, int]]:
        """Yield the periods of geometrically pruned words that are not counted yet, and how many."""
        if not self._by_class:
            return
        pruned = sa.select(sa.func.count()).where(sequence.c.rules.is_not(None))
        for p in orders_with_pruned(self._connection, self._selection):
            count = 0 if p in self._ragged else self._connection.scalar(pruned.where(sequence.c.p == p))
            if count:
                yield p, count


def marginal(counts: Mapping[Key, int], place: int) -> dict[Any, int]:
    """Return how many rows have each value of one of the columns of a `tally`."""
    found: Counter[Any] = Counter()
    for key, count in counts.items():
        found[key[place]] += count
    return dict(found)
