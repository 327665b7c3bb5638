"""The symmetry classes of a period that a catalogue knows, in memory while the period is filled."""

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.store.filling import Cursor, add_cycles
from orbitdb.store.schema import cycle, orbit
from orbitdb.words import from_strings, pack


class KnownClasses:
    """The classes of one period that are stored, and which of them are solved at the stadium."""

    def __init__(self, connection: sa.Connection, cursor: Cursor) -> None:
        self.cursor = cursor
        self._load(connection)

    def _load(self, connection: sa.Connection) -> None:
        p = self.cursor.p
        rows = connection.execute(
            sa.select(cycle.c.id, cycle.c.word).where(cycle.c.p == p).order_by(cycle.c.word)
        )
        pairs = rows.all()
        self.ids = np.array([number for number, _ in pairs], dtype=np.int64)
        self.codes = pack(from_strings([word for _, word in pairs]))
        mine = sa.select(orbit.c.cycle).where(orbit.c.stadium == self.cursor.stadium)
        solved = connection.scalars(mine.join(cycle, cycle.c.id == orbit.c.cycle).where(cycle.c.p == p)).all()
        self.solved = self.codes[np.isin(self.ids, np.array(solved, dtype=np.int64))]
        self.newest = self._newest(connection)

    def _newest(self, connection: sa.Connection) -> int:
        return connection.scalar(sa.select(sa.func.max(cycle.c.id))) or 0

    def refresh(self, connection: sa.Connection) -> None:
        """Read again if another process has added classes."""
        if self._newest(connection) != self.newest:
            self._load(connection)

    def add(
        self, connection: sa.Connection, words: NDArray[np.uint8], stabilisers: NDArray[np.uint8]
    ) -> None:
        """Store those of some classes, given by least words and stabilisers, that are new."""
        codes = pack(words)
        new = ~np.isin(codes, self.codes)
        if not new.any():
            return
        ids = add_cycles(connection, words[new], stabilisers[new])
        self.codes = np.concatenate([self.codes, codes[new]])
        self.ids = np.concatenate([self.ids, ids])
        order = np.argsort(self.codes)
        self.codes, self.ids = self.codes[order], self.ids[order]
        self.newest = ids[-1]

    def numbers(self, codes: NDArray[np.int64]) -> list[int]:
        """Return the numbers of classes, given by their packed least words."""
        numbers: list[int] = self.ids[np.searchsorted(self.codes, codes)].tolist()
        return numbers
