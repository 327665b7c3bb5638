"""Subsets as tables: pandas data frames, Arrow tables, and HTML with pictures for notebooks."""

from collections.abc import Mapping, Sequence
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Values
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import kind_of
from orbitdb.export import arrow_batch, arrow_schema
from orbitdb.extras import load
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import EXISTING
from orbitdb.plaintext import shortened
from orbitdb.store.rows import COORDINATES

if TYPE_CHECKING:
    import pandas
    import pyarrow

MOST_ROWS = 10
MOST_BOUNCES = 200
"""Longer orbits get no small picture, because it would be a smudge."""

_HEADINGS = ("", "code", "p", "status", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class", "symmetry")
_NUMBERS = {"p", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class"}
_SIDES = ["right" if heading in _NUMBERS else "left" for heading in _HEADINGS]
"""Alignment of each cell; by default, notebooks align all cells to the right."""


def columns_of(
    a: float, codes: NDArray[Any], arrays: Mapping[str, NDArray[Any]], coordinates: Sequence[Floats] | None
) -> dict[str, Values]:
    """Return the columns of a subset, with None where a word without a class has no value."""
    classless = (arrays["representative"] == "").tolist()
    columns: dict[str, Values] = {"code": codes.tolist(), "a": np.full(len(codes), a)}
    for name, values in arrays.items():
        kind = kind_of(name)
        if kind == "text":
            columns[name] = [text or None for text in values.tolist()]
        elif kind == "integer" and name != "p":
            columns[name] = [None if no else n for n, no in zip(values.tolist(), classless, strict=True)]
        else:
            columns[name] = values
    if coordinates is not None:
        columns[COORDINATES] = [None if np.isnan(x[0]) else x for x in coordinates[: len(codes)]]
    return columns


def to_pandas(columns: Mapping[str, Values]) -> "pandas.DataFrame":
    """Return a data frame; missing texts and integers are NA, missing numbers NaN.

    The coordinates of each row are an array or None.
    """
    pandas = load("pandas", "to_pandas()", "pandas")
    table: dict[str, Any] = {}
    for name, values in columns.items():
        if isinstance(values, np.ndarray):
            table[name] = values
        elif kind_of(name) == "numbers":
            table[name] = pandas.Series(values, dtype=object)
        else:
            table[name] = pandas.array(values, "string" if kind_of(name) == "text" else "Int64")
    return pandas.DataFrame(table)


def to_arrow(columns: Mapping[str, Values], notes: Mapping[str, Any]) -> "pyarrow.Table":
    """Return an Arrow table typed like an exported parquet file; missing values are null."""
    pa = load("pyarrow", "to_arrow()", "parquet")
    schema = arrow_schema(tuple(columns), notes)
    return pa.Table.from_batches([arrow_batch(list(columns.values()), schema)])


def to_html(title: str, orbits: Sequence[Orbit], total: int) -> str:
    """Return an HTML table of orbits with small pictures, a title, and the number of orbits not shown."""
    if not orbits:
        return f"<p>{escape(title)}</p>"
    head = _cells("th", _HEADINGS)
    rows = "\n".join(_row(orbit) for orbit in orbits)
    more = f"\n<p>… and {total - len(orbits):,} more</p>" if total > len(orbits) else ""
    return (
        f"<p>{escape(title)}</p>\n<table>\n<thead>{head}</thead>\n<tbody>\n{rows}\n</tbody>\n</table>{more}"
    )


def _row(orbit: Orbit) -> str:
    points, stadium = None, Stadium(orbit.a)
    if orbit.status in EXISTING and orbit.p <= MOST_BOUNCES:
        points = orbit.points
    picture = "" if points is None else import_module("orbitdb.plots.svg").small_svg(stadium, points)
    texts = (shortened(orbit.code), str(orbit.p), orbit.status, _number(orbit.length, 7),
             _number(orbit.lyapunov, 7), _number(orbit.lambda_d, 6), _number(orbit.lambda_c, 6),
             str(orbit.class_size or ""), orbit.symmetry or "")  # fmt: skip
    return _cells("td", [picture, *map(escape, texts)])


def _cells(tag: str, contents: Sequence[str]) -> str:
    """Return a row of HTML cells, with numbers aligned to the right."""
    cells = (
        f'<{tag} style="text-align: {side}; padding: 0 0.5em">{content}</{tag}>'
        for side, content in zip(_SIDES, contents, strict=True)
    )
    return f"<tr>{''.join(cells)}</tr>"


def _number(value: float | None, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f}"
