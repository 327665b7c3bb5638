"""Find missing and spurious levels in a list by comparison with the staircase of the orbits.

The staircase N_X(k) of the orbits (`orbitdb.quantum.levels_from_orbits`) is the exact one, smoothed with a
Gaussian of width 1/X, up to a small error. The staircase of the list, smoothed in the same way, differs from
it by one after each missing level. With the excess

    D_i = N_X(k_i) - sum over j of Phi(X (k_i - k_j)),   Phi the normal distribution,

i + D_i is the number of the level k_i, and `orbitdb.quantum.missing_levels` rounds it to a true number. The
radius can be fitted too: the cheapest scale of k is taken.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import ndtr

from orbitdb.arrays import Floats, Integers
from orbitdb.equality import ByValue
from orbitdb.extras import Drawn, data_frame
from orbitdb.quantum.amplitudes import Parity
from orbitdb.quantum.lengths import BLOCK
from orbitdb.quantum.levels_from_orbits import Staircase
from orbitdb.quantum.missing_levels import numbered

if TYPE_CHECKING:
    import pandas


CUTOFF, CUTOFF_OF_ALL = 10.0, 13.0
"""Cutoff X of the staircase for lists of one parity and of all levels."""

_SIGMA = 0.2
"""Uncertainty of the excess in exact lists; it is rarely more for any a, k and parity."""

_FAR = 4.0
"""Distance in units of 1/X beyond which a level no longer changes the smoothed staircase."""

_WIDEST = 0.005
"""Largest relative correction of a fitted radius."""
_SCALES, _FINER, _REFINED = 401, 21, 4
"""Number of scales in the first grid, number in each finer one, and number of grids."""
WIDEST = 1 + 2 * _WIDEST
"""End of the staircase needed, in units of the last level."""

_CORRELATED = 2.0
"""Error of a fitted radius divided by that for independent deviations; those of neighbours are correlated."""

_ROUNDS = 3
"""Number of times the spread is estimated and the levels are numbered."""


class Gap(NamedTuple):
    """A place in a list where levels are missing or spurious.

    Attributes
    ----------
    after, before : float or None
        The levels on both sides, in 1/radius; None at the beginning or end of the list.
    missing : int
        Number of missing levels minus the number of spurious or double ones between them.
    """

    after: float | None
    before: float | None
    missing: int

    def place(self) -> str:
        """Say where it is."""
        if self.before is None:
            return f"after {self.after:.4g}"
        return f"below {self.before:.4g}" if self.after is None else f"{self.after:.4g} to {self.before:.4g}"


@dataclass(frozen=True, eq=False, repr=False)
class Assessment(ByValue, Drawn):
    """Comparison of a list of levels with the orbits; `plot` draws N_X(k_i) - i + 1/2 and its steps.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    parity : Parity or None
        None for all levels in one list.
    k : ndarray, shape (N,)
        The levels in rising order, in 1/radius, scaled by `scale`.
    number : ndarray of int, shape (N,)
        Their true numbers, counted from 1; 0 for spurious levels.
    excess : ndarray, shape (N,)
        Number of levels missing below each level, according to the orbits; not an integer.
    sigma : float
        Uncertainty of the excess.
    scale, scale_error : float
        The fitted radius divided by the given one, and its standard error; 1 and 0 if it was not fitted.
    cost : float
        Cost of the assignment; lower is better.
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
        """The places where levels are missing or spurious, in rising order."""
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
        """Number of levels missing below the last one."""
        return int(self.number.max(initial=0)) - int((self.number > 0).sum())

    @property
    def spurious(self) -> int:
        """Number of spurious or double levels in the list."""
        return int((self.number == 0).sum())

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the gaps as a data frame, with the columns after, before and missing."""
        return data_frame(self.gaps, Gap._fields)

    def _figure(self) -> tuple[str, Sequence[Any], str]:
        return "curves.draw_assessment", (self,), self.verdict()

    def verdict(self) -> str:
        """Say in one sentence which levels are missing or spurious."""
        of = f" of {int(self.number.max(initial=0))}, k from 0 to {self.k[-1]:.4g}"
        none = self.spurious
        extra = f"; {none} {'is' if none == 1 else 'are'} spurious or double" if none else ""
        if not self.missing:
            return f"no level is missing{of}{extra}"
        are = "level is" if self.missing == 1 else "levels are"
        return f"{self.missing} {are} missing{of}{extra}"


def assess(
    k: Floats, orbits: Staircase, a: float, parity: Parity | None = None, fit_scale: bool = False
) -> Assessment:
    """Compare a list of levels with the staircase of the orbits.

    Parameters
    ----------
    k : ndarray, shape (N,)
        Levels in rising order, in 1/radius.
    orbits : Staircase
        For one cutoff, up to `WIDEST` times the last level.
    a : float
        Half length of the stadium.
    parity : Parity, optional
        Parity of the levels; None if the list has all levels.
    fit_scale : bool, optional
        Whether to fit the radius, within half a per cent.
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
    """Return the least cost of numbering levels, with the uncertainty of exact lists."""
    return float(_costs(k, orbits, _smoothed(k, orbits), _SIGMA, np.ones(1))[0])


def _costs(k: Floats, orbits: Staircase, own: Floats, sigma: float, scales: Floats) -> Floats:
    """Return the least costs of numbering levels, shape (N,), for several scales of k."""
    place = np.arange(1, len(k) + 1)
    excess = orbits.at((k * scales[:, None]).ravel())[0].reshape(len(scales), -1) - own
    return numbered(excess + place, sigma)[1]


def _smoothed(k: Floats, orbits: Staircase) -> Floats:
    """Return the smoothed staircase of a list at its own levels; levels beyond its end are evenly spaced."""
    (cutoff,) = orbits.cutoffs
    spacing = 1 / float(np.interp(k[-1], orbits.k, orbits.density))
    every = np.append(k, np.arange(k[-1] + spacing, k[-1] + _FAR / cutoff, spacing))
    parts = np.array_split(k, len(k) * len(every) // BLOCK + 1)
    return np.concatenate([ndtr(cutoff * (part[:, None] - every)).sum(axis=1) for part in parts])


def _fitted(k: Floats, orbits: Staircase, own: Floats, sigma: float, scale: float, wide: float) -> float:
    """Return the scale of k with the least cost, near a first guess, searched on finer and finer grids."""
    count = _SCALES if wide == _WIDEST else _FINER
    for _ in range(_REFINED):
        scales = scale + wide * np.linspace(-1, 1, count)
        scale = float(scales[_costs(k, orbits, own, sigma, scales).argmin()])
        wide, count = 2 * wide / (count - 1), _FINER
    return scale
