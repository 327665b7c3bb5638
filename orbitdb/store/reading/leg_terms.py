"""What sum rules need of the orbits of whole periods: whether they are all there, and sums along them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.leg_sums import LegSums, leg_sums
from orbitdb.averages.sum_rules import SumRules, sum_rules
from orbitdb.averages.swept_sum_rules import EXACT, sum_rules_beyond
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.chosen_classes import ChosenClasses
from orbitdb.store.reading.soundness import unsound
from orbitdb.store.reading.whole_periods import WholePeriods
from orbitdb.symbols.automaton import admissible
from orbitdb.symbols.words import keys_of_period, packed, unpack

_BLOCK = 1 << 15


def why_no_further_sum_rules(subset: WholePeriods) -> str:
    """Tell why some swept periods have no sum rules; empty if all have."""
    last = EXACT + len(subset.moments)
    if not subset.swept or subset.highest <= last:
        return ""
    return f"sum rules end at p = {last}: {last + 1} was swept before all lower periods were"


def why_no_sum_rules_of(subset: WholePeriods) -> str:
    """Tell why some of the periods of a subset have no sum rules; empty if all have."""
    whole = why_no_sum_rules(subset.selection, subset.missing, subset.part)
    return whole or why_no_further_sum_rules(subset)


def why_no_sum_rules(chosen: Selection, missing: Sequence[int], part: bool = False) -> str:
    """Tell why exact means say nothing of a subset; empty if it is all orbits up to some period.

    Parameters
    ----------
    chosen : Selection
    missing : sequence of int
        Periods below the highest that are not chosen or not stored as a whole.
    part : bool, optional
        Whether only some of what was chosen is there.
    """
    if part or replace(chosen, periods=()) != Selection(a=chosen.a, statuses=(Status.ORBIT,)):
        return "sum rules are for all orbits up to a period, not for a part of them"
    if missing:
        are = "is" if len(missing) == 1 else "are"
        return f"sum rules need all orbits up to a period; p = {', '.join(map(str, missing))} {are} missing"
    return ""


def sum_rules_of(subset: WholePeriods) -> SumRules | None:
    """Return the averages of whole periods by sum rules; None where they have none."""
    if why_no_sum_rules(subset.selection, subset.missing, subset.part):
        return None
    a = subset.selection.a
    if subset.swept:
        return sum_rules_beyond(a, subset.moments, subset.highest)
    sums = read_leg_sums(subset.classes, a)
    return sum_rules(subset.classes.rows(), sums, subset.highest, exact_means(a))


def read_leg_sums(classes: ChosenClasses, a: float) -> LegSums:
    """Return the sums along the orbits of chosen classes of periods that are filled, in their order.

    Raises
    ------
    StoreError
        If a class's number is not that of an admissible word of its period.
    """
    sums = np.empty((4, len(classes)))
    for p in np.unique(classes.p).tolist():
        rows = np.flatnonzero(classes.p == p)
        for start in range(0, len(rows), _BLOCK):
            part = rows[start : start + _BLOCK]
            found = leg_sums(_words(classes, part, p), a)
            sums[:, part] = found.legs, found.log_drift, found.log_kick, found.coupling
    return LegSums(*sums)


def _words(classes: ChosenClasses, rows: NDArray[np.intp], p: int) -> NDArray[np.uint8]:
    """Return the least words of some classes of one period, shape (N, p)."""
    number = classes.number[rows]
    low, high = keys_of_period(p)
    sound = (number >= low) & (number <= high)
    words = unpack(packed(number, p), p)
    sound &= admissible(words)
    if not sound.all():
        raise unsound("a class number that is no admissible word's:", number[~sound][0])
    return words
