"""Rows of the catalogue for other programs, and what their columns are, in short."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from orbitdb.cli.half_lengths import merged

if TYPE_CHECKING:
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
