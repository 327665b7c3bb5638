"""Find the missing and spurious levels of a list by comparing it with the staircase from the orbits.

Up to a small error, the staircase N_X(k) from the orbits (`orbitdb.quantum.levels_from_orbits`) is the true
staircase, smoothed with a Gaussian of width 1/X. The staircase of the list, smoothed in the same way, falls
behind it by one at each missing level. Define the excess

    D_i = N_X(k_i) - sum over j of Phi(X (k_i - k_j)),

where Phi is the normal distribution function. Then i + D_i is approximately the true number of the level k_i,
and `orbitdb.quantum.missing_levels` assigns an integer to it. The radius can also be fitted: the fit picks
the scale of k for which the assignment has the lowest cost.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.errors import InputError
from orbitdb.extras import Drawn, data_frame
from orbitdb.numerals import exact
from orbitdb.plaintext import several
from orbitdb.quantum.length_spectrum import BLOCK
from orbitdb.quantum.level_numbers import numbered
from orbitdb.quantum.levels_from_orbits import Staircase
from orbitdb.quantum.weyl import Parity, weyl

if TYPE_CHECKING:
    import pandas
    from numpy.typing import ArrayLike


CUTOFF, CUTOFF_OF_ALL = 10.0, 13.0
"""Cutoff X of the staircase for a list of one parity, and for a list of all levels."""

_SIGMA = 0.2
"""Uncertainty of the excess for an exact list; it is rarely larger, whatever the stadium, k and parity."""

_FAR = 4.0
"""Distance, in units of 1/X, beyond which a level has no effect on the smoothed staircase."""

_WIDEST = 0.005
"""Maximum relative change of the radius in a fit."""
_SCALES, _FINER, _REFINED = 401, 21, 4
"""Number of scales on the first grid, number of scales on each finer grid, and number of grids in all."""
WIDEST = 1 + 2 * _WIDEST
"""How far the staircase has to extend, in units of the last level."""

_CORRELATED = 2.0
"""Factor on the error of a fitted radius, because the deviations of neighbouring levels are correlated."""

_LEAST_LEVELS = 10
_OFF, _FEW = 0.2, 4
"""Allowed difference from Weyl's law: a fraction of the number that it predicts, plus a few levels."""

_ROUNDS = 3
"""Maximum number of times the levels are numbered and the spread of their deviations is estimated."""


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
class Assessment(ByValue, Drawn):
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
    sigma : float
        Uncertainty of the excess.
    scale, scale_error : float
        Ratio of the fitted radius to the given radius, and its standard error; 1 and 0 without a fit.
    cost : float
        Cost of the assignment of true numbers; lower is better.
    """

    a: float
    parity: Parity | None
    k: Floats
    number: Integers
    excess: Floats
    sigma: float
    scale: float
    scale_error: float
    cost: float

    def __len__(self) -> int:
        return len(self.k)

    def __repr__(self) -> str:
        return f"<{self.verdict()}>"

    @property
    def gaps(self) -> list[Gap]:
        """The places where levels are missing or spurious, in ascending order of k."""
        found: list[Gap] = []
        after, last, spurious = None, 0, 0
        for k, number in zip([*self.k.tolist(), None], [*self.number.tolist(), None], strict=True):
            if number == 0:
                spurious += 1
                continue
            missing = 0 if number is None else number - last - 1
            if missing - spurious or (missing and spurious):
                found.append(Gap(after, k, missing - spurious))
            after, last, spurious = k, number or 0, 0
        return found

    @property
    def missing(self) -> int:
        """Number of levels that are missing below the last true level of the list."""
        return int(self.number.max(initial=0)) - int((self.number > 0).sum())

    @property
    def spurious(self) -> int:
        """Number of spurious or duplicate levels in the list."""
        return int((self.number == 0).sum())

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the gaps as a data frame with the columns ``after``, ``before`` and ``missing``."""
        return data_frame(self.gaps, Gap._fields)

    def _figure(self) -> tuple[str, Sequence[Any], str]:
        return "curves.draw_assessment", (self,), self.verdict()

    def verdict(self) -> str:
        """Return a sentence that says how many levels are missing and how many are spurious."""
        of = f" of {int(self.number.max(initial=0))} levels with k from 0 to {self.k[-1]:.4g}"
        none = self.spurious
        extra = f"; {none} {'is' if none == 1 else 'are'} spurious or duplicate" if none else ""
        if not self.missing:
            return f"none{of} is missing{extra}"
        are = "is missing" if self.missing == 1 else "are missing"
        return f"{self.missing}{of} {are}{extra}"


def assess(
    k: Floats, orbits: Staircase, a: float, parity: Parity | None = None, fit_scale: bool = False
) -> Assessment:
    """Compare a list of levels with the staircase from the orbits.

    Parameters
    ----------
    k : ndarray, shape (N,)
        Levels in ascending order, in 1/radius.
    orbits : Staircase
        The staircase with a single cutoff, on a grid of k up to `WIDEST` times the last level.
    a : float
        Half length of the stadium.
    parity : Parity, optional
        Parity of the levels; None if the list contains levels of all parities.
    fit_scale : bool, optional
        Whether to fit the radius, which can then change by up to half a per cent.
    """
    own, sigma = _smoothed(k, orbits), _SIGMA
    place = np.arange(1, len(k) + 1)
    scale, wide = 1.0, _WIDEST
    for _ in range(_ROUNDS):
        if fit_scale:
            scale, wide = _fitted(k, orbits, own, sigma, scale, wide), _WIDEST / _FINER
        excess = orbits.at(k * scale)[0] - own
        numbers, cost = numbered((excess + place)[None], sigma)
        number = numbers[0]
        off = (excess + place - number)[number > 0]
        spread = float(1.4826 * np.median(np.abs(off))) if len(off) else sigma
        if spread <= sigma * 1.05:
            break
        sigma = spread
    slope = k * scale * np.interp(k * scale, orbits.k, orbits.density)
    scale_error = _CORRELATED * spread / float(np.linalg.norm(slope)) if fit_scale else 0.0
    return Assessment(a, parity, k * scale, number, excess, sigma, scale, scale_error, float(cost[0]))


def misfit(k: Floats, orbits: Staircase) -> float:
    """Return the lowest cost of numbering the levels, assuming the uncertainty of an exact list."""
    return float(_costs(k, orbits, _smoothed(k, orbits), _SIGMA, np.ones(1))[0])


def _costs(k: Floats, orbits: Staircase, own: Floats, sigma: float, scales: Floats) -> Floats:
    """Return the lowest cost of numbering the levels for each of several scales of k."""
    place = np.arange(1, len(k) + 1)
    excess = orbits.at((k * scales[:, None]).ravel())[0].reshape(len(scales), -1) - own
    return numbered(excess + place, sigma)[1]


def _smoothed(k: Floats, orbits: Staircase) -> Floats:
    """Return the smoothed staircase of a list at each of its levels.

    Evenly spaced levels are added beyond the end of the list, so that the staircase does not level off there.
    """
    (cutoff,) = orbits.cutoffs
    spacing = 1 / float(np.interp(k[-1], orbits.k, orbits.density))
    every = np.append(k, np.arange(k[-1] + spacing, k[-1] + _FAR / cutoff, spacing))
    parts = np.array_split(k, len(k) * len(every) // BLOCK + 1)
    return np.concatenate([ndtr(cutoff * (part[:, None] - every)).sum(axis=1) for part in parts])


def _fitted(k: Floats, orbits: Staircase, own: Floats, sigma: float, scale: float, wide: float) -> float:
    """Return the scale of k with the lowest cost near a first guess, searching on finer and finer grids."""
    count = _SCALES if wide == _WIDEST else _FINER
    for _ in range(_REFINED):
        scales = scale + wide * np.linspace(-1, 1, count)
        scale = float(scales[_costs(k, orbits, own, sigma, scales).argmin()])
        wide, count = 2 * wide / (count - 1), _FINER
    return scale


def check_levels(levels: "ArrayLike", stadium: Stadium, parity: Parity | None) -> Floats:
    """Return levels in ascending order; refuse a list that cannot be all levels of a stadium of radius 1.

    Raises
    ------
    InputError
        If there are too few levels, one is not positive and finite, or their number is far from Weyl's law.
    """
    k = np.sort(np.asarray(levels, np.float64), axis=-1)
    if k.ndim != 1:
        raise InputError(f"the levels have shape {k.shape}: give one row of numbers")
    if len(k) < _LEAST_LEVELS:
        raise InputError(f"the list has only {several(len(k), 'level')}: give {_LEAST_LEVELS} or more")
    if (wrong := k[~((k > 0) & (k < np.inf))]).size:
        raise InputError(f"{wrong[0]:g} is not a level: give finite k above 0, in 1/radius")
    if not _plausible(len(k), k[-1], stadium, parity):
        of = " of all parities" if parity is None else f" of parity {parity}"
        expected = max(0.0, float(weyl(stadium, parity)(k[-1])))
        raise InputError(
            f"{len(k)} levels up to k = {k[-1]:g}, but Weyl's law expects {expected:.0f}{of} at a = "
            f"{exact(stadium.a)}: {_remedy(len(k), k[-1], stadium, parity)}"
        )
    return k


def _plausible(count: int, end: float, stadium: Stadium, parity: Parity | None) -> bool:
    expected = float(weyl(stadium, parity)(end))
    return abs(count - expected) <= _OFF * expected + _FEW


def _remedy(count: int, end: float, stadium: Stadium, parity: Parity | None) -> str:
    """Return a message that says what may be wrong with a list that has too many or too few levels."""
    if _plausible(count, math.sqrt(end), stadium, parity):
        return "they look like energies: give --energies"
    if _plausible(count, end**2, stadium, parity):
        return "they look like wavenumbers: leave out --energies"
    if parity is not None and _plausible(count, end, stadium, None):
        return "they look like the levels of all parities: leave out --parity"
    if parity is None and any(_plausible(count, end, stadium, each) for each in Parity):
        return "they look like the levels of one parity: name it with --parity"
    return "check --parity, --a and the unit: k is in 1/radius, frequencies need --frequency and --radius"
