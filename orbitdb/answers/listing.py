"""`Listing`: rows of chosen subsets, read when they are asked for, and what a reader must know about them."""

import heapq
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cmp_to_key
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbitdb import __version__
from orbitdb.answers.completeness import Coverage, complete_length
from orbitdb.answers.results import MOST_ROWS, Result
from orbitdb.columns import Row
from orbitdb.criteria import unknown_column
from orbitdb.display import MOST_SHOWN, columns_of, data_frame, text_table
from orbitdb.output_files import check_rows, write_file
from orbitdb.selection import Selection
from orbitdb.store.conditions import parse_order
from orbitdb.store.file import read_whole
from orbitdb.store.select import ROW_COLUMNS, Words, count, rows_of
from orbitdb.store.sqlite import Connection, path_of
from orbitdb.text import format_float, several

if TYPE_CHECKING:
    import pandas

_NATURAL = ("p", "representative", "element")
"""The columns that decide the order of rows with equal sort keys."""

_falling: Callable[[Any], Any] = cmp_to_key(
    lambda one, other: 0 if one == other else 1 if one < other else -1
)
"""Sort key for descending order."""


@dataclass(eq=False, repr=False)
class Listing:
    """The rows of a subset, or of a subset at several values of a, merged into one order.

    Nothing is read before it is asked for. Outside a snapshot, each question reads the file as it then is.

    Attributes
    ----------
    selections : tuple of Selection
        What was chosen, once for each a.
    columns : tuple of str
        The columns of the rows.
    order : str
        The columns to sort by.
    limit, offset : int or None, int
        Maximum number of rows, and number of rows skipped first; both at each a.
    classes : bool
        Whether each symmetry class with chosen words has one row, that of the least of them.
    on_a : tuple of str
        The last of the notes if no a was named: which one was taken.

    Examples
    --------
    >>> listing = catalogue.rows(p="2-11", order="length", limit=2, columns=("code", "length"))
    >>> [code for code, _ in listing], listing.total
    (['13', '013'], 47157)
    >>> listing.complete[0].partition(";")[0]
    'complete, by proof, up to length 11.53'
    """

    _reading: Callable[[], AbstractContextManager[Connection]]  # of its catalogue
    selections: tuple[Selection, ...]
    columns: tuple[str, ...]
    order: str = "p"
    limit: int | None = None
    offset: int = 0
    classes: bool = False
    on_a: tuple[str, ...] = ()
    _known: tuple[Connection, list[int]] | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        for name in self.columns:
            if name not in ROW_COLUMNS:
                raise unknown_column(name, ROW_COLUMNS)
        parse_order(self.order)  # refuses unknown columns, too

    def __iter__(self) -> Iterator[Row]:
        """Yield the rows; missing values are None."""
        with self._reading() as connection:
            yield from self._rows(connection, self._end)

    def head(self, most: int = MOST_ROWS) -> Iterator[Row]:
        """Yield the first rows."""
        with self._reading() as connection:
            yield from self._head(connection, most)

    def _head(self, connection: Connection, most: int) -> Iterator[Row]:
        end = self.offset + most
        return islice(self._rows(connection, end if self._end is None else min(end, self._end)), most)

    def _rows(self, connection: Connection, end: int | None) -> Iterator[Row]:
        subsets = [Words(chosen, self.order, self.classes) for chosen in self.selections]
        if len(subsets) > 1:
            return self._merged(connection, subsets, end)
        return rows_of(connection, subsets[0], self.columns, self.offset, end)

    @property
    def total(self) -> int:
        """Number of rows without limit and offset."""
        with self._reading() as connection:
            return self._total(connection)

    @property
    def empty(self) -> bool:
        """Whether no row is stored."""
        return not self.total

    @property
    def notes(self) -> tuple[str, ...]:
        """What is missing: partial or unfilled periods, births, or all rows; one line each."""
        with self._reading() as connection:
            return self._notes(connection)

    @property
    def gaps(self) -> tuple[str, ...]:
        """The notes on partial or unfilled periods and on births, which need no rows."""
        with self._reading() as connection:
            return self._gaps(connection)

    @property
    def absent(self) -> tuple[str, ...]:
        """The last of the notes if there is no row: that nothing is found, a line for each a."""
        with self._reading() as connection:
            return self._absent(connection)

    @property
    def complete(self) -> tuple[str, ...]:
        """Up to which length orbits that a length sorts or bounds are complete, a line for each a.

        If there is no row, only what is proved counts.
        """
        with self._reading() as connection:
            return self._complete(connection)

    def _notes(self, connection: Connection) -> tuple[str, ...]:
        absent = self._absent(connection)  # first, because it refuses a wrong expression
        return (*self._gaps(connection), *absent, *self.on_a)

    def _gaps(self, connection: Connection) -> tuple[str, ...]:
        covered = (Coverage(connection, chosen) for chosen in self.selections)
        return tuple(line for one in covered for line in one.gaps(self.columns, self.order))

    def _absent(self, connection: Connection) -> tuple[str, ...]:
        if self._total(connection):
            return ()
        return tuple(filter(None, (Coverage(connection, chosen).nothing() for chosen in self.selections)))

    def _complete(self, connection: Connection) -> tuple[str, ...]:
        covered = [Coverage(connection, chosen) for chosen in self.selections]
        if not self._total(connection):
            covered = [one for one in covered if complete_length(one.fills, one.chosen)]
        lines = [(one.chosen.a, one.complete(self.order)) for one in covered]
        at = "at a = {}: " if len(lines) > 1 else ""
        return tuple(f"{at.format(format_float(a))}{line}" for a, line in lines if line)

    def describe(self, total: int | None = None) -> str:
        """Describe the chosen rows in one line, with every a that has rows, and their number if given."""
        with self._reading() as connection:
            return self._described(connection, total)

    def _described(self, connection: Connection, total: int | None = None) -> str:
        first, values = self.selections[0], [chosen.a for chosen in self._with_rows(connection)]
        if not self.classes:
            return first.describe(values, total)
        number = "classes" if total is None else several(total, "class", "classes")
        return f"{number} of {first.describe(values)}"

    def provenance(self, many: bool | None = None) -> dict[str, Any]:
        """Return where the rows come from; if `many`, a and the partial periods are lists.

        They have an item for each a with rows.
        """
        with self._reading() as connection:
            return self._provenance(connection, len(self.selections) > 1 if many is None else many)

    def _provenance(self, connection: Connection, many: bool) -> dict[str, Any]:
        selections = self._with_rows(connection)
        values = [chosen.a for chosen in selections]
        partial = [Coverage(connection, chosen).partial for chosen in selections]
        return {
            "orbitdb": __version__,
            "selection": self._described(connection),
            "order": self.order,
            "limit": self.limit,
            "offset": self.offset,
            "a": values if many else values[0],
            "database": str(path_of(connection).resolve()),
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "partial": partial if many else partial[0],
        }

    def write(self, path: Path | str, form: str | None = None, *, force: bool = False) -> int:
        """Write the rows, with all digits, and where they come from; return the number of rows.

        Parameters
        ----------
        path : path-like
            A file whose name ends in .csv, .tsv, .json, .jsonl or .parquet (extra ``parquet``). Those that
            are text get a second file for their provenance, such as ``orbits.csv-metadata.json``.
        form : str, optional
            The format, if the name does not say which.
        force : bool, optional
            Whether to replace an existing file.
        """
        file = Path(path)
        kind = check_rows(file, form, force)
        with self._reading() as connection:
            provenance = self._provenance(connection, len(self.selections) > 1)
            rows = read_whole(connection, self._rows(connection, self._end))
            return write_file(file, kind, self.columns, rows, provenance)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the rows as a data frame (extra ``pandas``)."""
        with self._reading() as connection:
            rows = list(self._rows(connection, self._end))
            return data_frame(rows, self.columns, selection=self._described(connection))

    def __repr__(self) -> str:
        with self._reading() as connection:
            rows, subject = list(self._head(connection, MOST_SHOWN + 1)), self._described(connection)
        if len(rows) > MOST_SHOWN:
            return f"<{subject}: {', '.join(self.columns)}>"
        table = text_table(columns_of(self.columns, rows), MOST_SHOWN) if rows else ()
        return "\n".join([f"<{subject}>", *table])

    def _repr_html_(self) -> str:
        with self._reading() as connection:
            columns = columns_of(self.columns, list(self._head(connection, MOST_ROWS)))
            facts = (self._described(connection, self._total(connection)),)
            notes = (*self._notes(connection), *self._complete(connection))
        return Result(self.selections[0], columns, facts, notes)._repr_html_()

    @property
    def _end(self) -> int | None:
        return None if self.limit is None else self.limit + self.offset

    def _with_rows(self, connection: Connection) -> Sequence[Selection]:
        """Return the selections that have rows; if none has any, return all of them."""
        if len(self.selections) == 1:
            return self.selections
        pairs = zip(self.selections, self._counts(connection), strict=True)
        return [chosen for chosen, number in pairs if number] or self.selections

    def _total(self, connection: Connection) -> int:
        return sum(self._counts(connection))

    def _counts(self, connection: Connection) -> list[int]:
        """Return the number of rows at each a, which is kept for further questions at the same moment."""
        if self._known is None or self._known[0] is not connection:
            self._known = connection, [count(connection, one, self.classes) for one in self.selections]
        return self._known[1]

    def _merged(self, connection: Connection, subsets: Sequence[Words], end: int | None) -> Iterator[Row]:
        """Merge the rows at several a; empty fields come last, whether the order ascends or descends."""
        falling = parse_order(self.order)
        for name in _NATURAL:
            falling.setdefault(name, False)
        width = len(self.columns)

        def place(row: Row) -> tuple[Any, ...]:
            keys = zip(row[width:], falling.values(), strict=True)
            return tuple(
                (value is None, _falling(value) if falls and value is not None else value)
                for value, falls in keys
            )

        streams = (
            rows_of(connection, chosen, (*self.columns, *falling), self.offset, end) for chosen in subsets
        )
        return (row[:width] for row in heapq.merge(*streams, key=place))
