"""`Catalogue`, the main class of the library: a database of periodic orbits to fill, query and check."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, Unpack

from orbitdb.answers.completeness import describe_fills
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, StoreError
from orbitdb.orbits.orbit import Orbit
from orbitdb.progress import Tell, telling
from orbitdb.store.asking.conditions import COLUMNS
from orbitdb.store.asking.criteria import Criteria, chosen_by, chosen_periods, with_criteria
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.database import default_path
from orbitdb.store.reading.lookup import find_or_solve, meant
from orbitdb.store.reading.moment import Moment, Reader
from orbitdb.symbols.words import WordError, is_primitive, parse, parse_primitive, primitive_root

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike

    from orbitdb.answers.counts import Counted
    from orbitdb.answers.identification import Candidate, Trajectory
    from orbitdb.answers.results import Result
    from orbitdb.answers.scars import Scar
    from orbitdb.answers.subset import Subset
    from orbitdb.answers.whole_periods import ChosenClasses
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.filling.workers import Workers
    from orbitdb.quantum.length_spectrum import Spectrum
    from orbitdb.quantum.levels import Levels
    from orbitdb.quantum.missing_levels import Assessment
    from orbitdb.quantum.weyl import Parity
    from orbitdb.store.reading.fills import Fill, Sweep
    from orbitdb.store.reading.lives import BirthFill, Life
    from orbitdb.trajectories.ensemble import Reference
    from orbitdb.verification.verify import Verification

_SHOWN = 4
"""Maximum number of further values of ``a`` in a repr."""


class Catalogue:
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.
    a : float, optional
        Half length of the stadium that all methods use by default. If you give none, it is the only
        value with stored orbits, or else 1.6.

    Raises
    ------
    StoreError
        If there is no catalogue at the path, or this version cannot read it.

    Examples
    --------
    >>> catalogue = Catalogue("orbits.db", a=1.6)
    >>> catalogue
    <Catalogue orbits.db: periods 2-11 at a = 1.6>
    >>> round(catalogue["1232131"].length, 9), "1232131" in catalogue, len(catalogue)
    (22.454362411, True, 89789)
    >>> catalogue.select(p="2-11", status="orbit", lambda_c=(None, 0.35))
    <74 orbits of period 2 to 11 at a = 1.6 with lambda_c <= 0.35>

    A ``with`` block closes the file at its end; the next query opens it again:

    >>> with Catalogue("orbits.db") as catalogue:
    ...     catalogue.count(p=7, status="orbit")
    376
    """

    def __init__(self, path: Path | str | None = None, a: float | None = None) -> None:
        self._a = None if a is None else Stadium(a).a
        self._file = Reader(path)

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> Self:
        """Open a catalogue; create it first if there is none, or upgrade it to the latest schema."""
        from orbitdb.store.file.migrate import migrate

        path = Path(path) if path is not None else default_path()
        migrate(path)
        return cls(path, a)

    @property
    def path(self) -> Path:
        """Path of the file."""
        return self._file.path

    @property
    def a(self) -> float:
        """Half length of the default stadium; it does not change once it has been determined.

        Raises
        ------
        InputError
            If you gave none, and orbits are stored at several values of ``a`` but not at 1.6.
        """
        if self._a is None:
            with self._file.moment() as moment:
                self._a = moment.a_meant()
        return self._a

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; the next query opens it again."""
        self._file.close()

    def __reduce__(self) -> tuple[type[Self], tuple[Path, float | None]]:
        """Pickle only the path and ``a``; the copy opens the file itself."""
        return type(self), (self.path.absolute(), self._a)

    def __repr__(self) -> str:
        try:
            with self._file.moment() as moment:
                known = self._contents(moment)
        except StoreError as error:
            known = str(error)
        return f"<Catalogue {self.path.name}: {known}>"

    def _contents(self, moment: Moment) -> str:
        """Return one line that says which periods are filled, beginning with the default ``a``."""
        values = moment.a_values(orbits=True)
        try:
            own = [meant(values) if self._a is None else self._a]
        except InputError:
            own = []
        others = [a for a in values if a not in own]
        parts = [describe_fills(moment.fills(a), a) for a in (*own, *others[:_SHOWN])]
        return "; ".join(parts) + (f"; and at {len(others) - _SHOWN} more" if len(others) > _SHOWN else "")

    # one word

    def find(self, word: str, a: float | None = None) -> Orbit | None:
        """Return the stored orbit of a primitive word, in the given rotation, or None if it is not stored.

        Parameters
        ----------
        word : str
            Symbols 0 to 5, or run notation, in any rotation.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Raises
        ------
        WordError
            If the text is not a word.
        """
        symbols = parse(word)
        with self._file.moment() as moment:
            return moment.find(symbols, self._at(a))

    def __contains__(self, word: object) -> bool:
        """Tell whether a word is stored, whatever its rotation and status."""
        try:
            return isinstance(word, str) and self.find(word) is not None
        except WordError:
            return False

    def __getitem__(self, word: str) -> Orbit:
        """Return the orbit of a word, in the given rotation, whatever its status.

        A word that is not stored is solved on the spot; its orbit has ``stored`` false.

        Raises
        ------
        KeyError
            If the word repeats a shorter one.
        WordError
            If the text is not a word.
        """
        symbols = parse(word)
        if not is_primitive(symbols):
            raise KeyError(f"{word} repeats {primitive_root(symbols)}: ask for the shorter word")
        return find_or_solve(self.path, symbols, self.a)

    def __iter__(self) -> Iterator[str]:
        """Yield the stored words, as least rotations, in order of period."""
        return (word for (word,) in self.rows(columns=("code",)))

    def __len__(self) -> int:
        """Return the number of stored words, not counting geometrically pruned ones."""
        return self.count()

    def __bool__(self) -> bool:
        return True

    # chosen subsets

    @with_criteria
    def rows(
        self,
        selection: Selection | None = None,
        columns: Sequence[str] = COLUMNS,
        order: str = "p",
        limit: int | None = None,
        offset: int = 0,
        **criteria: Unpack[Criteria],
    ) -> Iterator[tuple[Any, ...]]:
        """Yield the rows of a chosen subset, one per word.

        Parameters
        ----------
        selection : Selection, optional
            The subset; you can give criteria instead, as in `select`.
        columns : sequence of str, optional
            Names of columns of the view ``catalogue``.
        order : str, optional
            Columns to sort by, separated by commas; ``desc`` after a name, or ``-`` before it, reverses the
            order. Ties are broken by period, representative and element, in ascending order.
        limit, offset : int, optional
            Maximum number of rows to yield, and number of rows to skip first.

        Raises
        ------
        SelectionError
            If a column is unknown or ``where`` is refused.
        """
        if offset < 0 or (limit is not None and limit < 0):
            raise InputError(f"limit {limit}, offset {offset}: give 0 or more")
        with self._question(selection, criteria) as (moment, chosen):
            most = None if limit is None else limit + offset
            yield from moment.rows(moment.choose(chosen, order, most=most), columns, offset, most)

    @with_criteria
    def count(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> int:
        """Return the number of words in a chosen subset, given as in `select`."""
        with self._question(selection, criteria) as (moment, chosen):
            return moment.count(chosen)

    @with_criteria
    def counts(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Counted":
        """Return the counts of the paper's Table 1, taken from a fill, a sweep, or births.

        The only parameters are ``a`` and ``p``; by default, it counts all stored periods.
        """
        from orbitdb.answers.counts import count, need_periods_alone

        with self._question(selection, criteria) as (moment, chosen):
            need_periods_alone(chosen)
            return count(moment, chosen)

    @with_criteria
    def select(
        self,
        selection: Selection | None = None,
        *,
        order: str = "p",
        coordinates: bool = False,
        **criteria: Unpack[Criteria],
    ) -> "Subset":
        """Return a chosen subset as arrays, one entry per word.

        Parameters
        ----------
        selection : Selection, optional
            The subset; you can give the criteria below instead.
        order : str, optional
            Columns to sort by, as in `rows`.
        coordinates : bool, optional
            Whether to read the coordinates as well.
        a : float, optional
            Half length of the stadium; by default the catalogue's.
        p : int, str or iterable of int, optional
            A period, several periods such as ``range(2, 6)``, or a text such as ``2,3,5-7``.
        status : Status, str or iterable of them, optional
            One or more statuses; a text such as ``orbit,boundary`` can name several.
        time_reversal, symmetry, contains, where, parameters : optional
            As in `Selection`.
        exists, not_at : float or iterable of float, optional
            Values of ``a`` at which the words must be orbits, and at which they must not be.
        length, lyapunov, lambda_d, lambda_c, margin, born, dies : (float or None, float or None), optional
            Least and greatest value, or None for no limit, as in ``length=(3, None)``.

        Raises
        ------
        SelectionError
            If a criterion is invalid.

        Examples
        --------
        >>> catalogue.select(p="2-11", status="orbit", length=(None, 11)).codes
        array(['13', '013', '031', '132', '123'], dtype=StringDType())
        """
        from orbitdb.answers.subset import read_subset

        with self._question(selection, criteria) as (moment, chosen):
            return read_subset(moment, chosen, order, coordinates)

    @with_criteria
    def classes(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "ChosenClasses":
        """Return the symmetry classes of chosen orbits, each with the number of its words in the subset.

        The parameters are those of `select`. Orbits through a joint are included if you ask for their status.

        Raises
        ------
        SelectionError
            If you ask for a status whose words have no length and lambda.
        """
        from orbitdb.answers.whole_periods import read_classes

        with self._question(selection, criteria) as (moment, chosen):
            return read_classes(moment, chosen)

    @with_criteria
    def table(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Result":
        """Return the paper's Table 1: the numbers of words and orbits by period, and the entropy K_0.

        The only parameters are ``a`` and ``p``; `Subset.table` counts the rows of other subsets. If a period
        is not filled, its counts come from a sweep or from births.

        Examples
        --------
        >>> catalogue.table(p="2-4")["N_c"]
        [1, 8, 32]
        """
        from orbitdb.answers.entropy import table

        with self._question(selection, criteria) as (moment, chosen):
            return table(moment, chosen)

    @with_criteria
    def entropy(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Result":
        """Return the topological entropy estimated from chosen orbits, by period, and proved bounds on it.

        The parameters are those of `select`.

        Examples
        --------
        >>> [round(h, 4) for h in catalogue.entropy(p="2-11")["h_zeta"][-2:]]
        [1.1629, 1.1611]
        """
        from orbitdb.answers.entropy import entropy

        with self._question(selection, criteria) as (moment, chosen):
            return entropy(moment, chosen)

    @with_criteria
    def lyapunov(
        self,
        selection: Selection | None = None,
        *,
        weight: str = "exp",
        cut: float | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Result":
        """Return the Lyapunov exponents averaged over chosen orbits, for every period and by every method.

        Parameters
        ----------
        selection : Selection, optional
            The subset; you can give criteria instead, as in `select`.
        weight : str, optional
            ``exp`` for weights e^-lambda, as in the paper; ``det`` for weights ``1/|det(1 - M)|``.
        cut : float, optional
            Return instead a single zeta average, over all pseudo-cycles with lambda up to this value.
        """
        from orbitdb.answers.lyapunov import lyapunov

        with self._question(selection, criteria) as (moment, chosen):
            return lyapunov(moment, chosen, weight, cut)

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
        """Find the orbits that a trajectory shadows, given its start or its bounces.

        The trajectory is converted to symbols. Each piece between near returns, up to 24 bounces long, is
        looked up as a word, or solved if it is not stored. The result contains the orbits that the trajectory
        follows for at least two bounces.

        Parameters
        ----------
        start : (float, float, float), optional
            Position x, y relative to the centre of the stadium, inside it or on its boundary, and the angle
            in radians between path and x axis. The trajectory is followed forwards and backwards.
        points : array-like, shape (N, 2), optional
            Instead of a start, x and y of 3 to 1000 successive bounces; the last may repeat the first. The
            whole sequence is also tried as a word, whatever its period. If a point is closer to a joint of
            wall and semicircle than its error, it may be assigned to the wrong side, and the orbit missed.
        tolerance : float, optional
            Largest distance between a bounce and the corresponding bounce of the orbit, and between a point
            and the boundary; at most 1, by default 0.01.
        bounces : int, optional
            Number of bounces to follow in each direction from a start; 60 by default. The trajectory ends
            where rounding may have moved a bounce by as much as the tolerance.
        limit : int, optional
            Maximum number of orbits to return; 10 by default.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Returns
        -------
        Trajectory
            Its orbits are sorted; the one that the trajectory goes round most often comes first.

        Raises
        ------
        InputError
            If you give both or neither of ``start`` and ``points``, or if a value is invalid.

        Examples
        --------
        >>> found = catalogue.identify(start=(0, 0.001, 0))
        >>> [(each.orbit.code, each.first, each.bounces) for each in found.shadowed[:1]]
        [('31', -1, 4)]
        """
        from orbitdb.answers.identification import identify_trajectory

        at = Stadium(self._at(a))
        find = partial(find_or_solve, self.path, a=at.a)
        return identify_trajectory(at, find, start, points, tolerance, bounces, limit)

    def with_length(
        self,
        length: float,
        tolerance: float | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "tuple[Candidate, ...]":
        """Find the stored orbits with a given length, traversed once or more; the closest matches come first.

        Parameters
        ----------
        length : float
            Total length of all traversals, in units of the radius.
        tolerance : float, optional
            Largest difference, at most 1; 0.001 by default. The error bound of each stored length is added.
        limit : int, optional
            Maximum number of orbits to return; by default all.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Examples
        --------
        >>> [(each.code, each.repetitions) for each in catalogue.with_length(20.8)]
        [('13', 2)]
        """
        from orbitdb.answers.identification import identify_length

        with self._file.moment() as moment:
            return identify_length(moment, self._at(a), length, tolerance, limit)

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
        """Return the length spectra of the stored orbits and of the quantum levels.

        Parameters
        ----------
        lengths : (float, float), optional
            Range of lengths, in units of the radius.
        points : int, optional
            Number of lengths in the range.
        k_max : float, optional
            End of the window in k, in 1/radius; by default where the levels end, or 30 if there are none.
        levels : array-like, shape (N,), optional
            All levels k, beginning with the lowest; by default the stored ones.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo``; by default the levels of all parities together.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Raises
        ------
        InputError
            If no orbits are stored, or an argument is invalid.
        """
        from orbitdb.answers.length_spectrum import read_spectrum

        with self._file.moment() as moment:
            return read_spectrum(moment, self._at(a), lengths, points, k_max, levels, parity)

    # making

    def fill(
        self,
        periods: int | str | Iterable[int] | None = None,
        words: Iterable[str] = (),
        *,
        jobs: int | None = 1,
        geometric: bool = False,
        method: str = "newton",
        workers: "Workers | None" = None,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "list[Fill]":
        """Store all words of the given periods, or the given words, with their orbits.

        A fill that was interrupted resumes where it stopped; finished periods are skipped.

        Parameters
        ----------
        periods : int, str or iterable of int, optional
            Periods, such as ``"2-11"``.
        words : iterable of str, optional
            Primitive words of any period, to store with their symmetry classes.
        jobs : int or None, optional
            Number of processes; None for one per core if there is enough work. A script that uses more than
            one needs the usual ``if __name__ == "__main__":``.
        geometric : bool, optional
            Whether to store the geometrically pruned words of the periods as well.
        method : str, optional
            ``newton``, or ``relaxation`` for the paper's method, which is slow.
        workers : Workers, optional
            An open `orbitdb.filling.cluster.Cluster` to use instead of local processes.
        progress : callable, optional
            Function called with the amount done, the total, and a text. By default, a notebook shows a bar.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Returns
        -------
        list of Fill
            The progress and the counts of the given periods.

        Raises
        ------
        InputError
            If you give neither periods nor words, or if a value is invalid.
        StoreError
            If the file cannot be written, or the disk does not have enough room.

        Examples
        --------
        >>> own = Catalogue.create("own.db", a=1)
        >>> [fill.n_c for fill in own.fill("2-5")]
        [1, 8, 32, 48]
        """
        from orbitdb.filling.fill import fill

        at, wanted, single = self._at(a), _periods(periods), list(words)
        if not wanted and not single:
            raise InputError("say what to fill: periods such as '2-11', or words=['1232131']")
        if geometric and not wanted:
            raise InputError("geometric=True stores the pruned words of periods: name periods, too")
        if wanted:
            with telling(progress, "fill") as tell:
                fill(self.path, at, wanted, jobs, workers, geometric, method, tell)
        for word in single:
            self.fill_word(word, method=method, a=at)
        return [fill for fill in self.fills(at) if fill.p in wanted]

    def fill_word(self, word: str, *, method: str = "newton", a: float | None = None) -> Orbit:
        """Store a primitive word of any period with its symmetry class, and return its orbit.

        The other parameters are those of `fill`. The bouncing-ball family 02 is never stored.
        """
        from orbitdb.filling.fill import fill_word

        return fill_word(self.path, parse_primitive(word), self._at(a), method)

    def fill_births(
        self,
        periods: int | str | Iterable[int],
        *,
        jobs: int | None = 1,
        progress: Tell | None = None,
    ) -> "list[BirthFill]":
        """Find and store the values of ``a`` at which each word begins or ceases to be an orbit.

        The parameters are those of `fill`.
        """
        from orbitdb.filling.births import find_births

        wanted = _periods(periods)
        with telling(progress, "births") as tell:
            find_births(self.path, wanted, jobs, tell)
        return [each for each in self.birth_fills() if each.p in wanted]

    @with_criteria
    def sweep(
        self,
        periods: int | str | Iterable[int],
        selection: Selection | None = None,
        *,
        jobs: int | None = 1,
        workers: "Workers | None" = None,
        progress: Tell | None = None,
        **criteria: Unpack[Criteria],
    ) -> "list[Sweep]":
        """Count the orbits of the given periods and compute the sums for averages, without storing rows.

        `table`, `entropy` and `lyapunov` use sweeps for periods that are not filled.

        Parameters
        ----------
        periods, jobs, workers, progress : optional
            As for `fill`.
        selection : Selection, optional
            The orbits to sweep, by default all; you can give criteria instead, as in `select`.

        Raises
        ------
        SelectionError
            If the subset cannot be swept.
        """
        from orbitdb.filling.sweeps import sweep

        chosen, wanted = self._chosen(selection, criteria), _periods(periods)
        with telling(progress, "sweep") as tell:
            sweep(self.path, chosen, wanted, jobs, workers, tell)
        return [each for each in self.sweeps(chosen.a, chosen) if each.p in wanted]

    def simulate(
        self,
        bounces: int = 20_000_000,
        *,
        seed: "int | np.random.Generator" = 0,
        legwise: bool = False,
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
        progress, a : optional
            As for `fill`.
        """
        from orbitdb.filling import records

        at = Stadium(self._at(a))
        with telling(progress, "trajectories") as tell:
            found = records.simulate(at, bounces, _seed(seed), legwise, tell)
        records.keep_simulated(self.path, at.a, found)
        return found

    def prove_bounds(
        self,
        edges: int | None = None,
        *,
        width: float | None = None,
        seconds: float | None = None,
        balls: bool = False,
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
        balls : bool, optional
            Whether to check every decision in ball arithmetic, and use only those that it proves.
        progress, a : optional
            As for `fill`.

        Returns
        -------
        EntropyBounds
            The bounds that follow from the longest windows.
        """
        from orbitdb.filling import records

        at, limits = self._at(a), records.limits_of(edges, width, seconds)
        asked = {"a": f"{at!r}", "window": edges, "width": width, "time": seconds, "prove": balls}
        proofs: list[Any] | None = [] if balls else None
        with telling(progress, "bounds") as tell:
            *_, last = records.find_bounds(self.path, [at], limits, proofs, 1, tell, asked)
        return last

    def fill_levels(
        self,
        k_max: float,
        k_min: float = 0.0,
        parities: "Sequence[Parity | str]" = ("ee", "eo", "oe", "oo"),
        *,
        jobs: int | None = 1,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Levels":
        """Find and store all quantum levels with k_min <= k < k_max, each with an estimated error.

        Parameters
        ----------
        k_max, k_min : float
            The range of wavenumbers, in 1/radius.
        parities : sequence of str, optional
            Some of ``ee``, ``eo``, ``oe``, ``oo``: even (e) or odd (o) in x, then in y.
        jobs, progress, a : optional
            As for `fill`.
        """
        from orbitdb.filling import records
        from orbitdb.quantum.levels import Levels
        from orbitdb.quantum.weyl import parities_of

        at = Stadium(self._at(a))
        with telling(progress, "levels") as tell:
            found = records.find_levels(self.path, at, k_min, k_max, parities_of(parities), jobs, tell)
        return Levels.joined(at.a, k_min, k_max, found)

    def levels(
        self,
        k_max: float | None = None,
        parity: "Parity | str | None" = None,
        *,
        method: str = "elements",
        a: float | None = None,
    ) -> "Levels":
        """Return the quantum levels from k = 0 up, either the stored ones or those computed from orbits.

        Parameters
        ----------
        k_max : float, optional
            End of the range, in 1/radius. By default, the stored levels end at the first gap, and those from
            orbits where the rms error reaches a fifth of the mean spacing.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo``; by default all.
        method : str, optional
            ``elements`` for the levels that `fill_levels` stored; ``orbits`` for levels from N_X(k), with
            errors that hold for nine levels out of ten (`orbitdb.quantum.levels_from_orbits`).
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Raises
        ------
        InputError
            If the levels are not stored up to ``k_max``, or too few orbits are stored.
        """
        from orbitdb.answers.levels import levels_from_orbits, levels_from_zero
        from orbitdb.quantum.weyl import Parity, parities_of

        if method not in ("elements", "orbits"):
            raise InputError(f"method {method!r}: use elements or orbits")
        with self._file.moment() as moment:
            if method == "elements":
                return levels_from_zero(moment, self._at(a), parity, k_max)
            parities = tuple(Parity) if parity is None else parities_of([parity])
            return levels_from_orbits(moment, self._at(a), k_max, parities)

    def assess(
        self,
        k: "ArrayLike | None" = None,
        parity: "Parity | str | None" = None,
        *,
        fit_radius: bool = False,
        a: float | None = None,
    ) -> "Assessment":
        """Use the stored orbits to find where levels are missing from a list, and where some are spurious.

        Parameters
        ----------
        k : array-like, shape (N,), optional
            The levels, beginning with the lowest, in 1/radius; by default the stored ones.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo`` if all levels have this parity; by default, all four are mixed.
        fit_radius : bool, optional
            Whether to fit the radius, in case it is known only to within half a per cent.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Raises
        ------
        InputError
            If the values cannot be levels of the stadium, or too few orbits are stored.
        """
        from orbitdb.answers.assessment import assess_levels
        from orbitdb.quantum.weyl import parities_of

        of = None if parity is None else parities_of([parity])[0]
        with self._file.moment() as moment:
            return assess_levels(moment, self._at(a), k, of, fit_radius)[0]

    def scars(
        self,
        k_max: float,
        k_min: float,
        word: str | None = None,
        parities: "Sequence[Parity | str]" = ("ee", "eo", "oe", "oo"),
        *,
        a: float | None = None,
    ) -> "list[Scar]":
        """Measure how strongly orbits scar the quantum levels with k_min <= k < k_max.

        Parameters
        ----------
        k_max, k_min : float
            The range of wavenumbers, in 1/radius.
        word : str, optional
            An orbit; the result then has an entry for every level, the most strongly scarred first. By
            default, it has, for each level, the five of the twenty shortest stored orbits that scar it most.
        parities : sequence of str, optional
            As for `fill_levels`.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Raises
        ------
        InputError
            If the range is invalid, or the word is not an orbit.
        """
        from orbitdb.answers.scars import scars_of, scars_of_shortest
        from orbitdb.quantum.weyl import parities_of

        named, at = parities_of(parities), self._at(a)
        if word is not None:
            return scars_of(find_or_solve(self.path, parse_primitive(word), at), k_min, k_max, named)
        with self._file.moment() as moment:
            return scars_of_shortest(moment, at, k_min, k_max, named)

    @with_criteria
    def verify(
        self,
        selection: Selection | None = None,
        *,
        sample: int | None = None,
        restarts: int = 0,
        seed: "int | np.random.Generator" = 0,
        births: bool = False,
        rigorous: bool = False,
        jobs: int | None = 1,
        progress: Tell | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Verification":
        """Recompute the catalogue from its words alone, and compare the results with the stored ones.

        Parameters
        ----------
        selection : Selection, optional
            What to check, by default everything at every ``a``; or give criteria, as in `select`.
        sample : int, optional
            Check only this many classes, drawn at random.
        restarts : int, optional
            Number of random starts from which every word is solved again.
        seed : optional
            Seed of the sample and the restarts, as for `simulate`.
        births : bool, optional
            Whether to prove that no birth or death between a = 0.02 and 1000 is missing.
        rigorous : bool, optional
            Whether to prove every row in ball arithmetic, and store the certificates.
        jobs, progress : optional
            As for `fill`.

        Examples
        --------
        >>> catalogue.verify(p="2-5").sound
        True
        """
        from orbitdb.verification.verify import Verification, report, told, verification_steps

        everywhere = selection is None and criteria.get("a") is None
        chosen = self._chosen(selection, criteria)
        selections = [replace(chosen, a=at) for at in self.a_values()] if everywhere else [chosen]
        drawn = _seed(seed)
        work = verification_steps(self.path, selections, sample, restarts, drawn, births, rigorous, jobs=jobs)
        with telling(progress, "verify") as tell, closing(work) as steps:
            return Verification(tuple(report(told(steps, tell))))

    # what else is stored

    def a_values(self, orbits: bool = False) -> list[float]:
        """Return the stored values of ``a`` in order; with `orbits`, only those with orbits or sweeps."""
        with self._file.moment() as moment:
            return moment.a_values(orbits)

    def fills(self, a: float | None = None) -> "list[Fill]":
        """Return the fills at a given ``a``, in order of period."""
        with self._file.moment() as moment:
            return moment.fills(self._at(a))

    def birth_fills(self) -> "list[BirthFill]":
        """Return how far births and deaths are stored, period by period."""
        with self._file.moment() as moment:
            return moment.birth_fills()

    def births(self, p: int) -> "list[Life]":
        """Return the ranges of ``a`` in which the classes of a period are orbits, in order of birth.

        The list is empty if no births of the period are stored (`fill_births`).
        """
        with self._file.moment() as moment:
            return moment.births(p)

    def entropy_bounds(self, a: float | None = None, proof: str | None = None) -> "EntropyBounds | None":
        """Return the tightest bounds on the topological entropy that `prove_bounds` stored, or None.

        Parameters
        ----------
        a : float, optional
            Half length of the stadium; by default the catalogue's.
        proof : str, optional
            ``doubles`` or ``balls``, for bounds proved in this arithmetic only; by default in either.
        """
        with self._file.moment() as moment:
            return moment.entropy_bounds(self._at(a), proof)

    def reference(self, a: float | None = None) -> "Reference | None":
        """Return the averages over trajectories, with the smallest error, that `simulate` stored, or None."""
        with self._file.moment() as moment:
            return moment.reference(self._at(a))

    def entropy_curve(self, proof: str | None = None) -> "list[EntropyBounds]":
        """Return the tightest stored bounds on the topological entropy at every ``a`` that has any."""
        with self._file.moment() as moment:
            return moment.entropy_curve(proof)

    def sweeps(self, a: float | None = None, selection: Selection | None = None) -> "list[Sweep]":
        """Return the sweeps at a given ``a``, with their counts and sums, in order of period.

        Parameters
        ----------
        a : float, optional
            Half length of the stadium; by default the catalogue's.
        selection : Selection, optional
            The swept subset, by default all orbits; its ``a`` and periods are ignored.
        """
        with self._file.moment() as moment:
            return moment.sweeps(self._at(a), selection)

    def swept_subsets(self, a: float | None = None) -> list[Selection]:
        """Return the subsets, other than that of all orbits, that have been swept at a given ``a``."""
        with self._file.moment() as moment:
            return moment.swept_subsets(self._at(a))

    @contextmanager
    def _question(
        self, selection: Selection | None, criteria: Criteria
    ) -> Iterator[tuple[Moment, Selection]]:
        """Open a moment of the file, and yield it together with the chosen subset."""
        chosen = self._chosen(selection, criteria)
        with self._file.moment() as moment:
            yield moment, chosen

    def _chosen(self, selection: Selection | None, criteria: Criteria) -> Selection:
        if selection is not None and criteria:
            raise SelectionError("give a Selection or criteria, not both")
        if not isinstance(selection, Selection | None):
            raise TypeError(f"choose a subset by criteria such as p=3 or a Selection, not {selection!r:.40}")
        if selection is not None:
            return selection
        named = criteria.copy()
        if named.get("a") is None:
            named["a"] = self.a
        return chosen_by(**named)

    def _at(self, a: float | None) -> float:
        return self.a if a is None else Stadium(a).a


def _periods(periods: int | str | Iterable[int] | None) -> tuple[int, ...]:
    return () if periods is None else chosen_periods(periods)


def _seed(seed: "int | np.random.Generator") -> int:
    return int(seed.integers(2**63)) if hasattr(seed, "integers") else seed
