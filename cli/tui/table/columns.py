"""The columns that the table can show, and which of them a row has to bring along."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Column:
    """A column: its name in the catalogue, its heading, its least width, and whether it is text."""

    name: str
    heading: str
    width: int
    text: bool = False


COLUMNS = (
    Column("code", "code", 8, text=True),
    Column("p", "p", 3),
    Column("length", "length", 11),
    Column("status", "status", 9, text=True),
    Column("lambda_d", "λ_d", 9),
    Column("lambda_c", "λ_c", 9),
    Column("lyapunov", "lyapunov", 11),
    Column("time_reversal", "reversal", 8, text=True),
    Column("symmetry", "symmetry", 9, text=True),
    Column("class_size", "class", 5),
    Column("margin", "margin", 9),
    Column("error", "error", 8),
)
"""What the table shows where nothing else was chosen."""

_MORE = (
    Column("born", "born", 11),
    Column("dies", "dies", 11),
    Column("walls", "walls", 5),
    Column("maslov", "maslov", 6),
    Column("length_error", "length ±", 8),
    Column("lyapunov_error", "lyapunov ±", 10),
    Column("residual", "residual", 8),
    Column("iterations", "steps", 5),
    Column("solver", "solver", 10, text=True),
    Column("representative", "least of class", 14, text=True),
    Column("rules", "rules", 7, text=True),
    Column("cycle", "cycle", 12),
    Column("element", "element", 7),
)
EVERY = {column.name: column for column in (*COLUMNS, *_MORE)}
"""All that there are, by their names: those of the view ``catalogue``."""

USUAL = tuple(column.name for column in COLUMNS)
"""The names of `COLUMNS`."""

_NEEDED = ("code", "status")
"""What every row brings along: the word that it is of, and whether it is an orbit."""


def chosen(names: Iterable[str]) -> tuple[Column, ...]:
    """Return the columns of some names, the code first; those that are not known are left out."""
    known = [EVERY[name] for name in dict.fromkeys(names) if name in EVERY and name != "code"]
    return (EVERY["code"], *known)


def fields_of(columns: Sequence[Column], sorted_by: str) -> tuple[str, ...]:
    """Return what is to be read of a row, the code first: what is shown, and what it is sorted by."""
    return tuple(dict.fromkeys(("code", *(column.name for column in columns), *_NEEDED, sorted_by)))
