"""Compute levels from the stored orbits, and find the levels that a list lacks."""

from typing import TYPE_CHECKING

from orbitdb.answers.levels import classes_for_levels, levels_from_zero
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.quantum.levels_from_orbits import Staircase, staircase
from orbitdb.quantum.missing_levels import (
    CUTOFF,
    CUTOFF_OF_ALL,
    WIDEST,
    Assessment,
    assess,
    check_levels,
    misfit,
)
from orbitdb.quantum.trace_formula import Classes
from orbitdb.quantum.weyl import Parity
from orbitdb.store.reading.moment import Moment

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


_SHOWN = 3
"""Maximum number of gaps with missing levels to name in one line."""

_CLEARLY = 6.0
"""Another parity is suggested if its misfit is smaller by this much, the cost of one missing level."""


def assess_levels(
    moment: Moment,
    a: float,
    k: "ArrayLike | None" = None,
    parity: Parity | str | None = None,
    fit_radius: bool = False,
) -> tuple[Assessment, list[str]]:
    """Compare a list of levels with the stored orbits; return the assessment and notes.

    Raises
    ------
    InputError
        If the numbers cannot be levels of the stadium, or too few orbits are stored.
    """
    stadium = Stadium(a)
    of = None if parity is None else Parity(parity)
    given = levels_from_zero(moment, stadium.a, of).k if k is None else check_levels(k, stadium, of)
    notes = []
    classes, _ = classes_for_levels(moment, stadium.a)
    found = assess(given, orbits_for(stadium, classes, of, float(given[-1])), stadium.a, of, fit_radius)
    if of is not None and found.gaps:
        last = float(found.k[-1])
        costs = {each: misfit(found.k, orbits_for(stadium, classes, each, last)) for each in Parity}
        best = min(costs, key=lambda each: costs[each])
        if costs[best] < costs[of] - _CLEARLY:
            notes.append(f"the parity {best} fits these levels better than {of}")
    return found, notes


def told_missing(moment: Moment, a: float, k: Floats, parity: Parity | None) -> list[str]:
    """Return a line on the levels that a list lacks, and notes; [] if it lacks none or orbits cannot tell."""
    try:
        found, notes = assess_levels(moment, a, k, parity)
    except InputError:
        return []
    if not found.gaps:
        return []
    places = ", ".join(gap.place() for gap in found.gaps[:_SHOWN])
    more = f" and {len(found.gaps) - _SHOWN} more" if len(found.gaps) > _SHOWN else ""
    return [f"{found.verdict()}: {places}{more}; 'orbitdb assess FILE' lists them", *notes]


def orbits_for(stadium: Stadium, classes: Classes, parity: Parity | None, last: float) -> Staircase:
    """Return the staircase for judging levels up to k = `last`."""
    cutoff = CUTOFF_OF_ALL if parity is None else CUTOFF
    return staircase(stadium, classes, last * WIDEST + 0.1, parity, (cutoff,))
