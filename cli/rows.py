"""Rows of the catalogue at one a or at several: their columns and their order."""

import heapq
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.store.asking.selection import Selection

KEYS = (
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "walls", "maslov", "margin", "residual", "error",
    "length_error", "lyapunov_error", "symmetry", "solver",
)  # fmt: skip
"""The columns that are written where none are named; other programs may rely on them as keys of JSON."""

_NATURAL = ("p", "representative", "element")
"""What rows are sorted by in the end."""

Row = tuple[Any, ...]


def with_a(names: Sequence[str]) -> tuple[str, ...]:
    """Return names of columns with a among them: behind those that are of the word, or before them all."""
    if "a" in names:
        return tuple(names)
    place = 1 if names[:1] in (("code",), ("word",)) else 0
    return (*names[:place], "a", *names[place:])


class _Falling:
    """A value in falling order."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Falling) and self.value == other.value

    def __lt__(self, other: "_Falling") -> bool:
        return bool(other.value < self.value)


def in_order(
    catalogue: "Catalogue",
    stadiums: Sequence["Selection"],
    names: tuple[str, ...],
    order: str,
    limit: int | None,
    offset: int = 0,
) -> Iterator[Row]:
    """Return rows of a subset at one a, or at several as if they were one; of equal ones by a.

    An empty field comes last, whichever way its column is sorted.
    """
    if len(stadiums) == 1:
        return catalogue.rows(stadiums[0], names, order, limit, offset)
    from orbitdb.store.asking.conditions import parse_order

    falling = parse_order(order)
    for name in _NATURAL:
        falling.setdefault(name, False)
    end = None if limit is None else limit + offset
    streams = (catalogue.rows(chosen, (*names, *falling), order, end) for chosen in stadiums)

    def place(row: Row) -> tuple[Any, ...]:
        keys = zip(row[len(names) :], falling.values(), strict=True)
        return tuple((value is None, _Falling(value) if falls else value) for value, falls in keys)

    return (row[: len(names)] for row in islice(heapq.merge(*streams, key=place), offset, end))
