"""Ranges of periods: how they are read, checked and written."""

import re
from collections.abc import Iterable, Sequence

from orbitdb.errors import InputError, SelectionError
from orbitdb.symbols.enumeration import MAX_PERIOD
from orbitdb.text import parse_int

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


def listed(value: object) -> str:
    """Join values with commas; format a range so that `parse_periods` can read it."""
    if isinstance(value, range) and value.step == 1 and len(value):
        return f"{value[0]}-{value[-1]}"
    if isinstance(value, str) or not isinstance(value, Iterable):
        return str(value)
    return ",".join(map(str, value))


_PERIODS = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")
MOST_RANGES = 100
"""Maximum number of ranges in a selection, because SQLite allows 1000 terms."""


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
    if len(ranges) > MOST_RANGES:
        raise SelectionError(f"periods: {len(ranges)} ranges, more than {MOST_RANGES}; join some, as in 2-8")
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
    """Return the periods to fill or sweep, ascending.

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
