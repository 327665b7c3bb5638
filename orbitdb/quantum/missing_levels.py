"""Find the missing and spurious levels of a list by comparing it with the staircase from the orbits.

Up to a small error, the staircase N_X(k) from the orbits (`orbitdb.quantum.levels_from_orbits`) is the true
staircase, smoothed with a Gaussian of width 1/X. The staircase of the list, smoothed in the same way, falls
behind it by one at each missing level. Define the excess

    D_i = N_X(k_i) - sum over j of Phi(X (k_i - k_j)),

where Phi is the normal distribution function. Then i + D_i is approximately the true number of the level k_i,
and `orbitdb.quantum.level_numbers` assigns an integer to it. For a window, a list that begins anywhere, the
first of these integers is free: the orbits number a list whose beginning is unknown.

The error of N_X is largest where the trace formula fails, at the length of the perimeter, or half of it for
one parity, because orbits that creep along a semicircle accumulate there. This part oscillates slowly, so it
is fitted together with the places of the missing levels (`Filling`). The radius can also be fitted: the fit
picks the scale of k for which the numbers i + D_i are nearest to integers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Integers
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.extras import Drawn, data_frame
from orbitdb.quantum.level_numbers import Filling, filled_sigma, numbered, smoothed
from orbitdb.quantum.levels_from_orbits import Staircase
from orbitdb.quantum.weyl import Parity, weyl
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    import pandas


CUTOFF = 10.0
"""Cutoff X of the staircase, in units of the radius."""

_SIGMA, _END = 0.2, 4.0
"""Uncertainty of the excess of an exact list, and the factor on it at an end of the list."""
_AT_END = 0.05
_FAR = 4.0
"""Distance beyond the ends of the list, in units of 1/X, over which levels are assumed to go on evenly."""

_CREEPING, _CREEPING_OF_ALL = (-0.3, 1.3), (-1.4, 3.0)
"""Lengths between which N_X is wrong, relative to the perimeter and in units of the radius, for one parity
(where they are halved) and for a list of all levels."""
_WIDEST = 0.005
"""Maximum relative change of the radius in a fit."""
_SCALES, _FINER, _REFINED = 401, 21, 4
"""Number of scales on the first grid, number of scales on each finer grid, and number of grids in all."""
_FIRST, _LONGER = 1000, 8
"""Number of levels to which the first grids are fitted, and the factor by which it then grows."""
WIDEST = 1 + 2 * _WIDEST
"""How far the staircase has to extend, in units of the last level."""

_CORRELATED = 2.0
"""Factor on the error of a fitted radius, because the deviations of neighbouring levels are correlated."""

FITS = 0.27
"""Largest scatter of a list that fits the stadium, in mean spacings. In tests, lists that fit had at most
0.22, even with noise and missing levels, and others 0.29 or more."""
_CERTAIN = 8.0
"""The first number of a window is certain if the second best costs at least this much more."""
_CROWDED = 25.0
"""Largest number of levels within the resolution 1/X of the orbits."""


class Gap(NamedTuple):
    """A place in a list where levels are missing or spurious.

    Attributes
    ----------
    after, before : float or None
        The levels of the list on either side, in 1/radius; None at the beginning or end of the list.
    missing : int
        Number of missing levels between these two, minus the number of spurious or duplicate levels.
    """

    after: float | None
    before: float | None
    missing: int

    def place(self) -> str:
        """Describe where the gap is, for example ``12.65 to 12.99``."""
        if self.before is None:
            return f"after {self.after:.4g}"
        return f"below {self.before:.4g}" if self.after is None else f"{self.after:.4g} to {self.before:.4g}"


@dataclass(frozen=True, eq=False, repr=False)
class Assessment(Drawn):
    """Comparison of a list of levels with the orbits; `plot` draws how many levels are missing below each k.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    parity : Parity or None
        Parity of the levels; None if the list contains levels of all parities.
    k : ndarray, shape (N,)
        The levels in ascending order, in 1/radius, multiplied by `scale`.
    number : ndarray of int, shape (N,)
        True number of each level, counted from 1; 0 for a spurious level.
    excess : ndarray, shape (N,)
        Number of levels missing below each level according to the orbits, not rounded to an integer.
    scatter : float
        rms deviation of the staircase of the list from that of the orbits, once the missing levels are filled
        in; a spurious level counts as a deviation of 1.
    scale, scale_error : float
        Ratio of the fitted radius to the given radius, and its standard error; 1 and 0 without a fit.
    window : bool
        Whether the list was allowed to begin with any level.
    notes : tuple of str
        What else may explain a list that does not fit, or lacks its lowest levels.
    """

    a: float
    parity: Parity | None
    k: Floats
    number: Integers
    excess: Floats
    scatter: float
    scale: float = 1.0
    scale_error: float = 0.0
    window: bool = False
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.k)

    def __repr__(self) -> str:
        return f"<{self.verdict()}>"

    @property
    def gaps(self) -> list[Gap]:
        """The places where levels are missing or spurious, in ascending order of k."""
        gaps: list[Gap] = []
        after, last, spurious = None, self.first - 1, 0
        for k, number in zip([*self.k.tolist(), None], [*self.number.tolist(), None], strict=True):
            if number == 0:
                spurious += 1
                continue
            missing = 0 if number is None else number - last - 1
            if missing - spurious or (missing and spurious):
                gaps.append(Gap(after, k, missing - spurious))
            after, last, spurious = k, number or 0, 0
        return gaps

    @property
    def first(self) -> int:
        """True number with which the list begins; 1 unless it is a window."""
        true = self.number[self.number > 0]
        return int(true[0]) if self.window and len(true) else 1

    @property
    def fits(self) -> bool:
        """Whether the scatter is small enough for levels of this stadium and parity."""
        return self.scatter <= FITS

    @property
    def at_limit(self) -> bool:
        """Whether the fit of the radius ended at its limit, half a per cent, and has therefore failed."""
        return abs(self.scale - 1) > 0.99 * _WIDEST

    @property
    def total(self) -> int:
        """Number of levels from the first to the last true level of the list, with those that are missing."""
        return max(int(self.number.max(initial=0)) - self.first + 1, 0)

    @property
    def missing(self) -> int:
        """Number of levels that are missing below the last true level of the list."""
        return self.total - int((self.number > 0).sum())

    @property
    def spurious(self) -> int:
        """Number of spurious or duplicate levels in the list."""
        return int((self.number == 0).sum())

    def numbers(self) -> list[tuple[float, int, float]]:
        """Return k, the true number (0 for a spurious level) and the excess of each level of the list."""
        return list(zip(self.k.tolist(), self.number.tolist(), self.excess.tolist(), strict=True))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the gaps as a data frame with the columns ``after``, ``before`` and ``missing``."""
        return data_frame(self.gaps, Gap._fields)

    _FIGURES = ("assess",)

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        return (self,), self.verdict()

    def verdict(self) -> str:
        """Return a sentence that says whether the list fits, how many levels are missing or spurious."""
        of = f"a = {format_float(self.a)}, {'all parities' if self.parity is None else self.parity}"
        scatter = f"scatter {self.scatter:.2f}"
        if not self.fits:
            return f"the list does not fit {of}: {scatter} mean spacings; lists that fit have less than 0.2"
        low = f"{self.k[0]:.6g}" if self.window else "0"
        levels = f" of {self.total} levels with k from {low} to {self.k[-1]:.{6 if self.window else 4}g}"
        count = self.missing
        said = f"{count or 'none'}{levels} {'is' if count < 2 else 'are'} missing"
        if self.spurious:
            said += f"; {self.spurious} {'is' if self.spurious == 1 else 'are'} spurious or duplicate"
        begins = f"the list begins with level {self.first}; " if self.window else ""
        return f"{begins}{said} ({of}; {scatter})"


def assess(
    k: Floats,
    orbits: Staircase,
    stadium: Stadium,
    parity: Parity | None = None,
    window: bool = False,
    fit_scale: bool = False,
) -> Assessment:
    """Compare a list of levels with the staircase from the orbits.

    Parameters
    ----------
    k : ndarray, shape (N,)
        Levels in ascending order, in 1/radius.
    orbits : Staircase
        The staircase with a single cutoff, on a grid of k from 0, or from the first level of a window, up to
        `WIDEST` times the last level.
    window : bool, optional
        Whether the list may begin with any level; otherwise it begins with the lowest.
    fit_scale : bool, optional
        Whether to fit the radius, which can then change by up to half a per cent.

    Raises
    ------
    InputError
        If the orbits cannot tell with which level a window begins.
    """
    compared = _Compared(k, orbits, stadium, parity, window)
    scale = compared.fitted() if fit_scale else 1.0
    if window and compared.crowded > _CROWDED:
        raise InputError(
            f"the orbits cannot tell which levels are missing near k = {k[-1]:.4g}: "
            f"{compared.crowded:.0f} levels lie within their resolution, 1/{compared.cutoff:g}"
        )
    excess = orbits.at(k * scale)[0] - compared.own
    number, residual, scatter = compared.numbered(excess)
    assessment = Assessment(stadium.a, parity, k * scale, number, excess, scatter, scale, window=window)
    if window:
        compared.check_first(number, residual, scatter)
    if fit_scale:
        slope = k * scale * np.interp(k * scale, orbits.k, orbits.density)
        assessment = replace(assessment, scale_error=_CORRELATED * scatter / float(np.linalg.norm(slope)))
    return assessment


class _Compared:
    """A list of levels beside the staircase from the orbits; the arguments are those of `assess`."""

    def __init__(
        self, k: Floats, orbits: Staircase, stadium: Stadium, parity: Parity | None, window: bool
    ) -> None:
        smooth = weyl(stadium, parity)
        density = smooth.deriv()(k)
        self.k, self.orbits, (self.cutoff,) = k, orbits, orbits.cutoffs
        self.crowded = float(density[-1]) / self.cutoff
        spacing, far = 1 / np.maximum(density[[0, -1]], 0.1), _FAR / self.cutoff
        above = np.arange(k[-1] + spacing[1], k[-1] + far, spacing[1])
        below = np.arange(k[0] - spacing[0], max(k[0] - far, 0.0), -spacing[0])[::-1] if window else k[:0]
        self.own = smoothed(k, np.concatenate([below, k, above]), self.cutoff) - len(below)
        near_end = k[-1] - k
        if window:
            near_end = np.minimum(near_end, k - k[0])
        self.end = np.exp(-((self.cutoff * near_end) ** 2) / 2)
        lengths = stadium.perimeter + np.array(_CREEPING_OF_ALL if parity is None else _CREEPING)
        lengths, independent = (lengths, 4) if parity is None else (lengths / 2, 1)
        self.filling = Filling(k, smooth, self.end, self.cutoff, lengths, independent, window)

    def numbered(self, excess: Floats) -> tuple[Integers, Floats, float]:
        """Return the true numbers, the residual of the filled list and its scatter."""
        expected, sigma = excess + np.arange(1, len(self.k) + 1), _SIGMA * (1 + (_END - 1) * self.end)
        number, _ = numbered(expected, sigma, self.filling.first_free)
        number, residual = self.filling.filled(number, excess)
        inner = self.end < _AT_END if (self.end < _AT_END).any() else self.end >= 0
        off = np.where(number > 0, np.minimum(np.abs(residual), 1.0), 1.0)[inner]
        return number, residual, float(np.sqrt((off**2).mean()))

    def check_first(self, number: Integers, residual: Floats, scatter: float) -> None:
        """Raise if the next best first number of a window is nearly as good; any list may be too short."""
        spread = filled_sigma(min(scatter, FITS), self.end)
        off = np.abs(residual[number > 0].mean()) if scatter <= FITS else 0.0
        weight = (1 / spread**2).sum() / max(1.0, 2.5 * self.crowded)
        if weight * (0.5 - off) < _CERTAIN:
            raise InputError(
                f"the orbits cannot tell with which level a list of {several(len(self.k), 'level')} from k = "
                f"{self.k[0]:.6g} to {self.k[-1]:.6g} begins: give a longer window, or fill further periods"
            )

    def fitted(self) -> float:
        """Return the scale of k at which the numbers of the levels are nearest to integers.

        That is where the sum of cos(2 pi x_i) is largest, searched on finer grids and with more levels.
        """
        scale, wide, steps, count = 1.0, _WIDEST, _SCALES, _FIRST
        while True:
            part = slice(0, count)
            for _ in range(_REFINED):
                scales = scale + wide * np.linspace(-1, 1, steps)
                near = [self.orbits.at(self.k[part] * s)[0] - self.own[part] for s in scales]
                scale = float(scales[np.cos(2 * np.pi * np.array(near)).sum(axis=1).argmax()])
                wide, steps = 2 * wide / (steps - 1), _FINER
            if count >= len(self.k):
                return scale
            wide, count = _WIDEST / _FINER / 5 * (_FIRST / count), count * _LONGER
