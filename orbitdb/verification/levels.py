"""Stored quantum levels: found again on another grid, within their errors, and none too many."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.spectrum import stored_levels
from orbitdb.errors import InputError, StoreError
from orbitdb.quantum.levels import Levels, rounding, windows
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file.tables import level, level_fill
from orbitdb.verification.blocks import Part
from orbitdb.verification.check import Check, Step, judged, measured

_GRID = (18, 4)
"""Degree and divisions of the cells at the joint: finer than both grids on which levels are found."""


def level_parts(connection: sa.Connection, path: Path) -> Iterator["LevelPart"]:
    """Yield one part for each a and parity of which there are levels."""
    named = sa.union(*(sa.select(table.c.a, table.c.parity) for table in (level_fill, level)))
    return (LevelPart(path, a, parity) for a, parity in sorted(map(tuple, connection.execute(named))))


@dataclass(frozen=True, eq=False)
class LevelPart(Part):
    """The levels of one parity at one a."""

    a: float
    parity: str

    def checked(self, connection: sa.Connection) -> Step:
        """Return what is found in the rows that a connection reads."""
        name = f"levels {self.parity} at a = {self.a:g}"
        try:
            stored = stored_levels(connection, self.a, Parity(self.parity))
            checks = tuple(check for each in stored for check in _window(each))
        except (StoreError, InputError, ValueError):
            checks = (Check("levels", 1, 1, first=name),)
        return Step(name, 0, 1, checks)


def _window(stored: Levels) -> Iterator[Check]:
    """Check the number of levels in a window and below it, then each level, if the number is right.

    Raises
    ------
    InputError
        If no such window is ever solved.
    """
    tasks = windows(Stadium(stored.a), stored.parity, stored.low, stored.high)
    found = [task.on_grid(*_GRID) for task in tasks]
    k = np.concatenate([each for _, each in found])
    labels = [f"{stored.parity} {each:.6g}" for each in stored.k]
    if (stored.below, len(stored.k)) != (found[0][0], len(k)):
        yield judged("levels", [f"{stored.parity} {stored.low:g} to {stored.high:g}"], [True])
    else:
        allowed = np.where(stored.error < rounding(stored.k), 0.0, stored.error + rounding(k))
        yield measured("levels", labels, np.abs(stored.k - k), allowed)
