"""What sum rules need of the orbits of whole periods: whether they are all there, and sums along them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.leg_sums import LegSums, leg_sums
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.chosen_classes import ChosenClasses
from orbitdb.store.reading.soundness import unsound
from orbitdb.store.reading.whole_periods import WholePeriods
from orbitdb.symbols.pruning import rules_broken
from orbitdb.symbols.words import SYMBOLS, keys_of_period, packed, unpack

_BLOCK = 1 << 14


def why_no_sum_rules(subset: WholePeriods) -> str:
    """Tell why exact means say nothing of a subset; empty if it is all orbits up to some period."""
    chosen = subset.selection
    everything = Selection(a=chosen.a, statuses=(Status.ORBIT,))
    if replace(chosen, periods=()) != everything:
        return "sum rules hold for all orbits up to a period: no other subset has them"
    if subset.missing:
        return f"sum rules lack the periods {', '.join(map(str, subset.missing))}"
    return ""


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
    sound &= words.max(axis=1) < len(SYMBOLS)
    sound[sound] = rules_broken(words[sound]) == 0
    if not sound.all():
        raise unsound("a class number that is no admissible word's:", number[~sound][0])
    return words
