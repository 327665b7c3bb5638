"""Catalogue: a database of periodic orbits, opened for reading."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Unpack

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.stored_words import StoredWords
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.criteria import Criteria, with_criteria
from orbitdb.store.asking.selection import Selection

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from orbitdb.catalogue.identification import Candidate, Trajectory
    from orbitdb.catalogue.results import Result
    from orbitdb.catalogue.subset import Subset
    from orbitdb.catalogue.whole_periods import ChosenClasses
    from orbitdb.quantum.spectrum import Spectrum


class Catalogue(StoredWords):
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
        from orbitdb.catalogue.whole_periods import read_classes

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
