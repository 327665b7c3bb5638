"""`QuantumCatalogue`, the part of `Catalogue` about quantum levels: finds, stores and compares them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.filled_catalogue import FilledCatalogue
from orbitdb.errors import InputError, checked_methods
from orbitdb.extras import Rows
from orbitdb.progress import Tell, telling
from orbitdb.store.lookup import find_or_solve
from orbitdb.symbols.words import parse_primitive

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from orbitdb.answers.scars import Scar
    from orbitdb.quantum.length_spectrum import Spectrum
    from orbitdb.quantum.levels import Levels
    from orbitdb.quantum.missing_levels import Assessment
    from orbitdb.quantum.weyl import Parity


@checked_methods
class QuantumCatalogue(FilledCatalogue):
    """A catalogue that finds and stores quantum levels, and compares them with its orbits."""

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
        jobs : optional
            As for `fill`.
        """
        from orbitdb.filling import records
        from orbitdb.quantum.levels import Levels
        from orbitdb.quantum.weyl import parities_of

        at, (low, high) = Stadium(self._at(a)), (0.0, low) if high is None else (low, high)
        with telling(progress, "levels") as tell:
            windows = records.find_levels(self.path, at, low, high, parities_of(parities), jobs, tell)
        return Levels.joined(at.a, low, high, windows)

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

        `Spectrum.terms` and `Spectrum.term_rows` are the terms of the trace formula.

        Parameters
        ----------
        lengths : (float, float), optional
            Range of lengths, in units of the radius.
        points : int, optional
            Number of lengths in the range.
        k_max : float, optional
            End of the window in k, in 1/radius; by default where the levels end, or 30 without levels.
        levels : array-like, shape (N,), optional
            All levels k, beginning with the lowest; by default the stored ones.
        parity : str, optional
            ``ee``, ``eo``, ``oe`` or ``oo``; by default the levels of all parities together.
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
        radius_error: float | None = None,
        noise: float = 0.0,
        a: float | None = None,
    ) -> "Assessment":
        """Use the stored orbits to find where levels are missing from a list, and where some are spurious.

        Every statement of the result has a probability.

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
        radius_error : float, optional
            Relative standard error of the radius, if it is fitted.
        noise : float, optional
            Scatter of the levels, in mean spacings.
        """
        from orbitdb.answers.levels import assess_levels

        with self._file.moment() as moment:
            return assess_levels(moment, self._at(a), k, parity, fit_radius, window, radius_error, noise)[0]

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
        order : str, optional
            Order of the scars of a word: ``above`` or ``strength`` (the largest first), or ``k``.
        parities, progress : optional
            As for `fill_levels`.
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
