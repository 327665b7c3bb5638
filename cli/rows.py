"""Rows of the catalogue for other programs, and what their columns are, in short."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from orbitdb.columns import IN_CATALOGUE

if TYPE_CHECKING:
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


def lines_or_rows(
    catalogue: "Catalogue",
    chosen: "Selection",
    names: tuple[str, ...],
    order: str,
    form: str,
    mark: bool,
    limit: int | None = None,
    offset: int = 0,
) -> Iterator[Any]:
    """Return rows of a subset for a writer, as ready lines where a text gets very many of them."""
    from orbitdb.export import LINES
    from orbitdb.store.reading.spread import spread_lines

    def with_all(rows: Iterable[Any]) -> Iterator[tuple[Any, ...]]:
        told = with_rules(names, (tuple(row) for row in rows))
        return with_marks(names, told) if mark else told

    if form in LINES and limit is None and not offset:
        make = LINES[form]
        lines = spread_lines(catalogue, chosen, names, order, lambda rows: make(names, with_all(rows)))
        if lines is not None:
            return lines
    return with_all(catalogue.rows(chosen, names, order, limit, offset))
