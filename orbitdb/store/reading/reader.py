"""Reader: a database file opened for reading, and what is asked of it in SQL."""

import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import sqlalchemy as sa

from orbitdb.column_blocks import ColumnBlock
from orbitdb.store.asking.conditions import COLUMNS as CATALOGUE_COLUMNS
from orbitdb.store.asking.conditions import asks_of_lives
from orbitdb.store.asking.confinement import CancelledError, never
from orbitdb.store.asking.names import unknown as unknown_column
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.database import default_path, need_newest, plain_errors
from orbitdb.store.file.engines import driver, reading_engine
from orbitdb.store.file.tables import fill, stadium
from orbitdb.store.reading.chosen import Chosen
from orbitdb.store.reading.fills import Fill, as_fill, describe_unfilled
from orbitdb.store.reading.lives import birth_fills, describe_lacking
from orbitdb.store.reading.question import choose
from orbitdb.store.reading.row_blocks import COLUMNS, blocks_of
from orbitdb.store.reading.stadiums import a_filled
from orbitdb.symbols.enumeration import MAX_PERIOD

_ALL = 2**63 - 1
"""SQLite's largest integer."""


class Reader:
    """A database file opened for reading.

    Parameters
    ----------
    path : path-like, optional
        The file; by default ``ORBITDB_DB`` or a file in the user's data folder.

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
            pass  # so that a file that is damaged or tampered with is refused now, and not in mid-use
        self._engine.dispose()
        weakref.finalize(self, self._engine.dispose)  # so that it may be dropped without `close`
        self._moment: sa.Connection | None = None

    def close(self) -> None:
        """Close the file; it is opened again if something more is asked."""
        self._engine.dispose()

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Give a connection inside one read transaction: all it sees is of one moment."""
        if self._moment is not None:
            yield self._moment
            return
        with plain_errors(self.path), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def at_one_moment(self) -> Iterator[Self]:
        """Give the catalogue as it is when it is first read: its numbers, from however many queries, agree.

        What a fill stores meanwhile is seen behind the block.
        """
        with self.reading() as connection:
            still = object.__new__(type(self))
            still.__dict__.update(self.__dict__)  # not a copy, which would be opened anew
            still._moment = connection
            yield still

    def a_values(self) -> list[float]:
        """Return the values of a that the catalogue knows, in order."""
        with self.reading() as connection:
            return list(connection.scalars(sa.select(stadium.c.a).order_by(stadium.c.a)))

    def fills(self, a: float) -> list[Fill]:
        """Return what is filled at one a, by period."""
        query = sa.select(fill).join(stadium).where(stadium.c.a == a).order_by(fill.c.p)
        with self.reading() as connection:
            return [as_fill(row) for row in connection.execute(query)]

    def gaps(self, selection: Selection) -> str | None:
        """Say in one line which of the chosen periods are not filled, None if all that are named are."""
        with self.at_one_moment() as still, still.reading() as connection:
            known, elsewhere = still.fills(selection.a), a_filled(driver(connection))
        return describe_unfilled(known, selection.periods, selection.a, elsewhere)

    def lacking_births(self, selection: Selection, names: Sequence[str] = (), order: str = "p") -> str | None:
        """Say in one line of which chosen periods no births are stored, if they matter; None if all are.

        They matter where the subset, the columns that are shown of it, or its order depend on them.
        """
        return describe_lacking(self.without_births(selection, names, order))

    def without_births(self, selection: Selection, names: Sequence[str] = (), order: str = "p") -> list[int]:
        """Return the chosen periods that are filled and of which no births are stored, if they matter."""
        if not asks_of_lives(selection, names, order):
            return []
        with self.at_one_moment() as still, still.reading() as connection:
            filled = [fill.p for fill in still.fills(selection.a) if selection.includes(fill.p)]
            born = {each.p for each in birth_fills(connection) if each.whole}
        return [p for p in filled if p <= MAX_PERIOD and p not in born]

    def choose(
        self,
        selection: Selection,
        order: str = "p",
        columns: Sequence[str] = (),
        most: int | None = None,
        cancelled: Callable[[], bool] = never,
    ) -> Chosen:
        """Return a chosen subset as classes and their words (`orbitdb.store.reading.question.choose`)."""
        with self.reading() as connection:
            return choose(connection, selection, order, columns, most, cancelled)

    def blocks(
        self, chosen: Chosen, names: Sequence[str], first: int = 0, last: int | None = None
    ) -> Iterator[ColumnBlock]:
        """Yield rows of a subset by columns (`orbitdb.store.reading.row_blocks.blocks_of`)."""
        with self.reading() as connection:
            yield from blocks_of(connection, chosen, names, first, last)

    def row_blocks(
        self,
        selection: Selection,
        columns: Sequence[str] = CATALOGUE_COLUMNS,
        order: str = "p",
        limit: int | None = None,
        offset: int = 0,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[ColumnBlock]:
        """Yield rows of a chosen subset by columns, some at a time, as `Catalogue.rows` does one by one."""
        if unknown := [name for name in columns if name not in COLUMNS]:
            raise unknown_column(unknown[0], CATALOGUE_COLUMNS)
        most = None if limit is None else min(limit + offset, _ALL)
        with self.at_one_moment() as still:
            chosen = still.choose(selection, order, most=most, cancelled=cancelled)
            for block in still.blocks(chosen, columns, offset, most):
                if cancelled():
                    raise CancelledError
                yield block

    def rows(
        self,
        selection: Selection,
        columns: Sequence[str] = CATALOGUE_COLUMNS,
        order: str = "p",
        limit: int | None = None,
        offset: int = 0,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[tuple[Any, ...]]:
        """Yield rows of a chosen subset, one a symbol sequence, as `Catalogue.rows` does."""
        for block in self.row_blocks(selection, columns, order, limit, offset, cancelled):
            yield from block.rows()
