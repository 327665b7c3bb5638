"""The open file of a catalogue: its connections, one moment of it, and what it holds besides words."""

import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Self

import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.gaps import describe_fills
from orbitdb.entropy.bounds import EntropyBounds
from orbitdb.errors import InputError, StoreError
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import swept_text
from orbitdb.store.file import tables
from orbitdb.store.file.database import default_path, need_newest, plain_errors
from orbitdb.store.file.migrate import migrate
from orbitdb.store.file.tables import driver, reading_engine
from orbitdb.store.reading import lives, records, sweeps
from orbitdb.store.reading.fills import Fill, as_fill
from orbitdb.store.reading.lives import BirthFill, Life
from orbitdb.store.reading.lookup import a_stored, meant
from orbitdb.store.reading.sweeps import Sweep

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference

_SHOWN = 4
"""How many further values of a a short description lists."""


class OpenedCatalogue:
    """A database file, opened for reading, and what it holds besides words (`orbitdb.Catalogue`)."""

    def __init__(self, path: Path | str | None = None, a: float | None = None) -> None:
        self._a = None if a is None else Stadium(a).a
        self.path = Path(path) if path is not None else default_path()
        need_newest(self.path)
        self._engine = reading_engine(self.path)
        with plain_errors(self.path), self._engine.connect():
            pass  # so that a file that is damaged or tampered with is refused now, and not in mid-use
        self._engine.dispose()
        weakref.finalize(self, self._engine.dispose)  # so that it may be dropped without `close`
        self._moment: sa.Connection | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file. The next question opens it again."""
        self._engine.dispose()

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Open a read transaction: its connection sees the file at one moment."""
        if self._moment is not None:
            yield self._moment
            return
        with plain_errors(self.path), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def at_one_moment(self) -> Iterator[Self]:
        """Read the catalogue at one moment, so that the numbers of several queries agree.

        What a fill stores meanwhile appears after the block.
        """
        with self.reading() as connection:
            still = object.__new__(type(self))
            still.__dict__.update(self.__dict__)  # not a copy, which would be opened anew
            still._moment = connection
            yield still

    def __repr__(self) -> str:
        try:
            known = self._contents()
        except StoreError as error:
            known = str(error)
        return f"<Catalogue {self.path.name}: {known}>"

    def _contents(self) -> str:
        """Say in one line what is filled, at its own a first."""
        with self.at_one_moment() as still:
            values = still.stadiums()
            try:
                own = [meant(values) if self._a is None else self._a]
            except InputError:
                own = []
            others = [a for a in values if a not in own]
            parts = [describe_fills(still.fills(a), a) for a in (*own, *others[:_SHOWN])]
        return "; ".join(parts) + (f"; and at {len(others) - _SHOWN} more" if len(others) > _SHOWN else "")

    def __reduce__(self) -> tuple[type[Self], tuple[Path, float | None]]:
        """Pickle, and copy, the path and a: the file is opened anew where it is loaded."""
        return type(self), (self.path.absolute(), self._a)

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> Self:
        """Open a catalogue for reading; first make it, or bring it to the newest schema."""
        path = Path(path) if path is not None else default_path()
        migrate(path)
        return cls(path, a)

    @property
    def a(self) -> float:
        """The stadium of all questions that name none; once it is known, it stays the same.

        Raises
        ------
        InputError
            If none was given, and the catalogue has orbits at several, but none at 1.6.
        """
        if self._a is None:
            self._a = meant(self.stadiums())
        return self._a

    def stadiums(self) -> list[float]:
        """Return the values of a at which there are orbits, also of single words only, or sums of sweeps."""
        with self.reading() as connection:
            return a_stored(driver(connection))

    def a_values(self) -> list[float]:
        """Return the values of a in the catalogue, in order."""
        with self.reading() as connection:
            return list(connection.scalars(sa.select(tables.stadium.c.a).order_by(tables.stadium.c.a)))

    def fills(self, a: float | None = None) -> list[Fill]:
        """Return what is filled at one a, by default the catalogue's, by period."""
        fill, at = tables.fill, self.a if a is None else a
        query = sa.select(fill).join(tables.stadium).where(tables.stadium.c.a == at).order_by(fill.c.p)
        with self.reading() as connection:
            return [as_fill(row) for row in connection.execute(query)]

    def birth_fills(self) -> list[BirthFill]:
        """Return which periods have births and deaths stored, and how completely."""
        with self.reading() as connection:
            return lives.birth_fills(connection)

    def births(self, p: int) -> list[Life]:
        """Return the lives of the classes of one period, by birth: the ranges of a in which they are orbits.

        Empty if no births of the period are stored: `orbitdb births` stores them.
        """
        with self.reading() as connection:
            return lives.lives(connection, p)

    def entropy_bounds(self, a: float | None = None, proof: str | None = None) -> EntropyBounds | None:
        """Return the closest proved bounds that are stored on the topological entropy at one a.

        None if there are none: `orbitdb bounds` finds and stores them.

        Parameters
        ----------
        a : float, optional
            The stadium; by default the catalogue's.
        proof : str, optional
            ``doubles`` or ``balls``: only bounds proved in this arithmetic; by default the closer ones.

        Raises
        ------
        InputError
            If `proof` is another word.
        """
        with self.reading() as connection:
            found = records.closest(connection, proof, self.a if a is None else Stadium(a).a)
        return found[0] if found else None

    def reference(self, a: float | None = None) -> "Reference | None":
        """Return the stored averages over random trajectories at one a that have the smallest error.

        None if there are none: `orbitdb simulate` makes and stores them.

        Parameters
        ----------
        a : float, optional
            The stadium; by default the catalogue's.
        """
        with self.reading() as connection:
            return records.best_reference(connection, self.a if a is None else a)

    def entropy_curve(self, proof: str | None = None) -> list[EntropyBounds]:
        """Return the closest stored bounds on the topological entropy at every a, in order.

        The parameter is that of `entropy_bounds`.
        """
        with self.reading() as connection:
            return records.closest(connection, proof)

    def sweeps(self, a: float | None = None, selection: Selection | None = None) -> list[Sweep]:
        """Return the counts and sums of sweeps at one a, by period.

        Parameters
        ----------
        a : float, optional
            The stadium; by default the catalogue's.
        selection : Selection, optional
            The orbits that were swept; by default all. Its a and periods are ignored.

        Raises
        ------
        SelectionError
            If the subset cannot be swept.
        """
        chosen = "" if selection is None else swept_text(selection)
        with self.reading() as connection:
            return sweeps.sweeps(connection, self.a if a is None else a, chosen)

    def swept_subsets(self, a: float | None = None) -> list[Selection]:
        """Return the subsets, other than all orbits, that are swept at one a, by default the catalogue's."""
        with self.reading() as connection:
            return sweeps.swept_subsets(connection, self.a if a is None else a)
