"""Rows as blocks of columns: what files of columns are written from, many rows at a time."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

_ROWS = 20_000


@dataclass(frozen=True, eq=False)
class Lists:
    """A column of lists.

    Attributes
    ----------
    values : ndarray
        All of them, one list behind the other.
    lengths : ndarray of int64, shape (N,)
    present : ndarray of bool, shape (N,)
        Which rows have a list; one of length 0 is a list, too.
    """

    values: NDArray[Any]
    lengths: NDArray[np.int64]
    present: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.lengths)


Column = NDArray[np.float64] | Lists | Sequence[Any]
"""Numbers, NaN for none; lists; or any plain values, None for none."""


@dataclass(frozen=True, eq=False)
class ColumnBlock:
    """Some rows, column by column.

    Attributes
    ----------
    columns : sequence of Column
        Equally long.
    """

    columns: Sequence[Column]

    def __len__(self) -> int:
        return len(self.columns[0])

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Yield the rows as plain values, None for none."""
        return zip(*map(plain, self.columns), strict=True)


def plain(column: Column) -> Sequence[Any]:
    """Return a column as plain values, None for none."""
    if isinstance(column, Lists):
        parts = np.split(column.values, np.cumsum(column.lengths)[:-1])
        pairs = zip(parts, column.present.tolist(), strict=True)
        return [part.tolist() if present else None for part, present in pairs]
    if isinstance(column, np.ndarray):
        return [None if value != value else value for value in column.tolist()]
    return column


def in_columns(rows: Iterable[Any], size: int = _ROWS) -> Iterator[Sequence[Column]]:
    """Yield the columns of rows, so many at a time; rows may be blocks of columns, all of them or none."""
    rows = iter(rows)
    first = next(rows, None)
    if first is None:
        return
    rows = chain([first], rows)
    if isinstance(first, ColumnBlock):
        yield from (block.columns for block in rows)
        return
    while block := list(islice(rows, size)):
        yield list(zip(*block, strict=True))
