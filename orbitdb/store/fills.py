"""How far periods are filled, and the counts of the finished ones."""

from dataclasses import dataclass, fields
from typing import Any

import sqlalchemy as sa

DONE, FILLING = "done", "filling"


@dataclass(frozen=True)
class Fill:
    """How far a period is filled at one a, and the counts of the paper's Table 1.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``; there are no counts before it is done.
    words : int
        Words stored so far.
    seconds : float
        Time spent.
    enumerating, solving, storing : float
        Time of processors spent on words and their classes, on orbits, and on the database (seconds).
    primitive : int or None
        All primitive cyclic words of the period.
    pruned : tuple of int or None
        How many of them break rule 1, 2 .. 6.
    n_t, n_c : int or None
        Words left after geometric pruning, and orbits.
    classes : int or None
        Symmetry classes of the orbits.
    boundary, unresolved : int or None
        Words of these statuses.
    """

    p: int
    state: str
    words: int
    seconds: float
    enumerating: float
    solving: float
    storing: float
    primitive: int | None
    pruned: tuple[int | None, ...]
    n_t: int | None
    n_c: int | None
    classes: int | None
    boundary: int | None
    unresolved: int | None


def as_fill(row: sa.Row[Any]) -> Fill:
    """Return a row of the table ``fill``."""
    values = row._mapping
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    names = (each.name for each in fields(Fill) if each.name != "pruned")
    return Fill(pruned=pruned, **{name: values[name] for name in names})
