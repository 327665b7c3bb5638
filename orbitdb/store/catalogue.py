"""Catalogue: a database of periodic orbits, opened for reading."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.orbits import Orbit, Status
from orbitdb.selection import Selection, SelectionError, choose
from orbitdb.stadium import Stadium
from orbitdb.store.confinement import Patience, never
from orbitdb.store.database import check_file, default_path, plain_errors, reading_engine
from orbitdb.store.fills import Fill, as_fill, describe_unfilled
from orbitdb.store.lookup import find_word
from orbitdb.store.migrate import migrate
from orbitdb.store.narrowing import count_rows, few_words
from orbitdb.store.schema import SCHEMA_VERSION, catalogue, fill, stadium
from orbitdb.store.selecting import COLUMNS, Columns, answering, column_of, conditions_of, ordering_of
from orbitdb.store.stadiums import a_filled, a_stored, meant
from orbitdb.words import SYMBOLS, is_primitive, parse

if TYPE_CHECKING:
    from orbitdb.store.arrays import Subset
    from orbitdb.store.classes import ChosenClasses

_BLOCK = 2000
_SOLVED = tuple(status for status in Status if status is not Status.GEOMETRIC)
_ALL = 2**63 - 1
"""SQLite's largest integer."""


class Catalogue:
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default ``ORBITDB_DB`` or a file in the user's data folder.
    a : float, optional
        The stadium that words and `select` are about, unless they name another; by default the only
        one of which the catalogue has orbits, else 1.6.

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

    def __init__(self, path: Path | str | None = None, a: float | None = None) -> None:
        self._a = None if a is None else Stadium(a).a
        self.path = Path(path) if path is not None else default_path()
        version = check_file(self.path)
        if version is None:
            raise StoreError(f"no catalogue at {self.path}: make one with 'orbitdb fill --p 11'")
        if version < SCHEMA_VERSION:
            raise StoreError(f"{self.path} has the older schema {version}: run 'orbitdb migrate' first")
        self._engine = reading_engine(self.path)
        with plain_errors(self.path), self._engine.connect():
            pass  # so that a file that is damaged or tampered with is refused now, and not in mid-use
        self._engine.dispose()
        self._moment: sa.Connection | None = None

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> "Catalogue":
        """Open a catalogue, making it or bringing it to the newest schema first."""
        path = Path(path) if path is not None else default_path()
        migrate(path)
        return cls(path, a)

    @property
    def a(self) -> float:
        """The stadium that is meant where none is named; once it is asked for, it stays the same.

        Raises
        ------
        InputError
            If none was given, and the catalogue has orbits at several, but none at 1.6.
        """
        if self._a is None:
            with self.reading() as connection:
                self._a = meant(a_stored(connection))
        return self._a

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
    def at_one_moment(self) -> Iterator["Catalogue"]:
        """Give the catalogue as it is when it is first read: its numbers, from however many queries, agree.

        What a fill stores meanwhile is seen behind the block.
        """
        with self.reading() as connection:
            still = copy(self)
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

    def partial(self, selection: Selection | None = None, **criteria: Any) -> list[Fill]:
        """Return those periods of a subset that are stored in part: a fill goes on, or was stopped.

        The parameters are those of `select`. Rows of such periods are among those that `select`,
        `classes`, `rows` and `count` give; read both in one block of `at_one_moment`.
        """
        chosen = self._chosen(selection, criteria)
        return [fill for fill in self.fills(chosen.a) if not fill.whole and chosen.includes(fill.p)]

    def unfilled(self, selection: Selection | None = None, **criteria: Any) -> str | None:
        """Say in one line which periods of a subset are not filled, what is, and what fills them.

        None if all that are named are there, if only in part (`partial`). What is not filled is not
        known to be empty. The parameters are those of `select`.
        """
        chosen = self._chosen(selection, criteria)
        with self.at_one_moment() as still, still.reading() as connection:
            return describe_unfilled(still.fills(chosen.a), chosen.periods, chosen.a, a_filled(connection))

    def find(self, word: str, a: float) -> Orbit | None:
        """Return a primitive word's stored orbit, in the rotation asked for, or None.

        Parameters
        ----------
        word : str
            Symbols 0..5, in any rotation.
        a : float
            The stadium.
        """
        with self.reading() as connection:
            return find_word(connection, word, a)

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
        return (word for (word,) in self.rows(Selection(self.a, statuses=_SOLVED), ("code",)))

    def __len__(self) -> int:
        """Return how many words it holds; those that are geometrically pruned are not among them."""
        return self.count(Selection(self.a, statuses=_SOLVED))

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
        if selection is not None:
            return selection
        return choose(**criteria) if "a" in criteria else choose(self.a, **criteria)

    def count(self, selection: Selection) -> int:
        """Return the number of rows in a chosen subset."""
        with self.reading() as connection:
            return count_rows(connection, selection)

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
        with self.reading() as connection:
            query, patience = query.where(*conditions_of(selection)), Patience(cancelled=cancelled)
            wanted = None if limit is None else limit + offset
            if (words := few_words(connection, selection, order, wanted, patience)) is not None:
                orders = sorted(set(map(len, words)))
                query = query.where(catalogue.c.p.in_(orders), catalogue.c.word.in_(words))
            with answering(connection, selection, patience):
                result = connection.execute(query)
            while True:
                with answering(connection, selection, patience):
                    block = result.fetchmany(_BLOCK)
                if not block:
                    return
                yield from map(tuple, block)  # the connection is free for other queries meanwhile

    @contextmanager
    def selecting(
        self, selection: Selection, columns: Columns = catalogue.c
    ) -> Iterator[tuple[sa.Connection, list[sa.ColumnElement[bool] | sa.TextClause]]]:
        """Give a connection for one query over a subset, confined if it has a free expression."""
        with self.reading() as connection:
            conditions = conditions_of(selection, columns)
            with answering(connection, selection, Patience()):
                yield connection, conditions
