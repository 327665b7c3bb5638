"""A subset as a table of other packages: a data frame of pandas, a table of Arrow."""

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.columns import kind_of
from orbitdb.extras import load

if TYPE_CHECKING:
    import pandas
    import pyarrow

Columns = Mapping[str, NDArray[Any]]
"""Arrays of one entry a row, by the names of the columns."""

Lists = tuple[NDArray[np.float64], NDArray[np.int64]] | None
"""The coordinates of all rows one behind the other, and where each begins and the last one ends."""


def to_pandas(columns: Columns, coordinates: Lists, missing: NDArray[np.bool_]) -> "pandas.DataFrame":
    """Return a data frame; texts and integers that a row does not have are missing, numbers NaN.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (N,)
    coordinates : pair of ndarray, or None
        In the frame an array a row; None where a row has none.
    missing : ndarray of bool, shape (N,)
        Where the class of a row, and with it all that belongs to the class, is not known.
    """
    pandas = load("pandas", "to_pandas()", "pandas")
    table: dict[str, Any] = {}
    for name, values in columns.items():
        kind = kind_of(name)
        if kind == "text":
            table[name] = pandas.array([text or None for text in values.tolist()], dtype="string")
        elif kind == "integer" and name != "p":
            table[name] = pandas.arrays.IntegerArray(values.astype(np.int64), missing.copy())
        else:
            table[name] = values
    if coordinates is not None:
        table["coordinates"] = pandas.Series(_parts(*coordinates), dtype=object)
    return pandas.DataFrame(table)


def to_arrow(
    columns: Columns, coordinates: Lists, missing: NDArray[np.bool_], notes: Mapping[str, Any]
) -> "pyarrow.Table":
    """Return an Arrow table with the types that an exported parquet file has; what is missing is null.

    Parameters
    ----------
    columns, coordinates, missing
        As in `to_pandas`.
    notes : mapping
        What the schema's metadata say, each as JSON.
    """
    pa = load("pyarrow", "to_arrow()", "parquet")
    arrays: dict[str, Any] = {}
    for name, values in columns.items():
        kind = kind_of(name)
        if kind == "text":
            arrays[name] = pa.array([text or None for text in values.tolist()], pa.string())
        elif kind == "integer":
            arrays[name] = pa.array(values, pa.int64(), mask=None if name == "p" else missing)
        else:
            arrays[name] = pa.array(values, pa.float64(), from_pandas=True)
    if coordinates is not None:
        arrays["coordinates"] = pa.array(_parts(*coordinates), pa.list_(pa.float64()))
    table = pa.table(arrays)
    return table.replace_schema_metadata({name: json.dumps(value) for name, value in notes.items()})


def _parts(flat: NDArray[np.float64], start: NDArray[np.int64]) -> list[NDArray[np.float64] | None]:
    """Return the coordinates row by row, None where there are none."""
    parts = np.split(flat, start[1:-1]) if len(start) > 1 else []
    return [None if np.isnan(part[0]) else part for part in parts]
