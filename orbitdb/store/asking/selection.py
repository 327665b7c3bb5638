"""Selection: a chosen subset of a catalogue, which describes itself in words."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from inspect import Parameter, Signature, signature
from numbers import Real
from typing import Any, TypeAlias, TypedDict, TypeVar

from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.errors import InputError
from orbitdb.numerals import real
from orbitdb.orbits.orbit import STORED, Status
from orbitdb.plaintext import printable, several
from orbitdb.symbols.symmetry import NAMES, label, smallest_group
from orbitdb.symbols.words import parse

MEASURES = ("length", "lyapunov", "lambda_d", "lambda_c", "margin", "born", "dies")
"""The columns that a selection can bound from below and above."""

Bounds: TypeAlias = tuple[float | None, float | None]
"""The least and the greatest value, both allowed; None where there is none."""


class Criteria(TypedDict, total=False):
    """What a subset can be chosen by, as `choose` takes it."""

    a: float | None
    p: int | tuple[int, int] | str | Iterable[int] | None
    status: Status | str | Iterable[Status | str] | None
    time_reversal: str | None
    symmetry: str | None
    contains: str | None
    exists: float | Iterable[float]
    not_at: float | Iterable[float]
    where: str | None
    parameters: Mapping[str, str | int | float] | None
    length: Bounds | None
    lyapunov: Bounds | None
    lambda_d: Bounds | None
    lambda_c: Bounds | None
    margin: Bounds | None
    born: Bounds | None
    dies: Bounds | None


_Method = TypeVar("_Method", bound=Callable[..., Any])


def with_criteria(method: _Method) -> _Method:
    """Show the criteria of a method, taken as ``**criteria``, one by one in help and completion."""
    *kept, _ = signature(method).parameters.values()
    named = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for name, kind in Criteria.__annotations__.items()
    ]
    method.__signature__ = Signature([*kept, *named])  # type: ignore[attr-defined]
    return method


USUAL_A = 1.6
"""The paper's stadium."""

_PERIODS = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")
_LEAST = 2
_SHOWN = 60
_MOST_RANGES = 100
_MOST_VALUES = 6
_LARGEST_INTEGER = 2**63
_AS_OPTIONS = {"range": "the name of what is bounded, as in length=(3, 10)"}
"""What criteria are that are options by another name, unless the name is near."""

_INTEGER = re.compile(r"\s*[+-]?[0-9]+\s*")
_RANGE = re.compile(r"([^:]*):([^:]*)")


class SelectionError(InputError):
    """A part of the selection cannot be read; the message says how to write it."""


@dataclass(frozen=True, eq=False)
class Selection(ByValue):
    """The chosen subset of the symbol sequences of a catalogue.

    Attributes
    ----------
    a : float
        The stadium.
    periods : tuple of (int, int)
        Ranges of periods, both ends in them; empty for all.
    statuses : tuple of Status
        Empty for all.
    time_reversal : str or None
        ``self`` or ``pair``.
    symmetry : str or None
        The exact symmetry label, such as ``x,T,xT``.
    contains : str or None
        A factor that the word has in some rotation.
    exists, not_at : tuple of float
        Values of a at which the word is an orbit, and at which it is known to be none, by its births.
    ranges : mapping of str to (float or None, float or None)
        Least and greatest value of some of `MEASURES`, both in the subset.
    where : str or None
        An SQL expression over the columns of the view ``catalogue``.
    parameters : mapping of str to value
        What the names (``:name``) in ``where`` stand for.
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
        """Tell whether words of a period are asked for."""
        return not self.periods or any(low <= p <= high for low, high in self.periods)

    def describe(self, stadiums: Sequence[float] = (), count: int | None = None) -> str:
        """Return the selection as one line of English, be it for several a, behind how many there are."""
        one, many = self._subjects()
        parts = [many if count is None else several(count, one, many)]
        if self.periods:
            spans = [str(low) if low == high else f"{low} to {high}" for low, high in self.periods]
            parts.append(f"of period {', '.join(spans)}")
        parts.append(f"at a = {_listed_values(stadiums or (self.a,))}")
        if self.time_reversal:
            parts.append((_REVERSAL_OF_ONE if count == 1 else _REVERSALS)[self.time_reversal])
        return " ".join(filter(None, [*map(printable, parts), self.describe_rest(count)]))

    def describe_rest(self, count: int | None = None) -> str:
        """Return all but a, periods, statuses and reversal as English; empty if nothing else is chosen."""
        parts = []
        if self.symmetry:
            parts.append("without symmetry" if self.symmetry == "1" else f"with symmetry {self.symmetry}")
        if self.contains:
            shown = self.contains if len(self.contains) <= _SHOWN else f"{self.contains[:_SHOWN]}..."
            parts.append(f"containing {shown}")
        if self.exists or self.not_at:
            known = (("", self.exists), ("not " if self.exists else "", self.not_at))
            spans = [f"{no}at a = {', '.join(f'{a:g}' for a in values)}" for no, values in known if values]
            alive, dead = ("exists", "does not exist") if count == 1 else ("exist", "do not exist")
            parts.append(f"that {alive if self.exists else dead} {' and '.join(spans)}")
        bounded = {name: bounds for name, bounds in self.ranges.items() if any(b is not None for b in bounds)}
        parts += [f"with {_span(name, *bounds)}" for name, bounds in bounded.items()]
        if self.where:
            values = ", ".join(f"{name} = {value!r}" for name, value in self.parameters.items())
            parts.append(f"where {self.where}" + (f" ({values})" if values else ""))
        return printable(" ".join(parts))

    def _subjects(self) -> tuple[str, str]:
        """Return what one row is, and what all of them are."""
        if not self.statuses:
            return "symbol sequence", "symbol sequences"
        one, many = zip(*(_SUBJECTS[status] for status in self.statuses), strict=True)
        return " or ".join(one), " and ".join(many)


_SUBJECTS = {
    Status.ORBIT: ("orbit", "orbits"),
    Status.GEOMETRIC: ("geometrically pruned sequence", "geometrically pruned sequences"),
    Status.DYNAMICAL: ("dynamically pruned sequence", "dynamically pruned sequences"),
    Status.BOUNDARY: ("orbit through a joint", "orbits through a joint"),
    Status.FAMILY: ("bouncing-ball family", "bouncing-ball families"),
    Status.UNRESOLVED: ("unresolved sequence", "unresolved sequences"),
}
_REVERSALS = {"self": "that retrace their path", "pair": "whose time reverse is another orbit"}
_REVERSAL_OF_ONE = _REVERSALS | {"self": "that retraces its path"}


def _listed_values(values: Sequence[float]) -> str:
    shown = ", ".join(f"{value:g}" for value in values[:_MOST_VALUES])
    return shown + (f" and {len(values) - _MOST_VALUES} more" if len(values) > _MOST_VALUES else "")


def _span(name: str, low: float | None, high: float | None) -> str:
    if low is None:
        return f"{name} <= {high:g}"
    return f"{name} >= {low:g}" if high is None else f"{low:g} <= {name} <= {high:g}"


def parse_periods(text: str) -> tuple[tuple[int, int], ...]:
    """Read ranges of periods such as ``11``, ``2-8`` or ``2,3,5-7``.

    Raises
    ------
    SelectionError
        If the text is not of this form, or a range runs backwards.
    """
    ranges = []
    for part in text.split(","):
        found = _PERIODS.fullmatch(part.strip())
        if found is None:
            raise SelectionError(f"periods {text!r}: write them as 11, 2-8 or 2,3,5-7")
        low, high = int(found[1]), int(found[2] or found[1])
        if low > high:
            remedy = f"write {high}-{low}" if high >= _LEAST else f"the least period is {_LEAST}"
            raise SelectionError(f"periods {part.strip()!r} run backwards: {remedy}")
        ranges.append((low, high))
    if len(ranges) > _MOST_RANGES:
        raise SelectionError(f"periods: {len(ranges)} ranges, more than {_MOST_RANGES}; join some, as in 2-8")
    return tuple(ranges)


def parse_bound(text: str) -> tuple[str, Bounds]:
    """Read bounds on a measure such as ``length=3:10``, ``margin=:1e-4`` or ``lambda_c=0.4:``.

    Raises
    ------
    SelectionError
        If the text is not of this form, or does not name one of `MEASURES`.
    """
    name, _, span = text.partition("=")
    if name.strip() not in MEASURES:
        raise SelectionError(f"range {text!r}: name one of {', '.join(MEASURES)}, as in length=3:10")
    found = _RANGE.fullmatch(span.strip())
    try:
        if found is None or not (found[1].strip() or found[2].strip()):
            raise ValueError(text)
        low, high = (real(part) if part.strip() else None for part in found.groups())
        if low != low or high != high:
            raise ValueError(text)
    except ValueError:
        raise SelectionError(f"range {text!r}: write it as {name}=3:10, {name}=3: or {name}=:10") from None
    if low is not None and high is not None and low > high:
        raise SelectionError(f"range {text!r} runs backwards: write {name.strip()}={high:g}:{low:g}")
    return name.strip(), (low, high)


def parse_bounds(texts: Iterable[str]) -> dict[str, Bounds]:
    """Read bounds on measures; those on the same one hold together.

    Raises
    ------
    SelectionError
        If one of them cannot be read (`parse_bound`).
    """
    found: dict[str, Bounds] = {}
    for text in texts:
        name, bounds = parse_bound(text)
        low, high = zip(found.get(name, (None, None)), bounds, strict=True)
        found[name] = (
            max((bound for bound in low if bound is not None), default=None),
            min((bound for bound in high if bound is not None), default=None),
        )
    return found


def parse_parameter(text: str) -> tuple[str, str | int | float]:
    """Read a value for a name in ``where``, such as ``cut=0.5`` or ``kind=self``.

    Raises
    ------
    SelectionError
        If the text is not of the form name=value.
    """
    name, sign, value = text.partition("=")
    if not sign or not name.isidentifier():
        raise SelectionError(f"-P {text!r}: write it as name=value")
    try:
        number = real(value)
        return name, int(value) if _INTEGER.fullmatch(value) and abs(number) < _LARGEST_INTEGER else number
    except ValueError:
        return name, value


def parse_reversal(text: str) -> str:
    """Read ``self`` or ``pair``.

    Raises
    ------
    SelectionError
        If it is neither.
    """
    if text not in _REVERSALS:
        raise SelectionError(f"reversal {text!r}: use self or pair")
    return text


def parse_symmetry(text: str) -> str:
    """Read a symmetry label such as ``x,T,xT``, its elements in any order, or ``1`` for none.

    Raises
    ------
    SelectionError
        If one of them is no symmetry of the stadium, or they lack some of their products.
    """
    named = ordered_symmetry(text)
    if named == "1":
        return named
    group = label(smallest_group(map(NAMES.index, named.split(","))))
    if group != named:
        raise SelectionError(
            f"symmetry {text!r} is no group, and none of a word: the smallest that holds it is {group}"
        )
    return group


def ordered_symmetry(text: str) -> str:
    """Write the elements of a symmetry label in their order, be they a group or not.

    Raises
    ------
    SelectionError
        If one of them is no symmetry of the stadium.
    """
    names = {part.strip() for part in text.split(",")}
    if names != {"1"} and not names <= set(NAMES[1:]):
        raise SelectionError(f"symmetry {text!r}: use 1, or some of {', '.join(NAMES[1:])} with commas")
    return "1" if names == {"1"} else ",".join(name for name in NAMES if name in names)


def parse_statuses(text: str) -> tuple[Status, ...]:
    """Read statuses separated by commas; ``all`` stands for every one.

    Raises
    ------
    SelectionError
        If one of them is not a status, or no row has it.
    """
    if text.strip() == "all":
        return ()
    try:
        found = tuple(dict.fromkeys(Status(part.strip()) for part in text.split(",")))
    except ValueError:
        known = ", ".join(STORED)
        raise SelectionError(f"status {text!r}: use {known}, some of them with commas, or all") from None
    if Status.FAMILY in found:
        raise SelectionError(
            f"status {text!r}: the bouncing-ball family is never stored: 'orbitdb query 02' tells of it"
        )
    return found


def parse_exists(values: float | Iterable[float]) -> tuple[float, ...]:
    """Read one value of a, or several, at which words exist or do not.

    Raises
    ------
    StadiumError
        If there is no such stadium.
    """
    several = values if isinstance(values, Iterable) else (values,)
    return tuple(dict.fromkeys(Stadium(a).a for a in several))


def choose(
    a: float | None = None,
    p: int | tuple[int, int] | str | Iterable[int] | None = None,
    status: Status | str | Iterable[Status | str] | None = None,
    time_reversal: str | None = None,
    symmetry: str | None = None,
    contains: str | None = None,
    where: str | None = None,
    parameters: Mapping[str, str | int | float] | None = None,
    exists: float | Iterable[float] = (),
    not_at: float | Iterable[float] = (),
    **ranges: Bounds | None,
) -> Selection:
    """Return a selection from plain values.

    Parameters
    ----------
    a : float, optional
        The stadium, by default 1.6.
    p : int, (int, int), str or iterable of int, optional
        A period, the first and the last of a range (a tuple), text such as ``2,3,5-7``, or all periods
        one by one (a list, a range, an array).
    status : Status, str or iterable of them, optional
        One, or some, also in a text with commas, such as ``orbit,boundary``.
    time_reversal, symmetry, contains, where, parameters : optional
        As in `Selection`.
    exists, not_at : float or iterable of float, optional
        Where the words are orbits, and where they are none, whatever a is.
    **ranges : (float or None, float or None)
        Least and greatest value of one of `MEASURES`, such as ``length=(3, None)``.

    Raises
    ------
    SelectionError
        If one of them cannot be used.
    """
    if unknown := sorted(set(ranges) - set(MEASURES)):
        raise _no_criterion(unknown)
    spans = {name: _pair(name, bounds) for name, bounds in ranges.items() if bounds is not None}
    if not isinstance(where, str | None):
        raise SelectionError(f"where {where!r:.40}: give an SQL expression such as 'lambda_c < 0.4'")
    return Selection(
        a=Stadium(USUAL_A if a is None else a).a,
        periods=() if p is None else parse_periods(_periods_text(p)),
        statuses=() if status is None else parse_statuses(_listed(status)),
        time_reversal=None if time_reversal is None else parse_reversal(time_reversal),
        symmetry=None if symmetry is None else parse_symmetry(symmetry),
        contains=None if contains is None else parse(contains),
        exists=parse_exists(exists),
        not_at=parse_exists(not_at),
        ranges={name: pair for name, pair in spans.items() if pair != (None, None)},
        where=where,
        parameters=parameters or {},
    )


def _no_criterion(names: Sequence[str]) -> SelectionError:
    """Return the error that tells of names that are no criteria, and what the first of them may be."""
    known = tuple(Criteria.__annotations__)
    meant = _AS_OPTIONS.get(names[0]) or next(iter(get_close_matches(names[0], known, 1)), "")
    return SelectionError(
        f"{', '.join(names)}: not a criterion{meant and f', use {meant}'}; these are {', '.join(known)}"
    )


def _periods_text(p: int | tuple[int, int] | str | Iterable[int]) -> str:
    """Write periods as `parse_periods` reads them: a pair is a range, any other sequence has them all."""
    if isinstance(p, tuple) and len(p) == 2:
        return "-".join(map(str, p))
    if isinstance(p, range) and p.step == 1 and len(p):
        return f"{p[0]}-{p[-1]}"
    return _listed(p)


def _listed(value: object) -> str:
    """Write one value, or several with commas between."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return str(value)
    return ",".join(map(str, value))


def _pair(name: str, bounds: object) -> Bounds:
    """Return bounds on a measure; raise unless they are a pair, each a number or None."""
    pair = tuple(bounds) if isinstance(bounds, tuple | list) else ()
    numbers = [bound for bound in pair if bound is not None]
    if len(pair) != 2 or not all(isinstance(bound, Real) and bound == bound for bound in numbers):
        raise SelectionError(f"{name} = {bounds!r:.40}: give two numbers such as (3, 10), or None for one")
    low, high = pair
    if len(numbers) == len(pair) and low > high:
        raise SelectionError(f"{name} = {bounds!r:.40} runs backwards: give {(high, low)}")
    return low, high
