"""Periods to fill, given as numbers or as text."""

from collections.abc import Iterable

from orbitdb.errors import InputError
from orbitdb.store.selection import LEAST_PERIOD, SelectionError, listed, parse_periods
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.text import parse_int


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


def chosen_periods(periods: int | str | Iterable[int]) -> tuple[int, ...]:
    """Return the periods to fill, ascending, given as one, as a text such as ``2,3,5-7``, or as several.

    Raises `InputError` if no period is given, or one of them cannot be filled.
    """
    return check_periods(parse_periods(listed(periods)))


def periods_up_to(text: str, first: int = LEAST_PERIOD) -> tuple[tuple[int, int], ...]:
    """Read the periods to fill as `parse_periods` does, but take a single number to mean all up to it."""
    if "-" in text[1:] or "," in text:
        return parse_periods(text)
    try:
        return ((first, parse_int(text)),)
    except ValueError:
        raise SelectionError(f"periods {text!r:.40}: write them as 11, 2-8 or 2,3,5-7") from None
