"""`Selection`, a chosen subset of a catalogue, and how criteria, Python values or texts, become one.

A value that cannot be read raises `SelectionError`; the message says how to write it.
"""

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import Parameter, Signature, signature
from numbers import Integral, Real
from typing import Any, TypeAlias, TypedDict, TypeVar, Unpack

from orbitdb.billiard import USUAL_A
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, check_text
from orbitdb.open_stadium.openings import Opening, parse_openings, spans_on
from orbitdb.orbits.status import STORED, Status
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.symbols.symmetry import NAMES, label, smallest_group
from orbitdb.symbols.words import least_rotation, parse, parse_primitive
from orbitdb.text import format_float, guess, parse_int, printable, real, several, shortened

MEASURES = (
    "length", "quarter_length", "lyapunov", "lambda_d", "lambda_c", "margin", "born", "dies", "walls",
)  # fmt: skip
"""The columns that a selection can bound from below and above."""

COUNTED = ("walls",)
"""Those that are whole numbers: a single value stands for itself."""

Bounds: TypeAlias = tuple[float | None, float | None]
"""The least and the greatest value, both included; None if there is no limit."""

_MOST_VALUES = 6


class SelectionError(InputError):
    """A part of the selection cannot be read; the message says how to write it."""


@dataclass(frozen=True)
class Selection:
    """A chosen subset of the words of a catalogue.

    Methods of `Catalogue` that answer for a subset take a Selection or, as arguments, the criteria that
    `from_criteria` explains, such as ``p="2-8", status="orbit", lambda_c=(None, 0.4)``.

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
    codes : tuple of str
        Words, as least rotations; empty for all.
    contains : str or None
        Consecutive symbols of the word, read cyclically.
    without : tuple of str
        Patterns of consecutive symbols that the word must not contain, read cyclically.
    opening : tuple of Opening
        Intervals of the boundary in which the word must not have a bounce; words that are no orbits have none
        at all, and are left out.
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
    codes: tuple[str, ...] = ()
    contains: str | None = None
    without: tuple[str, ...] = ()
    opening: tuple[Opening, ...] = ()
    exists: tuple[float, ...] = ()
    not_at: tuple[float, ...] = ()
    ranges: Mapping[str, Bounds] = field(default_factory=dict, hash=False)
    where: str | None = None
    parameters: Mapping[str, str | int | float] = field(default_factory=dict, hash=False)

    @classmethod
    def from_criteria(cls, **criteria: "Unpack[Criteria]") -> "Selection":
        """Return the selection that fulfils all of the given criteria.

        Parameters
        ----------
        a : float, optional
            Half length of the stadium; by default the catalogue's, or 1.6.
        p : int, str or iterable of int, optional
            A period, several periods such as ``range(2, 6)``, or a text such as ``2,3,5-7``.
        status : Status, str or iterable of them, optional
            One or more statuses; a text such as ``orbit,boundary`` can name several, and ``all`` means every
            one. By default orbits; but every status if words are named (`code`), if `exists`, `not_at`,
            `born` or `dies` ask for lives, or if `where` names a column of these or of the status.
        time_reversal : str, optional
            ``self`` for orbits that retrace their path, ``pair`` for the others.
        symmetry : str, optional
            The exact symmetry, such as ``x,T,xT``; ``1`` for none.
        code : str or iterable of str, optional
            Words, in any rotation.
        contains : str, optional
            Consecutive symbols that the words must contain, read cyclically, such as ``"0202"``.
        without : str or iterable of str, optional
            Patterns of symbols that the words must not contain, read cyclically.
        opening : str or iterable of str, optional
            Intervals of the boundary in which the words must not have a bounce, such as ``"top:-0.3:0.3"``.
        exists, not_at : float or iterable of float, optional
            Values of ``a`` at which the words must be orbits, and at which they must not be.
        where : str, optional
            An SQL expression that uses the columns of the view ``catalogue``.
        parameters : mapping, optional
            Values for the names (``:name``) in `where`.
        length, quarter_length, lyapunov, lambda_d, lambda_c, margin, born, dies : (float, float), optional
            Least and greatest value, or None for no limit, as in ``length=(3, None)``.
        walls : int or (int, int), optional
            Number of bounces on straight walls, or its least and greatest value.

        Raises
        ------
        SelectionError
            If a criterion is invalid.
        """
        if unknown := sorted(set(criteria) - set(Criteria.__annotations__)):
            meant, names = guess(unknown[0], Criteria.__annotations__), ", ".join(Criteria.__annotations__)
            raise SelectionError(f"{', '.join(unknown)}: not a criterion; {meant}criteria are {names}")
        given: dict[str, Any] = {name: value for name, value in criteria.items() if value is not None}
        where, reversal = given.get("where"), given.get("time_reversal")
        if not isinstance(where, str | None):
            raise SelectionError(f"where {where!r:.40}: give an SQL expression such as 'lambda_c < 0.4'")
        parameters = plain_values(given.get("parameters", {}))
        if parameters and where is None:
            names = ", ".join(parameters)
            raise SelectionError(f"{names}: parameters are for names in where, which is not given")
        if reversal not in (None, *REVERSALS):
            raise SelectionError(f"reversal {reversal!r}: use self or pair")
        ranges = {name: _pair(name, given[name]) for name in MEASURES if name in given}
        chosen = cls(
            a=Stadium(given.get("a", USUAL_A)).a,
            periods=parse_periods(listed(given["p"])) if "p" in given else (),
            statuses=parse_statuses(given.get("status", ())),
            time_reversal=reversal,
            symmetry=parse_symmetry(given["symmetry"]) if "symmetry" in given else None,
            codes=_each(given, "code", _code, _MOST_CODES),
            contains=parse(given["contains"]) if "contains" in given else None,
            without=_each(given, "without", parse),
            opening=parse_openings(given.get("opening", ())),
            exists=_each(given, "exists", _half_length),
            not_at=_each(given, "not_at", _half_length),
            ranges={name: bounds for name, bounds in ranges.items() if bounds != (None, None)},
            where=where,
            parameters=parameters,
        )
        return chosen if "status" in given else replace(chosen, statuses=chosen.usual_statuses)

    @property
    def usual_statuses(self) -> tuple[Status, ...]:
        """The statuses that are chosen if none is named (`from_criteria`)."""
        bare = re.sub(r"'[^']*'", "", self.where or "").lower()
        named = {name for name in OF_STATUS if re.search(rf"\b{name}\b", bare)}
        if "rules" in named or ("status" in named and Status.GEOMETRIC in (self.where or "")):
            return STORED
        lives = self.exists or self.not_at or self.ranges.keys() & OF_STATUS
        return () if named or lives or self.codes else (Status.ORBIT,)

    def criteria(self) -> dict[str, Any]:
        """Return the criteria from which `from_criteria` makes this selection, except the usual ones."""
        spans = [str(low) if low == high else f"{low}-{high}" for low, high in self.periods]
        statuses = self.statuses or [status for status in STORED if status is not Status.GEOMETRIC]
        criteria = {
            "p": ",".join(spans),
            "status": "" if self.statuses == self.usual_statuses else ",".join(statuses),
            "code": list(self.codes),
            **{name: getattr(self, name) for name in ("time_reversal", "symmetry", "contains")},
            "without": list(self.without),
            "opening": list(map(str, self.opening)),
            "exists": list(self.exists),
            "not_at": list(self.not_at),
            **{name: tuple(bounds) for name, bounds in self.ranges.items()},
            "where": self.where,
            "parameters": dict(self.parameters),
        }
        return {"a": self.a, **{name: value for name, value in criteria.items() if value}}

    def check_opening(self) -> None:
        """Raise `OpeningError` if an opening does not fit on the boundary at this a."""
        spans_on(Stadium(self.a), self.opening)

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
            said = (_REVERSAL_OF_ONE if count == 1 else REVERSALS)[self.time_reversal]
            exist = self.statuses and {Status.ORBIT, Status.BOUNDARY}.issuperset(self.statuses)
            parts.append(said.format(another="orbit" if exist else "word"))
        return " ".join(filter(None, [*map(printable, parts), self.describe_rest(count)]))

    def describe_rest(self, count: int | None = None) -> str:
        """Describe all criteria except a, periods, statuses and time reversal; the text may be empty."""
        parts = []
        if self.symmetry:
            parts.append("without symmetry" if self.symmetry == "1" else f"with symmetry {self.symmetry}")
        if self.codes:
            named = f"with code {' or '.join(shortened(code, 60) for code in self.codes)}"
            parts.append(named if len(self.codes) <= _MOST_VALUES else f"of {len(self.codes)} codes")
        if self.contains:
            parts.append(f"containing {shortened(self.contains, 60)}")
        if self.without:
            parts.append(f"without {' or '.join(shortened(pattern, 60) for pattern in self.without)}")
        if self.opening:
            parts.append(f"without a bounce in {' or '.join(map(str, self.opening))}")
        if self.exists or self.not_at:
            lists = (("", self.exists), ("not " if self.exists else "", self.not_at))
            spans = [f"{no}at a = {', '.join(map(format_float, values))}" for no, values in lists if values]
            alive, dead = ("exists", "does not exist") if count == 1 else ("exist", "do not exist")
            parts.append(f"that {alive if self.exists else dead} {' and '.join(spans)}")
        bounded = (item for item in self.ranges.items() if item[1] != (None, None))
        parts += [f"with {_span(name, *bounds)}" for name, bounds in bounded]
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
REVERSALS = {"self": "that retrace their path", "pair": "whose time reverse is another {another}"}
_REVERSAL_OF_ONE = REVERSALS | {"self": "that retraces its path"}


def _listed_values(values: Sequence[float]) -> str:
    shown = ", ".join(map(format_float, values[:_MOST_VALUES]))
    return shown + (f" and {len(values) - _MOST_VALUES} more" if len(values) > _MOST_VALUES else "")


def _span(name: str, low: float | None, high: float | None) -> str:
    if low is None:
        return f"{name} <= {'' if high is None else format_float(high)}"
    if low == high:
        return f"{name} = {format_float(low)}"
    if high is None:
        return f"{name} >= {format_float(low)}"
    return f"{format_float(low)} <= {name} <= {format_float(high)}"


LEAST_PERIOD = 2
"""The smallest number of bounces that an orbit can have."""


def written_periods(periods: Sequence[int]) -> str:
    """Format periods as ranges, such as "period 4" or "periods 2-8, 11"."""
    spans = joined_spans([(p, p) for p in periods])
    ranges = (str(low) if low == high else f"{low}-{high}" for low, high in spans)
    return f"period{'s' * (len(set(periods)) > 1)} {', '.join(ranges)}"


def joined_spans(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Sort ranges of periods, and join those that touch or overlap."""
    joined: list[tuple[int, int]] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + 1:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def unknown_column(name: str, columns: Sequence[str]) -> SelectionError:
    """Return the error for an unknown column; its message suggests a similar name."""
    names = ", ".join(dict.fromkeys(columns))
    return SelectionError(f"column {name!r}: {guess(str(name), columns)}the columns are {names}")


# criteria


class Criteria(TypedDict, total=False):
    """Keyword arguments of `Selection.from_criteria`."""

    a: float | Iterable[float] | str | None
    p: int | str | Iterable[int] | None
    status: Status | str | Iterable[Status | str] | None
    time_reversal: str | None
    symmetry: str | None
    code: str | Iterable[str] | None
    contains: str | None
    without: str | Iterable[str] | None
    opening: str | Opening | Iterable[str | Opening] | None
    exists: float | Iterable[float]
    not_at: float | Iterable[float]
    where: str | None
    parameters: Mapping[str, str | int | float] | None
    length: Bounds | None
    quarter_length: Bounds | None
    lyapunov: Bounds | None
    lambda_d: Bounds | None
    lambda_c: Bounds | None
    margin: Bounds | None
    born: Bounds | None
    dies: Bounds | None
    walls: int | Bounds | None


OF_STATUS = frozenset({"status", "rules", "born", "dies"})
"""Columns that make a condition or a count mean words of every status."""

_Value = TypeVar("_Value")
_Method = TypeVar("_Method", bound=Callable[..., Any])


def with_criteria(method: _Method) -> _Method:
    """Decorate a method so that help and completion list all the criteria that ``**criteria`` stands for."""
    *kept, _ = signature(method).parameters.values()
    named = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for name, kind in Criteria.__annotations__.items()
    ]
    method.__signature__ = Signature([*kept, *named])  # type: ignore[attr-defined]
    return method


def listed(value: object) -> str:
    """Join values with commas; format a range so that `parse_periods` can read it."""
    if isinstance(value, range) and value.step == 1 and len(value):
        return f"{value[0]}-{value[-1]}"
    if isinstance(value, str) or not isinstance(value, Iterable):
        return str(value)
    return ",".join(map(str, value))


def _pair(name: str, bounds: object) -> Bounds:
    """Return bounds, after checking that they are a pair of numbers or None in ascending order."""
    alone = name in COUNTED and isinstance(bounds, Integral) and not isinstance(bounds, bool)
    pair = (bounds, bounds) if alone else tuple(bounds) if isinstance(bounds, tuple | list) else ()
    numbers = [bound for bound in pair if bound is not None]
    if len(pair) != 2 or not all(isinstance(bound, Real) and bound == bound for bound in numbers):
        raise SelectionError(f"{name} = {bounds!r:.40}: give two numbers such as (3, 10); either can be None")
    low, high = (None if bound is None else _plain_number(name, bound) for bound in pair)
    if low is not None and high is not None and low > high:
        raise SelectionError(f"{name} = {bounds!r:.40} runs backwards: give {(high, low)}")
    return low, high


def plain_values(parameters: Mapping[str, object]) -> dict[str, str | int | float]:
    """Return values of names in SQL as texts and numbers that SQLite stores as such."""
    if not isinstance(parameters, Mapping):
        raise SelectionError(f"parameters = {parameters!r:.40}: give a dict of values for names in the SQL")
    if odd := [name for name in parameters if not str(name).isidentifier()]:
        raise SelectionError(f"parameters: {odd[0]!r:.40} is not a name such as :cut")
    return {name: plain_value(name, value) for name, value in parameters.items()}


def plain_value(name: str, value: object) -> str | int | float:
    """Return a text or a number of any type as one that SQLite stores as such.

    Raises `SelectionError`, which names the value, for anything else.
    """
    if isinstance(value, str):
        return str(value)
    if isinstance(value, Real):
        return _plain_number(name, value)
    raise SelectionError(f"{name} = {value!r:.40}: give a number or a text")


def _plain_number(name: str, value: Real) -> int | float:
    try:
        whole = int(value) if isinstance(value, Integral) else None
        return float(value) if whole is None or abs(whole) >= _LARGEST else whole
    except OverflowError:
        raise SelectionError(f"{name}: {value!r:.20}... is too large") from None


_LARGEST = 2**63
"""SQLite's whole numbers are less than this; larger ones become real numbers."""


_PERIODS = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")
_MOST_RANGES, _MOST_CODES = 100, 10_000


def parse_periods(text: str) -> tuple[tuple[int, int], ...]:
    """Read ranges of periods such as ``11``, ``2-8`` or ``2,3,5-7``."""
    ranges = []
    for part in text.split(","):
        span = _PERIODS.fullmatch(part.strip())
        if span is None:
            raise SelectionError(f"periods {text!r}: write them as 11, 2-8 or 2,3,5-7")
        low, high = int(span[1]), int(span[2] or span[1])
        if low > high:
            remedy = f"write {high}-{low}" if high >= LEAST_PERIOD else f"the least period is {LEAST_PERIOD}"
            raise SelectionError(f"periods {part.strip()!r} run backwards: {remedy}")
        ranges.append((low, high))
    if len(ranges) > _MOST_RANGES:  # SQLite allows 1000 terms
        raise SelectionError(f"periods: {len(ranges)} ranges, more than {_MOST_RANGES}; join some, as in 2-8")
    return tuple(ranges)


def check_periods(spans: Iterable[tuple[int, int]]) -> tuple[int, ...]:
    """Return the periods in the given ranges, ascending; raise `InputError` if one cannot be filled."""
    periods: set[int] = set()
    for low, high in spans:
        if (least := min(low, high)) < LEAST_PERIOD:
            raise InputError(f"period {least}: the least period is {LEAST_PERIOD}")
        if (most := max(low, high)) > MAX_PERIOD:
            raise InputError(f"period {most}: the highest period is {MAX_PERIOD}")
        periods.update(range(low, high + 1))
    return tuple(sorted(periods))


def periods_to_make(p: int | str | Iterable[int]) -> tuple[int, ...]:
    """Return the periods of which to make data, ascending.

    A single number, which can be a text, means all periods up to it. Other texts, such as ``2,3,5-7``, and
    iterables give exactly these periods.

    Raises `InputError` if no period is given, or one of them cannot be filled.
    """
    text = listed(p)
    several = not isinstance(p, str) and isinstance(p, Iterable)
    if several or "-" in text[1:] or "," in text:
        return check_periods(parse_periods(text))
    try:
        highest = parse_int(text)
    except ValueError:
        raise SelectionError(f"periods {text!r:.40}: write them as 11, 2-8 or 2,3,5-7") from None
    return check_periods([(LEAST_PERIOD, highest)])


def parse_bound(text: str) -> tuple[str, Bounds]:
    """Read bounds on a measure such as ``length=3:10``, ``margin=:1e-4`` or ``lambda_c=0.4:``."""
    name, _, span = (part.strip() for part in text.partition("="))
    if name not in MEASURES:
        raise SelectionError(f"range {text!r}: name one of {', '.join(MEASURES)}, as in length=3:10")
    try:
        ends = [span] * 2 if name in COUNTED and ":" not in span else span.split(":")
        low, high = (real(end) if end.strip() else None for end in ends)
        if (low, high) == (None, None) or low != low or high != high:
            raise ValueError(text)
    except ValueError:
        raise SelectionError(f"range {text!r}: write it as {name}=3:10, {name}=3: or {name}=:10") from None
    if low is not None and high is not None and low > high:
        raise SelectionError(f"range {text!r} runs backwards: write {name}={high:g}:{low:g}")
    return name, (low, high)


def parse_bounds(texts: Iterable[str]) -> dict[str, Bounds]:
    """Read bounds on measures; if there are several bounds on the same measure, they all apply."""
    ranges: dict[str, Bounds] = {}
    for name, bounds in map(parse_bound, texts):
        low, high = zip(ranges.get(name, (None, None)), bounds, strict=True)
        ranges[name] = (
            max((bound for bound in low if bound is not None), default=None),
            min((bound for bound in high if bound is not None), default=None),
        )
    return ranges


def parse_symmetry(text: str) -> str:
    """Read a symmetry label: elements in any order, such as ``x,T,xT``, or ``1`` for no symmetry."""
    check_text("symmetry", text, "x,T,xT")
    names = {part.strip() for part in text.split(",")}
    if names == {"1"}:
        return "1"
    if not names <= set(NAMES[1:]):
        raise SelectionError(f"symmetry {text!r}: use 1, or some of {', '.join(NAMES[1:])} with commas")
    group = label(smallest_group(map(NAMES.index, names)))
    if set(group.split(",")) != names:
        raise SelectionError(
            f"symmetry {text!r} is not a group: the smallest group that contains it is {group}"
        )
    return group


def parse_statuses(value: Status | str | Iterable[Status | str]) -> tuple[Status, ...]:
    """Read statuses, also as a text with commas; ``all`` or an empty list means every status."""
    text = listed(value)
    if isinstance(value, Collection) and not isinstance(value, str) and not value:
        return ()
    if text.strip() == "all":
        return STORED
    try:
        statuses = tuple(dict.fromkeys(Status(part.strip()) for part in text.split(",")))
    except ValueError:
        allowed = ", ".join(STORED)
        raise SelectionError(f"status {text!r}: use {allowed}, some of them with commas, or all") from None
    if Status.FAMILY in statuses:
        raise SelectionError(
            f"status {text!r}: the bouncing-ball family is never stored: 'orbitdb query 02' describes it"
        )
    return statuses


def _each(
    given: Mapping[str, Any], name: str, read: Callable[[Any], _Value], most: int = _MOST_RANGES
) -> tuple[_Value, ...]:
    """Read one value or several of a criterion, and drop duplicates."""
    values = given.get(name, ())
    alone = isinstance(values, str) or not isinstance(values, Iterable)
    found = tuple(dict.fromkeys(map(read, (values,) if alone else values)))
    if len(found) > most:
        raise SelectionError(f"{name}: {len(found)} values, more than {most}; give fewer")
    return found


def _code(word: str) -> str:
    return least_rotation(parse_primitive(word))


def _half_length(a: float) -> float:
    return Stadium(a).a
