"""Find the missing and spurious levels of a list by comparing it with the staircase from the orbits.

Up to a small error, the staircase N_X(k) from the orbits (`orbitdb.quantum.levels_from_orbits`) is the true
staircase, smoothed with a Gaussian of width 1/X. The staircase of the list, smoothed in the same way, falls
behind it by one at each missing level. Every way of explaining the difference

    D(k) = N_X(k) - sum over j of Phi(X (k - k_j))

by missing and spurious levels has a probability: that of D, given the known errors of N_X
(`orbitdb.quantum.staircase_errors`), times that of the spacings, given the laws of random matrices
(`orbitdb.quantum.spacing_laws`). Sums over all likely ways (`orbitdb.quantum.level_paths`) judge each gap
(`orbitdb.quantum.judging`), and statements follow from them (`orbitdb.quantum.conclusions`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.arrays import Floats, Integers
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Drawn, data_frame
from orbitdb.quantum.comparison import CUTOFF, Comparison
from orbitdb.quantum.conclusions import Gap, conclude
from orbitdb.quantum.judging import FITS, judge
from orbitdb.quantum.level_paths import CROWDED
from orbitdb.quantum.levels_from_orbits import Staircase
from orbitdb.quantum.radius_fit import fit
from orbitdb.quantum.staircase_errors import ErrorOfOrbits
from orbitdb.quantum.weyl import Parity, weyl
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    import pandas

_LEAST_ERROR = 0.1
"""Least error that is stated for the number of missing levels, and the step to which it is rounded up."""
_MOST_PAIRED = 0.5
"""Largest share of the spurious levels that are taken to be in pairs."""
_SHOWN = 3
"""Maximum number of gaps to name in one line."""
_SURE = 0.9
"""Probability below which a first number is not certain."""
_TWINS, _FEW, _MANY, _MOST_OF = 0.02, 3, 5, 0.6
"""Distance of levels that may be one, in mean spacings; such pairs are merged if there are more than the
second number plus the third times the number expected by chance, but not more than this share of the list."""


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
        Most probable true number of each level, counted from 1; 0 for a spurious level.
    probability : ndarray, shape (N,)
        Probability of each number.
    excess : ndarray, shape (N,)
        Number of levels missing below each level according to the orbits, not rounded to an integer.
    gaps : list of Gap
        The places where levels are missing or spurious, in ascending order of k.
    places : ndarray, shape (M,)
        Most probable places of the missing levels, in 1/radius.
    missing, missing_error : float
        Expected number of levels that are missing below the last true level of the list, and its standard
        error. In a window, those below the first do not count.
    spurious_error : float
        Standard error of the number of spurious levels.
    net, net_error : float
        Expected number of missing levels less that of the spurious ones, and its standard error: what the
        orbits tell best.
    resolved : int
        Number of levels that a list must have here to be tested: those in 2/X, twice the resolution of the
        orbits.
    whole : float
        Probability that the list neither lacks a level nor has a spurious one.
    first : int
        True number with which the list begins; 1 unless it is a window.
    first_probability : float
        Probability of `first`.
    misfit : float
        By how much the agreement with the orbits is worse than expected; 1 is the limit for a list that fits.
    scale, scale_error : float
        Ratio of the fitted radius to the given radius, and its standard error; 1 and 0 without a fit.
    at_limit : bool
        Whether the fit of the radius ended at its limit, half a per cent, and has therefore failed.
    window : bool
        Whether the list was allowed to begin with any level.
    notes : tuple of str
        What else may explain a list that does not fit, or lacks its lowest levels.
    """

    a: float
    parity: Parity | None
    k: Floats
    number: Integers
    probability: Floats
    excess: Floats
    gaps: list[Gap]
    places: Floats
    missing: float
    missing_error: float
    spurious_error: float
    net: float
    net_error: float
    resolved: int
    whole: float
    first: int
    first_probability: float
    misfit: float
    scale: float = 1.0
    scale_error: float = 0.0
    at_limit: bool = False
    window: bool = False
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.k)

    def __repr__(self) -> str:
        return f"<{self.verdict()}>"

    @property
    def fits(self) -> bool:
        """Whether the misfit is small enough for levels of this stadium and parity."""
        return self.misfit <= FITS

    @property
    def short(self) -> bool:
        """Whether the list is too short to be tested."""
        return len(self.k) < self.resolved

    @property
    def crowded(self) -> bool:
        """Whether the orbits resolve only groups of levels, so that no single gap can be named."""
        return self.resolved >= 2 * CROWDED

    @property
    def total(self) -> int:
        """Number of levels from the first to the last true level of the list, with those that are missing."""
        return max(round(len(self.k) + self.net), 0)

    @property
    def spurious(self) -> int:
        """Most probable number of spurious or duplicate levels in the list."""
        return int((self.number == 0).sum())

    @property
    def sure_of_first(self) -> bool:
        """Whether the number of the first level has a probability of at least 0.9."""
        return not self.window or (self.fits and not self.short and self.first_probability >= _SURE)

    @property
    def missing_share(self) -> float | None:
        """Share of the levels that the list lacks, 0 if it lacks none; None if it is not known."""
        if not self.fits or self.short:
            return None
        lacks = any(gap.missing > 0 for gap in self.gaps)
        missing = self.net if self.crowded else self.missing
        return max(missing, 0.0) / self.total if lacks and self.total else 0.0

    def numbers(self) -> list[tuple[float, int, float, float]]:
        """Return k, the true number, 0 for a spurious level, its probability and the excess of each level."""
        columns = (self.k, self.number, self.probability, self.excess)
        return list(zip(*(column.tolist() for column in columns), strict=True))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the gaps as a data frame with their columns from ``after`` to ``probability``."""
        return data_frame([gap[:-1] for gap in self.gaps], Gap._fields[:-1])

    _FIGURES = ("assess",)

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        return (self,), self.verdict()

    def verdict(self) -> str:
        """Return a sentence that says whether the list fits, how many levels are missing or spurious."""
        of = f"a = {format_float(self.a)}, {'all parities' if self.parity is None else self.parity}"
        misfit = f"misfit {self.misfit:.2f}"
        if not self.fits:
            return f"the list does not fit {of}: {misfit}; lists that fit have less than {FITS:g}"
        if self.short:
            return f"too short to be tested: the orbits resolve {several(self.resolved, 'level')} here ({of})"
        said = f"{self._begins()}{self._lacks()}"
        if not self.sure_of_first:
            within = several(math.ceil(self.resolved / 2), "level")
            said += f"; the orbits tell their number to within about {within}"
        sure = "" if self.gaps else f"P {self.whole:.3g}; "
        return f"{said} ({sure}{of}; {misfit})"

    def lacking(self) -> list[str]:
        """Return a line on the levels that the list lacks, and the notes; [] if it lacks none."""
        if self.fits and not self.short and not self.gaps:
            return []
        if not self.fits or self.short:
            return [self.verdict(), *self.notes]
        places = ", ".join(gap.place() for gap in self.gaps[:_SHOWN])
        more = f" and {len(self.gaps) - _SHOWN} more" if len(self.gaps) > _SHOWN else ""
        return [f"{self.verdict()}: {places}{more}; `catalogue.assess(k)` lists them", *self.notes]

    def _begins(self) -> str:
        """Return with which level a window begins."""
        if not self.window:
            return ""
        begins = f"the list begins with level {self.first} (P {self.first_probability:.3g}"
        if self.sure_of_first:
            return f"{begins}); "
        return f"{begins}; its neighbours are possible): "

    def _lacks(self) -> str:
        """Return how many levels are missing and spurious."""
        low = f"{self.k[0]:.6g}" if self.window else "0"
        between = f"with k from {low} to {self.k[-1]:.{6 if self.window else 4}g}"
        if self.crowded:
            if not self.gaps:
                return f"none of {several(self.total, 'level')} {between} is missing"
            net = with_one_digit(abs(self.net), self.net_error)
            too = "missing" if self.net >= 0 else "too many"
            return f"{net} levels are {too} among these {len(self.k)} {between}"
        if any(gap.missing for gap in self.gaps):
            missing = with_one_digit(self.missing, self.missing_error)
            said = f"{missing} of {self.total} levels {between} are missing"
        else:
            said = f"none of {self.total} levels {between} is missing"
        if self.spurious:
            said += f"; {self.spurious} {'is' if self.spurious == 1 else 'are'} spurious or duplicate"
        return said


def with_one_digit(value: float, error: float) -> str:
    """Return an expected number with its standard error, rounded up to a tenth."""
    return f"{value:.1f} +- {max(math.ceil(error / _LEAST_ERROR) * _LEAST_ERROR, _LEAST_ERROR):.1f}"


def assess(
    k: Floats,
    orbits: Staircase,
    stadium: Stadium,
    parity: Parity | None = None,
    window: bool = False,
    fit_scale: bool = False,
    scale_error: float | None = None,
    noise: float = 0.0,
) -> Assessment:
    """Compare a list of levels with the staircase from the orbits.

    Parameters
    ----------
    k : ndarray, shape (N,)
        Levels in ascending order, in 1/radius.
    orbits : Staircase
        The staircase with the single cutoff `CUTOFF`, on a grid of k from 0, or from below the first level of
        a window, to above the last level; far enough for every scale of a fit.
    window : bool, optional
        Whether the list may begin with any level; otherwise it begins with the lowest.
    fit_scale : bool, optional
        Whether to fit the radius.
    scale_error : float, optional
        Relative standard error of the radius for the fit; by default it can change by up to half a per cent.
    noise : float, optional
        Scatter of the levels, in mean spacings.
    """
    compared = compare(k, orbits, stadium, parity, window, noise)
    crowded = float(compared.crowded[len(k) // 2])
    resolved = math.ceil(2 * crowded)
    if fit_scale and len(k) >= resolved:
        judged, scale, error, at_limit = fit(compared, scale_error)
    else:
        judged, scale, error, at_limit = judge(compared), 1.0, 0.0, False
    found = conclude(judged)
    levels, net = judged.compared.k, found.missing - found.spurious
    pairs = hidden_pairs(found.missing, found.spurious, len(k), crowded)
    return Assessment(
        a=stadium.a,
        parity=parity,
        k=levels,
        number=found.number,
        probability=found.probability,
        excess=judged.compared.excess(levels),
        gaps=found.gaps if len(k) >= resolved else [],
        places=found.places,
        missing=float(found.missing.mean()) + pairs,
        missing_error=math.hypot(float(found.missing.std()), math.sqrt(pairs)),
        spurious_error=math.hypot(float(found.spurious.std()), math.sqrt(pairs)),
        net=float(net.mean()),
        net_error=float(net.std()),
        resolved=resolved,
        whole=found.whole,
        first=found.first if window else 1,
        first_probability=found.first_probability,
        misfit=judged.misfit,
        scale=scale,
        scale_error=error,
        at_limit=at_limit,
        window=window,
    )


def hidden_pairs(missing: Integers, spurious: Integers, levels: int, crowded: float) -> float:
    """Return the expected number of pairs, one missing level and one spurious, that the orbits do not show.

    A spurious level is in such a pair if a level is missing among those within the resolution of the orbits,
    `crowded` of them; the numbers found on the paths are without pairs.
    """
    paired = min(float(missing.mean()) / levels * crowded, _MOST_PAIRED)
    return float(spurious.mean()) * paired / (1 - paired)


def compare(
    k: Floats, orbits: Staircase, stadium: Stadium, parity: Parity | None, window: bool, noise: float = 0.0
) -> Comparison:
    """Return a list of levels beside the staircase from the orbits, as for `assess`."""
    error = ErrorOfOrbits(CUTOFF, stadium.perimeter, orbits.sufficient, parity is None)
    return Comparison(k, lambda at: orbits.at(at)[0], weyl(stadium, parity), error, window, noise)


def without_twins(k: Floats, stadium: Stadium, parity: Parity | None) -> tuple[Floats, int]:
    """Return a list without the second of two equal levels, and the number of such pairs.

    Levels nearer than `_TWINS` mean spacings are taken for one if there are far more such pairs than chance
    would give: levels of one parity repel each other, those of different parities do not.
    """
    spacing = np.diff(k) * np.maximum(weyl(stadium, parity).deriv()(k[1:]), 0.1)
    near = spacing < _TWINS
    by_chance = len(k) * (0.75 * _TWINS if parity is None else math.pi / 4 * _TWINS**2)
    count = int(near.sum())
    if count <= _FEW + _MANY * by_chance or count > _MOST_OF * len(k):
        return k, 0
    group = np.cumsum(np.append(True, ~near)) - 1
    return np.bincount(group, k) / np.bincount(group), count
