"""The columns of the table, and the fields that must be read for them."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from orbitdb.columns import IN_CATALOGUE


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
    # the word equals the code, and all rows have the same a
    known = {each.name: each for each in IN_CATALOGUE if each.name not in ("word", "a")}
    found = {}
    for name in dict.fromkeys((*USUAL, *known)):
        text = known[name].kind not in ("number", "integer")
        width = max(_WIDTHS.get(name, 0), len(name) + 1)  # room for the arrow of the sort order
        found[name] = Column(name, width, text, known[name].brief)
    return found


EVERY = _every()
"""All columns of the view ``catalogue`` that the table can show, by name."""

COLUMNS = tuple(EVERY[name] for name in USUAL)
"""The default columns."""


def chosen(names: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns with the given names, the code first; unknown names are ignored."""
    known = [EVERY[name] for name in dict.fromkeys(names) if name in EVERY and name != "code"]
    return (EVERY["code"], *known)


def fields_of(columns: Sequence[Column], sorted_by: str) -> tuple[str, ...]:
    """Return the fields to read: the code, the shown columns, the status and the sort column."""
    return tuple(dict.fromkeys(("code", *(column.name for column in columns), "status", sorted_by)))
