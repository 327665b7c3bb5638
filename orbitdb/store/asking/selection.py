"""`Selection`, the description of a subset of a catalogue, and functions for ranges of periods."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from orbitdb.billiard import USUAL_A
from orbitdb.equality import ByValue
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.status import STORED, Status
from orbitdb.plaintext import guess, printable, several, shortened
from orbitdb.symbols.enumeration import MAX_PERIOD

MEASURES = ("length", "lyapunov", "lambda_d", "lambda_c", "margin", "born", "dies")
"""The columns that a selection can bound from below and above."""

Bounds: TypeAlias = tuple[float | None, float | None]
"""The least and the greatest value, both included; None if there is no limit."""

_MOST_VALUES = 6


class SelectionError(InputError):
    """A part of the selection cannot be read; the message says how to write it."""


@dataclass(frozen=True, eq=False)
class Selection(ByValue):
    """A chosen subset of the words of a catalogue.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    periods : tuple of (int, int)
        Ranges of periods, including both ends; empty for all periods.
    statuses : tuple of Status
        The statuses that a word may have; empty for all.
    time_reversal : str or None
        ``self`` or ``pair``.
    symmetry : str or None
        The exact symmetry label, such as ``x,T,xT``.
    contains : str or None
        Consecutive symbols of the word, read cyclically.
    exists, not_at : tuple of float
        Values of a at which the word must be an orbit, and at which it must not be, judged by its births.
    ranges : mapping of str to (float or None, float or None)
        Least and greatest values of some `MEASURES`, both inclusive; None for no limit.
    where : str or None
        An SQL expression that uses the columns of the view ``catalogue``.
    parameters : mapping of str to value
        Values for the names (``:name``) in ``where``.
    """

    a: float = USUAL_A
    periods: tuple[tuple[int, int], ...] = ()
    statuses: tuple[Status, ...] = ()
    time_reversal: str | None = None
    symmetry: str | None = None
    contains: str | None = None
    exists: tuple[float, ...] = ()
    not_at: tuple[float, ...] = ()
    ranges: Mapping[str, Bounds] = field(default_factory=dict)
    where: str | None = None
    parameters: Mapping[str, str | int | float] = field(default_factory=dict)

    def includes(self, p: int) -> bool:
        """Tell whether the subset can contain words of a given period."""
        return not self.periods or any(low <= p <= high for low, high in self.periods)

    def describe(self, stadiums: Sequence[float] = (), count: int | None = None) -> str:
        """Describe the selection in one line, with the number of its words or several stadiums, if given."""
        one, many = self._subjects()
        parts = [many if count is None else several(count, one, many)]
        if self.periods:
            spans = [str(low) if low == high else f"{low} to {high}" for low, high in self.periods]
            parts.append(f"of period {', '.join(spans)}")
        parts.append(f"at a = {_listed_values(stadiums or (self.a,))}")
        if self.time_reversal:
            parts.append((_REVERSAL_OF_ONE if count == 1 else REVERSALS)[self.time_reversal])
        return " ".join(filter(None, [*map(printable, parts), self.describe_rest(count)]))

    def describe_rest(self, count: int | None = None) -> str:
        """Describe all criteria except a, periods, statuses and time reversal; the text may be empty."""
        parts = []
        if self.symmetry:
            parts.append("without symmetry" if self.symmetry == "1" else f"with symmetry {self.symmetry}")
        if self.contains:
            parts.append(f"containing {shortened(self.contains, 60)}")
        if self.exists or self.not_at:
            known = (("", self.exists), ("not " if self.exists else "", self.not_at))
            spans = [f"{no}at a = {', '.join(map(exact, values))}" for no, values in known if values]
            alive, dead = ("exists", "does not exist") if count == 1 else ("exist", "do not exist")
            parts.append(f"that {alive if self.exists else dead} {' and '.join(spans)}")
        bounded = {name: bounds for name, bounds in self.ranges.items() if any(b is not None for b in bounds)}
        parts += [f"with {_span(name, *bounds)}" for name, bounds in bounded.items()]
        if self.where:
            values = ", ".join(f"{name} = {value!r}" for name, value in self.parameters.items())
            parts.append(f"where {self.where}" + (f" ({values})" if values else ""))
        return printable(" ".join(parts))

    def _subjects(self) -> tuple[str, str]:
        if not self.statuses or set(self.statuses) == set(STORED):
            return "word", "words"
        one, many = zip(*(_SUBJECTS[status] for status in self.statuses), strict=True)
        return " or ".join(one), " and ".join(many)


_SUBJECTS = {
    Status.ORBIT: ("orbit", "orbits"),
    Status.GEOMETRIC: ("geometrically pruned word", "geometrically pruned words"),
    Status.DYNAMICAL: ("dynamically pruned word", "dynamically pruned words"),
    Status.BOUNDARY: ("orbit through a joint", "orbits through a joint"),
    Status.FAMILY: ("bouncing-ball family", "bouncing-ball families"),
    Status.UNRESOLVED: ("unresolved word", "unresolved words"),
}
REVERSALS = {"self": "that retrace their path", "pair": "whose time reverse is another orbit"}
_REVERSAL_OF_ONE = REVERSALS | {"self": "that retraces its path"}


def _listed_values(values: Sequence[float]) -> str:
    shown = ", ".join(f"{value:g}" for value in values[:_MOST_VALUES])
    return shown + (f" and {len(values) - _MOST_VALUES} more" if len(values) > _MOST_VALUES else "")


def _span(name: str, low: float | None, high: float | None) -> str:
    if low is None:
        return f"{name} <= {high:g}"
    return f"{name} >= {low:g}" if high is None else f"{low:g} <= {name} <= {high:g}"


LEAST_PERIOD = 2
"""The smallest number of bounces that an orbit can have."""


def fillable(spans: Iterable[tuple[int, int]]) -> tuple[int, ...]:
    """Return the periods in the given ranges, ascending; raise `InputError` if one cannot be filled."""
    found: set[int] = set()
    for low, high in spans:
        if (least := min(low, high)) < LEAST_PERIOD:
            raise InputError(f"period {least}: the least period is {LEAST_PERIOD}")
        if (most := max(low, high)) > MAX_PERIOD:
            raise InputError(f"period {most}: the highest period is {MAX_PERIOD}")
        found.update(range(low, high + 1))
    return tuple(sorted(found))


def written_periods(periods: Sequence[int]) -> str:
    """Format periods as ranges, such as "periods 2-8, 11"."""
    return written_spans(joined_spans([(p, p) for p in periods]))


def joined_spans(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Sort ranges of periods, and join those that touch or overlap."""
    joined: list[tuple[int, int]] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + 1:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def are_many(spans: Sequence[tuple[int, int]]) -> bool:
    """Tell whether the ranges contain more than one period."""
    return len(spans) > 1 or spans[0][0] < spans[0][1]


def written_spans(spans: Sequence[tuple[int, int]]) -> str:
    """Format ranges of periods, such as "period 4" or "periods 2-8, 11"."""
    ranges = (str(low) if low == high else f"{low}-{high}" for low, high in spans)
    return f"period{'s' * are_many(spans)} {', '.join(ranges)}"


def parse_names(text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Read names of columns, separated by commas; each must be known."""
    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in known:
            raise unknown_column(name, known)
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(f"column {twice[0]!r} is named twice")
    return names


def unknown_column(name: str, known: Sequence[str]) -> SelectionError:
    """Return the error for an unknown column; its message suggests a similar name."""
    columns = ", ".join(dict.fromkeys(known))
    return SelectionError(f"column {name!r}: {guess(name, known)}the columns are {columns}")
