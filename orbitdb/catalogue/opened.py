"""The open file of a catalogue: its connections, one moment of it, and what is filled at which a."""

import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Self

import sqlalchemy as sa

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.gaps import describe_fills
from orbitdb.errors import InputError, StoreError
from orbitdb.store.file import tables
from orbitdb.store.file.database import default_path, need_newest, plain_errors
from orbitdb.store.file.engines import driver, reading_engine
from orbitdb.store.file.migrate import migrate
from orbitdb.store.reading.fills import Fill, as_fill
from orbitdb.store.reading.lookup import a_stored, meant

_SHOWN = 4
"""How many further values of a a short description lists."""


class OpenedCatalogue:
    """A database file, opened for reading; `orbitdb.Catalogue` says the rest."""

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
