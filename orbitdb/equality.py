"""Dataclasses with arrays, compared by value, because ``==`` on arrays returns an array, not a bool."""

import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray


class ByValue:
    """Base of dataclasses with ``eq=False`` that are equal if all fields are equal bit by bit.

    Fields with ``compare=False`` do not count. NaN equals NaN at the same position, but 0.0 in an array
    differs from -0.0. The hash depends on the
    arrays, so do not change them while the object is a key of a dictionary.
    """

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return bool(_key(_compared(self)) == _key(_compared(other)))

    def __hash__(self) -> int:
        return hash(_key(_compared(self)))

    def __repr__(self) -> str:
        """Return one line with the fields, or shapes of arrays; for dataclasses with ``repr=False``."""
        named = zip((field.name for field in fields(self)), _values(self), strict=True)  # type: ignore[arg-type]
        return f"{type(self).__name__}({', '.join(f'{name}={_brief(value)}' for name, value in named)})"


class Batch(ByValue):
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


def _brief(value: Any) -> str:
    return f"<array of shape {value.shape}>" if isinstance(value, np.ndarray) else reprlib.repr(value)


def _values(record: Any) -> list[Any]:
    """Return the values of a dataclass's fields."""
    return [getattr(record, field.name) for field in fields(record)]


def _compared(record: Any) -> list[Any]:
    return [getattr(record, field.name) for field in fields(record) if field.compare]


def _key(value: Any) -> Any:
    """Return a hashable key that is equal for equal values."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f":
            one_nan = np.where(np.isnan(value), np.nan, value)  # NaN has many bit patterns
            return "f", value.shape, one_nan.astype(float).tobytes()
        return value.dtype.kind, value.shape, tuple(value.ravel().tolist())
    if isinstance(value, Mapping):
        return frozenset((name, _key(item)) for name, item in value.items())
    if isinstance(value, list | tuple):
        return tuple(map(_key, value))
    return None if isinstance(value, float) and value != value else value
