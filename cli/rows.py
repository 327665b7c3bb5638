"""Rows of the catalogue for other programs."""

from collections.abc import Iterable, Iterator
from typing import Any

KEYS = (
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "margin", "residual", "error",
)  # fmt: skip
"""The keys of JSON output that other programs may rely on."""


def with_rules(names: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    """Give the rules broken as a list of numbers."""
    from orbitdb.store.asking.conditions import rules_of

    if "rules" not in names:
        yield from rows
        return
    place = names.index("rules")
    for row in rows:
        yield (*row[:place], rules_of(row[place]), *row[place + 1 :])
