"""`Catalogue`, the main class of the library: a database of periodic orbits to fill, query and check."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Unpack

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.filled_catalogue import FilledCatalogue
from orbitdb.errors import InputError, checked_methods, need_whole
from orbitdb.extras import Rows
from orbitdb.orbits.orbit import Orbit
from orbitdb.progress import Tell, telling
from orbitdb.store.lookup import find_or_solve, find_word
from orbitdb.store.query import COLUMNS, choose
from orbitdb.store.rows import rows_of
from orbitdb.store.selection import Criteria, Selection, with_criteria
from orbitdb.symbols.words import WordError, is_primitive, parse, parse_primitive, primitive_root

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from orbitdb.answers.completeness import Counted
    from orbitdb.answers.identification import Candidate, Trajectory
    from orbitdb.answers.results import Result
    from orbitdb.answers.scars import Scar
    from orbitdb.answers.subset import Subset
    from orbitdb.orbits.exponents import OrbitClasses
    from orbitdb.quantum.length_spectrum import Spectrum
    from orbitdb.quantum.levels import Levels
    from orbitdb.quantum.missing_levels import Assessment
    from orbitdb.quantum.weyl import Parity


@checked_methods
class Catalogue(FilledCatalogue):
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

    The file is open only while a question is answered, so nothing has to be closed. If another file takes its
    place, the next question reads that one.
    """

    # one word

    def find(self, word: str, *, a: float | None = None) -> Orbit | None:
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
            return find_word(moment, symbols, self._at(a))

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
        stored = self.find(symbols)
        if stored is not None:
            return stored
        from orbitdb.orbits.newton import solve_word

        return solve_word(symbols, self.a)

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
        *,
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
        for name, count in {"limit": 0 if limit is None else limit, "offset": offset}.items():
            need_whole(name, count, 0)
        with self._question(selection, criteria) as (moment, chosen):
            most = None if limit is None else limit + offset
            yield from rows_of(moment, choose(moment, chosen, order, most=most), columns, offset, most)

    @with_criteria
    def count(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> int:
        """Return the number of words in a chosen subset, given as in `select`."""
        with self._question(selection, criteria) as (moment, chosen):
            return len(choose(moment, chosen))

    @with_criteria
    def counts(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Counted":
        """Return the counts of the paper's Table 1, taken from a fill, a sweep, or births.

        The only parameters are ``a`` and ``p``; by default, it counts all stored periods.
        """
        from orbitdb.answers.completeness import count, need_periods_alone

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
        classes: bool = False,
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
        classes : bool, optional
            Whether to return one entry per symmetry class with chosen words, its representative.
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
            return read_subset(moment, chosen, order, coordinates, classes)

    @with_criteria
    def classes(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "OrbitClasses":
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
        *,
        tolerance: float | None = None,
        limit: int | None = None,
        a: float | None = None,
    ) -> "Rows[Candidate]":
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
        from orbitdb.answers.levels import read_spectrum

        with self._file.moment() as moment:
            return read_spectrum(moment, self._at(a), lengths, points, k_max, levels, parity)

    def levels(
        self,
        k_max: float | None = None,
        *,
        parity: "Parity | str | None" = None,
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
        from orbitdb.quantum.weyl import one_parity, parities_of

        if method not in ("elements", "orbits"):
            raise InputError(f"method {method!r}: use elements or orbits")
        with self._file.moment() as moment:
            if method == "elements":
                return levels_from_zero(moment, self._at(a), parity, k_max)
            return levels_from_orbits(moment, self._at(a), k_max, parities_of(one_parity(parity)))

    def assess(
        self,
        k: "ArrayLike | None" = None,
        *,
        parity: "Parity | str | None" = None,
        window: bool = False,
        fit_radius: bool = False,
        a: float | None = None,
    ) -> "Assessment":
        """Use the stored orbits to find where levels are missing from a list, and where some are spurious.

        Parameters
        ----------
        k : array-like, shape (N,), optional
            The levels in 1/radius, beginning with the lowest unless they are a window; by default the stored
            ones.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo`` if all levels have this parity; by default, all four are mixed.
        window : bool, optional
            Whether the list begins with any level; `Assessment.first` then says which one it is.
        fit_radius : bool, optional
            Whether to fit the radius, in case it is known only to within half a per cent.
        a : float, optional
            Half length of the stadium; by default the catalogue's.

        Raises
        ------
        InputError
            If the values cannot be levels of the stadium, too few orbits are stored, or the orbits cannot
            tell with which level a window begins.
        """
        from orbitdb.answers.levels import assess_levels

        with self._file.moment() as moment:
            return assess_levels(moment, self._at(a), k, parity, fit_radius, window)[0]

    def scars(
        self,
        low: float,
        high: float | None = None,
        *,
        word: str | None = None,
        parities: "Sequence[Parity | str] | str | None" = None,
        order: str = "above",
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Rows[Scar]":
        """Measure how strongly orbits scar the quantum levels with low <= k < high.

        Parameters
        ----------
        low, high : float
            The range of wavenumbers, in 1/radius. With `low` alone, the level of each parity nearest to it.
        word : str, optional
            An orbit, or ``02`` for the bouncing balls; the result then has an entry for every level. By
            default, it has for each level the five that scar it most, out of the bouncing balls and the
            twenty shortest stored orbits, and is sorted by k.
        parities : sequence of str, optional
            As for `fill_levels`.
        order : str, optional
            Order of the scars of a word: ``above`` or ``strength`` (the largest first), or ``k``.
        progress, a : optional
            As for `fill`.

        Raises
        ------
        InputError
            If the range is invalid, or the word is not an orbit.
        """
        from orbitdb.answers.scars import check_scarring, scars_of, shortest_orbits
        from orbitdb.quantum.weyl import parities_of

        named, at = parities_of(parities), self._at(a)
        if word is None:
            with self._file.moment() as moment:
                orbits = shortest_orbits(moment, at)
        else:
            orbits = [find_or_solve(self.path, parse_primitive(word), at)]
            check_scarring(orbits[0])
        with telling(progress, "waves") as tell:
            return Rows(scars_of(orbits, low, high, named, order, tell))
