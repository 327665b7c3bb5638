"""A chosen subset as averages need it: its symmetry classes, without words and coordinates.

Averages use only complete periods, filled or swept; sum rules need all orbits up to some period.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from orbitdb.answers.completeness import Counted, gaps, nothing, without_births
from orbitdb.arrays import Integers
from orbitdb.averages import by_period
from orbitdb.averages.by_period import PeriodSums, every_period, faults_of, of_divisors
from orbitdb.averages.sum_rules import EXACT, SumRules, orbits_of_words, sum_rules, swept_sum_rules
from orbitdb.averages.tilting import TiltedOrbits, TiltMoments
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.store.connection import Moment
from orbitdb.store.fills import moments_of, read_fills, read_sweeps
from orbitdb.store.query import choose
from orbitdb.store.selection import Selection, SelectionError
from orbitdb.symbols.words import packed, unpack


def read_classes(moment: Moment, selection: Selection, texts: Sequence[str] = ()) -> OrbitClasses:
    """Return the chosen classes that have a length and lambda (`Catalogue.classes`).

    `texts` may name ``symmetry`` and ``representative``, to read them, too.
    """
    if not selection.statuses:
        selection = replace(selection, statuses=(Status.ORBIT,))
    if without := [status for status in selection.statuses if status not in EXISTING]:
        raise SelectionError(
            f"only orbits (and boundary) have averages and lengths: leave out status {', '.join(without)}"
        )
    chosen = choose(moment, selection, columns=("p", "class_size", "length", "lyapunov", "walls", *texts))
    p, size, walls = (chosen.values[name].astype(np.int64) for name in ("p", "class_size", "walls"))
    length, lyapunov = (chosen.values[name].astype(np.float64) for name in ("length", "lyapunov"))
    return OrbitClasses(
        p,
        chosen.counts.astype(np.int64),
        length,
        lyapunov,
        walls,
        size,
        chosen.ids,
        **{name: chosen.values[name] for name in texts},
    )


@dataclass(frozen=True)
class WholePeriods:
    """The chosen classes of all filled periods, and the sums over the chosen classes of swept periods.

    Attributes
    ----------
    selection : Selection
        What was chosen; orbits if no status was named.
    filled : tuple of int
        The periods that are completely filled, in order.
    classes : OrbitClasses
        The chosen classes of the filled periods.
    swept : mapping of int to PeriodSums
        Sums over the periods that are not filled but swept, by period.
    moments : sequence
        Moments of swept periods for sum rules (`orbitdb.store.fills.moments_of`).
    orbits : mapping of int to int
        Number of chosen orbits of each swept period.
    unborn : tuple of int
        The periods left out because the subset depends on births that are not stored.
    part : bool
        Whether the classes are only a part of the chosen ones.
    lower : bool
        Whether the periods include those below the chosen ones, which averages by period need, too.
    """

    selection: Selection
    filled: tuple[int, ...]
    classes: OrbitClasses
    swept: Mapping[int, PeriodSums] = field(default_factory=dict)
    moments: Sequence[Mapping[int, TiltMoments]] = ()
    orbits: Mapping[int, int] = field(default_factory=dict)
    unborn: tuple[int, ...] = ()
    part: bool = False
    lower: bool = False

    @cached_property
    def periods(self) -> list[int]:
        """The complete periods, filled or swept, in ascending order."""
        return sorted([*self.filled, *self.swept])

    @property
    def shown(self) -> list[int]:
        """The chosen periods among the complete ones, which a table has rows for."""
        return [p for p in self.periods if self.selection.includes(p)]

    def counted(self) -> Counted:
        """Return which periods come from fills and which from sweeps."""
        return Counted(self.selection.a, {}, tuple(self.periods), (), tuple(self.swept))

    def sums(self) -> dict[int, PeriodSums]:
        """Return the sums over the chosen orbits of each period."""
        rows = self.classes.by_period()
        return {p: PeriodSums.of(part, p) for p, part in rows.items()} | dict(self.swept)

    def cycles(self) -> Integers:
        """Return the number of chosen orbits of each period from 0 to `highest`."""
        numbers = np.zeros(self.highest + 1, dtype=np.int64)
        np.add.at(numbers, self.classes.p, self.classes.words)
        for p, count in self.orbits.items():
            numbers[p] = count
        return numbers

    @property
    def highest(self) -> int:
        """The highest complete period, or 0 if there is none."""
        return max(self.periods, default=0)

    @property
    def missing(self) -> list[int]:
        """The missing periods below the highest one; a zeta function needs them all."""
        return sorted(every_period(self.highest).difference(self.periods))

    def why_missing(self) -> str:
        """Return a text that lists the `missing` periods with the reasons."""
        read = with_lower(self.selection) if self.lower else self.selection
        return why_missing(self.missing, read, self.unborn)


def with_lower(chosen: Selection) -> Selection:
    """Return a subset with all periods up to its highest one."""
    highest = max((high for _, high in chosen.periods), default=0)
    return replace(chosen, periods=((2, highest),)) if chosen.periods else chosen


def read_whole(moment: Moment, chosen: Selection, swept: bool = False, lower: bool = False) -> WholePeriods:
    """Return the chosen classes of the filled periods.

    If `swept` and all orbits are chosen, include swept periods without rows. If `lower`, include the periods
    below the chosen ones.
    """
    if not chosen.statuses:
        chosen = replace(chosen, statuses=(Status.ORBIT,))
    selection = with_lower(chosen) if lower else chosen
    fills = [fill for fill in read_fills(moment, selection.a) if selection.includes(fill.p)]
    unborn = tuple(without_births(moment, selection))
    whole = tuple(fill.p for fill in fills if fill.whole and fill.p not in unborn)
    sweeps = read_sweeps(moment, selection.a) if swept and all_orbits(selection) else []
    counted = [done for done in sweeps if selection.includes(done.p) and done.p not in whole]
    sums = {done.p: done.sums for done in counted if done.sums is not None}
    orbits = {done.p: done.tally.n_c for done in counted if done.p in sums}
    spans = tuple((p, p) for p in whole) or ((0, 0),)
    classes = read_classes(moment, replace(selection, periods=spans))
    return WholePeriods(chosen, whole, classes, sums, moments_of(sweeps), orbits, unborn, lower=lower)


def read_noted(
    moment: Moment, chosen: Selection, notes: list[str], swept: bool, lower: bool = True
) -> WholePeriods | None:
    """Return the chosen classes of complete periods, with those of lower periods (`read_whole`).

    Return None if the chosen periods contain no orbit. Notes on what is left out are added to `notes`.
    """
    subset = read_whole(moment, chosen, swept, lower)
    notes += gaps(moment, chosen, left_out=True, counted=subset.counted() if subset.swept else None)
    swept_orbits = (p for p, sums in subset.swept.items() if np.isfinite(sums.ranges).all())
    if not {*np.unique(subset.classes.p).tolist(), *swept_orbits}.isdisjoint(subset.shown):
        return subset
    notes += nothing(moment, subset.selection, swept=bool(subset.swept))
    return None


def notes_on_missing(
    found: by_period.Entropy | by_period.Lyapunov,
    periods: Sequence[int],
    shown: Sequence[int],
    lacking: str,
    chosen: Selection,
) -> tuple[str, ...]:
    """Return notes on the periods missing from the zeta function or from sums over fixed points.

    `periods` were read, `shown` have rows, and `lacking` names missing ones (`why_missing`).
    """
    divided = [
        f"p = {p}: the sums over fixed points lack p = {why_missing(gone, chosen)}"
        for p in shown
        if (gone := sorted(of_divisors(p).difference(periods)))
    ]
    zeta = f"the zeta function lacks p = {lacking}" if lacking else ""
    return tuple(filter(None, [zeta, faults_of(found, periods, shown), *divided]))


def rows_of(columns: Mapping[str, list[Any]], periods: Sequence[int]) -> dict[str, list[Any]]:
    """Return the same columns with only the rows of the given periods."""
    kept = [place for place, p in enumerate(columns["p"]) if p in periods]
    return {name: [values[place] for place in kept] for name, values in columns.items()}


def why_missing(periods: Sequence[int], selection: Selection, unborn: Sequence[int] = ()) -> str:
    """Return a text that lists periods that averages leave out, with the reasons."""
    reasons: dict[str, list[int]] = {}
    for p in periods:
        lacking = "births not stored, left out" if p in unborn else "not filled"
        reasons.setdefault(lacking if selection.includes(p) else "not chosen", []).append(p)
    return "; ".join(f"{', '.join(map(str, orders))} ({reason})" for reason, orders in reasons.items())


def all_orbits(chosen: Selection) -> bool:
    """Tell whether the subset consists of all orbits of its periods."""
    alone = replace(chosen, statuses=()) if chosen.statuses == (Status.ORBIT,) else chosen
    return alone == Selection(chosen.a, chosen.periods)


def why_no_sum_rules_of(subset: WholePeriods) -> str:
    """Return the reason why some periods of a subset have no sum rules; '' if all have them."""
    none, last = _why_none(subset), EXACT + len(subset.moments)
    if none or not subset.swept or subset.highest <= last:
        return none
    return f"sum rules end at p = {last}: {last + 1} was swept before all lower periods were"


def _why_none(subset: WholePeriods) -> str:
    """Return the reason why a subset has no sum rules; '' if it contains all orbits up to some period."""
    if subset.part or not all_orbits(subset.selection):
        return "sum rules are for all orbits up to a period, not for a part of them"
    if missing := subset.missing:
        are = "is" if len(missing) == 1 else "are"
        return f"sum rules need all orbits up to a period; p = {', '.join(map(str, missing))} {are} missing"
    return ""


def sum_rules_of(subset: WholePeriods) -> SumRules | None:
    """Return the averages of complete periods by sum rules, or None if there are none."""
    if _why_none(subset):
        return None
    a = subset.selection.a
    if subset.swept:
        return swept_sum_rules(a, subset.moments, subset.highest)
    return sum_rules(a, read_terms(subset.classes, a), subset.highest)


def read_terms(classes: OrbitClasses, a: float) -> Iterator[tuple[int, TiltedOrbits]]:
    """Yield the terms of sum rules from the chosen classes of filled periods, by period."""
    for p, part in classes.by_period().items():
        number = part.number
        assert number is not None
        yield p, orbits_of_words(unpack(packed(number, p), p), part.words, part.lyapunov, a)
