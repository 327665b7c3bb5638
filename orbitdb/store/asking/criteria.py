"""Criteria: plain values that choose a subset, and the resulting selection."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from inspect import Parameter, Signature, signature
from numbers import Real
from typing import Any, TypedDict, TypeVar

from orbitdb.billiard import USUAL_A
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.status import Status
from orbitdb.store.asking.parsing import (
    parse_exists,
    parse_periods,
    parse_reversal,
    parse_statuses,
    parse_symmetry,
)
from orbitdb.store.asking.periods import fillable
from orbitdb.store.asking.selection import MEASURES, Bounds, Selection, SelectionError
from orbitdb.symbols.words import parse

_AS_OPTIONS = {"range": "the name of what is bounded, as in length=(3, 10)"}
"""Hints for names of options that differ from those of criteria."""


class Criteria(TypedDict, total=False):
    """The criteria of a subset, as keyword arguments of `chosen_by`."""

    a: float | None
    p: int | str | Iterable[int] | None
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
    """Decorator that shows each of the ``**criteria`` of a method in help and completion."""
    *kept, _ = signature(method).parameters.values()
    named = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=kind)
        for name, kind in Criteria.__annotations__.items()
    ]
    method.__signature__ = Signature([*kept, *named])  # type: ignore[attr-defined]
    return method


def chosen_by(
    a: float | None = None,
    p: int | str | Iterable[int] | None = None,
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
    """Return a selection from plain values, as in `Catalogue.select`; a is 1.6 by default.

    Raises
    ------
    SelectionError
        If one of them cannot be used.
    """
    if unknown := sorted(set(ranges) - set(MEASURES)):
        raise _no_criterion(unknown)
    pairs = {name: _pair(name, bounds) for name, bounds in ranges.items() if bounds is not None}
    if not isinstance(where, str | None):
        raise SelectionError(f"where {where!r:.40}: give an SQL expression such as 'lambda_c < 0.4'")
    return Selection(
        a=Stadium(USUAL_A if a is None else a).a,
        periods=() if p is None else parse_periods(_listed(p)),
        statuses=() if status is None else parse_statuses(_listed(status)),
        time_reversal=None if time_reversal is None else parse_reversal(time_reversal),
        symmetry=None if symmetry is None else parse_symmetry(symmetry),
        contains=None if contains is None else parse(contains),
        exists=parse_exists(exists),
        not_at=parse_exists(not_at),
        ranges={name: pair for name, pair in pairs.items() if pair != (None, None)},
        where=where,
        parameters=parameters or {},
    )


def chosen_periods(periods: int | str | Iterable[int]) -> tuple[int, ...]:
    """Return the periods to fill, in rising order.

    Parameters
    ----------
    periods : int, str or iterable of int
        A period, text such as ``2-11`` or ``2,3,5-7``, or several: ``range(2, 12)``, a list, an array.

    Raises
    ------
    SelectionError
        If there are none, or one of them cannot be filled.
    """
    return fillable(parse_periods(_listed(periods)))


def _no_criterion(names: Sequence[str]) -> SelectionError:
    """Return the error for unknown criteria, with a suggestion for the first."""
    known = tuple(Criteria.__annotations__)
    meant = _AS_OPTIONS.get(names[0]) or next(iter(get_close_matches(names[0], known, 1)), "")
    return SelectionError(
        f"{', '.join(names)}: not a criterion{meant and f', use {meant}'}; these are {', '.join(known)}"
    )


def _listed(value: object) -> str:
    """Write values separated by commas; write a range of periods as `parse_periods` reads it."""
    if isinstance(value, range) and value.step == 1 and len(value):
        return f"{value[0]}-{value[-1]}"
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
