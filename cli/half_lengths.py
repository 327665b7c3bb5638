"""Several values of a: how they are typed, and how what is found at each of them becomes one answer."""

import heapq
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue

ALL = "all"
"""Stands for every a at which something is stored."""

Row = Sequence[Any]


def several(asked: Sequence[str] | None) -> bool:
    """Tell whether more than one a may be meant, so that rows have to name theirs."""
    return asked is not None and (len(asked) > 1 or asked[0] == ALL or ":" in asked[0])


def named(asked: Sequence[str] | None) -> tuple[float, ...] | None:
    """Return the values of a that are named, each once; None for all that are stored, and where none is.

    Raises
    ------
    InputError
        If one of them cannot be read, or there is no such stadium, or some are named beside all.
    """
    from orbitdb.cli.grid import lengths

    if not asked:
        return None
    if ALL in asked:
        if len(asked) > 1:
            raise InputError(f"--a {ALL} is every a that is stored: leave out the others, or name each")
        return None
    return tuple(dict.fromkeys(a for text in asked for a in lengths(text)))


def stored(catalogue: "Catalogue") -> tuple[float, ...]:
    """Return every a of which the catalogue has orbits, or sums of them; if there is none, the usual one."""
    from orbitdb.cli.options import USUAL_A

    return tuple(catalogue.stadiums()) or (USUAL_A,)


def with_a(names: Sequence[str]) -> tuple[str, ...]:
    """Return names of columns with a among them: behind those that are of the word, or before them all."""
    if "a" in names:
        return tuple(names)
    place = 1 if names[:1] in (("code",), ("word",)) else 0
    return (*names[:place], "a", *names[place:])


@dataclass(frozen=True)
class Answer:
    """What is found at one a: names of columns, and rows."""

    a: float
    names: Sequence[str]
    rows: Iterable[Row]


def joined(answers: Sequence[Answer], many: bool) -> tuple[list[str], list[Row]]:
    """Return the names and rows of all answers; of many with a before them, blank where one has no column."""
    if not many:
        return list(answers[0].names), list(answers[0].rows)
    names = list(dict.fromkeys(name for each in answers for name in each.names))
    known = ((each.a, dict(zip(each.names, row, strict=True))) for each in answers for row in each.rows)
    return ["a", *names], [(a, *map(row.get, names)) for a, row in known]


class _Falling:
    """A value in falling order."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Falling) and self.value == other.value

    def __lt__(self, other: "_Falling") -> bool:
        return bool(other.value < self.value)


def merged(
    streams: Sequence[Iterable[tuple[Any, ...]]], falling: Sequence[bool], limit: int | None, offset: int = 0
) -> Iterator[tuple[Any, ...]]:
    """Merge rows that are in order, each at its own a, into rows that are in order; of equal ones by a.

    Parameters
    ----------
    streams : sequence of iterables
        Rows that end in what they are sorted by.
    falling : sequence of bool
        Which of that falls. What is empty is last, whichever way it goes.
    limit, offset : int
        How many rows at most, and how many to pass over first.

    Yields
    ------
    tuple
        Rows without what they are sorted by.
    """
    count = len(falling)

    def place(row: Row) -> tuple[Any, ...]:
        return tuple(
            (value is None, _Falling(value) if falls else value)
            for value, falls in zip(row[-count:], falling, strict=True)
        )

    rows = heapq.merge(*streams, key=place)
    for row in islice(rows, offset, None if limit is None else offset + limit):
        yield row[:-count]
