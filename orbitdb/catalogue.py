"""`Catalogue`, the main class of the library: a database of periodic orbits to fill, query and check."""

import math
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from copy import copy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar, Unpack, cast, overload

from orbitdb.billiard.stadium import Stadium
from orbitdb.criteria import OF_STATUS, Criteria, with_criteria
from orbitdb.display import Rows, load
from orbitdb.errors import InputError, SelectionError, StoreError, as_texts, check_int, check_text
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import STORED, Status
from orbitdb.period_ranges import check_periods, periods_to_make
from orbitdb.progress import Tell, nobody, telling
from orbitdb.selection import Selection
from orbitdb.sql_text import names_in
from orbitdb.store.file import Moment, Store
from orbitdb.store.lookup import (
    WITH_ORBITS,
    a_values,
    born_with,
    certificate_of,
    default_a,
    find_words,
    note_on_a,
)
from orbitdb.store.paths import FileId, as_path, default_path, home_expanded, network_disk
from orbitdb.store.sqlite import Connection, never
from orbitdb.symbols.words import WordError, is_primitive, parse, primitive_root, read_words

if TYPE_CHECKING:
    import numpy as np
    import sqlalchemy
    from numpy.typing import ArrayLike

    from orbitdb.answers.dataset import Dataset
    from orbitdb.answers.field import FieldOrbits
    from orbitdb.answers.histogram import Histogram
    from orbitdb.answers.identification import Candidates, Trajectory
    from orbitdb.answers.info import Info
    from orbitdb.answers.listing import Listing
    from orbitdb.answers.results import Births, Result
    from orbitdb.answers.scars import Scar
    from orbitdb.answers.sql_result import SqlResult
    from orbitdb.answers.subset import Subset
    from orbitdb.entropy_bounds.bounds import EntropyBounds
    from orbitdb.filling.estimate import Need
    from orbitdb.filling.workers import Workers
    from orbitdb.open_stadium.escape import Escape
    from orbitdb.open_stadium.openings import Opening
    from orbitdb.orbits.exponents import OrbitClasses
    from orbitdb.plots.style import Picture
    from orbitdb.quantum.exact_levels import Levels
    from orbitdb.quantum.length_spectrum import Spectrum
    from orbitdb.quantum.missing_levels import Assessment
    from orbitdb.quantum.weyl import Parity, Wavenumbers
    from orbitdb.store.file import Migration
    from orbitdb.store.merging import Merged
    from orbitdb.store.periods import BirthFill, Contents, Fill, Sweep
    from orbitdb.trajectories.ensemble import Reference
    from orbitdb.trajectories.pruning_front import PruningFront
    from orbitdb.verification.verify import Verification

_Answer = TypeVar("_Answer")
_Noted = TypeVar("_Noted", "Result", "Trajectory", "FieldOrbits", "Levels", "Assessment", "Subset")

_ORBITS: tuple[Status, ...] = (Status.ORBIT,)
_EVERY: tuple[Status, ...] = ()
"""What some questions choose unless a status is named, whatever else they ask for."""


class Catalogue:
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.
    a : float, optional
        Half length of the stadium; all methods take another one as ``a``. If you give none, it is the only
        value with stored orbits, or else 1.6.
    missing_ok : bool, optional
        Whether a missing file is an empty catalogue; `create` makes one in which something can be stored.

    Raises
    ------
    StoreError
        If there is no catalogue at the path, unless `missing_ok`, or if this version cannot read it.

    Examples
    --------
    >>> catalogue = Catalogue("orbits.db", a=1.6)
    >>> catalogue
    <Catalogue orbits.db: periods 2-11 at a = 1.6>
    >>> round(catalogue["1232131"].length, 9), "1232131" in catalogue, len(catalogue)
    (22.454362411, True, 47157)
    >>> print(catalogue.select(p="2-11", status="orbit", lambda_c=(None, 0.35)))
    <74 orbits of period 2 to 11 at a = 1.6 with lambda_c <= 0.35>

    Each question opens the file, reads it as it is at that moment, and closes it again. `snapshot` asks
    several questions at one moment, which is also faster.
    """

    # the file

    def __init__(
        self, path: Path | str | None = None, a: float | None = None, *, missing_ok: bool = False
    ) -> None:
        self._a = None if a is None else Stadium(a).a
        self._missing_ok = missing_ok
        self._store: Store | Moment = Store(path, missing_ok)

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> Self:
        """Open a catalogue; create a missing one first, and upgrade an old one to the latest schema."""
        cls.migrate(path)
        return cls(path, a)

    @staticmethod
    def migrate(path: Path | str | None = None) -> "Migration":
        """Create a missing catalogue, or upgrade an old one; return its schema before and after, 0 if new."""
        from orbitdb.store.file import migrate

        return migrate(default_path() if path is None else home_expanded(path))

    @property
    def path(self) -> Path:
        """Absolute path of the file."""
        return self._store.path

    @property
    def missing(self) -> bool:
        """Whether there is no file yet (`missing_ok`)."""
        return not self._store.there()

    @property
    def warning(self) -> str | None:
        """A line that says why the file should be filled elsewhere: it is on a network disk; else None."""
        if (kind := network_disk(self.path)) is None:
            return None
        return (
            f"{self.path} is on a network disk ({kind}), where SQLite's journal works on one machine at a "
            "time: use it from one machine only, or fill on a local disk and copy the file afterwards"
        )

    @property
    def a(self) -> float:
        """Half length of the default stadium: the one that you gave, or else what the file now suggests.

        Raises
        ------
        InputError
            If you gave none, and orbits are stored at several values of ``a`` but not at 1.6.
        """
        return self._at(None)

    @property
    def note_on_a(self) -> str | None:
        """A line on the default ``a`` if it is not 1.6, or one of several; results have it in their notes."""
        return next(iter(self._on_a(None)), None)

    @contextmanager
    def snapshot(self, cancelled: Callable[[], bool] = never) -> Iterator[Self]:
        """Yield the catalogue as it is now; its answers do not show what others write meanwhile.

        It can only be read, in the ``with`` block and by the thread that opened it. The catalogue itself
        still reads the present, and can be written to. A snapshot of a snapshot is the same snapshot.

        Parameters
        ----------
        cancelled : callable, optional
            Called now and then during long questions; if it returns True, `CancelledError` is raised.

        Raises
        ------
        StoreError
            If the file was replaced by another one before the end of the block.

        Examples
        --------
        >>> with catalogue.snapshot() as then:
        ...     then.count(p=5) == then.table(p=5)["N_c"][0]
        True
        """
        if isinstance(self._store, Moment):
            yield self
            return
        with self._store.snapshot(cancelled) as moment:
            then = copy(self)
            then._store = moment
            yield then

    def _reading(self) -> AbstractContextManager[Connection]:
        """Return a connection for one question: that of the snapshot, or a new one."""
        return self._store.reading()

    def _present(self, what: str = "writing") -> Store:
        """Return the file as it is now, which a snapshot refuses to write to or to give away."""
        if isinstance(self._store, Moment):
            raise InputError(f"a snapshot only answers questions: ask the catalogue itself for {what}")
        return self._store

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Do nothing; the file is open only during a question."""

    @property
    def engine(self) -> "sqlalchemy.Engine":
        """SQLAlchemy's engine for SQL of your own, such as ``pandas.read_sql(query, catalogue.engine)``.

        Its connections read the tables and views of `orbitdb sql`, and know ``code()`` and ``contains()``;
        they cannot write.
        """
        return self._present("its engine").engine

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle only the arguments; the copy opens the file itself."""
        return partial(type(self), missing_ok=self._missing_ok), (self._present("a copy").path, self._a)

    def __repr__(self) -> str:
        from orbitdb.answers.completeness import describe_contents

        try:
            with self._reading() as connection:
                contents = describe_contents(connection, self._a)
        except (StoreError, InputError) as error:  # a snapshot may have ended
            contents = str(error)
        return f"<Catalogue {self.path.name}: {contents}>"

    # what is stored

    def info(self, *, facts: bool = True) -> "Info":
        """Return what the file contains, and the time and disk space that it took.

        Without `facts`, return only the filled and swept periods; the sizes of rows take long in large files.
        """
        from orbitdb.answers.info import read_info

        with self._reading() as connection:
            return read_info(connection, facts)

    def sql(self, statement: str, parameters: Mapping[str, str | int | float] | None = None) -> "SqlResult":
        """Return the rows of one SELECT statement, over all values of ``a``, read on demand.

        The statement can read the views ``catalogue`` (one row per word), ``class`` (one row per class) and
        ``life`` (births and deaths). It cannot write, and is stopped after a minute.

        Parameters
        ----------
        statement : str
        parameters : mapping, optional
            Values for the names (``:name``) in the statement.

        Examples
        --------
        >>> [*catalogue.sql("SELECT max(p) FROM catalogue WHERE a = :a", {"a": 1.6})]
        [(11,)]
        """
        from orbitdb.answers.sql_result import SqlResult

        check_text("statement", statement, "SELECT max(p) FROM catalogue")
        return SqlResult(self._reading, statement, parameters or {})

    def a_values(self, *, orbits: bool = False, with_levels: bool = False) -> list[float]:
        """Return the stored values of ``a`` in order.

        With `orbits`, only those with orbits or sweeps; `with_levels`, also those with levels alone.
        """
        if with_levels:
            from orbitdb.verification.verify import verifiable

            with self._reading() as connection:
                return verifiable(connection)
        with self._reading() as connection:
            return a_values(connection, WITH_ORBITS if orbits else ())

    def fills(self, *, a: float | None = None) -> "Rows[Fill]":
        """Return the fills at a given ``a``, in order of period."""
        from orbitdb.store.periods import read_fills

        with self._reading() as connection:
            return Rows(read_fills(connection, self._at(a, connection)))

    def birth_fills(self) -> "Rows[BirthFill]":
        """Return how far births and deaths are stored, period by period."""
        from orbitdb.store.periods import read_birth_fills

        with self._reading() as connection:
            return Rows(read_birth_fills(connection))

    def births(self, p: int) -> "Births":
        """Return the ranges of ``a`` in which the classes of a period are orbits, in order of birth.

        If not all births of the period are stored, `Births.notes` says so.

        Raises
        ------
        InputError
            If no catalogue can have births of the period.
        """
        from orbitdb.answers.results import Births
        from orbitdb.store.lookup import read_lives
        from orbitdb.store.periods import read_birth_fills

        period = check_int("p", p, -math.inf)
        check_periods([(period, period)])
        missing = f"births of period {period} are not stored: `catalogue.fill_births(p={period})` finds them"
        with self._reading() as connection:
            found = Births(read_lives(connection, period))
            fills = [fill for fill in read_birth_fills(connection) if fill.p == period]
        found.notes = fills[0].notes if fills else (missing,)
        return found

    def entropy_bounds(
        self, *, a: float | None = None, arithmetic: str | None = None
    ) -> "EntropyBounds | None":
        """Return the tightest bounds on the topological entropy that `prove_bounds` stored, or None.

        Parameters
        ----------
        arithmetic : str, optional
            ``doubles`` or ``balls``, for bounds proved in this arithmetic only; by default in either.
        """
        from orbitdb.store.stored_values import tightest_bounds

        with self._reading() as connection:
            return tightest_bounds(connection, self._at(a, connection), arithmetic)

    def entropy_curve(self, *, arithmetic: str | None = None) -> "Rows[EntropyBounds]":
        """Return the tightest stored bounds on the topological entropy at every ``a`` that has any."""
        from orbitdb.store.stored_values import bounds_by_a

        with self._reading() as connection:
            return Rows(bounds_by_a(connection, arithmetic))

    def reference(self, *, a: float | None = None) -> "Reference | None":
        """Return the averages over trajectories, with the smallest error, that `simulate` stored, or None."""
        from orbitdb.store.stored_values import best_reference

        with self._reading() as connection:
            found = best_reference(connection, self._at(a, connection))
            return None if found is None else replace(found, on_a=self._on_a(a, connection))

    def sweeps(self, *, a: float | None = None) -> "Rows[Sweep]":
        """Return the sweeps at a given ``a``, with their counts and sums, in order of period."""
        from orbitdb.store.periods import read_sweeps

        with self._reading() as connection:
            return Rows(read_sweeps(connection, self._at(a, connection)))

    def contents(self, a: float, p: int | str | Iterable[int] | None = None) -> "Contents":
        """Return what is stored at a given ``a``, in some periods or in all; `delete` would delete it."""
        from orbitdb.store.periods import contents

        chosen = Selection.from_criteria(a=a, p=p)
        with self._reading() as connection:
            return contents(connection, chosen.a, chosen.periods)

    # one word

    @overload
    def find(  # type: ignore[overload-overlap]  # a text is also an iterable of texts
        self, code: str, *, errors: str = "raise", a: float | None = None
    ) -> Orbit | None: ...
    @overload
    def find(
        self, code: Iterable[str], *, errors: str = "raise", a: float | None = None
    ) -> list[Orbit | None]: ...
    def find(
        self, code: str | Iterable[str], *, errors: str = "raise", a: float | None = None
    ) -> Orbit | list[Orbit | None] | None:
        """Return the stored orbit of a primitive word, in the given rotation, or None if it is not stored.

        Parameters
        ----------
        code : str or iterable of str
            Symbols 0 to 5, or run notation. For several words, which are one question, it returns a list.
        errors : str, optional
            ``skip`` to leave out words of a list that cannot be read; by default they raise.

        Raises
        ------
        WordError
            If a text is not a word; of a list, all such words are named by their places.
        """
        alone = isinstance(code, str)
        words = read_words(as_texts("code", code), errors, parse)
        with self._reading() as connection:
            found = find_words(connection, words, self._at(a, connection))
        return found[0] if alone else found

    def __contains__(self, word: object) -> bool:
        """Tell whether a word is stored, whatever its rotation and status."""
        try:
            return isinstance(word, str) and self.find(word) is not None
        except WordError:
            return False

    def __getitem__(self, word: str) -> Orbit:
        """Return the orbit of a word, in the given rotation, whatever its status.

        A word that is not stored is solved on the spot; its orbit has ``stored`` false. A word that repeats a
        shorter one raises a `KeyError`, and a text that is not a word a `WordError`.
        """
        symbols = parse(word)
        if not is_primitive(symbols):
            raise KeyError(f"{word} repeats {primitive_root(symbols)}: ask for the shorter word")
        return self.orbit(symbols)

    @overload
    def orbit(  # type: ignore[overload-overlap]  # a text is also an iterable of texts
        self, code: str, *, errors: str = "raise", a: float | None = None, exists: bool = False
    ) -> Orbit: ...
    @overload
    def orbit(
        self, code: Iterable[str], *, errors: str = "raise", a: float | None = None, exists: bool = False
    ) -> list[Orbit]: ...
    def orbit(
        self,
        code: str | Iterable[str],
        *,
        errors: str = "raise",
        a: float | None = None,
        exists: bool = False,
    ) -> Orbit | list[Orbit]:
        """Return the orbit of a primitive word at a given ``a``, stored or solved on the spot.

        With `exists`, the ranges of ``a`` in which it exists are computed if they are not stored. The other
        parameters are those of `find`; for several words, it returns a list.
        """
        words = read_words(as_texts("code", code), errors)
        with self._reading() as connection:
            at = self._at(a, connection)
            found = find_words(connection, words, at)
        new = [each for each, orbit in zip(words, found, strict=True) if orbit is None]
        if new or exists:
            from orbitdb.orbits.solve import solve_words, with_existence

            solved = iter(solve_words(new, Stadium(at)))
            found = [next(solved) if orbit is None else orbit for orbit in found]
        orbits = [with_existence(orbit) if exists else orbit for orbit in found if orbit is not None]
        return orbits[0] if isinstance(code, str) else orbits

    def born_with(self, orbit: Orbit) -> list[tuple[float, list[str]]]:
        """Return the stored births of an orbit, each with the classes that are born on the same path.

        They are given by their representatives. Classes with another period are left out.
        """
        _check_orbit(orbit)
        with self._reading() as connection:
            return born_with(connection, orbit)

    def certificate(self, orbit: Orbit) -> tuple[float, int] | None:
        """Return the radius and the number of bits of the stored proof of an orbit, or None."""
        _check_orbit(orbit)
        with self._reading() as connection:
            return certificate_of(connection, orbit.representative, orbit.a)

    def __iter__(self) -> Iterator[str]:
        """Yield the words of the stored orbits, as least rotations, in order of period."""
        return (word for (word,) in self.rows(columns=("code",)))

    def __len__(self) -> int:
        """Return the number of stored orbits."""
        return self.count()

    def __bool__(self) -> bool:
        return True

    # chosen subsets

    @with_criteria
    def rows(
        self,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        columns: Sequence[str] | None = None,
        order: str = "p",
        limit: int | None = None,
        offset: int = 0,
        classes: bool = False,
        **criteria: Unpack[Criteria],
    ) -> "Listing":
        """Return the rows of a subset, one per word (criteria: see `Selection`).

        Iterating over the result reads the rows; it also says how many there are, and what is missing.

        Parameters
        ----------
        selection : Selection or sequence of Selection, optional
            The subset, or one for each of several a; you can give criteria instead, also with several ``a``.
        columns : sequence of str, optional
            Names of columns of the view ``catalogue``, by default all, or ``coordinates``, ``area_slope`` or
            ``words``.
        order : str, optional
            Columns to sort by, separated by commas; ``desc`` after a name, or ``-`` before it, reverses the
            order. Ties are broken by period, representative and element, in ascending order.
        limit, offset : int, optional
            Maximum number of rows to yield, and number of rows to skip first, both at each a.
        classes : bool, optional
            Whether to return one row per symmetry class with chosen words: that of the least of them. The
            column ``words``, then shown by default, is their number.

        Examples
        --------
        >>> for code, length in catalogue.rows(p="2-11", order="length", limit=2, columns=("code", "length")):
        ...     print(code, round(length, 6))
        13 10.4
        013 10.850685
        """
        from orbitdb.answers.listing import Listing
        from orbitdb.store.select import WORDS
        from orbitdb.store.views import VIEWED

        first = check_int("offset", offset, 0)
        most = None if limit is None else check_int("limit", limit, 0)
        with self._reading() as connection:
            chosen = self._several(selection, criteria, connection)
            on_a = self._on_a(selection or criteria.get("a"), connection)
        given = columns.split(",") if isinstance(columns, str) else columns
        usual = (*VIEWED, *[WORDS] * classes)
        names = usual if given is None else tuple(as_texts("columns", given))
        return Listing(self._reading, chosen, names, order, most, first, classes, on_a)

    @overload
    def count(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> int: ...
    @overload
    def count(
        self,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        by: str | Sequence[str],
        **criteria: Unpack[Criteria],
    ) -> "Result": ...
    @with_criteria
    def count(
        self,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        by: str | Sequence[str] | None = None,
        **criteria: Unpack[Criteria],
    ) -> "int | Result":
        """Return the number of words in a subset (criteria: see `Selection`).

        With `by`, return a table of the numbers of words and classes instead.

        Parameters
        ----------
        by : str or sequence of str, optional
            One or several columns, such as ``status`` or ``"p,status"``, whose values all words of a class
            share: the table has a row for each combination of values, missing ones last. Without a
            column (``[]``), it has a single row. Several ``a`` give one table, whose first column is ``a``.

        Examples
        --------
        >>> catalogue.count(p=3)
        8
        >>> catalogue.count(p="2-3", by="p")
        p  words  classes
        2      1        1
        3      8        2
        orbits of period 2 to 3 at a = 1.6
        """
        if by is None:
            from orbitdb.store.select import count

            return self._answer(count, cast("Selection | None", selection), criteria)
        from orbitdb.answers.histogram import count_by

        named = [name.strip() for name in by.split(",")] if isinstance(by, str) else by
        columns = as_texts("by", named)
        if OF_STATUS.intersection(columns):
            criteria = _of(STORED, selection, criteria)
        return self._result(count_by, selection, criteria, columns)

    @with_criteria
    def histogram(
        self,
        column: str,
        selection: Selection | None = None,
        *,
        bins: int = 20,
        **criteria: Unpack[Criteria],
    ) -> "Histogram":
        """Count the words of a subset (criteria: see `Selection`) in bins of a column with real numbers.

        Parameters
        ----------
        column : str
            A column such as ``length``, which all words of a class share.
        bins : int, optional
            Maximum number of bins.

        Examples
        --------
        >>> found = catalogue.histogram("length", p="2-5", bins=10)
        >>> found.edges.tolist(), int(found.counts.sum()) == catalogue.count(p="2-5", length=(0, None))
        ([10.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0], True)
        """
        from orbitdb.answers.histogram import histogram

        return self._answer(histogram, selection, criteria, column, bins)

    @with_criteria
    def select(
        self,
        selection: Selection | None = None,
        *,
        order: str = "p",
        limit: int | None = None,
        coordinates: bool = False,
        classes: bool = False,
        **criteria: Unpack[Criteria],
    ) -> "Subset":
        """Return a subset as arrays, one entry per word (criteria: see `Selection`).

        Parameters
        ----------
        selection : Selection, optional
            The subset; you can give criteria instead.
        order : str, optional
            Columns to sort by, as in `rows`.
        limit : int, optional
            Maximum number of entries; the subset knows how many there are in all (`Subset.total`).
        coordinates : bool, optional
            Whether to read the coordinates at once; otherwise they are read when they are needed.
        classes : bool, optional
            Whether to return one entry per symmetry class with chosen words: the least of them.

        Raises
        ------
        SelectionError
            If a criterion is invalid.

        Examples
        --------
        >>> catalogue.select(p="2-11", status="orbit", length=(None, 11)).code
        array(['13', '013', '031', '132', '123'], dtype=StringDType())
        """
        from orbitdb.answers.read_subset import read_subset

        most = None if limit is None else check_int("limit", limit, 0)
        with self._reading() as connection:
            chosen = self._chosen(selection, criteria, connection)
            found = read_subset(connection, chosen, order, coordinates, classes, most)
            return self._noted(found, selection or criteria.get("a"), connection)

    @with_criteria
    def classes(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "OrbitClasses":
        """Return the symmetry classes of a subset, each with its number of words (criteria: see `Selection`).

        Orbits through a joint are included if you ask for their status.
        """
        from orbitdb.answers.complete_periods import read_classes

        return self._answer(read_classes, selection, _of(_ORBITS, selection, criteria))

    @with_criteria
    def table(
        self, selection: "Selection | Sequence[Selection] | None" = None, **criteria: Unpack[Criteria]
    ) -> "Result":
        """Return the paper's Table 1: the numbers of words and orbits by period, and the entropy K_0.

        The only parameters are ``a``, one or several, and ``p``; `Subset.table` counts the rows of other
        subsets. If a period is not filled, its counts come from a sweep or from births.

        Examples
        --------
        >>> catalogue.table(p="2-4")["N_c"]
        [1, 8, 32]
        """
        from orbitdb.answers.entropy import table

        return self._result(table, selection, _of(_EVERY, selection, criteria))

    @with_criteria
    def entropy(
        self, selection: "Selection | Sequence[Selection] | None" = None, **criteria: Unpack[Criteria]
    ) -> "Result":
        """Return the topological entropy estimated from chosen orbits, by period, and proved bounds on it.

        Criteria: see `Selection`. Several ``a`` give one table, with ``a`` as its first column.

        Examples
        --------
        >>> [round(h, 4) for h in catalogue.entropy(p="2-11")["h_zeta"][-2:]]
        [1.1629, 1.1611]
        """
        from orbitdb.answers.entropy import entropy

        return self._result(entropy, selection, _of(_ORBITS, selection, criteria))

    @with_criteria
    def lyapunov(
        self,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        weight: str = "exp",
        cut: float | None = None,
        progress: Tell | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Result":
        """Return the Lyapunov exponents averaged over chosen orbits, by period and method.

        Criteria: see `Selection`. Several ``a`` give one table, with ``a`` as its first column.

        Parameters
        ----------
        weight : str, optional
            ``exp`` for weights e^-lambda, as in the paper; ``det`` for weights ``1/|det(1 - M)|``.
        cut : float, optional
            Return instead a single zeta average, over all pseudo-cycles with lambda up to this value.
        progress : optional
            As for `fill`, while pseudo-cycles are summed.
        """
        from orbitdb.answers.lyapunov import lyapunov

        with telling(progress, "averaging") as tell:
            return self._result(lyapunov, selection, _of(_ORBITS, selection, criteria), weight, cut, tell)

    @with_criteria
    def statistics(
        self,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        weight: str = "exp",
        **criteria: Unpack[Criteria],
    ) -> "Result":
        """Return counts, entropies and Lyapunov averages by period in one table, as the screen shows them.

        Criteria: see `Selection`; `weight` is that of `lyapunov`. N_c counts the chosen orbits alone.

        Examples
        --------
        >>> catalogue.statistics(p="2-4")["N_c"]
        [1, 8, 32]
        """
        from orbitdb.answers.lyapunov import statistics

        return self._result(statistics, selection, _of(_ORBITS, selection, criteria), weight)

    @with_criteria
    def write_dataset(
        self,
        folder: Path | str,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        force: bool = False,
        progress: Tell | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Dataset":
        """Write a folder that others can load and cite, with the chosen words of complete periods.

        Criteria: see `Selection`. Its tables of classes, births, counts, averages, bounds and levels are not
        limited to these words.

        Parameters
        ----------
        folder : path-like
        selection : Selection or sequence of Selection, optional
            The subset, or one for each of several a, as in `rows`; you can give criteria instead.
        force : bool, optional
            Whether to replace an older dataset.
        progress : optional
            As for `fill`.
        """
        from orbitdb.answers.dataset import write_dataset

        with telling(progress, "dataset") as tell, self._reading() as connection:
            named = criteria.copy()
            if selection is None and named.get("a") is None:
                named["a"] = "all"
            chosen = self._several(selection, _of(_EVERY, selection, named), connection)
            return write_dataset(connection, as_path(folder), chosen, force, tell)

    @with_criteria
    def atlas(
        self,
        path: Path | str,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        order: str = "length",
        limit: int | None = None,
        force: bool = False,
        **criteria: Unpack[Criteria],
    ) -> int:
        """Write chosen classes of orbits as a web page; return their number.

        The page is one file that opens in any browser, without a server or the network. It has a table of the
        classes, a scatter plot of any two columns, the picture and the facts of the orbit that you click, its
        bounces in the symbol plane, and where all this comes from. Without classes, nothing is written.
        Criteria: see `Selection`.

        Parameters
        ----------
        path : path-like
            A file whose name ends in .html.
        selection : Selection, optional
            The subset, at one a; you can give criteria instead. Only orbits are shown.
        order : str, optional
            As in `rows`.
        limit : int, optional
            Maximum number of classes.
        force : bool, optional
            Whether to replace an existing file.

        Raises
        ------
        InputError
            For several a, statuses other than ``orbit``, or too many classes.
        ModuleNotFoundError
            If Bokeh, of the extra ``atlas``, is not installed.
        """
        from orbitdb.answers.atlas import atlas_command, only_orbits, write_atlas
        from orbitdb.answers.dataset import made_by
        from orbitdb.output_files import check_target

        page = home_expanded(path)
        check_target(page, force)
        with self.snapshot() as then, then._reading() as connection:
            chosen = only_orbits(then._several(selection, criteria, connection))
            subset = then.select(chosen, order=order, limit=limit, coordinates=True, classes=True)
            rows = then.rows(chosen, order=order, limit=limit, classes=True)
            if not len(subset):
                return 0
            told = rows.provenance() | {"made_by": made_by(connection)}
        told["command"] = atlas_command(page, told["database"], chosen, order, limit)
        return write_atlas(page, subset, told)

    def copy(
        self,
        target: Path | str,
        *,
        a: float | Iterable[float] | None = None,
        p: int | str | Iterable[int] | None = None,
        force: bool = False,
    ) -> None:
        """Copy the catalogue to a new file, as it is at this moment, even while others write to it.

        Parameters
        ----------
        target : path-like
        a : float or iterable of float, optional
            Copy only what is stored at these half lengths, and births; by default the whole file.
        p : int, str or iterable of int, optional
            Copy only orbits, fills, sweeps and births of these periods.
        force : bool, optional
            Whether to replace an existing file; a catalogue or another SQLite file is never replaced.

        Raises
        ------
        ExportError
            If the file must not be replaced.
        StoreError
            If the disk has no room, or the file cannot be written.
        """
        from orbitdb.output_files import atomic_file, check_space, check_target
        from orbitdb.store.file import copy_into, size_of
        from orbitdb.store.merging import EVERYTHING, Choice, copy_part

        path = home_expanded(target)
        values = [] if a is None else [*a] if isinstance(a, Iterable) else [a]
        chosen = Choice(tuple(Stadium(one).a for one in values), Selection.from_criteria(p=p).periods)
        check_target(path, force)
        if chosen != EVERYTHING:
            with atomic_file(path) as draft:
                copy_part(self._present("a part").path, draft, chosen)
            return
        with self._reading() as connection:
            check_space(path, size_of(connection), "the copy takes")
            with atomic_file(path) as draft:
                copy_into(connection, draft)

    @overload
    def identify(
        self,
        *,
        length: float,
        tolerance: float | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "Candidates": ...
    @overload
    def identify(
        self,
        *,
        start: Sequence[float] | None = None,
        points: "ArrayLike | None" = None,
        tolerance: float | None = None,
        bounces: int | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "Trajectory": ...
    def identify(
        self,
        *,
        start: Sequence[float] | None = None,
        points: "ArrayLike | None" = None,
        length: float | None = None,
        tolerance: float | None = None,
        bounces: int | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "Trajectory | Candidates":
        """Find the orbits that a trajectory shadows, given its start or its bounces, or those of a length.

        The trajectory is converted to symbols. Each piece between near returns, up to 24 bounces long, is
        looked up as a word, or solved if it is not stored. The result contains the orbits that the trajectory
        follows for at least two bounces; the one that it goes round most often comes first.

        A length is compared with that of each stored orbit, traversed once or more; the closest come first.

        Parameters
        ----------
        start : (float, float, float), optional
            Position x, y relative to the centre of the stadium, inside it or on its boundary, and the angle
            in radians between path and x axis. The trajectory is followed forwards and backwards.
        points : array-like, shape (N, 2), optional
            Instead of a start, x and y of 3 to 1000 successive bounces; the last may repeat the first. The
            whole sequence is also tried as a word, whatever its period. If a point is closer to a joint of
            wall and semicircle than its error, it may be assigned to the wrong side, and the orbit missed.
        length : float, optional
            Instead, the total length of all traversals of an orbit, in units of the radius.
        tolerance : float, optional
            Largest distance between a bounce and the corresponding bounce of the orbit, and between a point
            and the boundary; 0.01 by default. Or the largest difference of lengths, to which the error bound
            of each stored length is added; 0.001 by default. At most 1.
        bounces : int, optional
            Number of bounces to follow in each direction from a start; 60 by default. The trajectory ends
            where rounding may have moved a bounce by as much as the tolerance.
        limit : int, optional
            Maximum number of orbits to return; by default 10, or all of a length.

        Examples
        --------
        >>> trajectory = catalogue.identify(start=(0, 0.001, 0))
        >>> [(stretch.orbit.code, stretch.first, stretch.bounces) for stretch in trajectory.shadowed[:1]]
        [('31', -1, 4)]
        >>> [(match.code, match.repetitions) for match in catalogue.identify(length=20.8)]
        [('13', 2)]
        """
        from orbitdb.answers.identification import identify_trajectory, read_candidates

        if length is not None:
            if start is not None or points is not None or bounces is not None:
                raise InputError("give one of start, points and length; bounces goes with start")
            with self._reading() as connection:
                candidates = read_candidates(connection, self._at(a, connection), length, tolerance, limit)
                candidates.notes = (*self._on_a(a, connection), *candidates.notes)
                return candidates
        with self.snapshot() as then:
            at = Stadium(then._at(a))
            find = partial(then.orbit, a=at.a)
            found = identify_trajectory(at, find, start, points, tolerance, bounces, limit)
            return then._noted(found, a)

    # in a magnetic field

    @with_criteria
    def field(
        self,
        kappa: "ArrayLike",
        selection: Selection | None = None,
        *,
        progress: Tell | None = None,
        **criteria: Unpack[Criteria],
    ) -> "FieldOrbits":
        """Follow words into a magnetic field, where paths are arcs of circles; nothing is stored.

        Each word starts at its fixed point without a field, also if that is not an orbit, and is followed in
        steps of the curvature. Words chosen by ``a`` and ``p`` alone need not be stored.

        Parameters
        ----------
        kappa : float or sequence of float
            Curvatures of the path, 1 / (cyclotron radius), in 1/radius; positive if it turns left.
        selection : Selection, optional
            The words, by default those of all filled periods; or give criteria (`Selection`). They apply to
            the stored numbers, which are those without a field.
        code : str or iterable of str, optional
            Instead, primitive words of any period, stored or not; a single text is one word.
        progress : optional
            As for `fill`.

        Raises
        ------
        InputError
            If 2 / kappa is not above the longest chord, 2a + 2, or if there are too many words.

        Examples
        --------
        >>> orbits = catalogue.field([0.05, 0.1], code="0123")
        >>> orbits.status.tolist(), orbits.splitting.round(6).tolist()
        (['orbit', 'orbit'], [-0.52, -1.04])
        """
        from orbitdb.answers.field import follow_words
        from orbitdb.answers.field_words import chosen_words, named_words

        code = criteria.pop("code", None)
        if code is None:
            picked = self._answer(chosen_words, selection, _of(_EVERY, selection, criteria))
        elif selection is not None or {name for name, value in criteria.items() if value} - {"a"}:
            raise InputError("give code, or criteria that choose words, not both")
        else:
            picked = named_words(code, self._at(cast("float | None", criteria.get("a"))))
        with telling(progress, "field") as tell:
            return self._noted(follow_words(picked, kappa, tell), selection or criteria.get("a"))

    # making

    def estimate(
        self,
        p: int | str | Iterable[int],
        *,
        jobs: int | None = 1,
        method: str = "newton",
        sweep: bool = False,
        geometric: bool = False,
        a: float | None = None,
    ) -> "Need":
        """Estimate the words to solve, the time and the disk space of a fill or, with `sweep`, of a sweep.

        With `geometric`, estimate what the geometrically pruned words need that such a fill stores as well.
        The other parameters are those of `fill`.
        """
        from orbitdb.filling.estimate import SWEEP, need, need_of_pruned
        from orbitdb.filling.fill import check_method
        from orbitdb.filling.workers import number_of

        check_method(method)
        at, wanted, number = self._at(a), periods_to_make(p), number_of(jobs)
        if geometric:
            return need_of_pruned(self._present().path, wanted, number)
        return need(self._present().path, at, wanted, number, SWEEP if sweep else method)

    def _check_room(self, *needed: "Need") -> None:
        """Raise `StoreError` if the disk has less free space than fills need (`estimate`)."""
        from orbitdb.filling.estimate import check_room

        check_room(self.path, *needed)

    @overload
    def fill(
        self,
        p: int | str | Iterable[int],
        *,
        jobs: int | None = 1,
        geometric: bool = False,
        method: str = "newton",
        workers: "Workers | None" = None,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Rows[Fill]": ...
    @overload
    def fill(
        self,
        *,
        code: str | Iterable[str],
        errors: str = "raise",
        method: str = "newton",
        a: float | None = None,
    ) -> list[Orbit]: ...
    def fill(
        self,
        p: int | str | Iterable[int] | None = None,
        *,
        code: str | Iterable[str] | None = None,
        errors: str = "raise",
        jobs: int | None = 1,
        geometric: bool = False,
        method: str = "newton",
        workers: "Workers | None" = None,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Rows[Fill] | list[Orbit]":
        """Store all words of the given periods, or the given words, with their orbits.

        A fill that was interrupted resumes where it stopped; finished periods are skipped.

        Parameters
        ----------
        p : int, str or iterable of int, optional
            A single number means all periods up to it, as with ``fill --p 11``; a text such as ``"9-11"`` or
            ``"2,5"``, a list or a range means exactly these periods.
        code : str or iterable of str, optional
            Instead, primitive words of any periods, to store with their symmetry classes in one transaction;
            a single text is one word. The bouncing-ball family 02 is never stored.
        errors : str, optional
            ``skip`` to leave out codes that cannot be read or stored; by default they raise, and nothing is
            stored.
        jobs : int or None, optional
            Number of processes; None for one per core if there is enough work.
        geometric : bool, optional
            Whether to store the geometrically pruned words of the periods as well.
        method : str, optional
            ``newton``, or ``relaxation`` for the paper's method, which is slow.
        workers : Workers, optional
            An open `orbitdb.filling.cluster.Cluster` to use instead of local processes.
        progress : callable, optional
            Function called with the amount done, the total, and a text. By default, a notebook shows a bar.

        Returns
        -------
        list of Fill or Orbit
            The progress and the counts of the given periods; or the orbits of the given words, in order.

        Raises
        ------
        InputError
            If you give neither periods nor words, or both, or if a value is invalid.
        StoreError
            If the file cannot be written, or the disk does not have enough room.

        Examples
        --------
        >>> own = Catalogue.create("own.db", a=1)
        >>> [fill.n_c for fill in own.fill("2-5")]
        [1, 8, 32, 48]
        >>> own.fill(code=["1^3 3", "0123"])[0]
        <Orbit 1113 at a = 1: length 9.2376043, lambda 4.8674753>
        """
        from orbitdb.filling import fill as filling
        from orbitdb.store.periods import read_fills

        at = self._at(a)
        if p is None and code is not None:
            if geometric or workers is not None:
                raise InputError("geometric and workers are for periods: leave them out")
            return filling.fill_words(self._present().path, as_texts("code", code), at, method, errors)
        if p is None or code is not None:
            raise InputError("say what to fill: periods such as '2-11', or code='1232131'")
        wanted = periods_to_make(p)
        with telling(progress, "fill") as tell:
            filling.fill(self._present().path, at, wanted, jobs, workers, geometric, method, tell)
        return self._stored_now(read_fills, wanted, at)

    def fill_births(
        self,
        p: int | str | Iterable[int],
        *,
        jobs: int | None = 1,
        progress: Tell | None = None,
    ) -> "Rows[BirthFill]":
        """Find and store the values of ``a`` at which each word begins or ceases to be an orbit.

        The parameters are those of `fill`.
        """
        from orbitdb.filling.fill import find_births
        from orbitdb.store.periods import read_birth_fills

        wanted = periods_to_make(p)
        with telling(progress, "births") as tell:
            find_births(self._present().path, wanted, jobs, tell)
        return self._stored_now(read_birth_fills, wanted)

    def sweep(
        self,
        p: int | str | Iterable[int],
        *,
        jobs: int | None = 1,
        workers: "Workers | None" = None,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Rows[Sweep]":
        """Count the orbits of the given periods and compute the sums for averages, without storing rows.

        `table`, `entropy` and `lyapunov` use sweeps for periods that are not filled. The parameters are those
        of `fill`.
        """
        from orbitdb.filling.sweeps import sweep
        from orbitdb.store.periods import read_sweeps

        at, wanted = self._at(a), periods_to_make(p)
        with telling(progress, "sweep") as tell:
            sweep(self._present().path, at, wanted, jobs, workers, tell)
        return self._stored_now(read_sweeps, wanted, at)

    def simulate(
        self,
        bounces: int = 20_000_000,
        *,
        seed: "int | np.random.Generator" = 0,
        legwise: bool = False,
        store: bool = True,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Reference":
        """Average over random trajectories, and store the result, which `reference` returns.

        Parameters
        ----------
        bounces : int, optional
            Total number of bounces.
        seed : int or numpy.random.Generator, optional
            The same seed gives the same result; a generator draws one.
        legwise : bool, optional
            Whether to sample leg by leg and use exact means, which makes the errors much smaller.
        store : bool, optional
            Whether to store the result.
        """
        from orbitdb.filling.find_averages import find_averages

        at, wanted = Stadium(self._at(a)), check_int("bounces", bounces)
        file, on_a = self.check_writable() if store else None, self._on_a(a)
        with telling(progress, "trajectories") as tell:
            averages = find_averages(at, wanted, _seed(seed), legwise, tell)
        if store:
            self.keep(averages, file)
        return replace(averages, on_a=on_a)

    def keep(self, found: "Reference | Escape", file: FileId | None = None) -> None:
        """Store a result that was computed elsewhere, by `orbitdb.simulate` or `orbitdb.escape`.

        If `file` is given, which is what `check_writable` returned before the work, only that file gets it.
        """
        from orbitdb.filling.find_averages import keep_averages
        from orbitdb.filling.find_escape import keep_found
        from orbitdb.trajectories.ensemble import Reference

        if isinstance(found, Reference):
            keep_averages(self._present().path, found, file)
        else:
            keep_found(self._present().path, found, file)

    def escape(
        self,
        opening: "str | Opening | Iterable[str | Opening]" = (),
        without: str | Iterable[str] = (),
        *,
        trajectories: int = 1_000_000,
        bounces: int = 2000,
        seed: "int | np.random.Generator" = 0,
        jobs: int | None = 1,
        store: bool = True,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Escape":
        """Open the stadium, and find how fast trajectories escape; store the result, or read the stored one.

        No orbits are needed. A trajectory escapes at a bounce in an opening, or at the bounce that completes
        a pattern.

        Parameters
        ----------
        opening, without, trajectories, bounces
            As for `orbitdb.escape`.
        seed : int or numpy.random.Generator, optional
            The same seed gives the same result; a generator draws one.
        jobs, progress : optional
            As for `fill`.
        store : bool, optional
            Whether to store the result.

        Raises
        ------
        InputError
            If nothing is opened, an opening does not fit on the boundary, or nothing is left of it.

        Examples
        --------
        >>> found = catalogue.escape("top:-0.3:0.3", trajectories=0)
        >>> round(found.measure, 6), round(found.c1, 5), round(found.rate_leg, 3)
        (0.047307, 0.24304, 0.117)
        """
        from orbitdb.filling.find_escape import find_escape
        from orbitdb.open_stadium.question import Question
        from orbitdb.store.stored_values import stored_escape

        with self._reading() as connection:
            at = self._at(a, connection)
            asked = Question.of(at, opening, without, trajectories, bounces, _seed(seed))
            stored, known = stored_escape(connection, asked)
            on_a = self._on_a(a, connection)
        if stored is not None:
            return replace(stored, on_a=on_a)
        file = self.check_writable() if store else None
        with telling(progress, "trajectories") as tell:
            found = find_escape(asked, known, jobs, tell)
        if store:
            self.keep(found, file)
        return replace(found, on_a=on_a)

    def prove_bounds(
        self,
        edges: int | None = None,
        *,
        width: float | None = None,
        seconds: float | None = None,
        prove: bool = False,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "EntropyBounds":
        """Prove bounds on the topological entropy per bounce, and store them; `entropy_bounds` returns them.

        Parameters
        ----------
        edges : int, optional
            Number of edges of the longest windows; 14 if nothing else limits the search.
        width, seconds : float, optional
            Stop when the bounds differ by at most this width, or after about this many seconds.
        prove : bool, optional
            Whether to check every decision in ball arithmetic, and use only those that it proves.

        Returns
        -------
        EntropyBounds
            The bounds that follow from the longest windows.
        """
        with telling(progress, "bounds") as tell:
            steps = self.search_bounds(
                edges, width=width, seconds=seconds, prove=prove, jobs=1, progress=tell, a=a
            )
            *_, last = steps
        return last

    def search_bounds(
        self,
        edges: int | None = None,
        *,
        width: float | None = None,
        seconds: float | None = None,
        prove: bool = False,
        jobs: int | None = None,
        store: bool = True,
        progress: Tell = nobody,
        a: float | Iterable[float] | str | None = None,
    ) -> "Generator[EntropyBounds]":
        """Yield bounds on the topological entropy from longer and longer windows, and store them.

        Parameters
        ----------
        edges, width, seconds, prove : optional
            As for `prove_bounds`; the time is for each a.
        jobs : int, optional
            Number of processes for several a.
        store : bool, optional
            Whether to store the bounds.
        a : float, sequence of float or str, optional
            One or several half lengths; ``all`` for every stored one.
        """
        from orbitdb.filling.find_bounds import find_bounds

        with self._reading() as connection:
            if isinstance(a, str) and a == "all":
                a = self._every_a(connection)
            each: Iterable[Any] = a if isinstance(a, Iterable) and not isinstance(a, str) else [a]
            values = [self._at(one, connection) for one in each]
        path = self._present().path if store else None
        return find_bounds(path, values, edges, width, seconds, prove, jobs, progress)

    def check_writable(self) -> FileId:
        """Raise `StoreError` if nothing can be stored, before long work; return which file it would be."""
        from orbitdb.store.writer import check_writable

        return check_writable(self._present().path)

    @with_criteria
    def verify(
        self,
        selection: "Selection | Sequence[Selection] | None" = None,
        *,
        sample: int | None = None,
        restarts: int = 0,
        seed: "int | np.random.Generator" = 0,
        births: bool = False,
        prove: bool = False,
        jobs: int | None = 1,
        progress: Tell | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Verification":
        """Recompute the catalogue from its words alone, and compare the results with the stored ones.

        What is missing is no error, but the result has notes about it.

        Parameters
        ----------
        selection : Selection or sequence of Selection, optional
            What to check, by default everything at every ``a``; or give criteria (`Selection`).
        sample : int, optional
            Check only this many classes, drawn at random.
        restarts : int, optional
            Number of random starts from which every word is solved again.
        seed : optional
            Seed of the sample and the restarts, as for `simulate`.
        births : bool, optional
            Whether to prove that no birth or death between a = 0.02 and 1000 is missing.
        prove : bool, optional
            Whether to prove every row in ball arithmetic, and store the certificates.
        jobs, progress : optional
            As for `fill`.

        Examples
        --------
        >>> catalogue.verify(p="2-5").sound
        True
        """
        from orbitdb.answers.completeness import gaps_at
        from orbitdb.verification.verify import verifiable, verified

        everywhere, path = selection is None and criteria.get("a") is None, self._present("verify").path
        sample = None if sample is None else check_int("sample", sample)
        restarts, drawn = check_int("restarts", restarts, 0), _seed(seed)
        with self._reading() as connection:
            named = _of(_EVERY, selection, criteria)
            selections = () if everywhere else self._several(selection, named, connection)
            if everywhere:
                every = Selection.from_criteria(**named)
                selections = tuple(replace(every, a=at) for at in verifiable(connection))
            missing = gaps_at(connection, selections, everywhere)
        with telling(progress, "verify") as tell:
            found = verified(path, selections, sample, restarts, drawn, births, prove, jobs, tell)
        return replace(found, notes=(*missing, *found.notes))

    # deleting

    def delete(
        self, a: float, p: int | str | Iterable[int] | None = None, *, only: "Contents | None" = None
    ) -> "Contents":
        """Delete what is stored at a given ``a``, and return what that was.

        Parameters
        ----------
        a : float
            Half length of the stadium.
        p : int, str or iterable of int, optional
            Periods whose words, fills and sweeps to delete. By default, the method deletes everything at
            this ``a``: also levels, bounds on the entropy, averages over trajectories and open stadiums.
        only : Contents, optional
            What must still be stored, as `contents` returned it before you decided.

        Raises
        ------
        StoreError
            If something else is stored; then nothing is deleted.

        Examples
        --------
        >>> own = Catalogue.create("own.db", a=1)
        >>> fills = own.fill("2-5")
        >>> print(own.delete(1, p="4-5"))
        128 words, 2 fills (periods 4-5)
        """
        from orbitdb.store.deleting import delete

        at = Stadium(a).a  # no default: None would otherwise delete what is stored at 1.6
        return delete(self._present().path, at, Selection.from_criteria(p=p).periods, only)

    # parts

    def merge(
        self, paths: Path | str | Iterable[Path | str], *, progress: Tell | None = None
    ) -> "Rows[Merged]":
        """Copy from other catalogues what this one lacks, and return what that was, by part and ``a``.

        Fills of a period that have come further replace shorter ones. Each part is copied in one transaction,
        and merging it again changes nothing.

        Parameters
        ----------
        paths : path-like or iterable of path-like
            The other catalogues, such as those that the jobs of an array have filled.
        progress : optional
            As for `fill`.

        Raises
        ------
        StoreError
            If a part cannot be read, or contradicts this catalogue, such as by the same orbit with other
            numbers beyond its error bounds; nothing of that part is copied.

        Examples
        --------
        >>> whole, part = Catalogue.create("whole.db"), Catalogue.create("part.db")
        >>> fills = part.fill("2-5", a=1)
        >>> [(each.part, each.a, each.periods, each.words) for each in whole.merge(["part.db"])]
        [('part.db', 1.0, '2-5', 137)]
        """
        from orbitdb.store.merging import merge_all

        named = [paths] if isinstance(paths, Path) else as_texts("paths", paths)
        parts = [home_expanded(part).absolute() for part in named]
        with telling(progress, "merging") as tell:
            return Rows(merge_all(self._present().path, parts, tell))

    # quantum levels

    def fill_levels(
        self,
        k: "Wavenumbers",
        *,
        parity: "Sequence[Parity | str] | str | None" = None,
        jobs: int | None = 1,
        store: bool = True,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Levels":
        """Find and store all quantum levels in a range low <= k < high, each with an estimated error.

        Parameters
        ----------
        k : float or (float, float)
            The range of wavenumbers, in 1/radius. As in Python's `range`, a single number is the upper end.
        parity : str or sequence of str, optional
            Some of ``ee``, ``eo``, ``oe``, ``oo``: even (e) or odd (o) in x, then in y; by default all four.
        jobs, progress : optional
            As for `fill`.
        store : bool, optional
            Whether to store the levels; if not, stored ones are computed again.
        """
        from orbitdb.answers.stadium_levels import notes_on_windows
        from orbitdb.filling.find_levels import find_levels
        from orbitdb.quantum.exact_levels import Levels
        from orbitdb.quantum.weyl import k_range, parities_of

        at, (low, high), on_a = Stadium(self._at(a)), k_range(k), self._on_a(a)
        with telling(progress, "levels") as tell:
            path = self._present().path if store else None
            windows = find_levels(path, at, low, high, parities_of(parity), jobs, tell)
        levels = Levels.joined(at.a, low, high, windows)
        return replace(levels, notes=(*on_a, *notes_on_windows(levels, windows)))

    def spectrum(
        self,
        lengths: "ArrayLike | None" = None,
        *,
        resolution: int = 500,
        k: "Wavenumbers | None" = None,
        levels: "ArrayLike | None" = None,
        window: bool = False,
        parity: "Parity | str | None" = None,
        a: float | None = None,
    ) -> "Spectrum":
        """Return the length spectra of the stored orbits and of the quantum levels.

        `Spectrum.terms` and `Spectrum.term_rows` are the terms of the trace formula.

        Parameters
        ----------
        lengths : (float, float), optional
            Range of lengths, in units of the radius; by default from 1 to beyond 4 (1 + a).
        resolution : int, optional
            Number of lengths in the range.
        k : float or (float, float), optional
            Range of k, as for `levels`; by default that of the levels, or up to 30 without levels. Only a
            window can begin above 0.
        levels : array-like, shape (N,), optional
            All levels k, beginning with the lowest unless they are a window; by default the stored ones.
        window : bool, optional
            Whether the levels begin with any level.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo``; by default the levels of all parities together.
        """
        from orbitdb.answers.level_lists import read_spectrum

        with self._reading() as connection:
            at, on_a = self._at(a, connection), self._on_a(a, connection)
            found = read_spectrum(connection, at, lengths, resolution, k, levels, window, parity)
        return replace(found, on_a=on_a)

    def levels(
        self,
        k: "Wavenumbers | None" = None,
        *,
        parity: "Sequence[Parity | str] | str | None" = None,
        method: str = "elements",
        a: float | None = None,
    ) -> "Levels":
        """Return the quantum levels in a range of k, either the stored ones or those computed from orbits.

        Parameters
        ----------
        k : float or (float, float), optional
            The range, as for `fill_levels`; by default from 0. The stored levels then end at the first gap,
            and those from orbits where the rms error reaches a fifth of the mean spacing, as they do if the
            upper end is None.
        parity : str or sequence of str, optional
            As for `fill_levels`.
        method : str, optional
            ``elements`` for the levels that `fill_levels` stored; ``orbits`` for levels from N_X(k), with
            errors that hold for nine levels out of ten (`orbitdb.quantum.levels_from_orbits`).
        """
        from orbitdb.answers.stadium_levels import levels_from_orbits, levels_in_catalogue

        if method not in ("elements", "orbits"):
            raise InputError(f"method {method!r}: use elements or orbits")
        with self._reading() as connection:
            find = levels_in_catalogue if method == "elements" else levels_from_orbits
            return self._noted(find(connection, self._at(a, connection), parity, k), a, connection)

    def assess(
        self,
        levels: "ArrayLike | None" = None,
        *,
        parity: "Parity | str | None" = None,
        window: bool = False,
        fit_radius: bool = False,
        radius_error: float | None = None,
        noise: float = 0.0,
        a: float | None = None,
    ) -> "Assessment":
        """Use the stored orbits to find where levels are missing from a list, and where some are spurious.

        Every statement of the result has a probability.

        Parameters
        ----------
        levels : array-like, shape (N,), optional
            The levels in 1/radius, beginning with the lowest unless they are a window; by default the stored
            ones.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo`` if all levels have this parity; by default, all four are mixed.
        window : bool, optional
            Whether the list begins with any level; `Assessment.first` then says which one it is.
        fit_radius : bool, optional
            Whether to fit the radius, in case it is known only to within half a per cent.
        radius_error : float, optional
            Relative standard error of the radius, if it is fitted.
        noise : float, optional
            Scatter of the levels, in mean spacings.
        """
        from orbitdb.answers.level_lists import assess_levels

        with self._reading() as connection:
            how = fit_radius, window, radius_error, noise
            found = assess_levels(connection, self._at(a, connection), levels, parity, *how)
            return self._noted(found, a, connection)

    def level_statistics(
        self,
        levels: "Mapping[Parity, ArrayLike] | ArrayLike | None" = None,
        *,
        window: bool = False,
        parity: "Parity | str | None" = None,
        a: float | None = None,
    ) -> "Result":
        """Return the statistics of the levels of each parity, and of random matrices and random numbers.

        Parameters
        ----------
        levels : array-like, shape (N,), or mapping of Parity to array-like, optional
            The levels of one parity, or of each, beginning with the lowest unless they are a window; by
            default the stored ones.
        window : bool, optional
            Whether the levels begin with any level.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo``, the parity of `levels`; by default the stored levels of all
            four.
        """
        from orbitdb.answers.level_lists import level_statistics, levels_by_parity

        with self._reading() as connection:
            at = self._at(a, connection)
            own = levels_by_parity(connection, at, levels, parity, window)
            return self._noted(level_statistics(connection, at, own, window), a, connection)

    def _stored_counterparts(self, levels: "Levels") -> list[float | None]:
        """Return, for each level from orbits, the stored level with the same number, or None."""
        from orbitdb.answers.stadium_levels import stored_counterparts

        with self._reading() as connection:
            return stored_counterparts(connection, levels)

    def scars(
        self,
        k: "Wavenumbers",
        *,
        code: str | Iterable[str] | None = None,
        parity: "Sequence[Parity | str] | str | None" = None,
        order: str | None = None,
        limit: int | None = None,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Rows[Scar]":
        """Measure how strongly orbits scar the quantum levels with low <= k < high.

        Parameters
        ----------
        k : float or (float, float)
            The range of wavenumbers, in 1/radius; or a single one, for the level of each parity nearest to
            it.
        code : str or iterable of str, optional
            One or several orbits, or ``02`` for the bouncing balls; the result then has an entry for every
            level and orbit. By default, it has for each level the five that scar it most, out of the bouncing
            balls and the twenty shortest stored orbits.
        order : str, optional
            Columns to sort by, as in `rows`; by default ``above desc`` for named orbits, else ``k``.
        limit : int, optional
            Maximum number of entries.
        parity, progress : optional
            As for `fill_levels`.
        """
        from orbitdb.answers.scars import (
            STRONGEST,
            check_scarring,
            order_of_scars,
            scars_of,
            shortest_orbits,
        )
        from orbitdb.quantum.weyl import parities_of

        named, keys = parities_of(parity), order_of_scars(order, code is not None)
        most = None if limit is None else check_int("limit", limit, 0)
        if code is None:
            with self._reading() as connection:
                orbits = shortest_orbits(connection, self._at(a, connection))
        else:
            orbits = [self.orbit(each, a=a) for each in as_texts("code", code)]
            check_scarring(orbits)
        with telling(progress, "waves") as tell:
            return Rows(scars_of(orbits, k, named, keys, None if code else STRONGEST, tell)[:most])

    # figures

    @with_criteria
    def plot(
        self,
        name: str,
        selection: "Selection | Sequence[Selection] | str | None" = None,
        *,
        over_a: bool = False,
        order: str | None = None,
        limit: int | None = None,
        levels: "Mapping[Parity, ArrayLike] | ArrayLike | None" = None,
        parity: "Parity | str | None" = None,
        window: bool = False,
        lengths: tuple[float, float] | None = None,
        k: "Wavenumbers | None" = None,
        kappa: "ArrayLike | None" = None,
        size: float | Sequence[float] | None = None,
        title: str | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Picture":
        """Draw a figure of `orbitdb plot`, and return it as a matplotlib Figure.

        ``savefig`` writes it to a file. Its ``notes`` say what it leaves out. An argument that the figure
        does not use is an error.

        Parameters
        ----------
        name : str
            One of the names in ``orbitdb plot --help``, such as ``life`` or ``phase-space``.
        selection, a, code, ... : optional
            What to draw: a word, several as `code`, or a subset (`Selection`). Some figures compare several
            ``a``.
        over_a : bool, optional
            Whether ``entropy`` is drawn against ``a`` instead of the period.
        order, limit : optional
            Of the orbits of a ``sheet``, as in `rows`; at most 120 by default.
        levels, window : optional
            As for `spectrum`; for ``spacings`` and ``rigidity`` as for `level_statistics`.
        parity : str, optional
            As for `spectrum`; ``wave`` and ``husimi`` need one.
        lengths : (float, float), optional
            Range of lengths of a ``spectrum``, in units of the radius.
        k : float or (float, float), optional
            Of a ``wave`` or ``husimi``, the level nearest to this k; of a ``spectrum``, its range of k.
        kappa : float or sequence of float, optional
            Curvatures of paths in a magnetic field.
        size : float or (float, float), optional
            Width of the figure, or width and height, in inches.
        title : str, optional
            Title to replace that of the figure.

        Raises
        ------
        InputError
            If there is nothing to draw, or the figure does not use an argument.
        ModuleNotFoundError
            If matplotlib, of the extra ``plot``, is not installed.

        Examples
        --------
        >>> figure = catalogue.plot("life", "010203113", size=3.39)
        >>> figure.axes[0].get_title()
        '010203113 is born at $a = 0.386253$'
        """
        draw = load("orbitdb.plots.by_name", "plot", "plot").plot
        of_figure = {
            "over_a": over_a, "order": order, "limit": limit, "levels": levels, "parity": parity,
            "window": window, "lengths": lengths, "k": k, "kappa": kappa,
        }  # fmt: skip
        with self.snapshot() as then:
            made: Picture = draw(then, name, selection, criteria, of_figure, size, title)
        return made

    # the symbol plane

    def pruning_front(self, *, a: float | None = None) -> "PruningFront":
        """Return the pruning front of the stadium: the border of the orbits in the symbol plane.

        It does not depend on what is stored. It is computed in double precision and proves nothing. Below
        ``a = 0.05``, it forbids some orbits, as its `notes` say.

        Examples
        --------
        >>> front = catalogue.pruning_front()
        >>> front, front.walls.gamma.shape == front.walls.delta.shape
        (<pruning front at a = 1.6>, True)
        """
        from orbitdb.trajectories.pruning_front import PruningFront

        front = PruningFront(self._at(a))
        front.notes = (*self._on_a(a), *front.notes)
        return front

    def _stored_now(
        self, read: Callable[..., Iterable[Any]], periods: Collection[int], *arguments: Any
    ) -> "Rows[Any]":
        """Return what was just stored of some periods."""
        with self._reading() as connection:
            return Rows(one for one in read(connection, *arguments) if one.p in periods)

    def _answer(
        self,
        function: Callable[..., _Answer],
        selection: Selection | None,
        criteria: Criteria,
        *arguments: Any,
    ) -> _Answer:
        """Return what a function of a connection and the chosen subset answers, in one snapshot."""
        with self._reading() as connection:
            return function(connection, self._chosen(selection, criteria, connection), *arguments)

    def _result(
        self,
        function: Callable[..., "Result"],
        selection: Selection | Sequence[Selection] | None,
        criteria: Criteria,
        *arguments: Any,
    ) -> "Result":
        """Return a result at one a, or joined results at several."""
        from orbitdb.answers.results import over_a

        one = isinstance(selection, Selection | None) and not isinstance(criteria.get("a"), Iterable)
        with self._reading() as connection:
            subsets = self._several(selection, criteria, connection)
            results = [function(connection, chosen, *arguments) for chosen in subsets]
            return self._noted(
                results[0] if one else over_a(results), selection or criteria.get("a"), connection
            )

    def _chosen(
        self, selection: Selection | None, criteria: Criteria, connection: Connection | None = None
    ) -> Selection:
        if selection is not None and criteria:
            raise SelectionError("give a Selection or criteria, not both")
        if not isinstance(selection, Selection | None):
            raise SelectionError(
                f"choose a subset by criteria such as p=3 or a Selection, not {selection!r:.30}"
            )
        if selection is not None:
            selection.check_opening()
            return selection
        named = criteria.copy()
        if named.get("a") is None:
            named["a"] = self._at(None, connection)
        a: Any = named["a"]
        if isinstance(a, Iterable) and (not isinstance(a, str) or a == "all"):
            raise SelectionError("give one a here; rows, table, entropy and lyapunov take several")
        chosen = Selection.from_criteria(**named)
        chosen.check_opening()
        return chosen

    def _several(
        self,
        selection: Selection | Sequence[Selection] | None,
        criteria: Criteria,
        connection: Connection,
    ) -> tuple[Selection, ...]:
        """Return the chosen subset at each a."""
        values: Any = criteria.get("a")
        if isinstance(values, str) and values == "all":
            values = self._every_a(connection)
        if selection is None and isinstance(values, Iterable) and not isinstance(values, str):
            named = criteria.copy()
            named["a"] = None
            one = Selection.from_criteria(**named)
            chosen = tuple(replace(one, a=a) for a in dict.fromkeys(Stadium(a).a for a in values))
        elif not isinstance(selection, Sequence):
            return (self._chosen(selection, criteria, connection),)
        else:
            chosen = tuple(self._chosen(one, criteria, connection) for one in selection)
        if not chosen:
            raise SelectionError("give one a or more")
        for one in chosen:
            one.check_opening()
        return chosen

    def _every_a(self, connection: Connection) -> list[float]:
        """Return every a with orbits or sweeps, or else the default one, as ``--a all``."""
        return a_values(connection, WITH_ORBITS) or [self._at(None, connection)]

    def _on_a(self, chosen: object, connection: Connection | None = None) -> tuple[str, ...]:
        """Return the note on the default a if a question uses it: if it has neither an a nor a Selection."""
        if chosen is not None or self._a is not None:
            return ()
        if connection is not None:
            return tuple(filter(None, [note_on_a(connection)]))
        with self._reading() as now:
            return self._on_a(chosen, now)

    def _noted(self, found: _Noted, chosen: object, connection: Connection | None = None) -> _Noted:
        """Return a result whose notes begin with the note on the default a, if it uses it (`_on_a`)."""
        return replace(found, notes=(*self._on_a(chosen, connection), *found.notes))

    def _at(self, a: float | None, connection: Connection | None = None) -> float:
        """Return the given a, or else the default one, read from a connection if a question has one."""
        if a is not None:
            return Stadium(a).a
        if self._a is not None:
            return self._a
        if connection is not None:
            return default_a(connection)
        with self._reading() as now:
            return default_a(now)


def _of(statuses: Sequence[Status], selection: object, criteria: Criteria) -> Criteria:
    """Return criteria that choose some statuses, or every one, unless they or a Selection choose others.

    Every one leaves out geometrically pruned words, unless the condition names the status.
    """
    given = selection is not None or criteria.get("status") is not None
    by_status = OF_STATUS & names_in(str(criteria.get("where", "")))
    return criteria if given or (by_status and statuses == _EVERY) else {**criteria, "status": statuses}


def _check_orbit(orbit: Any) -> None:
    if not isinstance(orbit, Orbit):
        raise InputError(f"{orbit!r:.40} is not an Orbit: give one, such as catalogue['13']")


def _seed(seed: "int | np.random.Generator") -> int:
    if hasattr(seed, "integers"):
        return int(seed.integers(2**63))
    return check_int("seed", seed, 0)
