"""Reads a chosen subset from a catalogue as arrays: `Catalogue.select`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.answers.completeness import filled_periods, lacking_births, unfilled
from orbitdb.answers.subset import ARRAY_FIELDS, Subset
from orbitdb.arrays import Floats, Integers, Values
from orbitdb.columns import kind_of
from orbitdb.store.connection import Connection, path_of
from orbitdb.store.select import COORDINATES, Words, blocks_of, count
from orbitdb.store.selection import Selection


def read_subset(
    connection: Connection,
    selection: Selection,
    order: str,
    coordinates: bool,
    by_class: bool = False,
    limit: int | None = None,
) -> Subset:
    """Return the chosen words as arrays (`Catalogue.select`)."""
    chosen, number = Words(selection, order, by_class), count(connection, selection, by_class)
    names = [*ARRAY_FIELDS, *([COORDINATES] if coordinates else [])]
    parts: dict[str, list[Any]] = {name: [] for name in names}
    for block in blocks_of(connection, chosen, names, last=limit):
        for name, values in zip(names, block, strict=True):  # arrays at once, because lists take more memory
            parts[name].append(values if name == COORDINATES else _array(name, values))
    places = _flat(parts.pop(COORDINATES), parts["p"]) if coordinates else None
    arrays: dict[str, Any] = {
        name: np.concatenate(parts.pop(name) or [_array(name, [])]) for name in [*parts]
    }
    missing = unfilled(connection, selection) or lacking_births(connection, selection)
    total = None if limit is None or limit >= number else number
    filled = tuple(filled_periods(connection, selection))
    return Subset(selection, **arrays, coordinates=places, unfilled=missing, filled=filled, total=total,
                  path=path_of(connection), by_class=by_class)  # fmt: skip


def _array(name: str, values: Values) -> NDArray[Any]:
    """Return a column as an array, with '', 0 or NaN for missing text, integers or numbers."""
    if kind_of(name) == "number":
        return np.asarray(values, np.float64)
    if kind_of(name) == "integer":
        return np.array([value or 0 for value in values], np.int64)
    return np.array([value or "" for value in values], np.dtypes.StringDType())


def _flat(parts: list[Any], periods: list[Integers]) -> Floats:
    """Join the coordinates of all rows; a row without coordinates gets NaN for each bounce."""
    pairs = (pair for part in zip(parts, periods, strict=True) for pair in zip(*part, strict=True))
    return np.concatenate([np.zeros(0), *(np.full(p, np.nan) if x is None else x for x, p in pairs)])
