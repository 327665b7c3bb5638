"""Compute levels from the stored orbits, and find the levels that a list lacks."""

from typing import TYPE_CHECKING

from orbitdb.answers.levels import classes_for_levels, levels_from_zero
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.quantum.levels_from_orbits import Staircase, staircase
from orbitdb.quantum.missing_levels import CUTOFF, CUTOFF_OF_ALL, FITS, WIDEST, Assessment, assess
from orbitdb.quantum.weyl import Parity, check_levels, one_parity
from orbitdb.store.connection import driver
from orbitdb.store.file import Moment
from orbitdb.store.lookup import WITH_ORBITS, a_values

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


_SHOWN = 3
"""Maximum number of gaps with missing levels to name in one line."""

_LOWEST = 3
"""If this many of the lowest levels are missing, the list may be a window."""
_CLEARLY = 0.7
"""Hints are given if their scatter is below the largest that fits by this factor."""


def assess_levels(
    moment: Moment,
    a: float,
    k: "ArrayLike | None" = None,
    parity: Parity | str | None = None,
    fit_radius: bool = False,
    window: bool = False,
) -> tuple[Assessment, list[str]]:
    """Compare a list of levels with the stored orbits; return the assessment and notes.

    Raises
    ------
    InputError
        If the numbers cannot be levels of the stadium, if too few orbits are stored, or if the orbits cannot
        tell with which level a window begins.
    """
    stadium = Stadium(a)
    of = one_parity(parity)
    if window and (fit_radius or k is None):
        raise InputError(
            "a window is a list that may begin with any level: give its levels, with the radius known"
        )
    if k is None:
        k = levels_from_zero(moment, stadium.a, of).k
    levels = check_levels(k, stadium, of, window)
    classes, _ = classes_for_levels(moment, stadium.a)
    orbits = orbits_for(stadium, classes, of, levels, window)
    found = assess(levels, orbits, stadium, of, window, fit_radius)
    if not found.fits or found.at_limit:
        return found, _hints(moment, found, classes, levels)
    lowest = 0 if window else int(found.number[found.number > 0][0]) - 1
    if lowest < _LOWEST:
        return found, []
    return found, [f"the {lowest} lowest levels are missing: a list that begins higher up is a window"]


def _hints(moment: Moment, found: Assessment, classes: OrbitClasses, k: Floats) -> list[str]:
    """Return hints for a list that does not fit: a radius, a parity or a stored a with which it fits."""
    stadium, of, window = Stadium(found.a), found.parity, found.window

    def better(stadium: Stadium, classes: OrbitClasses, parity: Parity | None, fit: bool = False) -> bool:
        try:
            check_levels(k, stadium, parity, window)
            orbits = orbits_for(stadium, classes, parity, k, window)
            other = assess(k, orbits, stadium, parity, window, fit)
        except InputError:
            return False
        return other.scatter < _CLEARLY * FITS and not other.at_limit

    hints = []
    if found.at_limit:
        hints.append("the fit of the radius failed: the radius is off by more than half a per cent")
    elif not window and found.scale == 1 and better(stadium, classes, of, True):
        hints.append("they fit with another radius: fit the radius")
    hints += [
        f"they fit the parity {other}"
        for other in (Parity if of is not None else ())
        if other != of and better(stadium, classes, other)
    ]
    for a in a_values(driver(moment.connection), WITH_ORBITS):
        if a != stadium.a and len(hints) < _SHOWN:
            try:
                there, _ = classes_for_levels(moment, a)
            except InputError:
                continue
            if better(Stadium(a), there, of):
                hints.append(f"they fit a = {exact(a)}")
    return hints


def told_missing(moment: Moment, a: float, k: Floats, parity: Parity | None) -> list[str]:
    """Return a line on the levels that a list lacks, and notes; [] if it lacks none or orbits cannot tell."""
    try:
        found, notes = assess_levels(moment, a, k, parity)
    except InputError:
        return []
    if found.fits and not found.gaps:
        return []
    if not found.fits:
        return [found.verdict(), *notes]
    places = ", ".join(gap.place() for gap in found.gaps[:_SHOWN])
    more = f" and {len(found.gaps) - _SHOWN} more" if len(found.gaps) > _SHOWN else ""
    return [f"{found.verdict()}: {places}{more}; 'orbitdb assess FILE' lists them", *notes]


def orbits_for(
    stadium: Stadium, classes: OrbitClasses, parity: Parity | None, k: Floats, window: bool = False
) -> Staircase:
    """Return the staircase for comparison with the levels k; for a window, on its range only."""
    cutoff = CUTOFF_OF_ALL if parity is None else CUTOFF
    if window:
        return staircase(stadium, classes, float(k[-1]) + 0.1, parity, (cutoff,), max(float(k[0]) - 0.1, 0.0))
    return staircase(stadium, classes, float(k[-1]) * WIDEST + 0.1, parity, (cutoff,))
