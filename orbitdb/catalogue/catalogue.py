"""Catalogue: a database of periodic orbits, opened for reading."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Unpack

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.counted import Counted, count
from orbitdb.catalogue.gaps import describe_lacking, describe_unfilled
from orbitdb.catalogue.opened import OpenedCatalogue
from orbitdb.column_files import ColumnBlock
from orbitdb.entropy.entropy_bounds import EntropyBounds
from orbitdb.orbits.orbit import Orbit, Status
from orbitdb.store.asking.conditions import COLUMNS, asks_of_lives
from orbitdb.store.asking.confinement import CancelledError, never
from orbitdb.store.asking.criteria import Criteria, choose, with_criteria
from orbitdb.store.asking.parsing import unknown_column
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.asking.sweepable import swept_text
from orbitdb.store.file.engines import driver
from orbitdb.store.reading import lives, question, records, row_blocks, sweeps
from orbitdb.store.reading.chosen import Chosen
from orbitdb.store.reading.fills import Fill
from orbitdb.store.reading.lives import BirthFill, Life
from orbitdb.store.reading.lookup import a_stored, find_word
from orbitdb.store.reading.sweeps import Sweep
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.words import WordError, is_primitive, parse, primitive_root

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from orbitdb.catalogue.chosen_classes import ChosenClasses
    from orbitdb.catalogue.identification import Candidate, Trajectory
    from orbitdb.catalogue.results import Result
    from orbitdb.catalogue.subset import Subset
    from orbitdb.quantum.spectrum import Spectrum
    from orbitdb.trajectories.ensemble import Reference

_ALL = 2**63 - 1
"""SQLite's largest integer."""

_SOLVED = tuple(status for status in Status if status is not Status.GEOMETRIC)


class Catalogue(OpenedCatalogue):
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default that of ``ORBITDB_DB``, or one in your data folder.
    a : float, optional
        The stadium of all questions that name none; by default the only one with orbits in the
        catalogue, else 1.6.

    Raises
    ------
    StoreError
        If there is no catalogue there, or it cannot be read by this version.

    Examples
    --------
    >>> catalogue = Catalogue("orbits.db", a=1.6)
    >>> catalogue
    <Catalogue orbits.db: periods 2-11 at a = 1.6>
    >>> round(catalogue["1232131"].length, 9), "1232131" in catalogue, len(catalogue)
    (22.454362411, True, 89789)
    >>> catalogue.select(p="2-11", status="orbit", lambda_c=(None, 0.35))
    <74 orbits of period 2 to 11 at a = 1.6 with lambda_c <= 0.35>

    A ``with`` block closes it. The next question opens it again:

    >>> with Catalogue("orbits.db") as catalogue:
    ...     catalogue.count(p=7, status="orbit")
    376
    """

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
            return question.choose(connection, selection, order, columns, most, cancelled)

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

    def identify(
        self,
        *,
        start: Sequence[float] | None = None,
        points: "ArrayLike | None" = None,
        tolerance: float | None = None,
        bounces: int | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "Trajectory":
        """Find the orbits that a trajectory shadows, from its start or from its bounces.

        The trajectory becomes symbols. Its pieces between near returns, of up to 24 bounces, become words
        and are solved, stored or not; the result has the orbits that the trajectory stays with for two
        bounces or more.

        Parameters
        ----------
        start : (float, float, float), optional
            x, y from the middle of the stadium, inside it or on its boundary, and the angle of the path from
            the x axis (radians). The trajectory is followed forward and back.
        points : array-like, shape (N, 2), optional
            Instead of a start: x, y of 3 to 1000 successive bounces; the last may be the first again. All of
            them together are one more word to try, of any period. A point that is closer to a joint of wall
            and semicircle than its error may land on the wrong side of it, and then the word is not found.
        tolerance : float, optional
            Largest distance of a bounce from that of the orbit and of points from the boundary, at most 1;
            0.01 by default.
        bounces : int, optional
            Bounces to follow from a start, each way; by default 60. The trajectory ends where rounding may
            have moved a bounce by the tolerance.
        limit : int, optional
            Largest number of orbits; by default 10.
        a : float, optional
            The stadium, by default the catalogue's.

        Returns
        -------
        Trajectory
            First the orbit that the trajectory goes round most often.

        Raises
        ------
        InputError
            If you give not one of start and points, or a value that cannot be used.

        Examples
        --------
        >>> found = catalogue.identify(start=(0, 0.001, 0))
        >>> [(each.orbit.code, each.first, each.bounces) for each in found.shadowed[:1]]
        [('31', -1, 4)]
        """
        from orbitdb.catalogue.identification import identify_trajectory

        at = Stadium(self.a if a is None else a)
        find = partial(self._find_or_solve, a=at.a)
        return identify_trajectory(at, find, start, points, tolerance, bounces, limit)

    def with_length(
        self,
        length: float,
        tolerance: float | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "tuple[Candidate, ...]":
        """Find the stored orbits that have a length, repeated or not; the nearest come first.

        Parameters
        ----------
        length : float
            In units of the radius.
        tolerance : float, optional
            Largest difference, at most 1; 0.001 by default. Error bounds of stored lengths come on top.
        limit : int, optional
            Largest number of orbits; by default all.
        a : float, optional
            The stadium, by default the catalogue's.

        Raises
        ------
        InputError
            If a value cannot be used.

        Examples
        --------
        >>> [(each.code, each.repetitions) for each in catalogue.with_length(20.8)]
        [('13', 2)]
        """
        from orbitdb.catalogue.identification import identify_length

        with self.reading() as connection:
            return identify_length(
                connection, Stadium(self.a if a is None else a).a, length, tolerance, limit
            )

    def spectrum(
        self,
        lengths: "ArrayLike" = (1.0, 12.0),
        *,
        points: int = 500,
        k_max: float | None = None,
        levels: "ArrayLike | None" = None,
        parity: str | None = None,
        a: float | None = None,
    ) -> "Spectrum":
        """Return the length spectrum of the stored orbits, and beside it that of levels.

        Parameters
        ----------
        lengths : (float, float), optional
            The least and the largest, in units of the radius.
        points : int, optional
            Number of lengths.
        k_max : float, optional
            End of the window, in 1/radius; by default the end of the levels, or 30 without levels.
        levels : array-like, shape (N,), optional
            All levels k from the lowest on, in rising order; by default those in the catalogue.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo``; by default all levels together.
        a : float, optional
            The stadium; by default the catalogue's.

        Raises
        ------
        InputError
            If there are no orbits, or an argument cannot be used.
        """
        from orbitdb.catalogue.spectrum import read_spectrum

        return read_spectrum(self, self.a if a is None else a, lengths, points, k_max, levels, parity)

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

    def __contains__(self, word: object) -> bool:
        """Tell whether the catalogue holds a word, in any rotation and with any status."""
        try:
            return isinstance(word, str) and is_primitive(parse(word)) and self.find(word) is not None
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

    def _find_or_solve(self, word: str, a: float) -> Orbit:
        if (found := self.find(word, a)) is not None:
            return found
        from orbitdb.orbits.single_word import solve_word

        return solve_word(word, a)

    def __iter__(self) -> Iterator[str]:
        """Yield the stored words by period, as least rotations."""
        return (word for (word,) in self.rows(Selection(self.a, statuses=_SOLVED), ("code",)))

    def __len__(self) -> int:
        """Return how many words it holds, without those that are geometrically pruned."""
        return self.count(Selection(self.a, statuses=_SOLVED))

    def __bool__(self) -> bool:
        return True

    @with_criteria
    def select(
        self,
        selection: Selection | None = None,
        *,
        order: str = "p",
        coordinates: bool = False,
        **criteria: Unpack[Criteria],
    ) -> "Subset":
        """Return a chosen subset as arrays, one entry a word.

        Parameters
        ----------
        selection : Selection, optional
            The subset; or give the criteria.
        order : str, optional
            Columns to sort by, as in `rows`.
        coordinates : bool, optional
            Whether to read the coordinates, too.
        a : float, optional
            The stadium, by default the catalogue's.
        p : int, str or iterable of int, optional
            A period, text such as ``2,3,5-7``, or several: ``range(2, 6)``, a list, an array.
        status : Status, str or iterable of them, optional
            One or several, also as a text with commas, such as ``orbit,boundary``.
        time_reversal, symmetry, contains, where, parameters : optional
            As in `Selection`.
        exists, not_at : float or iterable of float, optional
            Values of a at which the words are orbits, and at which they are not.
        length, lyapunov, lambda_d, lambda_c, margin, born, dies : (float or None, float or None), optional
            Least and greatest value, such as ``length=(3, None)``.

        Raises
        ------
        SelectionError
            If a criterion cannot be used.

        Examples
        --------
        >>> catalogue.select(p="2-11", status="orbit", length=(None, 11)).codes
        array(['13', '013', '031', '132', '123'], dtype=StringDType())
        """
        from orbitdb.catalogue.subset import read_subset

        return read_subset(self, self._chosen(selection, criteria), order, coordinates)

    @with_criteria
    def classes(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "ChosenClasses":
        """Return the symmetry classes of a chosen subset, with the number of their words in it.

        These are the classes with a length and lambda: orbits and, if you name their status, orbits
        through a joint. The parameters are those of `select`.

        Raises
        ------
        SelectionError
            If you name a status whose words have no length and lambda.
        """
        from orbitdb.catalogue.chosen_classes import read_classes

        chosen = self._chosen(selection, criteria)
        return read_classes(self, chosen if chosen.statuses else replace(chosen, statuses=(Status.ORBIT,)))

    @with_criteria
    def table(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Result":
        """Return the paper's Table 1: counts of words and orbits by period, and the entropy K_0.

        Of the parameters of `select`, a and periods count. Where nothing is filled, the counts come from
        a sweep or from births.

        Examples
        --------
        >>> catalogue.table(p="2-4")["N_c"]
        [1, 8, 32]
        """
        from orbitdb.catalogue.averaged import table

        return table(self, self._chosen(selection, criteria))

    @with_criteria
    def entropy(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Result":
        """Return the topological entropy of chosen orbits by period, with proved bounds beside it.

        The parameters are those of `select`.

        Examples
        --------
        >>> [round(h, 4) for h in catalogue.entropy(p="2-11")["h_zeta"][-2:]]
        [1.1629, 1.1611]
        """
        from orbitdb.catalogue.averaged import entropy

        return entropy(self, self._chosen(selection, criteria))

    @with_criteria
    def lyapunov(
        self,
        selection: Selection | None = None,
        *,
        weight: str = "exp",
        cut: float | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Result":
        """Return the average Lyapunov exponents of chosen orbits by period, by every method.

        Parameters
        ----------
        selection : Selection, optional
            The subset; or give the criteria, as in `select`.
        weight : str, optional
            ``exp``: weights e^-lambda, as in the paper; ``det``: ``1/|det(1 - M)|``.
        cut : float, optional
            Return one zeta average instead, over all pseudo-cycles with a lambda up to this.

        Raises
        ------
        InputError
            If weight or cut cannot be used.
        """
        from orbitdb.catalogue.averaged import lyapunov

        return lyapunov(self, self._chosen(selection, criteria), weight, cut)

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

    @with_criteria
    def count(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> int:
        """Return the number of rows in a chosen subset; the parameters are those of `select`."""
        return len(self.choose(self._chosen(selection, criteria)))
