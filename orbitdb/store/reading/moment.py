"""A catalogue open for reading, and `Moment`, one read transaction, which answers all questions."""

import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from orbitdb.arrays import Values
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import EntropyBounds
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.limits import CancelledError, never
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import swept_text
from orbitdb.store.file import tables
from orbitdb.store.file.database import default_path, driver, need_newest, reading_engine, unchanged
from orbitdb.store.file.guard import plain_errors
from orbitdb.store.reading import fills, lives, lookup, question, records, rows
from orbitdb.store.reading.fills import Fill, Sweep
from orbitdb.store.reading.lives import BirthFill, Life
from orbitdb.store.reading.rows import Chosen

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference


@dataclass(frozen=True)
class Moment:
    """A read transaction on one catalogue, so that all answers are consistent.

    `orbitdb.Catalogue` has methods of the same names.

    Attributes
    ----------
    connection : sqlalchemy.Connection
        Sees the file as it was when the transaction began.
    path : Path
        The file.
    """

    connection: sa.Connection
    path: Path

    def a_values(self, orbits: bool = False) -> list[float]:
        """Return the values of a in order, all or only those with orbits or sums over them."""
        if orbits:
            return lookup.a_stored(driver(self.connection))
        return list(self.connection.scalars(sa.select(tables.stadium.c.a).order_by(tables.stadium.c.a)))

    def a_meant(self) -> float:
        """Return the default a (`orbitdb.store.reading.lookup.meant`)."""
        return lookup.meant(self.a_values(orbits=True))

    def fills(self, a: float) -> list[Fill]:
        """Return the fills at one a, by period."""
        return fills.fills(self.connection, a)

    def birth_fills(self) -> list[BirthFill]:
        """Return the progress of births and deaths by period."""
        return lives.birth_fills(self.connection)

    def births(self, p: int) -> list[Life]:
        """Return the lives of the classes of one period, by birth."""
        return lives.lives(self.connection, p)

    def entropy_bounds(self, a: float, proof: str | None = None) -> EntropyBounds | None:
        """Return the closest stored bounds on the topological entropy at one a."""
        found = records.closest(self.connection, proof, Stadium(a).a)
        return found[0] if found else None

    def entropy_curve(self, proof: str | None = None) -> list[EntropyBounds]:
        """Return the closest stored bounds on the topological entropy at every a, in order."""
        return records.closest(self.connection, proof)

    def reference(self, a: float) -> "Reference | None":
        """Return the stored averages over trajectories at one a that have the smallest error."""
        return records.best_reference(self.connection, a)

    def sweeps(self, a: float, selection: Selection | None = None) -> list[Sweep]:
        """Return the counts and sums of sweeps at one a, of all orbits or of a subset, by period."""
        return fills.sweeps(self.connection, a, "" if selection is None else swept_text(selection))

    def swept_subsets(self, a: float) -> list[Selection]:
        """Return the subsets, other than all orbits, that are swept at one a."""
        return fills.swept_subsets(self.connection, a)

    def find(self, word: str, a: float) -> Orbit | None:
        """Return the stored orbit of a primitive word, in the rotation given, or None."""
        return lookup.find_word(driver(self.connection), word, a)

    def choose(
        self,
        selection: Selection,
        order: str = "p",
        columns: Sequence[str] = (),
        most: int | None = None,
        counted: bool = False,
        cancelled: Callable[[], bool] = never,
    ) -> Chosen:
        """Return a chosen subset as classes and their words (`orbitdb.store.reading.question.choose`)."""
        return question.choose(self.connection, selection, order, columns, most, counted, cancelled)

    def blocks(
        self, chosen: Chosen, names: Sequence[str], first: int = 0, last: int | None = None
    ) -> Iterator[list[Values]]:
        """Yield columns of a subset, in blocks of rows (`orbitdb.store.reading.rows.blocks_of`)."""
        return rows.blocks_of(self.connection, chosen, names, first, last)

    def rows(
        self,
        chosen: Chosen,
        names: Sequence[str],
        first: int = 0,
        last: int | None = None,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[tuple[Any, ...]]:
        """Yield rows first .. last - 1 of a subset as plain values, with None for missing ones."""
        for columns in self.blocks(chosen, names, first, last):
            if cancelled():
                raise CancelledError
            yield from zip(*map(rows.plain, columns), strict=True)

    def count(self, selection: Selection) -> int:
        """Return the number of rows in a chosen subset."""
        return len(self.choose(selection))


class Reader:
    """A catalogue file open for reading, one moment after another.

    Parameters
    ----------
    path : path-like, optional
        The file; by default that of ``ORBITDB_DB``, or one in your data folder.

    Raises
    ------
    StoreError
        If there is no catalogue there, or it cannot be read by this version.
    """

    def __init__(self, path: Path | str | None = None) -> None:
        self.path = Path(path) if path is not None else default_path()
        need_newest(self.path)
        self._engine = reading_engine(self.path)
        with plain_errors(self.path), self._engine.connect():
            pass  # refuse a damaged or altered file now, not in the middle of a question
        self.close()
        weakref.finalize(self, self._engine.dispose)  # if nobody calls `close`

    def close(self) -> None:
        """Close the file. The next question opens it again."""
        self._engine.dispose()

    @contextmanager
    def moment(self) -> Iterator[Moment]:
        """Open a read transaction; later changes appear in the next one."""
        with unchanged(self.path), plain_errors(self.path), self._engine.begin() as connection:
            yield Moment(connection, self.path)


@contextmanager
def reading(path: Path | str | None = None) -> Iterator[Moment]:
    """Open a catalogue for one moment, and close it."""
    source = Reader(path)
    try:
        with source.moment() as moment:
            yield moment
    finally:
        source.close()
