"""How far periods are filled, and the counts of the finished ones."""

from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from orbitdb.store.rows import unsound
from orbitdb.words import MAX_PACKED


@dataclass(frozen=True)
class Fill:
    """How far a period is filled at one a, and the counts of the paper's Table 1.

    Attributes
    ----------
    p : int
        Period.
    state : str
        ``filling`` or ``done``; there are no counts before it is done.
    seconds : float
        Time spent.
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
    seconds: float
    primitive: int | None
    pruned: tuple[int | None, ...]
    n_t: int | None
    n_c: int | None
    classes: int | None
    boundary: int | None
    unresolved: int | None


def as_fill(row: sa.Row[Any]) -> Fill:
    """Return a row of the table ``fill``.

    Raises
    ------
    StoreError
        If its period cannot have been filled.
    """
    values = row._mapping
    if not 2 <= values["p"] <= MAX_PACKED:
        raise unsound("a filled period of", values["p"])
    names = ("p", "state", "seconds", "primitive", "n_t", "n_c", "classes", "boundary", "unresolved")
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    return Fill(pruned=pruned, **{name: values[name] for name in names})
