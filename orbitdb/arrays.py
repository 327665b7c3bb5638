"""The types of arrays that the whole package uses, and records of several arrays."""

from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Complexes = NDArray[np.complex128]
Marks = NDArray[np.bool_]
Indices = NDArray[np.intp]
"""Indices into other arrays."""

Words = NDArray[np.uint8]
"""Symbols 0 to 5 of words, one row per word."""

Masks = NDArray[np.uint8]
"""Sets of up to eight members, one bit per member."""

Texts = NDArray[Any]
"""Arrays of strings (`numpy.dtypes.StringDType`)."""

Values = Floats | Sequence[Any]
"""A column: numbers, with NaN for a missing one, or any values, with None for a missing one."""


class Batch:
    """Base of dataclasses with ``eq=False`` whose arrays have N entries along the last axis.

    Fields that are not arrays apply to all N entries.
    """

    def rows(self, chosen: slice | NDArray[Any]) -> Self:
        """Return a batch of some of the N entries, chosen by a slice, by indices or by a mask."""
        return type(self)(*(_chosen(value, chosen) for value in _values(self)))

    @classmethod
    def joined(cls, parts: Iterable[Self]) -> Self:
        """Join one or more batches into one; all their fields must be arrays."""
        columns = zip(*(_values(part) for part in parts), strict=True)
        return cls(*(np.concatenate(column, axis=-1) for column in columns))


def _chosen(value: Any, chosen: slice | NDArray[Any]) -> Any:
    if isinstance(value, Batch):
        return value.rows(chosen)
    if not isinstance(value, np.ndarray):
        return value
    if isinstance(chosen, slice):
        return value[..., chosen]
    return value.take(np.flatnonzero(chosen) if chosen.dtype == np.bool_ else chosen, axis=-1)


def _values(record: Any) -> list[Any]:
    """Return the values of a dataclass's fields."""
    return [getattr(record, field.name) for field in fields(record)]
