"""A subset as a table: a data frame of pandas, a table of Arrow, HTML with pictures for notebooks."""

import json
from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import kind_of
from orbitdb.extras import load
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.svg import small_svg

if TYPE_CHECKING:
    import pandas
    import pyarrow

MOST_ROWS = 10
MOST_BOUNCES = 200
"""A small picture of longer orbits would show nothing."""

_HEADINGS = ("", "code", "p", "status", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class", "symmetry")
_NUMBERS = {"p", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class"}
_SIDES = ["right" if heading in _NUMBERS else "left" for heading in _HEADINGS]
"""Said cell by cell, for notebooks would align all to the right."""

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


def to_html(title: str, orbits: Sequence[Orbit], total: int) -> str:
    """Return a table of some orbits.

    Parameters
    ----------
    title : str
        What they are.
    orbits : sequence of Orbit
        Those that are shown.
    total : int
        How many there are in all.
    """
    if not orbits:
        return f"<p>{escape(title)}</p>"
    head = _cells("th", _HEADINGS)
    rows = "\n".join(_row(orbit) for orbit in orbits)
    more = f"\n<p>… and {total - len(orbits):,} more</p>" if total > len(orbits) else ""
    return (
        f"<p>{escape(title)}</p>\n<table>\n<thead>{head}</thead>\n<tbody>\n{rows}\n</tbody>\n</table>{more}"
    )


def _row(orbit: Orbit) -> str:
    points = orbit.points
    picture = "" if points is None or orbit.p > MOST_BOUNCES else small_svg(Stadium(orbit.a), points)
    texts = (_short(orbit.code), str(orbit.p), orbit.status, _number(orbit.length, 7),
             _number(orbit.lyapunov, 7), _number(orbit.lambda_d, 6), _number(orbit.lambda_c, 6),
             str(orbit.class_size or ""), orbit.symmetry or "")  # fmt: skip
    return _cells("td", [picture, *map(escape, texts)])


def _cells(tag: str, contents: Sequence[str]) -> str:
    """Return a row of cells, numbers to the right."""
    cells = (
        f'<{tag} style="text-align: {side}; padding: 0 0.5em">{content}</{tag}>'
        for side, content in zip(_SIDES, contents, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"


def _number(value: float | None, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f}"


def _short(code: str) -> str:
    return code if len(code) <= 40 else f"{code[:37]}..."
