"""The paper's Table 1 and the topological entropy by period: `Catalogue.table` and `.entropy`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from orbitdb.answers.complete_periods import (
    CompletePeriods,
    Counted,
    Periods,
    all_orbits,
    counts,
    if_avoiding,
    read_noted,
    with_lower,
)
from orbitdb.answers.completeness import Coverage
from orbitdb.answers.results import PROVED, TABLE, Result
from orbitdb.arrays import Integers
from orbitdb.averages import by_period
from orbitdb.averages.by_period import divisors, every_period, none_where_incomplete, of_divisors
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import columns_of
from orbitdb.entropy_bounds.bounds import BALLS, EntropyBounds, search
from orbitdb.orbits.exponents import Tally
from orbitdb.orbits.status import STORED, Status
from orbitdb.period_ranges import written_periods
from orbitdb.selection import Selection
from orbitdb.store.sqlite import Connection
from orbitdb.store.stored_values import tightest_bounds
from orbitdb.text import format_float

_EDGES = 10
"""Edges of the longest windows if no bounds are stored; the search takes at most half a second (small a)."""

_AVOIDED = "this is the growth rate of the orbits that are left, at most that of all orbits"


@dataclass(frozen=True)
class ProvedBounds:
    """Proved bounds on the entropy of all orbits, and a line that describes them (`fact`)."""

    bounds: EntropyBounds
    fact: str

    def columns(self, rows: int) -> dict[str, list[Any]]:
        """Return the columns of a table that give the bounds in each of its rows."""
        values = (self.bounds.lower, self.bounds.upper, self.bounds.arithmetic)
        return {name: [value] * rows for name, value in zip(PROVED, values, strict=True)}


def table(connection: Connection, chosen: Selection) -> Result:
    """Return the paper's Table 1 (`Catalogue.table`)."""
    coverage = Coverage(connection, chosen)
    counted = counts(coverage)
    notes = _gaps(coverage, counted)
    for p in counted.chosen:
        if missing := sorted(of_divisors(p) - counted.tallies.keys()):
            notes.append(f"p = {p}: N also needs p = {', '.join(map(str, missing))} (not filled)")
    if not counted.chosen and not notes:
        notes = [f"no {chosen.describe()}"]
    stored = counted.chosen and tightest_bounds(connection, chosen.a) is not None
    proved = enclosure(connection, chosen.a) if stored else None
    columns = _table(counted.chosen, counted.tallies)
    facts = [chosen.describe()] * bool(counted.chosen) + ([] if proved is None else [proved.fact])
    return Result(chosen, columns, tuple(facts), tuple(notes))


def table_of_rows(chosen: Selection, periods: Sequence[int], p: Integers, status: Any, least: Any) -> Result:
    """Return the paper's Table 1 for rows that were already read (`Subset.table`)."""
    tallies = {}
    for period in periods:
        rows = (p == period) & (status != Status.GEOMETRIC.value)
        own, words = status[rows], least[rows]
        orbits, *apart = (own == kind.value for kind in (Status.ORBIT, Status.BOUNDARY, Status.UNRESOLVED))
        others = (int(marks.sum()) for marks in apart)
        tallies[period] = Tally(len(own), int(orbits.sum()), len(set(words[orbits].tolist())), *others)
    columns, notes = _table(periods, tallies), tuple[str, ...]()
    if chosen.statuses and not {*STORED} - {Status.GEOMETRIC} <= {*chosen.statuses}:  # some were not read
        columns |= {name: [None] * len(tallies) for name in ("N_t", "boundary", "unresolved")}
        notes = ("N_t, boundary and unresolved are blank: they count words of every status, `status='all'`",)
    return Result(chosen, columns, (chosen.describe(),), notes)


def _table(periods: Sequence[int], tallies: Mapping[int, Tally]) -> dict[str, list[Any]]:
    """Return the columns of Table 1, computed from the counts of the periods and of their divisors."""
    rows = []
    for p in periods:
        tally, whole = tallies[p], tallies.keys() >= of_divisors(p)
        points = sum(d * tallies[d].n_c for d in divisors(p) if d > 1) if whole else None
        entropy = math.log(points) / p if points else None
        rows.append(
            (p, tally.words, tally.n_c, points, entropy, tally.classes, tally.boundary, tally.unresolved)
        )
    return columns_of(TABLE, rows)


def entropy(connection: Connection, chosen: Selection) -> Result:
    """Return the topological entropy by period (`Catalogue.entropy`).

    All orbits of a period need only be counted; the rows of other subsets are read.
    """
    coverage = Coverage(connection, chosen)
    if not all_orbits(chosen):
        notes = _uncounted(coverage)
        subset = read_noted(connection, chosen, notes, swept=False)
        return Result(chosen, {}, (), tuple(notes)) if subset is None else entropy_of_rows(subset, notes)
    orbits, wide = replace(chosen, statuses=(Status.ORBIT,)), with_lower(chosen)
    counted = counts(coverage.of(Selection(wide.a, wide.periods)))
    notes = _gaps(coverage, counted)
    periods = Periods(orbits, wide, counted.chosen)
    if not periods.shown:
        return Result(chosen, {}, (), tuple(notes or [f"no {orbits.describe()}"]))
    columns = _entropy(periods, counted.cycles(), notes)
    proved = enclosure(connection, chosen.a)
    notes.append(outside(columns["p"], columns["h_zeta"], proved.bounds, chosen))
    columns |= proved.columns(len(columns["p"]))
    return Result(orbits, columns, (orbits.describe(), proved.fact), tuple(filter(None, notes)))


def entropy_of_rows(subset: CompletePeriods, notes: Sequence[str] = ()) -> Result:
    """Return the topological entropy by period of orbits that were already read (`Subset.entropy`)."""
    said = list(notes)
    columns = _entropy(subset, subset.cycles(), said)
    said.append(if_avoiding(subset.selection, _AVOIDED))
    return Result(subset.selection, columns, (subset.selection.describe(),), tuple(filter(None, said)))


def _entropy(periods: Periods, cycles: Integers, notes: list[str]) -> dict[str, list[Any]]:
    """Return the columns of the entropy, given the number of orbits of each period; add to the notes."""
    estimates = by_period.entropy_of_counts(cycles)
    columns = {"p": estimates.p.tolist()}
    columns |= none_where_incomplete(
        estimates.p, {"N": estimates.N, "K_0": estimates.K_0}, of_divisors, periods.periods
    )
    zeta = {"h_zeta": estimates.h_zeta, "h_zeta_change": estimates.h_zeta_change}
    columns |= none_where_incomplete(estimates.p, zeta, every_period, periods.periods)
    notes += periods.notes(estimates)
    return periods.rows_of(columns)


def _gaps(coverage: Coverage, counted: Counted) -> list[str]:
    return coverage.gaps(swept=counted.from_sweeps, from_births=counted.from_births, left_out=True)


def _uncounted(coverage: Coverage) -> list[str]:
    """Return a note on periods without rows; sweeps and births count all orbits, not those of a subset."""
    chosen = coverage.chosen
    counted = counts(coverage.of(Selection(chosen.a, chosen.periods)))
    if not (periods := sorted([*counted.from_sweeps, *counted.from_births])):
        return []
    return [
        f"at a = {format_float(chosen.a)}, all orbits of {written_periods(periods)} were counted, but no "
        "rows are stored: choose by periods alone, or fill these periods"
    ]


def stored_enclosure(connection: Connection, a: float) -> ProvedBounds | None:
    """Return the tightest stored bounds on the entropy, if any.

    The line also gives the tightest bounds that are proved in ball arithmetic.
    """
    closest = tightest_bounds(connection, a)
    if closest is None:
        return None
    line = f"entropy of all orbits: {closest.between}, proved from {closest.basis}"
    surer = None if closest.arithmetic == BALLS else tightest_bounds(connection, a, BALLS)
    return ProvedBounds(closest, line + ("" if surer is None else f"; {surer.between} from {surer.basis}"))


def enclosure(connection: Connection, a: float) -> ProvedBounds:
    """Return the tightest stored bounds on the entropy, or better ones that are computed now."""
    stored = stored_enclosure(connection, a)
    if stored is not None and stored.bounds.edges >= _EDGES:
        return stored
    computed = _computed_bounds(a)
    if stored is not None and stored.bounds.width <= computed.width:
        return stored
    closer = f"`catalogue.prove_bounds(a={format_float(a)})` finds tighter ones"
    line = f"entropy of all orbits: {computed.between}, proved from {computed.basis}; {closer}"
    return ProvedBounds(computed, line)


@cache
def _computed_bounds(a: float) -> EntropyBounds:
    """Compute bounds on the entropy; the cache keeps them for the next question."""
    *_, last = search(Stadium(a), _EDGES)
    return last


def outside(
    periods: Sequence[int], h_zeta: Sequence[float | None], bounds: EntropyBounds, chosen: Selection
) -> str:
    """Return a note that names the periods whose h_zeta lies outside the bounds on the entropy of all orbits.

    Return '' if there are none, or if only some orbits are chosen. Values of h_zeta may be None or NaN.
    """
    values = [(p, h) for p, h in zip(periods, h_zeta, strict=True) if h is not None]
    beyond = [p for p, h in values if h < bounds.lower or h > bounds.upper]
    if not (beyond and all_orbits(chosen)):
        return ""
    return f"h_zeta lies outside the proved bounds at {written_periods(beyond)}"
