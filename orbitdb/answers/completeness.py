"""How far an answer is complete, and notes on what it lacks: periods, births, and long orbits.

Missing data never count as zero. Instead, a note with every list, count or average says what is missing.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cached_property

from orbitdb.errors import AlteredError, InputError, NotStoredError
from orbitdb.orbits.least_values import (
    largest_least_length,
    least_exponent,
    least_length,
    least_limit_of_lengths,
)
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.period_ranges import LEAST_PERIOD, written_periods
from orbitdb.selection import Selection
from orbitdb.sql_text import on_codes
from orbitdb.store.conditions import asks_of_lives, may_choose_pruned, parse_order
from orbitdb.store.lookup import WITH_ORBITS, a_values, default_a
from orbitdb.store.periods import Fill, Sweep, read_birth_fills, read_fills, read_pruned_fills, read_sweeps
from orbitdb.store.select import count
from orbitdb.store.sqlite import DATABASE_ERRORS, Connection
from orbitdb.store.where import check
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.pruning import count_pruned, rules_of_pattern
from orbitdb.text import format_float, several, shortened

_USUAL = 11
"""Highest period of the first fill that messages suggest."""

_SHOWN = 6
"""Maximum number of values of a to list in a message."""

_FEW = 4
"""Maximum number of values of a, beside the default one, whose fills are described in one line."""

LENGTHS = ("length", "quarter_length")
"""The lengths by which lists of orbits can be complete."""

EXPONENTS = ("lyapunov", "quarter_lyapunov")
"""The lambdas by which they can be."""


class Stored:
    """What is stored at one a, at one moment; each table is read once, when it is first needed."""

    def __init__(self, connection: Connection, a: float) -> None:
        self._connection, self._a = connection, a

    @cached_property
    def fills(self) -> list[Fill]:
        """All fills, in order of period."""
        return read_fills(self._connection, self._a)

    @cached_property
    def sweeps(self) -> list[Sweep]:
        """All sweeps, in order of period."""
        return read_sweeps(self._connection, self._a)

    @cached_property
    def born(self) -> list[int]:
        """The periods whose births and deaths are all stored, in ascending order."""
        return periods_with_births(self._connection)

    @cached_property
    def pruned(self) -> dict[int, bool]:
        """The periods with geometrically pruned words, and whether all of them are stored."""
        return {p: whole for p, (_, whole) in read_pruned_fills(self._connection).items()}

    @cached_property
    def filled_at(self) -> list[float]:
        """Every a that has fills, in order."""
        return a_values(self._connection, ["fill"])


class Coverage:
    """How far a chosen subset is stored, and the notes on what it lacks.

    Parameters
    ----------
    connection : Connection
    chosen : Selection
    stored : Stored, optional
        What is stored at its a, if that has been read before.
    """

    def __init__(self, connection: Connection, chosen: Selection, stored: Stored | None = None) -> None:
        self.connection, self.chosen = connection, chosen
        self.stored = Stored(connection, chosen.a) if stored is None else stored

    def of(self, chosen: Selection) -> "Coverage":
        """Return the coverage of another subset at the same a, for which nothing is read again."""
        return Coverage(self.connection, chosen, self.stored)

    @property
    def fills(self) -> list[Fill]:
        """All fills at this a, in order of period."""
        return self.stored.fills

    @property
    def filled(self) -> list[int]:
        """The chosen periods that are completely filled, in ascending order."""
        return [fill.p for fill in self.fills if fill.done and self.chosen.includes(fill.p)]

    @property
    def partial(self) -> list[int]:
        """The chosen periods that are only partly stored; lists include their words."""
        return [fill.p for fill in self.fills if not fill.done and self.chosen.includes(fill.p)]

    def without_births(self, names: Sequence[str] = (), order: str = "p") -> list[int]:
        """Return the chosen periods that are filled, but whose births are needed and not stored.

        They are needed if the subset, the columns `names` or the order of the rows depends on them.
        """
        if not asks_of_lives(self.chosen, names, order):
            return []
        return [
            p for p in sorted([*self.filled, *self.partial]) if p <= MAX_PERIOD and p not in self.stored.born
        ]

    # notes

    def gaps(
        self,
        names: Sequence[str] = (),
        order: str = "p",
        *,
        swept: Collection[int] = (),
        from_births: Collection[int] = (),
        left_out: bool = False,
    ) -> list[str]:
        """Return a line for each kind of gap: chosen periods that are partial, not filled, or without births.

        Periods counted from sweeps or births are complete, but get a line, too. Set `left_out` if the result
        leaves out partial periods.
        """
        lines = [self._pruned_not_stored(), self._without_bounces()]
        if self.chosen.statuses != (Status.GEOMETRIC,):  # fills do not store these words
            counted = {*swept, *from_births}
            lines.append(self._counted(swept, "counted by a sweep, without stored rows"))
            lines.append(self._counted(from_births, "counted from births, without a fill"))
            lines.append(self._partly(counted, left_out))
            lines += [self.unfilled(counted), self.lacking_births(names, order)]
        return [line for line in lines if line]

    def nothing(self, swept: bool = False, answerable: tuple[Status, ...] = ()) -> str:
        """Return that the subset is empty, and statuses to try (`answerable`); '' if `gaps` says so."""
        chosen = self.chosen
        if chosen.statuses == (Status.GEOMETRIC,):
            return "" if self._pruned_not_stored() else f"no {chosen.describe()}"
        missing = self.unfilled()
        if missing and not (swept or self.filled or self.partial):
            return ""
        self._check_rows()
        lacking = missing or self.lacking_births() or self.partial
        hint = ""
        if chosen.where is not None and (how := on_codes(chosen.where)):
            hint = f"; {how}"
        if chosen.contains is not None and (broken := rules_of_pattern(chosen.contains)):
            rules = " and ".join(f"{rule.number} ({rule.sentence})" for rule in broken)
            hint = (
                f"; {shortened(chosen.contains)} breaks rule {rules}: only geometrically pruned words have it"
            )
        if chosen.statuses and (others := count(self.connection, replace(chosen, statuses=answerable))):
            are, named = "is" if others == 1 else "are", ",".join(answerable) or "all"
            hint = f"; there {are} {several(others, 'word')} of other statuses (`status='{named}'`){hint}"
        return f"no {chosen.describe()}{' among the stored words' if lacking else ''}{hint}"

    def _check_rows(self) -> None:
        """Raise `AlteredError` if a whole filled period has no rows, as in a table that was emptied."""
        chosen = self.chosen
        if replace(chosen, periods=(), statuses=()) != Selection(chosen.a):
            return
        of_orbits = chosen.statuses == (Status.ORBIT,)
        for fill in self.fills if of_orbits or not chosen.statuses else ():
            counted = fill.n_c if of_orbits else fill.words
            if fill.done and chosen.includes(fill.p) and counted:
                raise AlteredError(f"period {fill.p} is filled, but the rows of its {counted} words are gone")

    def complete(self, order: str = "p") -> str | None:
        """Return how far a list of orbits is complete that a length or lambda sorts or bounds, else None.

        Any expression that reads one of them counts as a bound.
        """
        chosen, first = self.chosen, next(iter(parse_order(order)))
        read = () if chosen.where is None else check(chosen.where, chosen.parameters).columns
        bounding = {first, *read, *chosen.ranges}
        named = [name for name in (*LENGTHS, *EXPONENTS) if name in bounding]
        if not named or Status.ORBIT not in (chosen.statuses or (Status.ORBIT,)):
            return None
        if named[0] in EXPONENTS:
            return describe_exponents(self.fills, chosen, named[0])
        return describe_complete(complete_length(self.fills, chosen), chosen, named[0])

    def unfilled(self, counted: Collection[int] = ()) -> str | None:
        """Return a line that says which chosen periods are not filled, which are, and how to fill the others.

        Return None if no period is missing. Partial periods do not count as missing, nor do `counted` ones
        and periods below 2, which have no words. If no periods are chosen, all filled ones are.
        """
        periods, a = self.chosen.periods, format_float(self.chosen.a)
        stored = {fill.p for fill in self.fills}.union(counted)
        if not periods and stored:
            return None
        lines = []
        if missing := _within(periods or [(2, _USUAL)], stored):
            named, (are, them) = written_periods(missing), _are(missing)
            what, them = (f"{named} {are} not filled", them) if periods else ("nothing is filled", named)
            command = f"`catalogue.fill(p={missing[-1]}, a={a})`"
            lines.append(f"{what} at a = {a}{self._elsewhere()}: {command} fills {them}")
        if any(high > MAX_PERIOD for _, high in periods):
            if not lines:
                lines.append(f"no period above {MAX_PERIOD} is filled at a = {a}{self._elsewhere()}")
            lines.append(
                f"fills go up to period {MAX_PERIOD}: `catalogue.fill(code=WORD)` stores single words"
            )
        return "; ".join(lines) or None

    def _elsewhere(self) -> str:
        """Return, in parentheses, which periods are filled at this a and which other a have fills, or ''."""
        whole, a = [fill.p for fill in self.fills if fill.done], self.chosen.a
        others = sorted(
            (other for other in self.stored.filled_at if other != a), key=lambda other: abs(other - a)
        )
        parts = [written_periods(whole)] if whole else []
        if others:
            more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN else ""
            parts.append(f"some at a = {', '.join(map(format_float, sorted(others[:_SHOWN])))}{more}")
        return f" (filled: {'; '.join(parts)})" if parts else ""

    def _counted(self, periods: Collection[int], how: str) -> str | None:
        """Return a line that says how some periods were counted, or None if none of them is chosen."""
        shown = sorted(p for p in periods if self.chosen.includes(p))
        return f"{written_periods(shown)} at a = {format_float(self.chosen.a)}: {how}" if shown else None

    def _partly(self, counted: Collection[int], left_out: bool) -> str | None:
        """Return a line that names periods that are only partly stored, and how to complete them, or None."""
        if not (periods := [p for p in self.partial if p not in counted]):
            return None
        a, (are, them) = format_float(self.chosen.a), _are(periods)
        return (
            f"{written_periods(periods)} at a = {a} {are} partial{' and left out' * left_out}: a fill is "
            f"running or was stopped; `catalogue.fill(p={max(periods)}, a={a})` completes {them}"
        )

    def _pruned_not_stored(self) -> str | None:
        """Return a line that names chosen periods without stored geometrically pruned words, or None."""
        if not may_choose_pruned(self.chosen) or self.chosen.codes:
            return None
        stored = [p for p, whole in self.stored.pruned.items() if whole]
        missing = _within(self.chosen.periods or [(p, p) for p in self.filled] or [(2, _USUAL)], stored)
        periods = [p for p in missing if may_choose_pruned(self.chosen, p)]
        if not periods:
            return None
        total = sum(count_pruned(p) for p in periods)
        every = " all" if self.stored.pruned.keys() & set(periods) else ""
        named = f"'{periods[0]}-{periods[-1]}'" if periods[0] > 2 else periods[-1]
        return (
            f"geometrically pruned words of {written_periods(periods)} are not{every} stored (there "
            f"{'are' if total > 1 else 'is'} {total:,}): "
            f"`catalogue.fill(p={named}, geometric=True)` stores them"
        )

    def _without_bounces(self) -> str | None:
        """Return a line that says that an opening leaves out words that are no orbits, or None."""
        if not self.chosen.opening or set(self.chosen.statuses or Status) <= {*EXISTING}:
            return None
        return "words that are no orbits have no bounces, so the opening leaves them out"

    def lacking_births(self, names: Sequence[str] = (), order: str = "p") -> str | None:
        """Return a line that names the filled periods whose births are needed but not stored, or None."""
        if not (periods := self.without_births(names, order)):
            return None
        return (
            f"births of {written_periods(periods)} are not stored, so what depends on them is left "
            f"out or blank: `catalogue.fill_births(p={max(periods)})` finds them"
        )


def _are(periods: Sequence[int]) -> tuple[str, str]:
    return ("are", "them") if len(periods) > 1 else ("is", "it")


def gaps_at(connection: Connection, chosen: Sequence[Selection], everywhere: bool) -> list[str]:
    """Return the gaps at each a; where nothing is filled, only if periods are chosen and not `everywhere`.

    A file that cannot be read has none: the checks of `Catalogue.verify` report it.
    """
    lines = []
    try:
        for coverage in (Coverage(connection, selection) for selection in chosen):
            if coverage.fills or (coverage.chosen.periods and not everywhere):
                lines += coverage.gaps(swept=[sweep.p for sweep in coverage.stored.sweeps])
    except (AlteredError, TypeError, ValueError, *DATABASE_ERRORS):
        return []
    return lines


def periods_with_births(connection: Connection) -> list[int]:
    """Return the periods whose births and deaths are all stored, in ascending order."""
    return [fill.p for fill in read_birth_fills(connection) if fill.done]


def _within(spans: Sequence[tuple[int, int]], stored: Collection[int]) -> list[int]:
    """Return the periods in the given ranges that can be filled and are not stored."""
    periods = (p for p in range(2, MAX_PERIOD + 1) if any(low <= p <= high for low, high in spans))
    return [p for p in periods if p not in stored]


def no_orbits(a: float) -> NotStoredError:
    """Return the error that no orbits are stored at an a."""
    at = format_float(a)
    return NotStoredError(f"no orbits at a = {at}: `catalogue.fill(p=11, a={at})` finds some")


def highest_filled(fills: Sequence[Fill], chosen: Selection) -> int:
    """Return the highest p such that 2 to p are chosen, filled and without unresolved words; or 1."""
    filled = {fill.p for fill in fills if fill.done and not fill.unresolved and chosen.includes(fill.p)}
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
        return _of_any("length", chosen)
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


def describe_exponents(fills: Sequence[Fill], chosen: Selection, name: str) -> str:
    """Return a line that says up to which lambda, rounded down, a list of orbits is complete.

    `name` is one of `EXPONENTS`: an orbit of lambda has a quarter_lyapunov of at least lambda/2.
    """
    highest = highest_filled(fills, chosen)
    if highest < LEAST_PERIOD:
        return _of_any("lambda", chosen)
    least = least_exponent(highest, chosen.a) / (2 if name == "quarter_lyapunov" else 1)
    return f"complete, by proof, up to {name} {math.floor(least * 1000) / 1000:.3f}; others may be missing"


def _of_any(what: str, chosen: Selection) -> str:
    """Return a line that says that a list may lack orbits of any length or lambda, and what to do."""
    remedy = "fill all periods from 2 on"
    if not chosen.includes(2):
        remedy = f"choose all periods from 2 on, such as `p='2-{max(high for _, high in chosen.periods)}'`"
    return f"orbits of any {what} may be missing: {remedy}"


def describe_fills(fills: Sequence[Fill], a: float) -> str:
    """Return a short text that says which periods are filled at the given a."""
    whole, partial = ([fill.p for fill in fills if fill.done is state] for state in (True, False))
    parts = [written_periods(whole)] if whole else []
    parts += [f"part of {written_periods(partial)}"] if partial else []
    return f"{' and '.join(parts) or 'no complete period'} at a = {format_float(a)}"


def describe_contents(connection: Connection, a: float | None) -> str:
    """Return one line that says which periods are filled, first at the given or at the default a."""
    values = a_values(connection, WITH_ORBITS)
    try:
        own = [default_a(connection) if a is None else a]
    except InputError:
        own = []
    others = [other for other in values if other not in own]
    parts = [describe_fills(read_fills(connection, at), at) for at in (*own, *others[:_FEW])]
    return "; ".join(parts) + (f"; and at {len(others) - _FEW} more" if len(others) > _FEW else "")
