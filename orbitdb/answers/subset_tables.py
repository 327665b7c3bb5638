"""Subsets as tables: pandas data frames, Arrow tables, and HTML with pictures for notebooks."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Values
from orbitdb.billiard.stadium import Stadium
from orbitdb.columns import WRITTEN, kind_of
from orbitdb.export import arrow_batch, arrow_schema
from orbitdb.extras import load
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import EXISTING
from orbitdb.plaintext import shortened
from orbitdb.store.rows import COORDINATES

if TYPE_CHECKING:
    import pandas
    import pyarrow

    from orbitdb.answers.subset import Subset

_BLOCK = 1 << 14
MOST_ROWS = 10
MOST_BOUNCES = 200
"""Longer orbits get no small picture, because it would be a smudge."""

_HEADINGS = ("", "code", "p", "status", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class", "symmetry")
_NUMBERS = {"p", "length", "λ", "λ<sub>d</sub>", "λ<sub>c</sub>", "class"}
_SIDES = ["right" if heading in _NUMBERS else "left" for heading in _HEADINGS]
"""Alignment of each cell; by default, notebooks align all cells to the right."""


def columns_of(subset: "Subset") -> Iterator[tuple[str, Values]]:
    """Yield the columns of a subset, with None where a word without a class has no value.

    They are made one at a time, because together they take as much memory as the subset.
    """
    classless = (subset.representative == "").tolist()
    yield "code", _texts(subset.codes)
    yield "a", np.full(len(subset), subset.selection.a)
    for name in _COLUMNS:
        kind, values = kind_of(name), getattr(subset, name)
        if kind == "text":
            yield name, _texts(values)
        elif kind == "integer" and name != "p":
            yield name, [None if no else n for n, no in zip(values.tolist(), classless, strict=True)]
        else:
            yield name, values
    if subset.coordinates is not None:
        parts = np.split(subset.coordinates, subset.start[1:-1])
        yield COORDINATES, [None if np.isnan(x[0]) else x for x in parts[: len(subset)]]


_COLUMNS = (*(name for name in WRITTEN if name not in ("code", "a", "rules")), "born", "dies")


def _texts(values: NDArray[Any]) -> list[str | None]:
    """Return texts as a list, with None for empty ones; equal texts are a single object, to save memory."""
    known: dict[str, str] = {}
    blocks = (values[start : start + _BLOCK].tolist() for start in range(0, len(values), _BLOCK))
    return [known.setdefault(text, text) or None for block in blocks for text in block]


def to_pandas(columns: Iterable[tuple[str, Values]]) -> "pandas.DataFrame":
    """Return a data frame; missing texts and integers are NA, missing numbers NaN.

    The coordinates of each row are an array or None.
    """
    pandas = load("pandas", "to_pandas()", "pandas")
    table: dict[str, Any] = {}
    for name, values in columns:
        if isinstance(values, np.ndarray):
            table[name] = values
        elif kind_of(name) == "numbers":
            table[name] = pandas.Series(values, dtype=object)
        else:
            table[name] = pandas.array(values, "string" if kind_of(name) == "text" else "Int64")
    return pandas.DataFrame(table, copy=False)  # each column once in memory


def to_arrow(columns: Iterable[tuple[str, Values]], notes: Mapping[str, Any]) -> "pyarrow.Table":
    """Return an Arrow table typed like an exported parquet file; missing values are null."""
    pa = load("pyarrow", "to_arrow()", "parquet")
    names, values = zip(*columns, strict=True)
    schema = arrow_schema(names, notes)
    return pa.Table.from_batches([arrow_batch(values, schema)])


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
