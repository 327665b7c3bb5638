"""What the rows show: a subset in some order with some columns, as a view and as rows that are read."""

import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from textual.cache import LRUCache

from orbitdb.columns import IN_CATALOGUE
from orbitdb.store.file import Reader
from orbitdb.store.query import position_of
from orbitdb.store.rows import Chosen, rows_of
from orbitdb.store.selection import Selection
from orbitdb.text import exact


class Column(NamedTuple):
    """A column: its name in the catalogue, its minimum width, whether it contains text, and its meaning."""

    name: str
    width: int
    text: bool
    brief: str


USUAL = (
    "code", "p", "length", "status", "lambda_d", "lambda_c", "lyapunov", "time_reversal", "symmetry",
    "class_size", "margin", "error",
)  # fmt: skip
"""Names of the default columns."""

_WIDTHS = {
    "code": 8, "p": 3, "length": 11, "status": 9, "lyapunov": 11, "margin": 9, "error": 8, "born": 11,
    "dies": 11, "solver": 10, "rules": 7, "cycle": 12,
}  # fmt: skip
"""Widths of the columns whose values are wider than their names."""


def _every() -> dict[str, Column]:
    entries = {entry.name: entry for entry in IN_CATALOGUE if entry.name != "a"}  # all rows have the same a
    columns = {}
    for name in dict.fromkeys((*USUAL, *entries)):
        text = entries[name].kind not in ("number", "integer")
        width = max(_WIDTHS.get(name, 0), len(name) + 1)  # room for the arrow of the sort order
        columns[name] = Column(name, width, text, entries[name].brief)
    return columns


EVERY = _every()
"""All columns of the view ``catalogue`` that the table can show, by name."""

COLUMNS = tuple(EVERY[name] for name in USUAL)
"""The default columns."""


def columns_named(names: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns with the given names, the code first; unknown names are ignored."""
    named = [EVERY[name] for name in dict.fromkeys(names) if name in EVERY and name != "code"]
    return (EVERY["code"], *named)


def fields_of(columns: Sequence[Column], sorted_by: str) -> tuple[str, ...]:
    """Return the fields to read: the code, the shown columns, the status and the sort column."""
    return tuple(dict.fromkeys(("code", *(column.name for column in columns), "status", sorted_by)))


class Ordering(NamedTuple):
    """The sort column, and whether the order is descending."""

    column: str = "p"
    descending: bool = False

    def __str__(self) -> str:
        """Return the order as `Catalogue.rows` and ``--order`` take it, such as ``p desc``."""
        return self.column + (" desc" if self.descending else "")


def _quoted(word: str) -> str:
    """Return a word for the shell; double quotes are easier to read around single ones."""
    return f'"{word}"' if "'" in word and not set(word) & set('"$`\\!') else shlex.quote(word)


class View(NamedTuple):
    """The rows that are shown."""

    selection: Selection
    ordering: Ordering = Ordering()
    columns: tuple[Column, ...] = COLUMNS

    def command(self, path: Path) -> str:
        """Return the shell command that writes these rows."""
        words = ["orbitdb", "query", "--db", str(path)]
        for name, value in self._criteria().items():
            option = "--reversal" if name == "time_reversal" else f"--{name.replace('_', '-')}"
            match value:
                case dict():
                    words += [word for pair in value.items() for word in ("-P", "=".join(map(str, pair)))]
                case tuple():
                    low, high = ("" if bound is None else exact(bound) for bound in value)
                    words += ["--range", f"{name}={low}:{high}"]
                case list():
                    words += [word for a in value for word in (option, exact(a))]
                case _:
                    words += [option, exact(value) if isinstance(value, float) else value]
        if self.ordering != Ordering():
            words += ["--order", str(self.ordering)]
        return " ".join(map(_quoted, [*words, "-c", ",".join(column.name for column in self.columns)]))

    def python(self, path: Path) -> str:
        """Return the line of Python that selects these rows, after ``from orbitdb import Catalogue``."""
        criteria = self._criteria()
        if self.ordering != Ordering():
            criteria["order"] = str(self.ordering)
        arguments = ", ".join(f"{name}={value!r}" for name, value in criteria.items())
        return f"Catalogue({str(path)!r}).select({arguments})"

    def _criteria(self) -> dict[str, Any]:
        """Return the arguments of `Catalogue.select` that give this subset."""
        chosen = self.selection
        spans = ",".join(str(low) if low == high else f"{low}-{high}" for low, high in chosen.periods)
        criteria = {
            "p": spans,
            "status": ",".join(chosen.statuses),
            **{name: getattr(chosen, name) for name in ("time_reversal", "symmetry", "contains")},
            "exists": list(chosen.exists),
            "not_at": list(chosen.not_at),
            **{name: tuple(bounds) for name, bounds in chosen.ranges.items()},
            "where": chosen.where,
            "parameters": dict(chosen.parameters),
        }
        return {"a": chosen.a, **{name: value for name, value in criteria.items() if value}}


Row = tuple[Any, ...]

_BLOCK = 64
_KEPT = 32


@dataclass(eq=False)
class Pages:
    """The rows of a subset in some order, each with the code first; the most recently read blocks are cached.

    Without a catalogue there are no rows (`NONE`).
    """

    catalogue: Reader | None
    chosen: Chosen
    fields: Sequence[str]

    def __post_init__(self) -> None:
        self._blocks: LRUCache[int, list[Row]] = LRUCache(_KEPT)  # a cached method would keep it alive

    def __len__(self) -> int:
        return len(self.chosen)

    def row(self, place: int) -> Row:
        number, within = divmod(place, _BLOCK)
        if number not in self._blocks:
            assert self.catalogue is not None
            with self.catalogue.moment() as moment:
                first = number * _BLOCK
                self._blocks[number] = list(rows_of(moment, self.chosen, self.fields, first, first + _BLOCK))
        return self._blocks[number][within]

    def position(self, word: str) -> int | None:
        """Return the index of the row of a word, given as its least rotation, or None."""
        if self.catalogue is None:
            return None
        with self.catalogue.moment() as moment:
            return position_of(moment, self.chosen, word)


NONE = Pages(None, Chosen(Selection(), np.zeros(0, np.int64), np.zeros(0, np.uint8)), USUAL)
"""No rows: the table shows this before any rows are read, and if none can be read."""
