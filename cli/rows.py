"""Rows of the catalogue for other programs, and what their columns are, in short."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from orbitdb.cli.half_lengths import merged
from orbitdb.columns import IN_CATALOGUE

if TYPE_CHECKING:
    from orbitdb.column_blocks import ColumnBlock
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue

KEYS = (
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "margin", "residual", "error",
    "length_error", "lyapunov_error", "symmetry", "solver",
)  # fmt: skip
"""The columns that are written where none are named; other programs may rely on them as keys of JSON."""

_WIDTH = max(len(each.name) for each in IN_CATALOGUE)

COLUMNS_HELP = "\n".join([
    "\b",
    "Columns (see 'orbitdb columns'):",
    *(f"  {each.name:{_WIDTH}}  {each.brief}" for each in IN_CATALOGUE),
])  # fmt: skip
"""The columns for the end of a command's help, a line each, which is not to be wrapped."""


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
    for name in ("p", "code"):
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


def with_rules(names: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    """Give the rules broken as a list of numbers."""
    from orbitdb.store.asking.conditions import rules_of

    if "rules" not in names:
        yield from rows
        return
    place = names.index("rules")
    for row in rows:
        yield (*row[:place], rules_of(row[place]), *row[place + 1 :])


def ready_lines(
    catalogue: "Catalogue",
    stadiums: Sequence["Selection"],
    names: tuple[str, ...],
    order: str,
    form: str,
    mark: bool,
) -> Iterator[str] | None:
    """Return all rows of a subset at one a as ready lines of a text; None where they are not so many."""
    from orbitdb.export import LINES
    from orbitdb.store.reading.spread import spread_lines

    if form not in LINES or len(stadiums) > 1:
        return None

    def lines(rows: Iterable[Sequence[Any]]) -> Iterator[str]:
        told = with_rules(names, map(tuple, rows))
        return LINES[form](names, with_marks(names, told) if mark else told)

    return spread_lines(catalogue, stadiums[0], names, order, lines)


def ready_columns(
    catalogue: "Catalogue", stadiums: Sequence["Selection"], names: tuple[str, ...], order: str, form: str
) -> "Iterator[ColumnBlock] | None":
    """Return all rows of a subset at one a by columns; None where they are not so many, or form is a text."""
    from orbitdb.export import TEXT_WRITERS
    from orbitdb.store.reading.spread_columns import spread_columns

    if form in TEXT_WRITERS or len(stadiums) > 1:
        return None
    return spread_columns(catalogue, stadiums[0], names, order)
