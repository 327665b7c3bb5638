"""Say up to where an answer is complete, and what it lacks: periods not filled or only in part, and births.

What is not filled never counts as zero: every list, count or average comes with a note.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

from orbitdb.answers.counts import Counted
from orbitdb.numerals import exact
from orbitdb.orbits.least_values import least_length
from orbitdb.store.asking.conditions import asks_of_lives
from orbitdb.store.asking.selection import Selection, are_many, joined_spans, written_periods, written_spans
from orbitdb.store.file.database import driver
from orbitdb.store.reading.fills import Fill
from orbitdb.store.reading.lookup import a_stored
from orbitdb.store.reading.moment import Moment
from orbitdb.symbols.enumeration import MAX_PERIOD

_USUAL = 11
"""The highest period of a first fill, in messages."""

_SHOWN = 6
"""Most values of a in a message."""

_SINGLE = "'orbitdb fill --code WORD' stores single words"


def gaps(
    moment: Moment,
    chosen: Selection,
    left_out: bool = False,
    counted: Counted | None = None,
    names: Sequence[str] = (),
    order: str = "p",
) -> list[str]:
    """Return a line each on the chosen periods that are partial, not filled, or lack births that matter.

    Another line names those that are counted from births or a sweep, which are complete. `left_out` says that
    the result leaves out partial periods. Births matter if the subset, the columns `names` or the order of
    rows depends on them.
    """
    said: list[str | None] = []
    rest: Selection | None = chosen
    partial = partial_fills(moment, chosen)
    if counted is not None and counted.without_rows:
        said.append(counted.describe())
        partial = [fill for fill in partial if fill.p not in counted.without_rows]
        rest = without(chosen, counted.chosen)
    if partial:
        said.append(describe_partial(partial, chosen.a, left_out))
    said.append(None if rest is None else unfilled(moment, rest))
    said.append(lacking_births(moment, chosen, names, order))
    return [line for line in said if line]


def partial_fills(moment: Moment, chosen: Selection) -> list[Fill]:
    """Return the chosen periods that are stored in part; rows, classes and counts include them."""
    return [fill for fill in moment.fills(chosen.a) if not fill.whole and chosen.includes(fill.p)]


def unfilled(moment: Moment, chosen: Selection) -> str | None:
    """Return a line on the chosen periods that are not filled (`describe_unfilled`)."""
    elsewhere = a_stored(driver(moment.connection), ["fill"])
    return describe_unfilled(moment.fills(chosen.a), chosen.periods, chosen.a, elsewhere)


def lacking_births(
    moment: Moment, chosen: Selection, names: Sequence[str] = (), order: str = "p"
) -> str | None:
    """Return a line on the chosen periods without stored births, if births matter."""
    return describe_lacking(without_births(moment, chosen, names, order))


def without_births(
    moment: Moment, chosen: Selection, names: Sequence[str] = (), order: str = "p"
) -> list[int]:
    """Return the chosen periods that are filled, but without stored births, if births matter."""
    if not asks_of_lives(chosen, names, order):
        return []
    filled = [fill.p for fill in moment.fills(chosen.a) if chosen.includes(fill.p)]
    born = {each.p for each in moment.birth_fills() if each.whole}
    return [p for p in filled if p <= MAX_PERIOD and p not in born]


def without(chosen: Selection, known: tuple[int, ...]) -> Selection | None:
    """Return a subset without some of its periods; None if none is left."""
    within, beyond = _missing(chosen.periods, known)
    spans = (*((p, p) for p in within), *beyond)
    return replace(chosen, periods=spans) if spans else None


def _missing(
    asked: Sequence[tuple[int, int]], known: Collection[int]
) -> tuple[list[int], list[tuple[int, int]]]:
    """Return the unknown periods in some ranges, and the parts of ranges that no fill can reach."""
    within = [p for p in range(2, MAX_PERIOD + 1) if any(low <= p <= high for low, high in asked)]
    beyond = [(max(low, MAX_PERIOD + 1), high) for low, high in asked if high > MAX_PERIOD]
    return [p for p in within if p not in known], beyond


def nothing(moment: Moment, chosen: Selection, swept: bool = False) -> list[str]:
    """Say that a subset is empty, if at least one of its periods is filled or swept."""
    missing = unfilled(moment, chosen)
    if missing and not swept and not any(chosen.includes(fill.p) for fill in moment.fills(chosen.a)):
        return []
    lacking = missing or lacking_births(moment, chosen) or partial_fills(moment, chosen)
    return [f"no {chosen.describe()}{' in what is stored' if lacking else ''}"]


def complete_length(fills: Sequence[Fill], chosen: Selection) -> float | None:
    """Return the length up to which no chosen orbit is missing, by proof, in units of the radius.

    None unless at least period 2 is filled without unresolved words.
    """
    whole = [fill.p for fill in fills if fill.whole and not fill.unresolved and chosen.includes(fill.p)]
    highest = 1
    while highest + 1 in whole:
        highest += 1
    return least_length(highest, chosen.a) if highest > 1 else None


def describe_complete(complete: float | None) -> str:
    """Say up to which length, rounded down, a list of orbits is complete."""
    if complete is None:
        return "orbits of any length may be missing: fill all periods from 2 on"
    end = math.floor(complete * 100) / 100
    return f"complete, by proof, up to length {end:.2f}; longer orbits may be missing"


def describe_lacking(periods: Sequence[int]) -> str | None:
    """Name periods without stored births, and the command that finds them; None without periods."""
    if not periods:
        return None
    return (
        f"births of {written_periods(periods)} are not stored, so what depends on them is left out or "
        f"blank: 'orbitdb births --p {max(periods)}' finds them"
    )


def describe_fills(fills: Sequence[Fill], a: float) -> str:
    """Say in a few words what is filled at one a."""
    whole, partial = ([fill.p for fill in fills if fill.whole is state] for state in (True, False))
    parts = [written_periods(whole)] if whole else []
    parts += [f"{written_periods(partial)} in part"] if partial else []
    return f"{' and '.join(parts) or 'no whole period'} at a = {exact(a)}"


def describe_partial(fills: Sequence[Fill], a: float, left_out: bool = False) -> str:
    """Name periods that are stored in part, and the command that completes them."""
    many = len(fills) > 1
    periods = ", ".join(str(fill.p) for fill in fills)
    return (
        f"period{'s' * many} {periods} at a = {exact(a)} {'are' if many else 'is'} partial"
        f"{' and left out' * left_out}: a fill is running or was stopped; "
        f"'orbitdb fill --p {max(fill.p for fill in fills)} --a {exact(a)}' completes "
        f"{'them' if many else 'it'}"
    )


def describe_unfilled(
    known: Sequence[Fill], periods: Sequence[tuple[int, int]], a: float, filled_at: Sequence[float]
) -> str | None:
    """Name the chosen periods that are not filled, those that are, and the command that fills the others.

    None if nothing is missing. Partial periods do not count as missing, nor do those below 2, which have no
    words. Without ranges, whatever is filled is chosen. `filled_at` are the values of a with fills.
    """
    if not periods and known:
        return None
    gaps, beyond = _missing(periods or [(2, _USUAL)], {fill.p for fill in known})
    if not gaps and not beyond:
        return None
    spans = joined_spans([*((p, p) for p in gaps), *beyond])
    verb = "are" if are_many(spans) else "is"
    what = f"{written_spans(spans)} {verb} not filled" if periods else "nothing is filled"
    command = f"'orbitdb fill --p {gaps[-1]} --a {exact(a)}'" if gaps else ""
    remedy = f"{command} fills {written_spans(spans) if not periods else 'them' if are_many(spans) else 'it'}"
    if beyond:
        remedy = f"fills go up to period {MAX_PERIOD}{f' ({command})' if gaps else ''}, {_SINGLE}"
    return f"{what} at a = {exact(a)}{_filled(known, a, filled_at)}: {remedy}"


def _filled(known: Sequence[Fill], a: float, filled_at: Sequence[float]) -> str:
    """Say in parentheses what is filled at this a, and which other a have fills; empty if nothing is."""
    here = joined_spans([(fill.p, fill.p) for fill in known if fill.whole])
    others = sorted((other for other in filled_at if other != a), key=lambda other: abs(other - a))
    parts = [written_spans(here)] if here else []
    if others:
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        parts.append(f"some at a = {', '.join(map(exact, sorted(others[:_SHOWN])))}{more}")
    return f" (filled: {'; '.join(parts)})" if parts else ""
