"""`Reader`, a catalogue open for reading, and `Moment`, a read transaction, which answers all questions."""

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
from orbitdb.store import fills, lives, lookup, query, rows, tables
from orbitdb.store.connection import (
    driver,
    place,
    places_beside,
    plain_errors,
    reading_engine,
    remove_journal_of,
    unchanged,
)
from orbitdb.store.file import absolute_path, default_path, home_expanded, need_newest
from orbitdb.store.fills import Fill, Sweep
from orbitdb.store.lives import BirthFill, Life
from orbitdb.store.rows import Chosen
from orbitdb.store.selection import Selection
from orbitdb.store.where import CancelledError, never

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference


@dataclass(frozen=True)
class Moment:
    """A read transaction on a catalogue; all its answers are consistent with one another.

    `orbitdb.Catalogue` has methods with the same names.

    Attributes
    ----------
    connection : sqlalchemy.Connection
        A connection that sees the file as it was when the transaction began.
    path : Path
        The path of the file.
    """

    connection: sa.Connection
    path: Path

    def a_values(self, orbits: bool = False) -> list[float]:
        """Return the stored values of a in order; with `orbits`, only those with orbits or sweeps."""
        if orbits:
            return lookup.a_stored(driver(self.connection))
        return list(self.connection.scalars(sa.select(tables.stadium.c.a).order_by(tables.stadium.c.a)))

    def a_meant(self) -> float:
        """Return the default a (`orbitdb.store.lookup.meant`)."""
        return lookup.meant(self.a_values(orbits=True))

    def fills(self, a: float) -> list[Fill]:
        """Return the fills at a given a, in order of period."""
        return fills.fills(self.connection, a)

    def birth_fills(self) -> list[BirthFill]:
        """Return how far births and deaths are stored, in order of period."""
        return lives.birth_fills(self.connection)

    def births(self, p: int) -> list[Life]:
        """Return the lives of the classes of a period, in order of birth."""
        return lives.lives(self.connection, p)

    def entropy_bounds(self, a: float, proof: str | None = None) -> EntropyBounds | None:
        """Return the tightest stored bounds on the topological entropy at a given a, or None."""
        found = fills.closest(self.connection, proof, Stadium(a).a)
        return found[0] if found else None

    def entropy_curve(self, proof: str | None = None) -> list[EntropyBounds]:
        """Return the tightest stored bounds on the topological entropy at every a that has any, in order."""
        return fills.closest(self.connection, proof)

    def reference(self, a: float) -> "Reference | None":
        """Return the stored averages over trajectories with the smallest error at a given a, or None."""
        return fills.best_reference(self.connection, a)

    def sweeps(self, a: float) -> list[Sweep]:
        """Return the sweeps at a given a, in order of period."""
        return fills.sweeps(self.connection, a)

    def find(self, word: str, a: float) -> Orbit | None:
        """Return the stored orbit of a primitive word, in the given rotation, or None."""
        return lookup.find_word(driver(self.connection), word, a)

    def choose(
        self,
        selection: Selection,
        order: str = "p",
        columns: Sequence[str] = (),
        most: int | None = None,
        counted: bool = False,
        cancelled: Callable[[], bool] = never,
        by_class: bool = False,
    ) -> Chosen:
        """Find the classes and words of a selection (`orbitdb.store.query.choose`)."""
        return query.choose(self.connection, selection, order, columns, most, counted, cancelled, by_class)

    def blocks(
        self, chosen: Chosen, names: Sequence[str], first: int = 0, last: int | None = None
    ) -> Iterator[list[Values]]:
        """Yield the named columns of a subset in blocks of rows (`orbitdb.store.rows.blocks_of`)."""
        return rows.blocks_of(self.connection, chosen, names, first, last)

    def rows(
        self,
        chosen: Chosen,
        names: Sequence[str],
        first: int = 0,
        last: int | None = None,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[tuple[Any, ...]]:
        """Yield rows first .. last - 1 of a subset as plain values; missing values are None."""
        for columns in self.blocks(chosen, names, first, last):
            if cancelled():
                raise CancelledError
            yield from zip(*map(rows.plain, columns), strict=True)

    def count(self, selection: Selection) -> int:
        """Return the number of rows in a chosen subset."""
        return len(self.choose(selection))


class Reader:
    """A catalogue file to read; each call of `moment` starts a new `Moment` of the file that is then there.

    Between moments the file is closed.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.

    Raises
    ------
    StoreError
        If there is no catalogue at the path, or this version cannot read it.
    """

    def __init__(self, path: Path | str | None = None) -> None:
        need_newest(default_path() if path is None else home_expanded(path))
        self.path = absolute_path(path)
        self._place = place(self.path)
        self._engine = reading_engine(self.path)

    @contextmanager
    def moment(self) -> Iterator[Moment]:
        """Yield a read transaction; changes made meanwhile appear in the next one."""
        if place(self.path) != self._place:  # another file has taken its place
            need_newest(self.path)
            self._place = place(self.path)
        with unchanged(self.path), plain_errors(self.path), self._engine.begin() as connection:
            journal = places_beside(self.path)
            try:
                yield Moment(connection, self.path)
            finally:
                remove_journal_of(self.path, self._place, journal)


@contextmanager
def reading(path: Path | str | None = None) -> Iterator[Moment]:
    """Open a catalogue for a single moment, and close it afterwards."""
    with Reader(path).moment() as moment:
        yield moment
