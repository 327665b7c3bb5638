"""The paper's Table 1 and the topological entropy by period: `Catalogue.table` and `.entropy`."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from orbitdb.answers.completeness import count, gaps, need_periods_alone
from orbitdb.answers.results import PROVED, TABLE, Result
from orbitdb.answers.whole_periods import (
    WholePeriods,
    all_orbits,
    notes_on_missing,
    read_noted,
    rows_of,
    why_missing,
    with_lower,
)
from orbitdb.arrays import Integers
from orbitdb.averages import by_period
from orbitdb.averages.by_period import divisors, every_period, of_divisors, standing
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import BALLS, EntropyBounds, search
from orbitdb.orbits.exponents import Tally
from orbitdb.orbits.status import Status
from orbitdb.store.connection import Moment
from orbitdb.store.fills import tightest_bounds
from orbitdb.store.selection import Selection, written_periods
from orbitdb.text import exact

_EDGES = 10
"""Edges of the longest windows if no bounds are stored; the search takes at most half a second (small a)."""


def table(moment: Moment, chosen: Selection) -> Result:
    """Return the paper's Table 1 (`Catalogue.table`)."""
    need_periods_alone(chosen)
    counted = count(moment, chosen)
    notes = gaps(moment, chosen, left_out=True, counted=counted)
    for p in counted.chosen:
        if missing := sorted(of_divisors(p) - counted.known.keys()):
            notes.append(f"p = {p}: N also needs p = {', '.join(map(str, missing))} (not filled)")
    if not counted.chosen and not notes:
        notes = [f"no {chosen.describe()}"]
    stored = counted.chosen and tightest_bounds(moment, chosen.a) is not None
    known = enclosure(moment, chosen.a) if stored else None
    columns = _table(counted.chosen, counted.known)
    return Result(chosen, columns, () if known is None else (known[1],), tuple(notes))


def table_of_rows(
    chosen: Selection, filled: Sequence[int], p: Any, status: Any, representative: Any
) -> Result:
    """Return the paper's Table 1 for rows that were already read (`Subset.table`)."""
    tallies = {}
    for order in filled:
        of_period, least = status[p == order], representative[p == order]
        orbits = of_period == Status.ORBIT.value
        apart = (int((of_period == kind.value).sum()) for kind in (Status.BOUNDARY, Status.UNRESOLVED))
        tallies[order] = Tally(len(of_period), int(orbits.sum()), len(set(least[orbits].tolist())), *apart)
    return Result(chosen, _table(filled, tallies), (chosen.describe(),))


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
    return {name: [row[place] for row in rows] for place, name in enumerate(TABLE)}


def entropy(moment: Moment, chosen: Selection) -> Result:
    """Return the topological entropy by period, from rows or counts (`Catalogue.entropy`)."""
    wide, whole = with_lower(chosen), all_orbits(chosen)
    if whole and (counted := count(moment, wide)).without_rows and any(map(chosen.includes, counted.chosen)):
        notes = gaps(moment, chosen, left_out=True, counted=counted)
        lacking = why_missing(sorted(every_period(max(counted.chosen)).difference(counted.chosen)), wide)
        chosen = replace(chosen, statuses=(Status.ORBIT,))
        shown = [p for p in counted.chosen if chosen.includes(p)]
        columns, told = _entropy(counted.cycles(), counted.chosen, shown, lacking, wide)
    else:
        notes = _uncounted(moment, chosen)
        subset = read_noted(moment, chosen, notes, swept=True)
        if subset is None:
            return Result(chosen, {}, (), tuple(notes))
        chosen = subset.selection
        columns, told = _entropy(subset.cycles(), subset.periods, subset.shown, subset.why_missing(), wide)
    notes += told
    if not whole:  # the bounds are those of all orbits
        return Result(chosen, columns, (chosen.describe(),), tuple(notes))
    proved, line = enclosure(moment, chosen.a)
    notes.append(outside(columns["p"], columns["h_zeta"], proved, chosen))
    bounds = zip(PROVED, (proved.lower, proved.upper, proved.proof), strict=True)
    columns |= {name: [value] * len(columns["p"]) for name, value in bounds}
    return Result(chosen, columns, (chosen.describe(), line), tuple(filter(None, notes)))


def entropy_of_rows(subset: WholePeriods) -> Result:
    """Return the topological entropy by period of orbits that were already read (`Subset.entropy`)."""
    read = with_lower(subset.selection) if subset.lower else subset.selection
    columns, notes = _entropy(subset.cycles(), subset.periods, subset.shown, subset.why_missing(), read)
    return Result(subset.selection, columns, (subset.selection.describe(),), notes)


def _entropy(
    cycles: Integers, periods: Sequence[int], shown: Sequence[int], lacking: str, chosen: Selection
) -> tuple[dict[str, list[Any]], tuple[str, ...]]:
    """Return the columns of the entropy by period, and notes, given the number of orbits of each period.

    The counts of `periods` are complete; the `shown` ones among them have rows.
    """
    estimates = by_period.entropy_of_counts(cycles)
    columns = {"p": estimates.p.tolist()}
    columns |= standing(estimates.p, {"N": estimates.N, "K_0": estimates.K_0}, of_divisors, periods)
    zeta = {"h_zeta": estimates.h_zeta, "h_zeta_change": estimates.h_zeta_change}
    columns |= standing(estimates.p, zeta, every_period, periods)
    return rows_of(columns, shown), notes_on_missing(estimates, periods, shown, lacking, chosen)


def _uncounted(moment: Moment, chosen: Selection) -> list[str]:
    """Return a note on periods known only from births, which count all orbits but not those of a subset."""
    if all_orbits(chosen):
        return []
    if not (born := count(moment, Selection(chosen.a, chosen.periods)).from_births):
        return []
    return [
        f"births give the number of all orbits of {written_periods(born)} at a = {exact(chosen.a)}, not of "
        "the chosen ones: choose by periods alone, or fill these periods"
    ]


def stored_enclosure(moment: Moment, a: float) -> tuple[EntropyBounds, str] | None:
    """Return the tightest stored bounds on the entropy, if any, and a line that describes them.

    The line also gives the tightest bounds that are proved in ball arithmetic.
    """
    closest = tightest_bounds(moment, a)
    if closest is None:
        return None
    line = f"entropy of all orbits: {closest.between}, proved by {closest.basis}"
    surer = None if closest.proof == BALLS else tightest_bounds(moment, a, BALLS)
    return closest, line + ("" if surer is None else f"; {surer.between} by {surer.basis}")


def enclosure(moment: Moment, a: float) -> tuple[EntropyBounds, str]:
    """Return the tightest stored bounds on the entropy, or better new ones, and a line about them."""
    stored = stored_enclosure(moment, a)
    if stored is not None and stored[0].window >= _EDGES:
        return stored
    computed = _computed_bounds(a)
    if stored is not None and stored[0].width <= computed.width:
        return stored
    closer = f"'orbitdb bounds --a {exact(a)}' finds tighter ones"
    return computed, f"entropy of all orbits: {computed.between}, proved by {computed.basis}; {closer}"


@cache
def _computed_bounds(a: float) -> EntropyBounds:
    """Compute bounds on the entropy; the cache keeps them for the next question."""
    *_, last = search(Stadium(a), _EDGES)
    return last


def outside(
    periods: Sequence[int], h_zeta: Sequence[float | None], found: EntropyBounds, chosen: Selection
) -> str:
    """Return a note that names the periods whose h_zeta lies outside the bounds on the entropy of all orbits.

    Return '' if there are none, or if only some orbits are chosen. Values of h_zeta may be None or NaN.
    """
    known = [(p, h) for p, h in zip(periods, h_zeta, strict=True) if h is not None]
    beyond = [p for p, h in known if h < found.lower or h > found.upper]
    if not (beyond and all_orbits(chosen)):
        return ""
    return f"h_zeta lies outside the proved bounds at {written_periods(beyond)}"
