"""`Catalogue`, the main class of the library: a database of periodic orbits to fill, query and check."""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Unpack

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.quantum_catalogue import QuantumCatalogue
from orbitdb.errors import InputError, checked_methods, need_whole
from orbitdb.orbits.orbit import Orbit
from orbitdb.progress import Tell, telling
from orbitdb.store.lookup import find_or_solve, find_word
from orbitdb.store.query import COLUMNS, choose
from orbitdb.store.rows import rows_of
from orbitdb.store.selection import Criteria, Selection, with_criteria
from orbitdb.symbols.words import WordError, is_primitive, parse, primitive_root

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from orbitdb.answers.completeness import Counted
    from orbitdb.answers.field import FieldOrbits
    from orbitdb.answers.identification import Candidate, Trajectory
    from orbitdb.answers.results import Result
    from orbitdb.answers.subset import Subset
    from orbitdb.extras import Rows
    from orbitdb.orbits.exponents import OrbitClasses


@checked_methods
class Catalogue(QuantumCatalogue):
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default the one that ``ORBITDB_DB`` names, or else ``orbits.db`` in your data folder.
    a : float, optional
        Half length of the stadium; all methods take another one as ``a``. If you give none, it is the only
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

        The word consists of symbols 0 to 5, or is in run notation; otherwise a `WordError` is raised.
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

        A word that is not stored is solved on the spot; its orbit has ``stored`` false. A word that repeats a
        shorter one raises a `KeyError`, and a text that is not a word a `WordError`.
        """
        symbols = parse(word)
        if not is_primitive(symbols):
            raise KeyError(f"{word} repeats {primitive_root(symbols)}: ask for the shorter word")
        stored = self.find(symbols)
        if stored is not None:
            return stored
        from orbitdb.orbits.solve import solve_word

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
        """Yield the rows of a subset, one per word, chosen by a `Selection` or by the criteria of `select`.

        Parameters
        ----------
        columns : sequence of str, optional
            Names of columns of the view ``catalogue``.
        order : str, optional
            Columns to sort by, separated by commas; ``desc`` after a name, or ``-`` before it, reverses the
            order. Ties are broken by period, representative and element, in ascending order.
        limit, offset : int, optional
            Maximum number of rows to yield, and number of rows to skip first.
        """
        need_whole("limit", limit or 0, 0)
        need_whole("offset", offset, 0)
        chosen = self._chosen(selection, criteria)
        with self._file.moment() as moment:
            most = None if limit is None else limit + offset
            yield from rows_of(moment, choose(moment, chosen, order, most=most), columns, offset, most)

    @with_criteria
    def count(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> int:
        """Return the number of words in a chosen subset, given as in `select`."""
        return len(self._answer(choose, selection, criteria))

    @with_criteria
    def counts(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "Counted":
        """Return the counts of the paper's Table 1, taken from a fill, a sweep, or births.

        The only parameters are ``a`` and ``p``; by default, it counts all stored periods.
        """
        from orbitdb.answers.completeness import count

        return self._answer(count, selection, criteria)

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

        return self._answer(read_subset, selection, criteria, order, coordinates, classes)

    @with_criteria
    def classes(self, selection: Selection | None = None, **criteria: Unpack[Criteria]) -> "OrbitClasses":
        """Return the symmetry classes of chosen orbits, each with the number of its words in the subset.

        The parameters are those of `select`. Orbits through a joint are included if you ask for their status.
        """
        from orbitdb.answers.whole_periods import read_classes

        return self._answer(read_classes, selection, criteria)

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

        return self._answer(table, selection, criteria)

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

        return self._answer(entropy, selection, criteria)

    @with_criteria
    def lyapunov(
        self,
        selection: Selection | None = None,
        *,
        weight: str = "exp",
        cut: float | None = None,
        **criteria: Unpack[Criteria],
    ) -> "Result":
        """Return the Lyapunov exponents averaged over orbits chosen as in `select`, by period and method.

        Parameters
        ----------
        weight : str, optional
            ``exp`` for weights e^-lambda, as in the paper; ``det`` for weights ``1/|det(1 - M)|``.
        cut : float, optional
            Return instead a single zeta average, over all pseudo-cycles with lambda up to this value.
        """
        from orbitdb.answers.lyapunov import lyapunov

        return self._answer(lyapunov, selection, criteria, weight, cut)

    @with_criteria
    def field(
        self,
        kappa: "ArrayLike",
        selection: Selection | None = None,
        *,
        words: str | Iterable[str] | None = None,
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
            The words, by default those of all filled periods; or give criteria, as in `select`. They apply to
            the stored numbers, which are those without a field.
        words : str or iterable of str, optional
            Instead, primitive words of any period, stored or not; a single text is one word.
        progress : optional
            As for `fill`.

        Raises
        ------
        InputError
            If 2 / kappa is not above the longest chord, 2a + 2, or if there are too many words.

        Examples
        --------
        >>> orbits = catalogue.field([0.05, 0.1], words="0123")
        >>> orbits.status.tolist(), orbits.splitting.round(6).tolist()
        (['orbit', 'orbit'], [-0.52, -1.04])
        """
        from orbitdb.answers.field import follow_words
        from orbitdb.answers.field_words import chosen_words, named_words

        if words is not None:
            if selection is not None or criteria.keys() - {"a"}:
                raise InputError("give words, or criteria that choose them, not both")
            picked = named_words(words, self._at(criteria.get("a")))
        else:
            picked = self._answer(chosen_words, selection, criteria)
        with telling(progress, "field") as tell:
            return follow_words(picked, kappa, tell)

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
        follows for at least two bounces; the one that it goes round most often comes first.

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

        Examples
        --------
        >>> trajectory = catalogue.identify(start=(0, 0.001, 0))
        >>> [(stretch.orbit.code, stretch.first, stretch.bounces) for stretch in trajectory.shadowed[:1]]
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

        Examples
        --------
        >>> [(match.code, match.repetitions) for match in catalogue.with_length(20.8)]
        [('13', 2)]
        """
        from orbitdb.answers.identification import identify_length

        with self._file.moment() as moment:
            return identify_length(moment, self._at(a), length, tolerance, limit)
