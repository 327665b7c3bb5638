"""The counts of complete periods at any a, and notes on what an answer lacks: periods, and births.

Missing data never count as zero. Instead, a note with every list, count or average says what is missing.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.arrays import Integers
from orbitdb.errors import AlteredError, InputError, NotStoredError
from orbitdb.orbits.least_values import largest_least_length, least_length, least_limit_of_lengths
from orbitdb.orbits.status import Status
from orbitdb.store.lives import counts_at
from orbitdb.store.lookup import WITH_ORBITS, a_values, default_among
from orbitdb.store.periods import Fill, read_birth_fills, read_fills, read_pruned_fills, read_sweeps
from orbitdb.store.select import asks_of_lives, parse_order
from orbitdb.store.selection import Selection, SelectionError, written_periods
from orbitdb.store.sqlite import DATABASE_ERRORS, Connection
from orbitdb.store.where import check, codes_are_texts, reads_codes
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.pruning import count_pruned, rules_of_pattern
from orbitdb.text import format_float, shortened

if TYPE_CHECKING:
    from orbitdb.orbits.exponents import Tally

_USUAL = 11
"""Highest period of the first fill that messages suggest."""

_SHOWN = 6
"""Maximum number of values of a to list in a message."""

_FEW = 4
"""Maximum number of values of a, beside the default one, whose fills are described in one line."""

LENGTHS = ("length", "quarter_length")
"""The lengths by which lists of orbits can be complete."""


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
    tallies: Mapping[int, "Tally"]
    chosen: tuple[int, ...]
    from_births: tuple[int, ...]
    from_sweeps: tuple[int, ...] = ()

    def cycles(self) -> Integers:
        """Return the number of orbits of each period from 0 to the highest chosen one; 0 where unknown."""
        numbers = np.zeros(max(self.chosen, default=0) + 1, dtype=np.int64)
        for p in self.chosen:
            numbers[p] = self.tallies[p].n_c
        return numbers


def counts(connection: Connection, selection: Selection) -> Counted:
    """Return the counts of each chosen period: from its fill, else from a sweep, else from births.

    Raises `SelectionError` if the selection has criteria other than a and periods.
    """
    if selection != Selection(selection.a, selection.periods):
        raise SelectionError(
            "a table counts all words of its periods: give only a and p, or count the rows of a subset "
            "with select(...).table()"
        )
    from orbitdb.orbits.exponents import Tally

    names = ("n_t", "n_c", "classes", "boundary", "unresolved")
    tallies = {
        fill.p: Tally(*(getattr(fill, name) for name in names))
        for fill in read_fills(connection, selection.a)
        if fill.complete
    }
    sweeps = [
        sweep for sweep in read_sweeps(connection, selection.a) if sweep.complete and sweep.p not in tallies
    ]
    tallies |= {sweep.p: sweep.tally for sweep in sweeps}
    born = [p for p in periods_with_births(connection) if p not in tallies]
    chosen = tuple(sorted(p for p in (*tallies, *born) if selection.includes(p)))
    needed = {p for p in born if any(multiple % p == 0 for multiple in chosen)}
    tallies |= {p: counts_at(connection, selection.a, p) for p in needed}
    swept = tuple(sweep.p for sweep in sweeps if selection.includes(sweep.p))
    counted = tuple(p for p in born if selection.includes(p))
    return Counted(selection.a, dict(sorted(tallies.items())), chosen, counted, swept)


def gaps(
    connection: Connection,
    chosen: Selection,
    left_out: bool = False,
    from_sweeps: Collection[int] = (),
    from_births: Collection[int] = (),
    names: Sequence[str] = (),
    order: str = "p",
    empty: bool = False,
) -> list[str]:
    """Return one line for each kind of gap: chosen periods that are partial, not filled, or without births.

    Periods counted from sweeps or births are complete, but get a line, too. Births matter only if the subset,
    the columns `names` or the order of the rows depends on them. Set `left_out` if the result leaves out
    partial periods, and `empty` if nothing was found, so that a line says so.
    """
    lines = [pruned_not_stored(connection, chosen)]
    if chosen.statuses != (Status.GEOMETRIC,):  # fills do not store these words
        counted = {*from_sweeps, *from_births}
        sources = {"counted by a sweep, without stored rows": from_sweeps,
                   "counted from births, without a fill": from_births}  # fmt: skip
        for source, periods in sources.items():
            if shown := sorted(p for p in periods if chosen.includes(p)):
                lines.append(f"{written_periods(shown)} at a = {format_float(chosen.a)}: {source}")
        partial = [p for p in partial_periods(connection, chosen) if p not in counted]
        lines.append(describe_partial(partial, chosen.a, left_out) if partial else None)
        lines.append(unfilled(connection, chosen, counted))
        lines.append(lacking_births(connection, chosen, names, order))
    lines.append(nothing(connection, chosen, swept=bool(from_sweeps)) if empty else None)
    return [line for line in lines if line]


def gaps_of_periods(connection: Connection, chosen: Sequence[Selection], everywhere: bool) -> list[str]:
    """Return the gaps at each a; where nothing is filled, only if periods are chosen and not `everywhere`.

    A file that cannot be read has none: the checks of `Catalogue.verify` report it.
    """
    lines = []
    try:
        for selection in chosen:
            if read_fills(connection, selection.a) or (selection.periods and not everywhere):
                swept = [sweep.p for sweep in read_sweeps(connection, selection.a)]
                lines += gaps(connection, selection, from_sweeps=swept)
    except (AlteredError, TypeError, ValueError, *DATABASE_ERRORS):
        return []
    return lines


def filled_periods(connection: Connection, chosen: Selection) -> list[int]:
    """Return the chosen periods that are completely filled, in ascending order."""
    return [fill.p for fill in read_fills(connection, chosen.a) if fill.complete and chosen.includes(fill.p)]


def periods_with_births(connection: Connection) -> list[int]:
    """Return the periods whose births and deaths are all stored, in ascending order."""
    return [fill.p for fill in read_birth_fills(connection) if fill.complete]


def partial_periods(connection: Connection, chosen: Selection) -> list[int]:
    """Return the chosen periods that are only partly stored; lists include their words."""
    return [
        fill.p for fill in read_fills(connection, chosen.a) if not fill.complete and chosen.includes(fill.p)
    ]


def describe_partial(periods: Sequence[int], a: float, left_out: bool = False) -> str:
    """Return a line that names periods that are only partly stored, and the command that completes them."""
    are, them = ("are", "them") if len(periods) > 1 else ("is", "it")
    return (
        f"{written_periods(periods)} at a = {format_float(a)} {are} partial{' and left out' * left_out}: "
        f"a fill is running or was stopped; 'orbitdb fill --p {max(periods)} --a {format_float(a)}' "
        f"completes {them}"
    )


def unfilled(connection: Connection, chosen: Selection, counted: Collection[int] = ()) -> str | None:
    """Return a line that names the chosen periods that are neither filled nor `counted`, or None."""
    elsewhere = a_values(connection, ["fill"])
    return describe_unfilled(read_fills(connection, chosen.a), chosen.periods, chosen.a, elsewhere, counted)


def describe_unfilled(
    fills: Sequence[Fill],
    periods: Sequence[tuple[int, int]],
    a: float,
    filled_at: Sequence[float],
    counted: Collection[int] = (),
) -> str | None:
    """Return a line that says which chosen periods are not filled, which are, and how to fill the others.

    Return None if no period is missing. Partial periods do not count as missing, nor do periods below 2,
    which have no words. If `periods` is empty, all filled periods are chosen. `filled_at` lists every a that
    has fills.
    """
    stored = {fill.p for fill in fills}.union(counted)
    if not periods and stored:
        return None
    lines = []
    if missing := _within(periods or [(2, _USUAL)], stored):
        named, (are, them) = written_periods(missing), ("are", "them") if len(missing) > 1 else ("is", "it")
        what, them = (f"{named} {are} not filled", them) if periods else ("nothing is filled", named)
        command = f"'orbitdb fill --p {missing[-1]} --a {format_float(a)}'"
        lines.append(f"{what} at a = {format_float(a)}{_filled(fills, a, filled_at)}: {command} fills {them}")
    if any(high > MAX_PERIOD for _, high in periods):
        if not lines:
            filled = _filled(fills, a, filled_at)
            lines.append(f"no period above {MAX_PERIOD} is filled at a = {format_float(a)}{filled}")
        lines.append(f"fills go up to period {MAX_PERIOD}: 'orbitdb fill --code WORD' stores single words")
    return "; ".join(lines) or None


def _filled(fills: Sequence[Fill], a: float, filled_at: Sequence[float]) -> str:
    """Return, in parentheses, which periods are filled at this a and which other a have fills, or ''."""
    whole = [fill.p for fill in fills if fill.complete]
    others = sorted((other for other in filled_at if other != a), key=lambda other: abs(other - a))
    parts = [written_periods(whole)] if whole else []
    if others:
        more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
        parts.append(f"some at a = {', '.join(map(format_float, sorted(others[:_SHOWN])))}{more}")
    return f" (filled: {'; '.join(parts)})" if parts else ""


def _within(spans: Sequence[tuple[int, int]], stored: Collection[int]) -> list[int]:
    """Return the periods in the given ranges that can be filled and are not stored."""
    periods = (p for p in range(2, MAX_PERIOD + 1) if any(low <= p <= high for low, high in spans))
    return [p for p in periods if p not in stored]


def pruned_not_stored(connection: Connection, chosen: Selection) -> str | None:
    """Return a line that names chosen periods without stored geometrically pruned words, or None."""
    if Status.GEOMETRIC not in chosen.statuses:
        return None
    begun = read_pruned_fills(connection)
    stored = [p for p, (_, whole) in begun.items() if whole]
    filled = [(p, p) for p in filled_periods(connection, chosen)]
    periods = _within(chosen.periods or filled or [(2, _USUAL)], stored)
    if not periods:
        return None
    total = sum(count_pruned(p) for p in periods)
    all_ = " all" if begun.keys() & set(periods) else ""
    chosen_as = f"{periods[0]}-{periods[-1]}" if periods[0] > 2 else periods[-1]
    return (
        f"geometrically pruned words of {written_periods(periods)} are not{all_} stored (there "
        f"{'are' if total > 1 else 'is'} {total:,}): "
        f"'orbitdb fill --p {chosen_as} --geometric' stores them"
    )


def lacking_births(
    connection: Connection, chosen: Selection, names: Sequence[str] = (), order: str = "p"
) -> str | None:
    """Return a line that names the filled periods whose births are needed but not stored, or None."""
    if not (periods := without_births(connection, chosen, names, order)):
        return None
    return (
        f"births of {written_periods(periods)} are not stored, so what depends on them is left "
        f"out or blank: 'orbitdb births --p {max(periods)}' finds them"
    )


def without_births(
    connection: Connection, chosen: Selection, names: Sequence[str] = (), order: str = "p"
) -> list[int]:
    """Return the chosen periods that are filled, but whose births are needed and not stored."""
    if not asks_of_lives(chosen, names, order):
        return []
    born = periods_with_births(connection)
    filled = (fill.p for fill in read_fills(connection, chosen.a) if chosen.includes(fill.p))
    return [p for p in filled if p <= MAX_PERIOD and p not in born]


def no_orbits(a: float) -> NotStoredError:
    """Return the error that no orbits are stored at an a."""
    at = format_float(a)
    return NotStoredError(f"no orbits at a = {at}: 'orbitdb fill --p 11 --a {at}' finds some")


def nothing(connection: Connection, chosen: Selection, swept: bool = False) -> str:
    """Return a message that a subset is empty, or '' if `gaps` says that none of its periods is stored."""
    if chosen.statuses == (Status.GEOMETRIC,):
        return "" if pruned_not_stored(connection, chosen) else f"no {chosen.describe()}"
    missing = unfilled(connection, chosen)
    filled = swept or any(chosen.includes(fill.p) for fill in read_fills(connection, chosen.a))
    if missing and not filled:
        return ""
    lacking = missing or lacking_births(connection, chosen) or partial_periods(connection, chosen)
    hint = ""
    if chosen.where is not None and reads_codes(chosen.where):
        hint = f"; {codes_are_texts(chosen.where)}"
    if chosen.contains is not None and (broken := rules_of_pattern(chosen.contains)):
        rules = " and ".join(f"{rule.number} ({rule.sentence})" for rule in broken)
        hint = f"; {shortened(chosen.contains)} breaks rule {rules}: only geometrically pruned words have it"
    return f"no {chosen.describe()}{' among the stored words' if lacking else ''}{hint}"


def highest_filled(fills: Sequence[Fill], chosen: Selection) -> int:
    """Return the highest p such that 2 to p are chosen, filled and without unresolved words; or 1."""
    filled = {fill.p for fill in fills if fill.complete and not fill.unresolved and chosen.includes(fill.p)}
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


def describe_complete(complete: float | None, chosen: Selection, name: str = "length") -> str:
    """Return a line that says up to which length, rounded down, a list of orbits is complete.

    For a list of all orbits, it also says how far such proofs can reach, and where no list can be complete.
    `name` is one of `LENGTHS`: an orbit of length L has a quarter_length of at least L/2.
    """
    if complete is None:
        remedy = "fill all periods from 2 on"
        if not chosen.includes(2):
            remedy = f"choose all periods from 2 on, such as --p 2-{max(high for _, high in chosen.periods)}"
        return f"orbits of any length may be missing: {remedy}"
    share, bound = (2, "2a + pi") if name == "quarter_length" else (1, "4a + 2 pi")
    end = math.floor(complete / share * 100) / 100
    line = f"complete, by proof, up to {name} {end:.2f}; longer orbits may be missing"
    if chosen.where is not None:
        reads = check(chosen.where, chosen.parameters)
        if reads.columns <= {*LENGTHS} and reads.queries == 1:  # it bounds lengths, as ranges do
            chosen = replace(chosen, where=None, parameters={})
    plain = replace(chosen, periods=(), statuses=(), ranges={}) == Selection(chosen.a)
    if not plain or chosen.statuses not in ((), (Status.ORBIT,)) or chosen.ranges.keys() - set(LENGTHS):
        return line
    most = math.floor(largest_least_length(chosen.a) / share * 100) / 100
    reach = "" if most == end else f"further periods prove {most:.2f} at most; "
    # rounded up, because only finitely many are shorter than any number below the limit
    limit = math.ceil(least_limit_of_lengths(chosen.a) / share * 100) / 100
    return f"{line} ({reach}infinitely many are shorter than {bound} < {limit:.2f})"


def complete_by_length(connection: Connection, chosen: Selection, order: str = "p") -> str | None:
    """Return `describe_complete` for orbits that a length sorts or bounds, else None.

    Any expression that reads a length counts as a bound.
    """
    first = next(iter(parse_order(order)))
    read = () if chosen.where is None else check(chosen.where, chosen.parameters).columns
    named = [name for name in LENGTHS if name == first or name in read or name in chosen.ranges]
    if not named or Status.ORBIT not in (chosen.statuses or (Status.ORBIT,)):
        return None
    return describe_complete(complete_length(read_fills(connection, chosen.a), chosen), chosen, named[0])


def describe_fills(fills: Sequence[Fill], a: float) -> str:
    """Return a short text that says which periods are filled at the given a."""
    whole, partial = ([fill.p for fill in fills if fill.complete is state] for state in (True, False))
    parts = [written_periods(whole)] if whole else []
    parts += [f"part of {written_periods(partial)}"] if partial else []
    return f"{' and '.join(parts) or 'no complete period'} at a = {format_float(a)}"


def describe_contents(connection: Connection, a: float | None) -> str:
    """Return one line that says which periods are filled, first at the given or at the default a."""
    values = a_values(connection, WITH_ORBITS)
    try:
        own = [default_among(values) if a is None else a]
    except InputError:
        own = []
    others = [other for other in values if other not in own]
    parts = [describe_fills(read_fills(connection, at), at) for at in (*own, *others[:_FEW])]
    return "; ".join(parts) + (f"; and at {len(others) - _FEW} more" if len(others) > _FEW else "")
