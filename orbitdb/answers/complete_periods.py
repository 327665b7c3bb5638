"""Complete periods: their counts at any a, and a chosen subset as averages need it, by symmetry classes.

Averages use only complete periods, filled or swept; sum rules need all orbits up to some period.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from orbitdb.answers.completeness import Coverage
from orbitdb.arrays import Integers
from orbitdb.averages import by_period
from orbitdb.averages.by_period import PeriodSums, every_period, faults_of, of_divisors
from orbitdb.averages.sum_rules import SumRules, orbits_of_words, sum_rules
from orbitdb.averages.tilting import TiltedOrbits
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import SelectionError
from orbitdb.open_stadium.openings import measure
from orbitdb.open_stadium.patterns import patterns_of
from orbitdb.open_stadium.rates import FAST
from orbitdb.open_stadium.tails import tails
from orbitdb.orbits.exponents import OrbitClasses, Tally
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.selection import Selection
from orbitdb.sql_text import reads_codes
from orbitdb.store.lookup import counts_at
from orbitdb.store.periods import Sweep
from orbitdb.store.select import WORDS, Words, arrays_of
from orbitdb.store.sqlite import Connection
from orbitdb.store.tables import readable
from orbitdb.symbols.words import packed, unpack

_WITH_LAMBDA = tuple(map(Status, EXISTING))
"""The statuses of orbits that have a length and lambda."""


def read_classes(connection: Connection, selection: Selection, texts: Sequence[str] = ()) -> OrbitClasses:
    """Return the chosen classes that have a length and lambda (`Catalogue.classes`).

    `texts` may name ``symmetry`` and ``representative``, to read them, too.
    """
    selection = of_orbits(selection)
    names = ("p", WORDS, "length", "lyapunov", "walls", "class_size", *texts)
    found = arrays_of(connection, Words(selection, by_class=True), names)
    with readable(f"a row of {selection.describe()}"):
        return OrbitClasses(**{name: found[name] for name in names}, number=found["id"])


def of_orbits(chosen: Selection) -> Selection:
    """Return the selection of orbits, unless statuses were chosen; raise if these have no lambda."""
    orbits = (Status.ORBIT,)
    chosen = chosen.preferring(orbits) if chosen.statuses else replace(chosen, statuses=orbits)
    if without := [status for status in chosen.statuses if status not in EXISTING]:
        raise SelectionError(
            f"only orbits (and boundary) have averages and lengths: leave out status {', '.join(without)}"
        )
    return chosen


@dataclass(frozen=True)
class Counted:
    """Counts of the words and orbits of complete periods at a given a.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    tallies : dict of int to Tally
        Counts by period, including periods that are not chosen but are needed in sums over divisors.
    chosen : tuple of int
        The chosen periods that have counts.
    from_births, from_sweeps : tuple of int
        The chosen periods that are not filled and were counted from births, or by a sweep, instead.
    """

    a: float
    tallies: Mapping[int, Tally]
    chosen: tuple[int, ...]
    from_births: tuple[int, ...]
    from_sweeps: tuple[int, ...] = ()

    def cycles(self) -> Integers:
        """Return the number of orbits of each period from 0 to the highest chosen one; 0 where unknown."""
        numbers = np.zeros(max(self.chosen, default=0) + 1, dtype=np.int64)
        for p in self.chosen:
            numbers[p] = self.tallies[p].n_c
        return numbers


def counts(coverage: Coverage) -> Counted:
    """Return the counts of each chosen period: from its fill, else from a sweep, else from births.

    Raises `SelectionError` if the selection has criteria other than a and periods.
    """
    selection = coverage.chosen
    if selection != Selection(selection.a, selection.periods):
        raise SelectionError(
            "a table counts all words of its periods: give only a and p, or count the rows of a subset "
            "with select(...).table()"
        )
    names = ("n_t", "n_c", "classes", "boundary", "unresolved")
    tallies = {
        fill.p: Tally(*(getattr(fill, name) for name in names)) for fill in coverage.fills if fill.done
    }
    sweeps = [sweep for sweep in coverage.stored.sweeps if sweep.done and sweep.p not in tallies]
    tallies |= {sweep.p: sweep.tally for sweep in sweeps}
    born = [p for p in coverage.stored.born if p not in tallies]
    chosen = tuple(sorted(p for p in (*tallies, *born) if selection.includes(p)))
    needed = {p for p in born if any(multiple % p == 0 for multiple in chosen)}
    tallies |= {p: counts_at(coverage.connection, selection.a, p) for p in needed}
    swept = tuple(sweep.p for sweep in sweeps if selection.includes(sweep.p))
    counted = tuple(p for p in born if selection.includes(p))
    return Counted(selection.a, dict(sorted(tallies.items())), chosen, counted, swept)


@dataclass(frozen=True)
class Periods:
    """Complete periods, the chosen ones among them, and why others are missing.

    Attributes
    ----------
    selection : Selection
        What was chosen; orbits if no status was named.
    wide : Selection
        The same with the lower periods that averages by period need, too.
    periods : tuple of int
        The complete periods in `wide`, in ascending order.
    unborn : tuple of int
        The periods left out because the subset depends on births that are not stored.
    """

    selection: Selection
    wide: Selection
    periods: tuple[int, ...]
    unborn: tuple[int, ...] = ()

    @property
    def shown(self) -> list[int]:
        """The chosen periods among the complete ones, which a table has rows for."""
        return [p for p in self.periods if self.selection.includes(p)]

    @property
    def highest(self) -> int:
        """The highest complete period, or 0 if there is none."""
        return max(self.periods, default=0)

    @property
    def missing(self) -> list[int]:
        """The missing periods below the highest one; a zeta function needs them all."""
        return sorted(every_period(self.highest).difference(self.periods))

    def why_missing(self, periods: Sequence[int]) -> str:
        """Return a text that lists periods that averages leave out, with the reasons."""
        reasons: dict[str, list[int]] = {}
        for p in periods:
            lacking = "births not stored, left out" if p in self.unborn else "not filled"
            reasons.setdefault(lacking if self.wide.includes(p) else "not chosen", []).append(p)
        return "; ".join(f"{', '.join(map(str, orders))} ({reason})" for reason, orders in reasons.items())

    def notes(self, averages: by_period.Entropy | by_period.Lyapunov) -> list[str]:
        """Return notes on the periods missing from the zeta function or from sums over fixed points."""
        lacking = self.why_missing(self.missing)
        notes = [f"the zeta function lacks p = {lacking}" if lacking else "",
                 faults_of(averages, self.periods, self.shown)]  # fmt: skip
        notes += [
            f"p = {p}: the sums over fixed points lack p = {self.why_missing(gone)}"
            for p in self.shown
            if (gone := sorted(of_divisors(p).difference(self.periods)))
        ]
        return [note for note in notes if note]

    def rows_of(self, columns: Mapping[str, list[Any]]) -> dict[str, list[Any]]:
        """Return the same columns with only the rows of the chosen periods."""
        kept = [place for place, p in enumerate(columns["p"]) if p in self.shown]
        return {name: [values[place] for place in kept] for name, values in columns.items()}


@dataclass(frozen=True, kw_only=True)
class CompletePeriods(Periods):
    """The chosen classes of all filled periods, and the sums over the orbits of swept periods.

    Attributes
    ----------
    classes : OrbitClasses
        The chosen classes of the filled periods.
    swept : mapping of int to Sweep
        The sweeps of the periods that are not filled.
    part : bool
        Whether the classes are only a part of the chosen ones.
    """

    classes: OrbitClasses
    swept: Mapping[int, Sweep] = field(default_factory=dict)
    part: bool = False

    def sums(self) -> dict[int, PeriodSums]:
        """Return the sums over the chosen orbits of each period."""
        sums = {p: PeriodSums.of(part, p) for p, part in self.classes.by_period().items()}
        return sums | {p: sweep.sums for p, sweep in self.swept.items() if sweep.sums is not None}

    def cycles(self) -> Integers:
        """Return the number of chosen orbits of each period from 0 to `highest`."""
        numbers = np.zeros(self.highest + 1, dtype=np.int64)
        np.add.at(numbers, self.classes.p, self.classes.words)
        for p, sweep in self.swept.items():
            numbers[p] = sweep.tally.n_c
        return numbers


def with_lower(chosen: Selection) -> Selection:
    """Return a subset with all periods up to its highest one."""
    highest = max((high for _, high in chosen.periods), default=0)
    return replace(chosen, periods=((2, highest),)) if chosen.periods else chosen


def read_complete_periods(
    connection: Connection, chosen: Selection, swept: bool = False, lower: bool = False
) -> CompletePeriods:
    """Return the chosen classes of the filled periods.

    If `swept` and all orbits are chosen, include swept periods without rows. If `lower`, include the periods
    below the chosen ones.
    """
    chosen = of_orbits(chosen)
    wide = with_lower(chosen) if lower else chosen
    coverage = Coverage(connection, wide)
    unborn = tuple(coverage.without_births())
    filled = [p for p in coverage.filled if p not in unborn]
    sweeps = coverage.stored.sweeps if swept and all_orbits(wide) else []
    counted = {
        sweep.p: sweep
        for sweep in sweeps
        if wide.includes(sweep.p) and sweep.p not in filled and sweep.sums is not None
    }
    classes = read_classes(connection, replace(wide, periods=tuple((p, p) for p in filled) or ((0, 0),)))
    periods = tuple(sorted([*filled, *counted]))
    return CompletePeriods(chosen, wide, periods, unborn, classes=classes, swept=counted)


def read_noted(
    connection: Connection, chosen: Selection, notes: list[str], swept: bool, lower: bool = True
) -> CompletePeriods | None:
    """Return the chosen classes of complete periods, with those of lower periods (`read_complete_periods`).

    Return None if the chosen periods contain no orbit. Notes on what is left out are added to `notes`.
    """
    subset = read_complete_periods(connection, chosen, swept, lower)
    empty = {*subset.classes.p.tolist(), *subset.swept}.isdisjoint(subset.shown)
    coverage = Coverage(connection, subset.selection)
    notes += coverage.gaps(swept=subset.swept, left_out=True)
    notes += filter(None, [coverage.nothing(bool(subset.swept), _WITH_LAMBDA) if empty else ""])
    return None if empty else subset


def all_orbits(chosen: Selection) -> bool:
    """Tell whether the subset consists of all orbits of its periods."""
    alone = replace(chosen, statuses=()) if chosen.statuses == (Status.ORBIT,) else chosen
    return alone == Selection(chosen.a, chosen.periods)


def if_avoiding(chosen: Selection, said: str) -> str:
    """Return what averages over some orbits mean, under a condition for filters that read codes; else ''."""
    if chosen.without or chosen.opening:
        return said
    if chosen.where is not None and reads_codes(chosen.where):
        return f"if the filter leaves out just the words that contain some pattern, {said}"
    return ""


def why_no_lambda(chosen: Selection) -> str:
    """Return the reason why the orbits that an opening leaves have no average lambda; '' if they have one."""
    if not chosen.opening:
        return ""
    stadium = Stadium(chosen.a)
    left = tails(stadium, chosen.opening, patterns_of(chosen.without))
    if left.uncut:
        return (
            "no average of lambda: bouncing balls that drift from one semicircle to the other are left, for "
            "which the averages do not converge; open a part of a straight wall"
        )
    if left.c2 > 0 and measure(stadium, chosen.opening) > FAST:
        return (
            f"no average of lambda: more than {FAST:.0%} of the boundary is open, so almost only runs along "
            "a semicircle are left, for which the averages do not converge"
        )
    return ""


def why_no_sum_rules(subset: CompletePeriods) -> str:
    """Return the reason why some periods of a subset have no sum rules; '' if all have them."""
    if subset.part or not all_orbits(subset.selection):
        return "sum rules are for all orbits up to a period, not for a part of them"
    if missing := subset.missing:
        are = "is" if len(missing) == 1 else "are"
        return f"sum rules need all orbits up to a period; p = {', '.join(map(str, missing))} {are} missing"
    if subset.swept:
        first = min(subset.swept)
        return f"sum rules need stored orbits: they are blank from p = {first} on, which is swept"
    return ""


def sum_rules_of(subset: CompletePeriods) -> SumRules | None:
    """Return the averages of complete periods by sum rules, or None if these do not apply."""
    if subset.part or subset.missing or not all_orbits(subset.selection):
        return None
    a, last = subset.selection.a, min(subset.swept, default=subset.highest + 1) - 1
    terms = ((p, orbits) for p, orbits in read_terms(subset.classes, a) if p <= last)
    return sum_rules(a, terms, last, subset.highest) if last > 1 else None


def read_terms(classes: OrbitClasses, a: float) -> Iterator[tuple[int, TiltedOrbits]]:
    """Yield the terms of sum rules from the chosen classes of filled periods, by period."""
    for p, part in classes.by_period().items():
        number = part.number
        assert number is not None
        yield p, orbits_of_words(unpack(packed(number, p), p), part.words, part.lyapunov, a)
