"""Ranges of periods: check, join and write them."""

from collections.abc import Iterable, Sequence

from orbitdb.errors import InputError
from orbitdb.symbols.enumeration import MAX_PERIOD

LEAST_PERIOD = 2
"""The least number of bounces of an orbit."""


def fillable(spans: Iterable[tuple[int, int]]) -> tuple[int, ...]:
    """Return the periods in some ranges in rising order; refuse those that cannot be filled."""
    found: set[int] = set()
    for low, high in spans:
        if (least := min(low, high)) < LEAST_PERIOD:
            raise InputError(f"period {least}: the least period is {LEAST_PERIOD}")
        if (most := max(low, high)) > MAX_PERIOD:
            raise InputError(f"period {most}: the highest period is {MAX_PERIOD}")
        found.update(range(low, high + 1))
    return tuple(sorted(found))


def written_periods(periods: Sequence[int]) -> str:
    """Write periods as ranges, such as "periods 2-8, 11"."""
    return written_spans(joined_spans([(p, p) for p in periods]))


def joined_spans(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return ranges of periods in order, with touching and overlapping ones joined."""
    joined: list[tuple[int, int]] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + 1:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def are_many(spans: Sequence[tuple[int, int]]) -> bool:
    """Tell whether ranges contain more than one period."""
    return len(spans) > 1 or spans[0][0] < spans[0][1]


def written_spans(spans: Sequence[tuple[int, int]]) -> str:
    """Write ranges of periods, such as "period 4" or "periods 2-8, 11"."""
    ranges = (str(low) if low == high else f"{low}-{high}" for low, high in spans)
    return f"period{'s' * are_many(spans)} {', '.join(ranges)}"
