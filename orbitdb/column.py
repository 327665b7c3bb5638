"""A column of rows, files and JSON: what it holds."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

Row: TypeAlias = Sequence[Any]
"""One value per column; None for a missing one."""


@dataclass(frozen=True)
class Column:
    """What a column holds.

    Attributes
    ----------
    name : str
    kind : str
        ``text``, ``integer`` or ``number``; ``integers`` or ``numbers`` for a list of them; else in words.
    means : str
        Its meaning; a few words, then details after a semicolon.
    unit : str
        Unit of a number; ``1`` for a pure number, empty if it is not a quantity.
    bound : str
        The columns that bound its error, or ``exact``, ``proved``, ``itself``; empty without a bound.
    empty : str
        When it has no value.
    sql : str
        Of a column of the catalogue: its value in a row of the tables that the view ``class`` joins, or,
        if `single`, the view ``catalogue``.
    formula : str
        Instead of `sql`: the value from other columns, written with ``+ - * / ( )``, numbers and their
        names, which SQLite and Python read alike.
    single : bool
        Whether the words of one symmetry class differ in it.
    written : bool
        Whether it is written where no columns are named.
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
        """The columns in the formula."""
        return tuple(dict.fromkeys(NAME.findall(self.formula)))

    @property
    def brief(self) -> str:
        """The meaning in a few words."""
        return self.means.partition(";")[0]


NAME = re.compile(r"\b[a-z]\w*")
"""A name in a formula."""

PRUNED = "geometrically pruned"
NO_ORBIT = "no orbit"
UNKNOWN = "no orbit; relaxation"
PLACE = "radius, rad"
"""When columns are empty, and the unit of a coordinate."""
