"""Compare dataclasses with arrays, because ``==`` on arrays returns an array."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np


def same(one: Any, other: Any) -> bool:
    """Tell whether two dataclasses have the same type and, bit by bit, the same fields; NaN equals NaN."""
    if is_dataclass(one):
        names = [field.name for field in fields(one) if field.compare]
        return type(one) is type(other) and all(same(getattr(one, n), getattr(other, n)) for n in names)
    if isinstance(one, np.ndarray):
        equal = bool(np.array_equal(one, other, equal_nan=one.dtype.kind == "f"))
        return equal and (one.dtype.kind != "f" or np.array_equal(np.signbit(one), np.signbit(other)))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)
