"""`Column`, the description of a column of rows, files and JSON."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Row: TypeAlias = Sequence[Any]
"""One value per column; None if it is missing."""


@dataclass(frozen=True)
class Column:
    """The description of a column.

    Attributes
    ----------
    name : str
    kind : str
        ``text``, ``integer`` or ``number``; ``integers`` or ``numbers`` for lists; other kinds in words.
    means : str
        The meaning in a few words, then details after a semicolon.
    unit : str
        Unit of a number; ``1`` for a pure number, empty if it is not a quantity.
    bound : str
        The column that bounds its error, or ``exact``, ``proved`` or ``itself``; empty if none does.
    empty : str
        When the column has no value.
    sql : str
        For a column of the catalogue: SQL for its value in a row of the tables that the view ``class``
        or, if `single`, the view ``catalogue`` joins.
    formula : str
        Instead of `sql`, an expression that SQLite and Python read in the same way, made of names of
        other columns, numbers and ``+ - * / ( )``.
    single : bool
        Whether its value can differ between the words of a symmetry class.
    written : bool
        Whether it is written if you name no columns.
    """

    name: str
    kind: str
    means: str
    unit: str = ""
    bound: str = ""
    empty: str = "never"
    sql: str = ""
    formula: str = ""
    single: bool = False
    written: bool = True

    @property
    def needs(self) -> tuple[str, ...]:
        """The columns that the formula uses."""
        return tuple(dict.fromkeys(NAME.findall(self.formula)))

    @property
    def brief(self) -> str:
        """The meaning in a few words, without the details."""
        return self.means.partition(";")[0]


NAME = re.compile(r"\b[a-z]\w*")
"""A column name in a formula."""

PRUNED = "geometrically pruned"
NO_ORBIT = "no orbit"
UNKNOWN = "no orbit; relaxation"
PLACE = "radius, rad"
"""Reasons why a column is empty, and the unit of a coordinate."""
