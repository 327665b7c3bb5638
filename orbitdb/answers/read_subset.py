"""Reads a chosen subset from a catalogue as arrays: `Catalogue.select`."""

from dataclasses import replace
from typing import Any

import numpy as np

from orbitdb.answers.completeness import Coverage
from orbitdb.answers.subset import ARRAY_FIELDS, Subset
from orbitdb.selection import Selection
from orbitdb.store.select import WORDS, Words, arrays_of, count
from orbitdb.store.sqlite import Connection, path_of


def read_subset(
    connection: Connection,
    selection: Selection,
    order: str,
    coordinates: bool,
    by_class: bool = False,
    limit: int | None = None,
) -> Subset:
    """Return the chosen words as arrays (`Catalogue.select`)."""
    names = [name for name in ARRAY_FIELDS if name != WORDS or by_class]
    arrays: dict[str, Any] = arrays_of(connection, Words(selection, order, by_class), names, limit)
    size = len(arrays.pop("id"))
    arrays.setdefault(WORDS, np.ones(size, np.int64))
    number = size if limit is None else count(connection, selection, by_class)
    coverage, total = Coverage(connection, selection), None if size == number else number
    unborn = coverage.without_births()
    missing = coverage.unfilled() or coverage.lacking_births()
    subset = Subset(
        selection,
        **arrays,
        unfilled=missing,
        notes=tuple(coverage.gaps(ARRAY_FIELDS, order)),
        filled=tuple(p for p in coverage.filled if p not in unborn),
        total=total,
        path=path_of(connection),
        by_class=by_class,
        cut=total is not None,
    )
    return replace(subset, coordinates=subset.read_coordinates(connection)) if coordinates else subset
