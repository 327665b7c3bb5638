"""How far periods are filled, and the counts of the finished ones."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import sqlalchemy as sa

from orbitdb.store.file.schema import DONE
from orbitdb.store.reading.soundness import unsound
from orbitdb.symbols.words import MAX_PACKED


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

    @property
    def whole(self) -> bool:
        """Whether all words of the period are stored; if not, a fill goes on or was stopped."""
        return self.state == DONE


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
    pruned = tuple(values[f"rule_{number}"] for number in range(1, 7))
    names = (each.name for each in fields(Fill) if each.name != "pruned")
    return Fill(pruned=pruned, **{name: values[name] for name in names})


def describe_partial(fills: Sequence[Fill], a: float, left_out: bool = False) -> str:
    """Say in one line that periods are stored in part, and what completes them.

    Parameters
    ----------
    fills : sequence of Fill
        One period or more at one a, none of them whole.
    a : float
        The stadium.
    left_out : bool, optional
        Whether what is shown does without them.
    """
    many = len(fills) > 1
    periods = ", ".join(str(fill.p) for fill in fills)
    return (
        f"period{'s' * many} {periods} at a = {a:g} {'are' if many else 'is'} partial"
        f"{' and left out' * left_out}: a fill goes on or was stopped; "
        f"'orbitdb fill --p {max(fill.p for fill in fills)} --a {a:g}' completes {'them' if many else 'it'}"
    )
