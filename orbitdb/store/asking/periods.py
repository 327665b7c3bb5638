"""Periods in words: ranges of them, joined and written."""

from collections.abc import Sequence


def written_periods(periods: Sequence[int]) -> str:
    """Write periods as ranges, such as "periods 2-8, 11"."""
    return written_spans(joined_spans([(p, p) for p in periods]))


def joined_spans(spans: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return ranges of periods in order, those that touch or overlap as one."""
    joined: list[tuple[int, int]] = []
    for low, high in sorted(spans):
        if joined and low <= joined[-1][1] + 1:
            joined[-1] = (joined[-1][0], max(high, joined[-1][1]))
        else:
            joined.append((low, high))
    return joined


def are_many(spans: Sequence[tuple[int, int]]) -> bool:
    """Tell whether ranges are of more than one period."""
    return len(spans) > 1 or spans[0][0] < spans[0][1]


def written_spans(spans: Sequence[tuple[int, int]]) -> str:
    """Write ranges of periods, such as "period 4" or "periods 2-8, 11"."""
    ranges = (str(low) if low == high else f"{low}-{high}" for low, high in spans)
    return f"period{'s' * are_many(spans)} {', '.join(ranges)}"
