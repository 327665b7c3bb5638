"""`StoredCatalogue`, the part of `Catalogue` that opens, fills and checks its file, and lists contents."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, Unpack

from orbitdb.answers.completeness import describe_fills
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, StoreError, checked_methods, need_whole
from orbitdb.extras import Rows
from orbitdb.orbits.orbit import Orbit
from orbitdb.progress import Tell, telling
from orbitdb.store.connection import Moment
from orbitdb.store.file import Reader
from orbitdb.store.fills import best_reference, bounds_by_a, read_fills, read_sweeps, tightest_bounds
from orbitdb.store.lives import read_birth_fills, read_lives
from orbitdb.store.lookup import WITH_ORBITS, a_meant, a_values, meant
from orbitdb.store.paths import default_path, home_expanded
from orbitdb.store.selection import (
    Criteria,
    Selection,
    SelectionError,
    chosen_by,
    chosen_periods,
    fillable,
    with_criteria,
)

if TYPE_CHECKING:
    import numpy as np
    import sqlalchemy

    from orbitdb.answers.results import Births
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.filling.workers import Workers
    from orbitdb.quantum.levels import Levels
    from orbitdb.quantum.weyl import Parity
    from orbitdb.store.fills import Contents, Fill, Sweep
    from orbitdb.store.lives import BirthFill
    from orbitdb.trajectories.ensemble import Reference
    from orbitdb.verification.verify import Verification

_SHOWN = 4
"""Maximum number of further values of ``a`` in a repr."""


@checked_methods
class StoredCatalogue:
    """A file of periodic orbits: opened, filled, checked, and listed (`orbitdb.Catalogue`)."""

    def __init__(self, path: Path | str | None = None, a: float | None = None) -> None:
        self._a = None if a is None else Stadium(a).a
        self._file = Reader(path)

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> Self:
        """Open a catalogue; create it first if there is none, or upgrade it to the latest schema."""
        from orbitdb.store.file import migrate

        migrate(default_path() if path is None else home_expanded(path))
        return cls(path, a)

    @property
    def path(self) -> Path:
        """Absolute path of the file."""
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
                self._a = a_meant(moment)
        return self._a

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Do nothing: the file is open only while a question is answered."""

    def engine(self) -> "sqlalchemy.Engine":
        """Return an SQLAlchemy engine for SQL of your own, such as ``pandas.read_sql(query, c.engine())``.

        Its connections read the tables and views of `orbitdb sql`, and know ``code()``; they cannot write.
        """
        import sqlalchemy as sa

        return sa.create_engine("sqlite://", creator=self._file.connect, poolclass=sa.NullPool)

    def __reduce__(self) -> tuple[type[Self], tuple[Path, float | None]]:
        """Pickle only the path and ``a``; the copy opens the file itself."""
        return type(self), (self.path, self._a)

    def __repr__(self) -> str:
        try:
            with self._file.moment() as moment:
                known = self._contents(moment)
        except StoreError as error:
            known = str(error)
        return f"<Catalogue {self.path.name}: {known}>"

    def _contents(self, moment: Moment) -> str:
        """Return one line that says which periods are filled, beginning with the default ``a``."""
        values = a_values(moment, WITH_ORBITS)
        try:
            own = [meant(values) if self._a is None else self._a]
        except InputError:
            own = []
        others = [a for a in values if a not in own]
        parts = [describe_fills(read_fills(moment, a), a) for a in (*own, *others[:_SHOWN])]
        return "; ".join(parts) + (f"; and at {len(others) - _SHOWN} more" if len(others) > _SHOWN else "")

    # making

    def fill(
        self,
        periods: int | str | Iterable[int] | None = None,
        *,
        words: str | Iterable[str] = (),
        jobs: int | None = 1,
        geometric: bool = False,
        method: str = "newton",
        workers: "Workers | None" = None,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Rows[Fill]":
        """Store all words of the given periods, or the given words, with their orbits.

        A fill that was interrupted resumes where it stopped; finished periods are skipped.

        Parameters
        ----------
        periods : int, str or iterable of int, optional
            Periods, such as ``"2-11"``.
        words : str or iterable of str, optional
            Primitive words of any period, to store with their symmetry classes; a single text is one word.
        jobs : int or None, optional
            Number of processes; None for one per core if there is enough work.
        geometric : bool, optional
            Whether to store the geometrically pruned words of the periods as well.
        method : str, optional
            ``newton``, or ``relaxation`` for the paper's method, which is slow.
        workers : Workers, optional
            An open `orbitdb.filling.workers.Cluster` to use instead of local processes.
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
        from orbitdb.filling.fill import fill, fillable

        at, wanted = self._at(a), () if periods is None else chosen_periods(periods)
        single = [fillable(word) for word in ([words] if isinstance(words, str | int) else words)]
        if not wanted and not single:
            raise InputError("say what to fill: periods such as '2-11', or words=['1232131']")
        if geometric and not wanted:
            raise InputError("geometric=True stores the pruned words of periods: name periods, too")
        if wanted:
            with telling(progress, "fill") as tell:
                fill(self.path, at, wanted, jobs, workers, geometric, method, tell)
        for word in single:
            self.fill_word(word, method=method, a=at)
        return Rows(fill for fill in self.fills(a=at) if fill.p in wanted)

    def fill_word(self, word: str, *, method: str = "newton", a: float | None = None) -> Orbit:
        """Store a primitive word of any period with its symmetry class, and return its orbit.

        The other parameters are those of `fill`. The bouncing-ball family 02 is never stored.
        """
        from orbitdb.filling.fill import fill_word

        return fill_word(self.path, word, self._at(a), method)

    def fill_births(
        self,
        periods: int | str | Iterable[int],
        *,
        jobs: int | None = 1,
        progress: Tell | None = None,
    ) -> "Rows[BirthFill]":
        """Find and store the values of ``a`` at which each word begins or ceases to be an orbit.

        The parameters are those of `fill`.
        """
        from orbitdb.filling.fill import find_births

        wanted = chosen_periods(periods)
        with telling(progress, "births") as tell:
            find_births(self.path, wanted, jobs, tell)
        return Rows(fill for fill in self.birth_fills() if fill.p in wanted)

    def sweep(
        self,
        periods: int | str | Iterable[int],
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

        at, wanted = self._at(a), chosen_periods(periods)
        with telling(progress, "sweep") as tell:
            sweep(self.path, at, wanted, jobs, workers, tell)
        return Rows(sweep for sweep in self.sweeps(a=at) if sweep.p in wanted)

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
        need_whole("bounces", bounces)
        records.check_writable(self.path)
        with telling(progress, "trajectories") as tell:
            found = records.simulate(at, bounces, _seed(seed), legwise, tell)
        records.keep_simulated(self.path, found)
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
        low: float = 0.0,
        high: float | None = None,
        *,
        parities: "Sequence[Parity | str] | str | None" = None,
        jobs: int | None = 1,
        progress: Tell | None = None,
        a: float | None = None,
    ) -> "Levels":
        """Find and store all quantum levels with low <= k < high, each with an estimated error.

        Parameters
        ----------
        low, high : float
            The range of wavenumbers, in 1/radius. As in Python's `range`, a single number is the upper end.
        parities : str or sequence of str, optional
            Some of ``ee``, ``eo``, ``oe``, ``oo``: even (e) or odd (o) in x, then in y; by default all four.
        jobs, progress, a : optional
            As for `fill`.
        """
        from orbitdb.filling import records
        from orbitdb.quantum.levels import Levels
        from orbitdb.quantum.weyl import parities_of

        at, (low, high) = Stadium(self._at(a)), (0.0, low) if high is None else (low, high)
        with telling(progress, "levels") as tell:
            found = records.find_levels(self.path, at, low, high, parities_of(parities), jobs, tell)
        return Levels.joined(at.a, low, high, found)

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
        from orbitdb.verification.verify import verifiable, verified

        everywhere = selection is None and criteria.get("a") is None
        chosen = self._chosen(selection, criteria)
        selections = [chosen]
        if everywhere:
            with self._file.moment() as moment:
                selections = [replace(chosen, a=at) for at in verifiable(moment)]
        drawn = _seed(seed)
        with telling(progress, "verify") as tell:
            return verified(self.path, selections, sample, restarts, drawn, births, rigorous, jobs, tell)

    # deleting

    def contents(self, a: float, p: int | str | Iterable[int] | None = None) -> "Contents":
        """Return what is stored at a given ``a``, in some periods or in all; `delete` would delete it."""
        from orbitdb.store.fills import contents

        chosen = chosen_by(a=a, p=p)
        with self._file.moment() as moment:
            return contents(moment, chosen.a, chosen.periods)

    def delete(self, a: float, p: int | str | Iterable[int] | None = None) -> "Contents":
        """Delete what is stored at a given ``a``, and return what that was.

        Parameters
        ----------
        a : float
            Half length of the stadium.
        p : int, str or iterable of int, optional
            Periods whose orbits, fills and sweeps are deleted. By default everything at this ``a`` is
            deleted, levels, bounds on the entropy and averages over trajectories, too.

        Examples
        --------
        >>> own = Catalogue.create("own.db", a=1)
        >>> fills = own.fill("2-5")
        >>> print(own.delete(1, p="4-5"))
        128 words, 2 fills (periods 4-5)
        """
        from orbitdb.store.writing import delete

        contents, chosen = self.contents(a, p), chosen_by(a=a, p=p)
        delete(self.path, chosen.a, chosen.periods)
        return contents

    # what is stored

    def a_values(self, *, orbits: bool = False) -> list[float]:
        """Return the stored values of ``a`` in order; with `orbits`, only those with orbits or sweeps."""
        with self._file.moment() as moment:
            return a_values(moment, WITH_ORBITS if orbits else ())

    def fills(self, *, a: float | None = None) -> "Rows[Fill]":
        """Return the fills at a given ``a``, in order of period."""
        with self._file.moment() as moment:
            return Rows(read_fills(moment, self._at(a)))

    def birth_fills(self) -> "Rows[BirthFill]":
        """Return how far births and deaths are stored, period by period."""
        with self._file.moment() as moment:
            return Rows(read_birth_fills(moment))

    def births(self, p: int) -> "Births":
        """Return the ranges of ``a`` in which the classes of a period are orbits, in order of birth.

        The list is empty if no births of the period are stored (`fill_births`).

        Raises
        ------
        InputError
            If no catalogue can have births of the period.
        """
        from orbitdb.answers.results import Births

        fillable([(p, p)])
        with self._file.moment() as moment:
            return Births(read_lives(moment, p))

    def entropy_bounds(self, *, a: float | None = None, proof: str | None = None) -> "EntropyBounds | None":
        """Return the tightest bounds on the topological entropy that `prove_bounds` stored, or None.

        Parameters
        ----------
        a : float, optional
            Half length of the stadium; by default the catalogue's.
        proof : str, optional
            ``doubles`` or ``balls``, for bounds proved in this arithmetic only; by default in either.
        """
        with self._file.moment() as moment:
            return tightest_bounds(moment, self._at(a), proof)

    def entropy_curve(self, *, proof: str | None = None) -> "Rows[EntropyBounds]":
        """Return the tightest stored bounds on the topological entropy at every ``a`` that has any."""
        with self._file.moment() as moment:
            return Rows(bounds_by_a(moment, proof))

    def reference(self, *, a: float | None = None) -> "Reference | None":
        """Return the averages over trajectories, with the smallest error, that `simulate` stored, or None."""
        with self._file.moment() as moment:
            return best_reference(moment, self._at(a))

    def sweeps(self, *, a: float | None = None) -> "Rows[Sweep]":
        """Return the sweeps at a given ``a``, with their counts and sums, in order of period."""
        with self._file.moment() as moment:
            return Rows(read_sweeps(moment, self._at(a)))

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
            raise SelectionError(
                f"choose a subset by criteria such as p=3 or a Selection, not {selection!r:.30}"
            )
        if selection is not None:
            return selection
        named = criteria.copy()
        if named.get("a") is None:
            named["a"] = self.a
        return chosen_by(**named)

    def _at(self, a: float | None) -> float:
        return self.a if a is None else Stadium(a).a


def _seed(seed: "int | np.random.Generator") -> int:
    if hasattr(seed, "integers"):
        return int(seed.integers(2**63))
    need_whole("seed", seed, 0)
    return int(seed)
