"""Averages and counts by period over a chosen subset: `Catalogue.entropy`, `.lyapunov` and `.table`."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.answers.counts import count
from orbitdb.answers.gaps import gaps, nothing
from orbitdb.answers.methods import AVERAGES, Given
from orbitdb.answers.results import PROVED, TABLE, TRAJECTORIES, UP_TO_CUT, Result
from orbitdb.answers.whole_periods import (
    WholePeriods,
    all_orbits,
    read_whole,
    why_missing,
    why_no_sum_rules_of,
)
from orbitdb.averages import by_period, pseudocycles
from orbitdb.averages.by_period import faults_of, standing
from orbitdb.averages.exact_means import exact_means
from orbitdb.averages.fixed_points import Weight, divisors, every_period, of_divisors
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import BALLS, EntropyBounds, search
from orbitdb.errors import InputError
from orbitdb.numerals import exact, with_error
from orbitdb.orbits.least_values import least_exponent
from orbitdb.orbits.status import Status
from orbitdb.orbits.sums import Tally
from orbitdb.store.asking.periods import written_periods
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import why_not_swept
from orbitdb.store.reading.moment import Moment

_EDGES = 10
"""Length of the windows decided if no bounds are stored; takes up to half a second, at small a."""

_LARGEST_CUT = 1000
MOST_FACTORS = 100_000


def table(moment: Moment, chosen: Selection) -> Result:
    """Return the paper's Table 1 (`Catalogue.table`)."""
    counted = count(moment, chosen)
    notes = gaps(moment, chosen, left_out=True, counted=counted)
    for p in counted.chosen:
        if missing := sorted(of_divisors(p) - counted.known.keys()):
            notes.append(f"p = {p}: N needs p = {', '.join(map(str, missing))}: not filled")
    if not counted.chosen and not notes:
        notes = [f"no {chosen.describe()}"]
    known = stored_enclosure(moment, chosen.a) if counted.chosen else None
    columns = _table(counted.chosen, counted.known)
    return Result(chosen, columns, () if known is None else (known[1],), tuple(notes))


def table_of_rows(
    chosen: Selection, filled: Sequence[int], p: Any, status: Any, representative: Any
) -> Result:
    """Return counts by period of rows already read (`Subset.table`)."""
    known = {}
    for order in filled:
        here, least = status[p == order], representative[p == order]
        orbits = here == Status.ORBIT.value
        apart = (int((here == each.value).sum()) for each in (Status.BOUNDARY, Status.UNRESOLVED))
        known[order] = Tally(len(here), int(orbits.sum()), len(set(least[orbits].tolist())), *apart)
    return Result(chosen, _table(filled, known), (chosen.describe(),))


def _table(periods: Sequence[int], known: Mapping[int, Tally]) -> dict[str, list[Any]]:
    """Return the columns of Table 1 for some periods, from the counts of these periods and their divisors."""
    rows = []
    for p in periods:
        here, whole = known[p], known.keys() >= of_divisors(p)
        points = sum(d * known[d].n_c for d in divisors(p) if d > 1) if whole else None
        entropy = math.log(points) / p if points else None
        rows.append((p, here.words, here.n_c, points, entropy, here.classes, here.boundary, here.unresolved))
    return {name: [row[place] for row in rows] for place, name in enumerate(TABLE)}


def entropy_of_rows(subset: WholePeriods) -> Result:
    """Return the topological entropy by period of orbits already read (`Subset.entropy`)."""
    columns, notes = _entropy(subset.cycles(), subset.periods, subset.why_missing(), subset.selection)
    return Result(subset.selection, columns, (subset.selection.describe(),), notes)


def lyapunov_of_rows(subset: WholePeriods, weight: str = "exp") -> Result:
    """Return the average Lyapunov exponents by period of orbits already read (`Subset.averages`)."""
    notes: list[str] = []
    columns = averages(subset, _weight(weight), notes)
    return Result(subset.selection, columns, (subset.selection.describe(),), tuple(filter(None, notes)))


def entropy(moment: Moment, chosen: Selection) -> Result:
    """Return the topological entropy by period, from rows or else from counts (`Catalogue.entropy`)."""
    if all_orbits(chosen) and (counted := count(moment, chosen)).without_rows:
        notes = gaps(moment, chosen, left_out=True, counted=counted)
        lacking = why_missing(sorted(every_period(max(counted.chosen)).difference(counted.chosen)), chosen)
        chosen = replace(chosen, statuses=(Status.ORBIT,))
        columns, told = _entropy(counted.cycles(), counted.chosen, lacking, chosen)
    else:
        notes = _uncounted(moment, chosen)
        subset = read(moment, chosen, notes, swept=True)
        if subset is None:
            return Result(chosen, {}, (), tuple(notes))
        chosen = subset.selection
        columns, told = _entropy(subset.cycles(), subset.periods, subset.why_missing(), chosen)
    proved, line = enclosure(moment, chosen.a)
    notes += [outside(columns["p"], columns["h_zeta"], proved, chosen), *told]
    bounds = zip(PROVED, (proved.lower, proved.upper, proved.proof), strict=True)
    columns |= {name: [value] * len(columns["p"]) for name, value in bounds}
    return Result(chosen, columns, (chosen.describe(), line), tuple(filter(None, notes)))


def _entropy(
    cycles: NDArray[np.int64], periods: Sequence[int], lacking: str, chosen: Selection
) -> tuple[dict[str, list[Any]], tuple[str, ...]]:
    """Return the entropy of whole periods from the counts of their orbits, and notes on it."""
    found = by_period.entropy_of_counts(cycles)
    columns = {"p": found.p.tolist()}
    columns |= standing(found.p, {"N": found.N, "K_0": found.K_0}, of_divisors, periods)
    zeta = {"h_zeta": found.h_zeta, "h_zeta_change": found.h_zeta_change}
    columns |= standing(found.p, zeta, every_period, periods)
    return _of_periods(columns, periods), _told(found, periods, lacking, chosen)


def _told(
    found: by_period.Entropy | by_period.Lyapunov, periods: Sequence[int], lacking: str, chosen: Selection
) -> tuple[str, ...]:
    """Name the periods that the zeta function or the sums over fixed points lack."""
    divided = [
        f"p = {p}: the sums over fixed points lack p = {why_missing(gone, chosen)}"
        for p in periods
        if (gone := sorted(of_divisors(p).difference(periods)))
    ]
    zeta = f"the zeta function lacks p = {lacking}" if lacking else ""
    return tuple(filter(None, [zeta, faults_of(found, periods), *divided]))


def _weight(name: str) -> Weight:
    if name not in set(Weight):
        raise InputError(f"weight {name!r}: use {' or '.join(Weight)}")
    return Weight(name)


def lyapunov(
    moment: Moment,
    chosen: Selection,
    weight: str = "exp",
    cut: float | None = None,
    tell: Callable[[float], None] = lambda done: None,
) -> Result:
    """Return the average Lyapunov exponents by period, or one up to a cut (`Catalogue.lyapunov`)."""
    wanted, notes = _weight(weight), list[str]()
    subset = read(moment, chosen, notes, swept=cut is None)
    if subset is None:
        return Result(chosen, {}, (), tuple(notes))
    if cut is not None:
        return _up_to(subset, cut, wanted, notes, tell)
    reference, facts = moment.reference(chosen.a), [subset.selection.describe()]
    if reference is None:
        a = exact(chosen.a)
        notes.append(f"no trajectory value at a = {exact(chosen.a)}: 'orbitdb simulate --a {a}' makes one")
    else:
        told = (f"{name} = {with_error(getattr(reference, name), getattr(reference, f'{name}_error'))}"
                for name in ("lambda_d", "lambda_c"))  # fmt: skip
        facts.append(f"trajectories: {', '.join(told)}")
    columns = averages(subset, wanted, notes)
    for name in TRAJECTORIES if reference is not None else ():
        columns[f"{name}_trajectory"] = [getattr(reference, name)] * len(columns["p"])
    facts.append(_without_orbits(chosen.a))
    return Result(subset.selection, columns, tuple(facts), tuple(filter(None, notes)))


def averages(subset: WholePeriods, weight: Weight, notes: list[str]) -> dict[str, list[Any]]:
    """Return the averages of every method over whole periods; add a note on what is missing."""
    given = Given(subset, weight)
    p = given.sums.p
    columns: dict[str, list[Any]] = {"p": p.tolist()}
    for average in AVERAGES:
        columns |= {name: [None] * len(p) for name in average.columns}
        columns |= standing(p, average.compute(given), average.needs, subset.periods)
    notes.append(why_no_sum_rules_of(subset))
    notes += _told(given.sums, subset.periods, subset.why_missing(), subset.selection)
    return _of_periods(columns, subset.periods)


def _of_periods(columns: Mapping[str, list[Any]], periods: Sequence[int]) -> dict[str, list[Any]]:
    """Keep the rows of whole periods."""
    kept = [place for place, p in enumerate(columns["p"]) if p in periods]
    return {name: [values[place] for place in kept] for name, values in columns.items()}


def read(moment: Moment, chosen: Selection, notes: list[str], swept: bool) -> WholePeriods | None:
    """Return the chosen classes of whole periods, None without any; add notes on what is left out."""
    subset = read_whole(moment, chosen, swept)
    notes += gaps(moment, chosen, left_out=True, counted=subset.counted() if subset.swept else None)
    if len(subset.classes) or any(np.isfinite(sums.ranges).all() for sums in subset.swept.values()):
        return subset
    notes += nothing(moment, subset.selection, swept=bool(subset.swept))
    return None


def _uncounted(moment: Moment, chosen: Selection) -> list[str]:
    """Explain that births count all orbits of a period, but not those of a subset."""
    if all_orbits(chosen):
        return []
    known = [] if why_not_swept(chosen) else [s.p for s in moment.sweeps(chosen.a, chosen) if s.whole]
    born = count(moment, Selection(chosen.a, chosen.periods)).from_births
    if not (born := tuple(p for p in born if p not in known)):
        return []
    return [
        f"births tell how many orbits of {written_periods(born)} there are at a = {exact(chosen.a)}, "
        "but not which of them are chosen: leave out all but --p, or fill them"
    ]


def _without_orbits(a: float) -> str:
    """Give the bounds on the exponents that follow from exact means, without any orbit."""
    low, high = exact_means(a).bounds
    scales = (("lambda_d", Stadium(a).legs_per_bounce), ("lambda_c", Stadium(a).legs_per_length))
    ranges = (f"{low * scale:.6f} < {name} < {high * scale:.6f}" for name, scale in scales)
    return f"by exact means, without any orbit: {', '.join(ranges)}"


def _up_to(
    subset: WholePeriods, cut: float, weight: Weight, notes: list[str], tell: Callable[[float], None]
) -> Result:
    """Return one average over all pseudo-cycles up to a cut."""
    if not 0 < cut <= _LARGEST_CUT:
        raise InputError(f"cut {cut:g}: give a lambda above 0 and up to {_LARGEST_CUT}, such as 9")
    rows, a = subset.classes.rows(), subset.selection.a
    if weight is Weight.DETERMINANT and (most := pseudocycles.largest_cut(rows, cut, MOST_FACTORS)) < cut:
        raise InputError(f"cut {cut:g} has too many terms with --weight det: give {most:g} or less")
    found = pseudocycles.lyapunov_by_stability(rows, cut, subset.highest, weight, tell)
    if subset.missing:
        notes.append(f"the zeta function lacks p = {subset.why_missing()}")
    else:
        notes.append(f"the zeta function gives no average {found.fault}" if found.fault else "")
        complete = math.floor(least_exponent(subset.highest, a) * 1000) / 1000
        if cut > complete:
            notes.append(
                f"complete, by proof, up to lambda = {complete:.3f} at a = {exact(a)}: up to the cut "
                f"{cut:g}, orbits of periods above {subset.highest} may be missing, and the average changes "
                "with them"
            )
    values = (found.lambda_d, found.lambda_c, found.mean_path, found.z0)
    row = [cut, *(None if subset.missing or value != value else value for value in values)]
    columns = {name: [value] for name, value in zip(UP_TO_CUT, row, strict=True)}
    return Result(subset.selection, columns, (subset.selection.describe(),), tuple(filter(None, notes)))


def stored_enclosure(moment: Moment, a: float) -> tuple[EntropyBounds, str] | None:
    """Return the closest stored bounds on the entropy at one a, and a line that describes them.

    If less close ones were proved in balls, the line gives those, too.
    """
    closest = moment.entropy_bounds(a)
    if closest is None:
        return None
    line = f"entropy of all orbits: {closest.between}, proved by {closest.basis}"
    surer = None if closest.proof == BALLS else moment.entropy_bounds(a, BALLS)
    return closest, line + ("" if surer is None else f"; {surer.between} by {surer.basis}")


def enclosure(moment: Moment, a: float) -> tuple[EntropyBounds, str]:
    """Return the closest stored bounds on the entropy at one a, or bounds found now, and a line on them."""
    if (known := stored_enclosure(moment, a)) is not None:
        return known
    found = _found_now(a)
    closer = f"'orbitdb bounds --a {exact(a)}' finds closer ones"
    return found, f"entropy of all orbits: {found.between}, proved by {found.basis}; {closer}"


@cache
def _found_now(a: float) -> EntropyBounds:
    """Find bounds on the entropy at one a, and keep them for the next average."""
    *_, last = search(Stadium(a), _EDGES)
    return last


def outside(
    periods: Sequence[int], h_zeta: Sequence[float | None], found: EntropyBounds, chosen: Selection
) -> str:
    """Name the periods at which h_zeta of all orbits lies outside the bounds.

    Empty if there are none, or if the bounds do not apply to the chosen subset. h_zeta may be None or NaN.
    """
    known = [(p, h) for p, h in zip(periods, h_zeta, strict=True) if h is not None]
    beyond = [p for p, h in known if h < found.lower or h > found.upper]
    if not (beyond and all_orbits(chosen)):
        return ""
    return f"h_zeta lies outside the proved bounds at {written_periods(beyond)}"
