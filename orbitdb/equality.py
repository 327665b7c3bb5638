"""Equality of frozen dataclasses that hold arrays, of which NumPy's ``==`` makes arrays and no truth."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np


class ByValue:
    """Base of dataclasses, made with ``eq=False``, that are equal if all their fields are, bit by bit.

    NaN equals NaN in the same place, and 0.0 differs from -0.0 in an array. Equal objects have equal
    hashes, so their arrays are not to be changed once they are keys.
    """

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return bool(_key(_values(self)) == _key(_values(other)))

    def __hash__(self) -> int:
        return hash(_key(_values(self)))


def _values(record: Any) -> list[Any]:
    """Return the fields of a dataclass."""
    return [getattr(record, field.name) for field in fields(record)]


def _key(value: Any) -> Any:
    """Return something with a hash that is equal for equal values."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f":
            one_nan = np.where(np.isnan(value), np.nan, value)  # which has many bit patterns
            return "f", value.shape, one_nan.astype(float).tobytes()
        return value.dtype.kind, value.shape, tuple(value.ravel().tolist())
    if isinstance(value, Mapping):
        return frozenset((name, _key(item)) for name, item in value.items())
    if isinstance(value, list | tuple):
        return tuple(map(_key, value))
    return None if isinstance(value, float) and value != value else value
