"""The counts of complete periods at any a, and notes on what an answer lacks: periods, and births.

Missing data never count as zero. Instead, a note with every list, count or average says what is missing.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.arrays import Integers
from orbitdb.orbits.least_values import largest_least_length, least_length, least_limit_of_lengths
from orbitdb.orbits.status import Status
from orbitdb.store.connection import Moment
from orbitdb.store.fills import Fill, read_fills, read_sweeps
from orbitdb.store.lives import counts_at, read_birth_fills
from orbitdb.store.lookup import a_values
from orbitdb.store.query import asks_of_lives
from orbitdb.store.selection import (
    Selection,
    SelectionError,
    are_many,
    joined_spans,
    written_periods,
    written_spans,
)
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.pruning import count_admissible, count_primitive
from orbitdb.text import exact

if TYPE_CHECKING:
    from orbitdb.orbits.exponents import Tally

_COUNTS = ("n_t", "n_c", "classes", "boundary", "unresolved")
"""The columns of a fill that make up a `Tally`, in the order of its fields."""

_USUAL = 11
"""Highest period of the first fill that messages suggest."""

_SHOWN = 6
"""Maximum number of values of a to list in a message."""

_SINGLE = "'orbitdb fill --code WORD' stores single words"


@dataclass(frozen=True)
class Counted:
    """Counts of the words and orbits of complete periods at a given a.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    known : dict of int to Tally
        Counts by period, including periods that are not chosen but are needed in sums over divisors.
    chosen : tuple of int
        The chosen periods in `known`.
    from_births, from_sweeps : tuple of int
        The chosen periods that are not filled and were counted from births, or by a sweep, instead.
    """

    a: float
    known: Mapping[int, "Tally"]
    chosen: tuple[int, ...]
    from_births: tuple[int, ...]
    from_sweeps: tuple[int, ...] = ()

    @property
    def without_rows(self) -> tuple[int, ...]:
        """The chosen periods that were counted without a fill."""
        return self.from_sweeps + self.from_births

    def cycles(self) -> Integers:
        """Return the number of orbits of each period from 0 to the highest chosen one; 0 where unknown."""
        numbers = np.zeros(max(self.chosen) + 1, dtype=np.int64)
        for p in self.chosen:
            numbers[p] = self.known[p].n_c
        return numbers

    def describe(self) -> str | None:
        """Return a line that says how the periods without a fill were counted; None if there are none."""
        sources = {"counted by a sweep, without stored rows": self.from_sweeps,
                   "counted from births, without a fill": self.from_births}  # fmt: skip
        told = [
            f"{written_periods(periods)} at a = {exact(self.a)}: {source}"
            for source, periods in sources.items()
            if periods
        ]
        return "; ".join(told) or None


def count(moment: Moment, selection: Selection) -> Counted:
    """Return the counts of each chosen period: from its fill, else from a sweep, else from births."""
    known = {fill.p: _tally(fill) for fill in read_fills(moment, selection.a) if fill.whole}
    swept = {
        each.p: each.tally for each in read_sweeps(moment, selection.a) if each.whole and each.p not in known
    }
    known |= swept
    born = [each.p for each in read_birth_fills(moment) if each.whole and each.p not in known]
    wanted = [p for p in born if selection.includes(p)]
    chosen = sorted(p for p in (*known, *wanted) if selection.includes(p))
    needed = {p for p in born if any(multiple % p == 0 for multiple in chosen)}
    known.update((p, counts_at(moment, selection.a, p)) for p in needed)
    return Counted(selection.a, dict(sorted(known.items())), tuple(chosen), tuple(wanted),
                   tuple(p for p in swept if selection.includes(p)))  # fmt: skip


def need_periods_alone(chosen: Selection) -> None:
    """Raise `SelectionError` if a selection has criteria other than ``a`` and periods."""
    if chosen != Selection(chosen.a, chosen.periods):
        raise SelectionError(
            "a table counts all words of its periods: give only a and p, or count the rows of a subset "
            "with select(...).table()"
        )


def _tally(fill: Fill) -> "Tally":
    """Return the counts of a filled period."""
    from orbitdb.orbits.exponents import Tally

    return Tally(*(getattr(fill, name) for name in _COUNTS))


def gaps(
    moment: Moment,
    chosen: Selection,
    left_out: bool = False,
    counted: Counted | None = None,
    names: Sequence[str] = (),
    order: str = "p",
) -> list[str]:
    """Return one line for each kind of gap: chosen periods that are partial, not filled, or without births.

    Births matter only if the subset, the columns `names` or the order of the rows depends on them. Another
    line names the periods that were counted from births or a sweep; these are complete. Set `left_out` if the
    result leaves out partial periods.
    """
    said: list[str | None] = [pruned_not_stored(moment, chosen)]
    if chosen.statuses == (Status.GEOMETRIC,):  # fills do not store these words
        return [line for line in said if line]
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
    """Return the fills of the chosen periods that are only partly stored; lists include their words."""
    return [fill for fill in read_fills(moment, chosen.a) if not fill.whole and chosen.includes(fill.p)]


def unfilled(moment: Moment, chosen: Selection) -> str | None:
    """Return a line that names the chosen periods that are not filled, or None (`describe_unfilled`)."""
    elsewhere = a_values(moment, ["fill"])
    return describe_unfilled(read_fills(moment, chosen.a), chosen.periods, chosen.a, elsewhere)


def pruned_not_stored(moment: Moment, chosen: Selection) -> str | None:
    """Return a line that names chosen periods without stored geometrically pruned words, or None."""
    if Status.GEOMETRIC not in chosen.statuses:
        return None
    stored = {p for (p,) in moment.execute("SELECT DISTINCT p FROM pruned")}
    filled = [(fill.p, fill.p) for fill in read_fills(moment, chosen.a) if fill.whole]
    periods, _ = _missing(chosen.periods or filled or [(2, _USUAL)], stored)
    if not periods:
        return None
    there = sum(count_primitive(p) - count_admissible(p) for p in periods)
    are = "are" if there > 1 else "is"
    first = f" --from {periods[0]}" if periods[0] > 2 else ""
    return (
        f"geometrically pruned words of {written_periods(periods)} are not stored (there {are} {there}): "
        f"'orbitdb fill --p {periods[-1]}{first} --geometric' stores them"
    )


def lacking_births(
    moment: Moment, chosen: Selection, names: Sequence[str] = (), order: str = "p"
) -> str | None:
    """Return a line that names the filled periods whose births are needed but not stored, or None."""
    return describe_lacking(without_births(moment, chosen, names, order))


def without_births(
    moment: Moment, chosen: Selection, names: Sequence[str] = (), order: str = "p"
) -> list[int]:
    """Return the chosen periods that are filled, but whose births are needed and not stored."""
    if not asks_of_lives(chosen, names, order):
        return []
    filled = [fill.p for fill in read_fills(moment, chosen.a) if chosen.includes(fill.p)]
    born = {each.p for each in read_birth_fills(moment) if each.whole}
    return [p for p in filled if p <= MAX_PERIOD and p not in born]


def without(chosen: Selection, known: tuple[int, ...]) -> Selection | None:
    """Return the subset without the `known` periods, or None if no period is left."""
    within, beyond = _missing(chosen.periods, known)
    spans = (*((p, p) for p in within), *beyond)
    return replace(chosen, periods=spans) if spans else None


def _missing(
    asked: Sequence[tuple[int, int]], known: Collection[int]
) -> tuple[list[int], list[tuple[int, int]]]:
    """Return the periods in the given ranges that are not `known`, and the parts above `MAX_PERIOD`."""
    within = [p for p in range(2, MAX_PERIOD + 1) if any(low <= p <= high for low, high in asked)]
    beyond = [(max(low, MAX_PERIOD + 1), high) for low, high in asked if high > MAX_PERIOD]
    return [p for p in within if p not in known], beyond


def nothing(moment: Moment, chosen: Selection, swept: bool = False) -> list[str]:
    """Return a message that a subset is empty, or [] if none of its periods is filled or swept."""
    if chosen.statuses == (Status.GEOMETRIC,):
        return [] if pruned_not_stored(moment, chosen) else [f"no {chosen.describe()}"]
    missing = unfilled(moment, chosen)
    if missing and not swept and not any(chosen.includes(fill.p) for fill in read_fills(moment, chosen.a)):
        return []
    lacking = missing or lacking_births(moment, chosen) or partial_fills(moment, chosen)
    return [f"no {chosen.describe()}{' among the stored words' if lacking else ''}"]


def highest_filled(fills: Sequence[Fill], chosen: Selection) -> int:
    """Return the highest p such that 2 to p are chosen, filled and without unresolved words; or 1."""
    filled = {fill.p for fill in fills if fill.whole and not fill.unresolved and chosen.includes(fill.p)}
    highest = 1
    while highest + 1 in filled:
        highest += 1
    return highest


def complete_length(fills: Sequence[Fill], chosen: Selection) -> float | None:
    """Return the length, in units of the radius, up to which it is proved that no chosen orbit is missing.

    Return None unless at least period 2 is filled and has no unresolved words.
    """
    highest = highest_filled(fills, chosen)
    return least_length(highest, chosen.a) if highest > 1 else None


def describe_complete(complete: float | None, chosen: Selection) -> str:
    """Return a line that says up to which length, rounded down, a list of orbits is complete.

    For a list of all orbits, it also says how far such proofs can reach, and where no list can be complete.
    """
    if complete is None:
        return "orbits of any length may be missing: fill all periods from 2 on"
    end = math.floor(complete * 100) / 100
    line = f"complete, by proof, up to length {end:.2f}; longer orbits may be missing"
    plain = replace(chosen, periods=(), statuses=(), ranges={}) == Selection(chosen.a)
    if not plain or chosen.statuses not in ((), (Status.ORBIT,)) or chosen.ranges.keys() - {"length"}:
        return line
    most = math.floor(largest_least_length(chosen.a) * 100) / 100
    reach = "no further period proves more" if most == end else f"further periods prove {most:.2f} at most"
    limit = math.ceil(least_limit_of_lengths(chosen.a) * 100) / 100
    return f"{line} ({reach}; infinitely many are shorter than 4a + 2 pi = {limit:.2f})"


def describe_lacking(periods: Sequence[int]) -> str | None:
    """Return a line that names periods without births, and a command to find them; None if there are none."""
    if not periods:
        return None
    return (
        f"births of {written_periods(periods)} are not stored, so what depends on them is left "
        f"out or blank: 'orbitdb births --p {max(periods)}' finds them"
    )


def describe_fills(fills: Sequence[Fill], a: float) -> str:
    """Return a short text that says which periods are filled at the given a."""
    whole, partial = ([fill.p for fill in fills if fill.whole is state] for state in (True, False))
    parts = [written_periods(whole)] if whole else []
    parts += [f"part of {written_periods(partial)}"] if partial else []
    return f"{' and '.join(parts) or 'no complete period'} at a = {exact(a)}"


def describe_partial(fills: Sequence[Fill], a: float, left_out: bool = False) -> str:
    """Return a line that names periods that are only partly stored, and the command that completes them."""
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
    """Return a line that says which chosen periods are not filled, which are, and how to fill the others.

    Return None if no period is missing. Partial periods do not count as missing, nor do periods below 2,
    which have no words. If `periods` is empty, all filled periods are chosen. `filled_at` lists every a that
    has fills.
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
        remedy = f"fills go up to period {MAX_PERIOD}{f' ({command})' if gaps else ''}; {_SINGLE}"
    return f"{what} at a = {exact(a)}{_filled(known, a, filled_at)}: {remedy}"


def _filled(known: Sequence[Fill], a: float, filled_at: Sequence[float]) -> str:
    """Return, in parentheses, which periods are filled at this a and which other a have fills, or ''."""
    whole = joined_spans([(fill.p, fill.p) for fill in known if fill.whole])
    others = sorted((other for other in filled_at if other != a), key=lambda other: abs(other - a))
    parts = [written_spans(whole)] if whole else []
    if others:
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        parts.append(f"some at a = {', '.join(map(exact, sorted(others[:_SHOWN])))}{more}")
    return f" (filled: {'; '.join(parts)})" if parts else ""
