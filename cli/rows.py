"""Answers of one a or of several as rows: their columns, their order, and writing them to stdout."""

import heapq
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

import typer

from orbitdb.cli.options import Format
from orbitdb.cli.render import note
from orbitdb.cli.render import write as write_rows

if TYPE_CHECKING:
    from orbitdb.catalogue.results import Result
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
Reading = Callable[["Selection", tuple[str, ...], int | None, int], Iterator[Row]]
"""Gives rows of a subset at one a that begin with some columns: so many at most, others passed over first."""


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
    rows: Iterable[Sequence[Any]]


def joined(answers: Sequence[Answer], many: bool) -> tuple[list[str], list[Sequence[Any]]]:
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

    def place(row: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(
            (value is None, _Falling(value) if falls else value)
            for value, falls in zip(row[-count:], falling, strict=True)
        )

    rows = heapq.merge(*streams, key=place)
    for row in islice(rows, offset, None if limit is None else offset + limit):
        yield row[:-count]


def in_order(
    read: Reading,
    stadiums: Sequence["Selection"],
    names: tuple[str, ...],
    order: str,
    limit: int | None,
    offset: int = 0,
) -> Iterator[Row]:
    """Return rows of a subset at one a, or at several as if they were one; of equal ones by a."""
    if len(stadiums) == 1:
        return read(stadiums[0], names, limit, offset)
    from orbitdb.store.asking.conditions import parse_order

    falling = parse_order(order)
    for name in _NATURAL:
        falling.setdefault(name, False)
    most = None if limit is None else limit + offset
    streams = [
        _keys_last(read(chosen, (*names, *falling), most, 0), len(names), len(falling)) for chosen in stadiums
    ]
    return merged(streams, list(falling.values()), limit, offset)


def _keys_last(rows: Iterable[Row], start: int, count: int) -> Iterator[Row]:
    end = start + count
    return ((*row[:start], *row[end:], *row[start:end]) for row in rows)


_WORDS = ("code", "word", "representative", "sequence")


def with_marks(names: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    """Give words in a form that no program takes for numbers: w01023."""
    from orbitdb.symbols.words import MARK

    places = [place for place, name in enumerate(names) if name in _WORDS]
    for row in rows:
        marked = list(row)
        for place in places:
            marked[place] = None if row[place] is None else f"{MARK}{row[place]}"
        yield tuple(marked)


Write = Callable[[Sequence[str], Sequence[Sequence[Any]]], object]


def write_results(
    found: "Sequence[Result]",
    many: bool,
    form: Format,
    hidden: Collection[str] = (),
    write: Write | None = None,
) -> None:
    """Write what is found at one a, or at several, and its notes; leave if there is nothing.

    Parameters
    ----------
    found : sequence of Result
    many : bool
        Whether there may be several a, which are named then.
    form : Format
    hidden : collection of str, optional
        Columns that a table does without, as a note tells of them.
    write : callable, optional
        What writes the table, by default as usual.
    """
    for each in found:
        for text in (*each.notes, *(each.facts if form is Format.TABLE else ())):
            here = f"a = {each.selection.a:g}"
            note(f"{here}: {text}" if many and here not in text else text)
    answers = []
    for each in filter(len, found):
        names = [name for name in each.columns if form is not Format.TABLE or name not in hidden]
        answers.append(Answer(each.selection.a, names, [list(row) for row in each.rows(names)]))
    if not answers:
        raise typer.Exit(1)
    names, rows = joined(answers, many)
    if write is not None:
        write(names, rows)
    else:
        write_rows(names, rows, form)
