"""`SqlResult`: the rows of a statement that a user wrote."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from html import escape
from itertools import islice
from typing import TYPE_CHECKING, Any

from orbitdb.columns import Row
from orbitdb.display import MOST_SHOWN, columns_of, data_frame, html_of, text_table
from orbitdb.sql_text import on_codes
from orbitdb.store.sqlite import Connection
from orbitdb.store.where import run_statement
from orbitdb.text import shortened

if TYPE_CHECKING:
    import pandas


@dataclass(eq=False, repr=False)
class SqlResult:
    """The columns and rows of one SELECT statement, read when they are asked for.

    Attributes
    ----------
    statement : str
    parameters : mapping
        Values for the names in the statement.
    """

    _reading: Callable[[], AbstractContextManager[Connection]]  # of its catalogue
    statement: str
    parameters: Mapping[str, str | int | float]
    _begun: tuple[Connection, tuple[str, ...], Iterator[Row]] | None = field(default=None, init=False)

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns."""
        with self._reading() as connection:
            return self._run(connection)[0]

    @property
    def absent(self) -> str:
        """What to say if the statement finds no row; if it reads codes, also how to write them."""
        return "; ".join(filter(None, ["no rows", on_codes(self.statement)]))

    def __iter__(self) -> Iterator[Row]:
        """Yield the rows; BLOBs become hexadecimal digits."""
        with self._reading() as connection:
            _, rows = self._run(connection)
            self._begun = None
            yield from rows

    def _run(self, connection: Connection) -> tuple[tuple[str, ...], Iterator[Row]]:
        """Begin to run the statement, unless it has been begun at this moment."""
        if self._begun is None or self._begun[0] is not connection:
            self._begun = connection, *run_statement(connection, self.statement, self.parameters)
        return self._begun[1:]

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the rows as a data frame (extra ``pandas``)."""
        with self._reading() as connection:
            names, rows = self._run(connection)
            return data_frame(list(rows), names)

    def __repr__(self) -> str:
        title, columns = self._shown()
        return "\n".join([f"<{title}>", *text_table(columns, MOST_SHOWN)])

    def _repr_html_(self) -> str:
        title, columns = self._shown()
        return f"<p>{escape(title)}</p>{html_of(columns)}"

    def _shown(self) -> tuple[str, dict[str, list[Any]]]:
        """Return a title and the columns of the first rows."""
        with self._reading() as connection:
            names, begun = self._run(connection)
            rows = list(islice(begun, MOST_SHOWN + 1))
        some = f"the first {MOST_SHOWN} " * (len(rows) > MOST_SHOWN)
        return f"{some}rows of {shortened(self.statement)!r}", columns_of(names, rows[:MOST_SHOWN])
