"""Compute levels from the stored orbits, and find the levels that a list lacks."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from orbitdb.answers.spectrum import levels_from_zero, read_classes, stored_levels
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.plaintext import several
from orbitdb.quantum.amplitudes import Classes, Parity
from orbitdb.quantum.assessment import CUTOFF, CUTOFF_OF_ALL, WIDEST, Assessment, assess, misfit
from orbitdb.quantum.levels import LARGEST_A, LEAST_A, Levels, LevelWindow
from orbitdb.quantum.levels_from_orbits import CUTOFFS, Staircase, levels_of, reliable_end, staircase
from orbitdb.quantum.spectrum import check_levels
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


_LEAST, _ENOUGH = 8, 12
"""Levels need all orbits up to the first of these periods, and improve up to the second."""

_SHOWN = 3
"""Maximum number of gaps with missing levels to name in one line."""

_MOST_K = 300.0
_CLEARLY = 6.0
"""Another parity is suggested if its misfit is smaller by this much, the cost of one missing level."""


def levels_from_orbits(
    moment: Moment,
    a: float,
    k_max: float | None = None,
    parities: Iterable[Parity] = tuple(Parity),
) -> Levels:
    """Return the levels computed from the stored orbits (`Catalogue.levels`)."""
    stadium, named = Stadium(a), tuple(parities)
    classes, highest = _classes(moment, stadium.a)
    reliable = min(reliable_end(stadium, parity) for parity in named)
    end = math.floor(reliable * 10) / 10 if k_max is None else k_max
    if not 0 < end <= _MOST_K:
        raise InputError(f"k up to {end:g}: give a k above 0 and up to {_MOST_K:g}")
    found = {}
    for parity in named:
        k, error = levels_of(staircase(stadium, classes, end + 1.0, parity), end)
        found[parity] = [LevelWindow(stadium.a, parity, 0.0, end, 0, k, error)]
    basis = [
        f"from {several(len(classes.length), 'class', 'classes')} of orbits up to period {highest}, "
        f"with cutoffs X = {CUTOFFS[0]:g} to {CUTOFFS[-1]:g}"
    ]
    if highest < _ENOUGH:
        basis.append(
            f"period {_ENOUGH} reduces the errors: 'orbitdb fill --p {_ENOUGH} --a {exact(stadium.a)}'"
        )
    if end > reliable:
        basis.append(f"above k = {reliable:.1f} the rms error is more than a fifth of the mean spacing")
    return replace(Levels.joined(stadium.a, 0.0, end, found), basis="; ".join(basis))


def beside(moment: Moment, found: Levels) -> list[float | None]:
    """Return, for each level from orbits, the stored level with the same number, or None."""
    known: dict[tuple[str, int], float] = {}
    for parity in found.parities:
        for window in stored_levels(moment.connection, found.a, parity):
            known.update(((str(parity), window.below + n), k) for n, k in enumerate(window.k.tolist(), 1))
    numbers = dict.fromkeys(map(str, found.parities), 0)
    values = []
    for parity in found.parity.tolist():
        numbers[parity] += 1
        values.append(known.get((parity, numbers[parity])))
    return values


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
    classes, _ = _classes(moment, stadium.a)
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


def _classes(moment: Moment, a: float) -> tuple[Classes, int]:
    """Return the orbits at a, and the period up to which all are filled; raise if this period is too low."""
    if not LEAST_A <= a <= LARGEST_A:
        raise InputError(f"no levels at a = {exact(a)}: give a half length from {LEAST_A:g} to {LARGEST_A:g}")
    classes, _, highest = read_classes(moment, Selection(a))
    if highest < _LEAST:
        raise InputError(
            f"periods are complete only up to {highest} at a = {exact(a)}, but levels need {_LEAST} or more: "
            f"'orbitdb fill --p {_ENOUGH} --a {exact(a)}' finds their orbits"
        )
    return classes, highest
