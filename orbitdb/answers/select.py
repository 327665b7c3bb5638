"""Read a chosen subset as arrays: `Catalogue.select`."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.answers.completeness import lacking_births, unfilled
from orbitdb.answers.subset import OF_ROWS, Subset
from orbitdb.arrays import Floats
from orbitdb.columns import kind_of
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.rows import COORDINATES
from orbitdb.store.reading.soundness import unsound


def read_subset(moment: Moment, selection: Selection, order: str, coordinates: bool) -> Subset:
    """Return the chosen words as arrays (`Catalogue.select`)."""
    names = ["code", *OF_ROWS[1:], *([COORDINATES] if coordinates else [])]
    blocks = list(moment.blocks(moment.choose(selection, order), names))
    missing = unfilled(moment, selection) or lacking_births(moment, selection)
    filled = tuple(each.p for each in moment.fills(selection.a) if each.whole and selection.includes(each.p))
    columns: dict[str, list[Any]] = {}
    for place, name in enumerate(names):
        columns[name] = [block[place] for block in blocks]
    places = _flat(columns.pop(COORDINATES), columns["p"]) if coordinates else None
    arrays: dict[str, Any] = {name: _array(name, parts) for name, parts in columns.items()}
    return Subset(
        selection, arrays.pop("code"), coordinates=places, unfilled=missing, filled=filled, **arrays
    )


def _array(name: str, parts: list[Any]) -> NDArray[Any]:
    """Join the parts of a column into an array, with '', 0 or NaN for missing text, integers or numbers."""
    if kind_of(name) == "number":
        values: Floats = np.concatenate([np.zeros(0), *parts])
        if np.isinf(values).any():
            raise unsound("infinite numbers in the column", name)
        return values
    plain = [value for part in parts for value in part]
    if kind_of(name) == "integer":
        return np.array([value or 0 for value in plain], np.int64)
    return np.array([value or "" for value in plain], np.dtypes.StringDType())


def _flat(parts: list[Any], periods: list[list[int]]) -> Floats:
    """Join the coordinates of all rows; a row without coordinates gets NaN for each bounce."""
    pairs = (pair for part in zip(parts, periods, strict=True) for pair in zip(*part, strict=True))
    return np.concatenate([np.zeros(0), *(np.full(p, np.nan) if x is None else x for x, p in pairs)])
