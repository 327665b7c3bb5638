"""The words of a catalogue: found one by one, chosen, counted, read in rows, and what is missing."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Unpack

from orbitdb.catalogue.counts import Counted, count
from orbitdb.catalogue.gaps import describe_lacking, describe_unfilled
from orbitdb.catalogue.opened import OpenedCatalogue
from orbitdb.column_files import ColumnBlock
from orbitdb.orbits.orbit import Orbit
from orbitdb.store.asking.conditions import COLUMNS, asks_of_lives
from orbitdb.store.asking.confinement import CancelledError, never
from orbitdb.store.asking.criteria import Criteria, choose, with_criteria
from orbitdb.store.asking.parsing import unknown_column
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.tables import driver
from orbitdb.store.reading import question, row_blocks
from orbitdb.store.reading.chosen import Chosen
from orbitdb.store.reading.fills import Fill
from orbitdb.store.reading.lookup import a_stored, find_word
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.words import WordError, is_primitive, parse, primitive_root

_ALL = 2**63 - 1
"""SQLite's largest integer."""


class StoredWords(OpenedCatalogue):
    """The words of a database file (`orbitdb.Catalogue`)."""

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
        with self.reading() as connection:
            return question.choose(connection, selection, order, columns, most, counted, cancelled)

    def blocks(
        self, chosen: Chosen, names: Sequence[str], first: int = 0, last: int | None = None
    ) -> Iterator[ColumnBlock]:
        """Yield rows of a subset by columns (`orbitdb.store.reading.row_blocks.blocks_of`)."""
        with self.reading() as connection:
            yield from row_blocks.blocks_of(connection, chosen, names, first, last)

    @with_criteria
    def rows(
        self,
        selection: Selection | None = None,
        columns: Sequence[str] = COLUMNS,
        order: str = "p",
        limit: int | None = None,
        offset: int = 0,
        cancelled: Callable[[], bool] = never,
        **criteria: Unpack[Criteria],
    ) -> Iterator[tuple[Any, ...]]:
        """Yield rows of a chosen subset, one a word.

        Parameters
        ----------
        selection : Selection, optional
            The subset; or name it by the criteria, as in `select`.
        columns : sequence of str, optional
            Some of the columns of the view ``catalogue``.
        order : str, optional
            Columns separated by commas; ``desc`` after a name or ``-`` before it makes it fall. Among
            equal rows the lower period, representative and element come first.
        limit, offset : int, optional
            Largest number of rows, and how many to skip first.
        cancelled : callable, optional
            Called now and then while an SQL expression is at work; if it returns true, the query stops.

        Raises
        ------
        SelectionError
            If a column is not known or ``where`` is refused.
        """
        for name in columns:
            if name not in row_blocks.COLUMNS:
                raise unknown_column(name, COLUMNS)
        most = None if limit is None else min(limit + offset, _ALL)
        with self.at_one_moment() as still:
            chosen = still.choose(self._chosen(selection, criteria), order, most=most, cancelled=cancelled)
            for block in still.blocks(chosen, columns, offset, most):
                if cancelled():
                    raise CancelledError
                yield from block.rows()

    @with_criteria
    def count(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> int:
        """Return the number of rows in a chosen subset; the parameters are those of `select`."""
        return len(self.choose(self._chosen(selection, criteria)))

    @with_criteria
    def counts(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> Counted:
        """Return the counts of the paper's Table 1 at any a: from a fill, a sweep, or births.

        Parameters
        ----------
        selection : Selection, optional
            Its a and periods count; or give them as criteria. By default all periods that are there.
        **criteria
            As in `select`.
        """
        chosen = self._chosen(selection, criteria)
        with self.at_one_moment() as still, still.reading() as connection:
            return count(connection, still.fills(chosen.a), chosen)

    @with_criteria
    def partial(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> list[Fill]:
        """Return the periods of a subset that are stored only in part, as a fill goes on or was stopped.

        The parameters are those of `select`. `select`, `classes`, `rows` and `count` include such
        periods; read both in one block of `at_one_moment`.
        """
        chosen = self._chosen(selection, criteria)
        return [fill for fill in self.fills(chosen.a) if not fill.whole and chosen.includes(fill.p)]

    @with_criteria
    def unfilled(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> str | None:
        """Say in one line which periods of a subset are not filled, what is, and what fills them.

        None if all that are named are there, if only in part (`partial`). What is not filled is not
        known to be empty. The parameters are those of `select`.
        """
        chosen = self._chosen(selection, criteria)
        with self.at_one_moment() as still, still.reading() as connection:
            known, elsewhere = still.fills(chosen.a), a_stored(driver(connection), ["fill"])
        return describe_unfilled(known, chosen.periods, chosen.a, elsewhere)

    def lacking_births(self, selection: Selection, names: Sequence[str] = (), order: str = "p") -> str | None:
        """Name in one line the chosen periods without stored births, if births matter; else None.

        They matter where the subset, the columns that are shown of it, or its order depend on them.
        """
        return describe_lacking(self.without_births(selection, names, order))

    def without_births(self, selection: Selection, names: Sequence[str] = (), order: str = "p") -> list[int]:
        """Return the chosen periods that are filled but have no stored births, if births matter."""
        if not asks_of_lives(selection, names, order):
            return []
        with self.at_one_moment() as still:
            filled = [fill.p for fill in still.fills(selection.a) if selection.includes(fill.p)]
            born = {each.p for each in still.birth_fills() if each.whole}
        return [p for p in filled if p <= MAX_PERIOD and p not in born]

    def find(self, word: str, a: float | None = None) -> Orbit | None:
        """Return the stored orbit of a primitive word, in the rotation given, or None.

        Parameters
        ----------
        word : str
            Symbols 0..5, in any rotation.
        a : float, optional
            The stadium, by default the catalogue's.

        Raises
        ------
        WordError
            If it is no word.
        """
        symbols, at = parse(word), self.a if a is None else a
        with self.reading() as connection:
            return find_word(driver(connection), symbols, at)

    def _find_or_solve(self, word: str, a: float) -> Orbit:
        if (found := self.find(word, a)) is not None:
            return found
        from orbitdb.orbits.single_word import solve_word

        return solve_word(word, a)

    def __contains__(self, word: object) -> bool:
        """Tell whether the catalogue holds a word, in any rotation and with any status."""
        try:
            return isinstance(word, str) and self.find(word) is not None
        except WordError:
            return False

    def __getitem__(self, word: str) -> Orbit:
        """Return the orbit of a word in the rotation given (run notation, too), or why there is none.

        A word that is not stored is solved now; its ``stored`` is false.

        Raises
        ------
        KeyError
            If it repeats a shorter word.
        WordError
            If it is no word.
        TypeError
            If it is no text.
        """
        symbols = parse(word)
        if not is_primitive(symbols):
            raise KeyError(f"{word} repeats {primitive_root(symbols)}: ask for that")
        return self._find_or_solve(symbols, self.a)

    def __iter__(self) -> Iterator[str]:
        """Yield the stored words by period, as least rotations."""
        return (word for (word,) in self.rows(Selection(self.a), ("code",)))

    def __len__(self) -> int:
        """Return how many words it holds, without those that are geometrically pruned."""
        return self.count(Selection(self.a))

    def __bool__(self) -> bool:
        return True

    def _chosen(self, selection: Selection | None, criteria: Criteria) -> Selection:
        if selection is not None and criteria:
            raise SelectionError("give a Selection or criteria, not both")
        if not isinstance(selection, Selection | None):
            raise TypeError(f"name a subset by criteria such as p=3 or a Selection, not by {selection!r:.40}")
        if selection is not None:
            return selection
        named = criteria.copy()
        if named.get("a") is None:
            named["a"] = self.a
        return choose(**named)
