"""Catalogue: a database of periodic orbits, opened for reading."""

import math
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import sqlalchemy as sa

from orbitdb import symmetry
from orbitdb.errors import StoreError
from orbitdb.orbits import NUMBERS, Orbit, Status
from orbitdb.pruning import pruned_word
from orbitdb.selection import Selection, SelectionError, choose
from orbitdb.stadium import Stadium
from orbitdb.store import where as free
from orbitdb.store.confinement import Patience, confined, never
from orbitdb.store.database import check_file, default_path, plain_errors, reading_engine
from orbitdb.store.fills import Fill, as_fill
from orbitdb.store.migrate import migrate
from orbitdb.store.rows import is_whole, unsound
from orbitdb.store.schema import SCHEMA_VERSION, catalogue, cycle, fill, orbit, sequence, stadium
from orbitdb.store.selecting import COLUMNS, Columns, column_of, conditions_of, ordering_of
from orbitdb.words import SYMBOLS, is_primitive, parse

if TYPE_CHECKING:
    from orbitdb.store.arrays import Subset
    from orbitdb.store.classes import ChosenClasses

_BLOCK = 2000
_ALL = 2**63 - 1
"""SQLite's largest integer."""


class Catalogue:
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default ``ORBITDB_DB`` or a file in the user's data folder.
    a : float, optional
        The stadium that words and `select` are about, unless they name another.

    Raises
    ------
    StoreError
        If there is no catalogue there, or it cannot be read by this version.

    Examples
    --------
    >>> catalogue = Catalogue("orbits.db", a=1.6)  # doctest: +SKIP
    >>> catalogue["1232131"].length, "1232131" in catalogue, len(catalogue)  # doctest: +SKIP
    >>> orbits = catalogue.select(p=(2, 11), status="orbit", lambda_c=(None, 0.4))  # doctest: +SKIP
    """

    def __init__(self, path: Path | str | None = None, a: float = 1.6) -> None:
        self.a = Stadium(a).a
        self.path = Path(path) if path is not None else default_path()
        version = check_file(self.path)
        if version is None:
            raise StoreError(f"no catalogue at {self.path}: make one with 'orbitdb fill --p 11'")
        if version < SCHEMA_VERSION:
            raise StoreError(f"{self.path} has the older schema {version}: run 'orbitdb migrate' first")
        self._engine = reading_engine(self.path)
        with plain_errors(self.path), self._engine.connect():
            pass  # so that a file that is damaged or tampered with is refused now, and not in mid-use

    @classmethod
    def create(cls, path: Path | str | None = None, a: float = 1.6) -> "Catalogue":
        """Open a catalogue, making it or bringing it to the newest schema first."""
        path = Path(path) if path is not None else default_path()
        migrate(path)
        return cls(path, a)

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Give a connection inside one read transaction: all it sees is of one moment."""
        with plain_errors(self.path), self._engine.begin() as connection:
            yield connection

    def a_values(self) -> list[float]:
        """Return the values of a that the catalogue knows, in order."""
        with self.reading() as connection:
            return list(connection.scalars(sa.select(stadium.c.a).order_by(stadium.c.a)))

    def fills(self, a: float) -> list[Fill]:
        """Return what is filled at one a, by period."""
        query = sa.select(fill).join(stadium).where(stadium.c.a == a).order_by(fill.c.p)
        with self.reading() as connection:
            return [as_fill(row) for row in connection.execute(query)]

    def find(self, word: str, a: float) -> Orbit | None:
        """Return a primitive word's stored orbit, in the rotation asked for, or None.

        Parameters
        ----------
        word : str
            Symbols 0..5, in any rotation.
        a : float
            The stadium.
        """
        if (pruned := pruned_word(word, a)) is not None:
            return self._find_pruned(pruned)
        family = symmetry.class_of(word)
        query = (
            sa.select(cycle, orbit)
            .join(orbit, orbit.c.cycle == cycle.c.id)
            .join(stadium, stadium.c.id == orbit.c.stadium)
            .where(cycle.c.p == len(word), cycle.c.word == family.representative, stadium.c.a == a)
        )
        with self.reading() as connection:
            row = connection.execute(query).mappings().first()
        if row is None:
            return None
        if not is_whole({str(name): row[name] for name in row}, len(word)):
            raise unsound("a row without what its status demands, of", family.representative)
        blob = row["coordinates"]
        coordinates = None
        if blob is not None:
            places = np.frombuffer(blob, dtype="<f8")[None, :]
            least = [family.representative]
            coordinates = symmetry.image_coordinates([word], least, family.element, places)[0]
        return Orbit(
            code=word,
            representative=family.representative,
            a=a,
            status=Status(row["status"]),
            time_reversal=row["time_reversal"],
            symmetry=row["symmetry"],
            class_size=row["class_size"],
            coordinates=coordinates,
            stored=True,
            **{name: row[name] for name in NUMBERS},
        )

    def _find_pruned(self, pruned: Orbit) -> Orbit | None:
        key = (sequence.c.p == pruned.p, sequence.c.word == pruned.representative)
        with self.reading() as connection:
            known = connection.scalar(sa.select(sequence.c.p).where(*key))
        return None if known is None else replace(pruned, stored=True)

    def __contains__(self, word: object) -> bool:
        """Tell whether what becomes of a word is stored, in any rotation and with any status."""
        return isinstance(word, str) and set(word) <= set(SYMBOLS) and self._get(word) is not None

    def __getitem__(self, word: str) -> Orbit:
        """Return the stored orbit of a word (run notation, too) in the rotation asked for.

        Raises
        ------
        KeyError
            If it is not stored; `orbitdb.solve_word` solves any word.
        """
        found = self._get(parse(word))
        if found is None:
            raise KeyError(f"{word} is not stored at a = {self.a:g}")
        return found

    def _get(self, word: str) -> Orbit | None:
        return self.find(word, self.a) if word and is_primitive(word) else None

    def __iter__(self) -> Iterator[str]:
        """Yield the stored words by period, as least rotations."""
        stored = tuple(status for status in Status if status is not Status.GEOMETRIC)
        return (word for (word,) in self.rows(Selection(self.a, statuses=stored), ("code",)))

    def __len__(self) -> int:
        """Return how many words it holds; those that are geometrically pruned are not among them."""
        query = (
            sa.select(sa.func.sum(cycle.c.class_size))
            .join(orbit, orbit.c.cycle == cycle.c.id)
            .join(stadium, stadium.c.id == orbit.c.stadium)
            .where(stadium.c.a == self.a)
        )
        with self.reading() as connection:
            return connection.scalar(query) or 0

    def __bool__(self) -> bool:
        return True

    def select(
        self,
        selection: Selection | None = None,
        *,
        order: str = "p,code",
        coordinates: bool = False,
        **criteria: Any,
    ) -> "Subset":
        """Return a chosen subset as arrays, one entry a symbol sequence.

        Parameters
        ----------
        selection : Selection, optional
            The subset; or name it by the criteria.
        order : str, optional
            Columns to sort by, as in `rows`.
        coordinates : bool, optional
            Whether to read the coordinates, too.
        **criteria
            As in `orbitdb.selection.choose`, at the catalogue's a unless ``a`` is given.

        Examples
        --------
        >>> catalogue.select(p=(2, 11), status="orbit", length=(None, 9)).words  # doctest: +SKIP
        """
        from orbitdb.store.arrays import read_subset

        return read_subset(self, self._chosen(selection, criteria), order, coordinates)

    def classes(self, selection: Selection | None = None, **criteria: Any) -> "ChosenClasses":
        """Return the symmetry classes of a chosen subset, with how many of their words are in it.

        Only classes with a length and lambda, which are orbits and, if their status is named, orbits
        through a joint. No coordinates are read; unless the subset depends on the single words
        (``contains``, ``where``) they are not read either. The parameters are those of `select`.
        """
        from orbitdb.store.classes import read_classes

        chosen = self._chosen(selection, criteria)
        return read_classes(self, chosen if chosen.statuses else replace(chosen, statuses=(Status.ORBIT,)))

    def _chosen(self, selection: Selection | None, criteria: dict[str, Any]) -> Selection:
        if selection is not None and criteria:
            raise SelectionError("give a Selection or criteria, not both")
        return choose(**{"a": self.a} | criteria) if selection is None else selection

    def count(self, selection: Selection) -> int:
        """Return the number of rows in a chosen subset."""
        query = sa.select(sa.func.count()).select_from(catalogue)
        with self.selecting(selection) as (connection, conditions, _):
            return connection.scalar(query.where(*conditions)) or 0

    def rows(
        self,
        selection: Selection,
        columns: Sequence[str] = COLUMNS,
        order: str = "p,code",
        limit: int | None = None,
        offset: int = 0,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[tuple[Any, ...]]:
        """Yield rows of a chosen subset, one a symbol sequence.

        Parameters
        ----------
        selection : Selection
        columns : sequence of str, optional
            Some of `COLUMNS`.
        order : str, optional
            Columns with commas between, each with ``desc`` behind it or ``-`` before it to fall.
        limit, offset : int, optional
            How many rows at most, and how many to pass over first.
        cancelled : callable, optional
            Asked now and then, while there is a free expression, whether to stop.

        Raises
        ------
        SelectionError
            If a column is not known or ``where`` is refused.
        """
        query = sa.select(*(column_of(name) for name in columns)).order_by(*ordering_of(order))
        if limit is not None or offset:
            query = query.limit(-1 if limit is None else min(limit, _ALL)).offset(min(offset, _ALL))
        with self.selecting(selection, cancelled=cancelled) as (connection, conditions, patience):
            result = connection.execute(query.where(*conditions))
            while block := result.fetchmany(_BLOCK):
                with patience.resting():
                    yield from map(tuple, block)

    @contextmanager
    def selecting(
        self,
        selection: Selection,
        columns: Columns = catalogue.c,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[tuple[sa.Connection, list[sa.ColumnElement[bool] | sa.TextClause], Patience]]:
        """Give a connection for one query over a subset, confined if it has a free expression."""
        with self.reading() as connection:
            if selection.where is None:
                yield connection, conditions_of(selection, columns), Patience(math.inf, never)
                return
            free.check(selection.where, dict(selection.parameters))
            with confined(connection, cancelled) as patience:
                try:
                    yield connection, conditions_of(selection, columns), patience
                except (sa.exc.DBAPIError, sqlite3.Error) as error:
                    message = str(getattr(error, "orig", error))
                    if "interrupted" in message and not patience.ended:
                        raise KeyboardInterrupt from error  # SQLite, asked for the time, swallows it
                    raise free.refusal(selection.where, message) from error
