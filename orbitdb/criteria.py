"""What chooses words: criteria as keyword arguments, and how each is read from Python values or a text.

A value that cannot be read raises `SelectionError`; the message says how to write it.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from inspect import Parameter, Signature, signature
from numbers import Integral, Real
from typing import Any, TypeAlias, TypedDict, TypeVar

from orbitdb.errors import SelectionError, check_text
from orbitdb.open_stadium.openings import Opening
from orbitdb.orbits.status import STORED, Status
from orbitdb.period_ranges import MOST_RANGES, listed
from orbitdb.sql_text import plain_number
from orbitdb.symbols.symmetry import NAMES, label, smallest_group
from orbitdb.text import guess, real

MEASURES = (
    "length", "quarter_length", "lyapunov", "quarter_lyapunov", "lambda_d", "lambda_c", "margin", "born",
    "dies", "walls",
)  # fmt: skip
"""The columns that a selection can bound from below and above."""

COUNTED = ("walls",)
"""Those that are whole numbers: a single value stands for itself."""

Limits: TypeAlias = tuple[float | None, float | None]
"""The least and the greatest value, both included; None if there is no limit."""

MOST_CODES = 10_000
"""Maximum number of words in a selection."""


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
    length: Limits | None
    quarter_length: Limits | None
    lyapunov: Limits | None
    quarter_lyapunov: Limits | None
    lambda_d: Limits | None
    lambda_c: Limits | None
    margin: Limits | None
    born: Limits | None
    dies: Limits | None
    walls: int | Limits | None


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


def pair_of(name: str, bounds: object) -> Limits:
    """Return bounds, after checking that they are a pair of numbers or None in ascending order."""
    alone = name in COUNTED and isinstance(bounds, Integral) and not isinstance(bounds, bool)
    pair = (bounds, bounds) if alone else tuple(bounds) if isinstance(bounds, tuple | list) else ()
    numbers = [bound for bound in pair if bound is not None]
    if len(pair) != 2 or not all(isinstance(bound, Real) and bound == bound for bound in numbers):
        raise SelectionError(f"{name} = {bounds!r:.40}: give two numbers such as (3, 10); either can be None")
    low, high = (None if bound is None else plain_number(name, bound) for bound in pair)
    if low is not None and high is not None and low > high:
        raise SelectionError(f"{name} = {bounds!r:.40} runs backwards: give {(high, low)}")
    return low, high


def parse_range(text: str) -> tuple[str, Limits]:
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


def parse_ranges(texts: Iterable[str]) -> dict[str, Limits]:
    """Read bounds on measures; if there are several bounds on the same measure, they all apply."""
    ranges: dict[str, Limits] = {}
    for name, bounds in map(parse_range, texts):
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
            f"status {text!r}: the bouncing-ball family is never stored: `catalogue.orbit('02')` describes it"
        )
    return statuses


def each_of(
    given: Mapping[str, Any], name: str, read: Callable[[Any], _Value], most: int = MOST_RANGES
) -> tuple[_Value, ...]:
    """Read one value or several of a criterion, and drop duplicates."""
    values = given.get(name, ())
    alone = isinstance(values, str) or not isinstance(values, Iterable)
    found = tuple(dict.fromkeys(map(read, (values,) if alone else values)))
    if len(found) > most:
        raise SelectionError(f"{name}: {len(found)} values, more than {most}; give fewer")
    return found


def unknown_column(name: str, columns: Sequence[str]) -> SelectionError:
    """Return the error for an unknown column; its message suggests a similar name."""
    names = ", ".join(dict.fromkeys(columns))
    return SelectionError(f"column {name!r}: {guess(str(name), columns)}the columns are {names}")
