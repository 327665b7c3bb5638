"""`FilledCatalogue`, the part of `Catalogue` that fills and checks its file, and deletes from it."""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.stored_catalogue import StoredCatalogue
from orbitdb.errors import InputError, checked_methods, need_whole
from orbitdb.extras import Rows
from orbitdb.orbits.orbit import Orbit
from orbitdb.progress import Tell, telling
from orbitdb.store.selection import Criteria, Selection, chosen_by, chosen_periods, with_criteria

if TYPE_CHECKING:
    import numpy as np

    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.filling.workers import Workers
    from orbitdb.store.contents import Contents
    from orbitdb.store.fills import Fill, Sweep
    from orbitdb.store.lives import BirthFill
    from orbitdb.trajectories.ensemble import Reference
    from orbitdb.verification.verify import Verification


@checked_methods
class FilledCatalogue(StoredCatalogue):
    """A catalogue that can be filled and checked (`orbitdb.Catalogue`)."""

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
            An open `orbitdb.filling.cluster.Cluster` to use instead of local processes.
        progress : callable, optional
            Function called with the amount done, the total, and a text. By default, a notebook shows a bar.

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
        """
        from orbitdb.filling import records

        at = Stadium(self._at(a))
        need_whole("bounces", bounces)
        records.check_writable(self.path)
        with telling(progress, "trajectories") as tell:
            averages = records.simulate(at, bounces, _seed(seed), legwise, tell)
        records.keep_simulated(self.path, averages)
        return averages

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
            with self._file.snapshot() as moment:
                selections = [replace(chosen, a=at) for at in verifiable(moment)]
        drawn = _seed(seed)
        with telling(progress, "verify") as tell:
            return verified(self.path, selections, sample, restarts, drawn, births, rigorous, jobs, tell)

    # deleting

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


def _seed(seed: "int | np.random.Generator") -> int:
    if hasattr(seed, "integers"):
        return int(seed.integers(2**63))
    need_whole("seed", seed, 0)
    return int(seed)
