"""Run SQL that users write: expressions for ``where``, and the statements of ``orbitdb sql``.

SQLite itself reads the SQL. It runs on a connection that cannot write, may only read and call functions, and
is stopped after `SECONDS` or if it is no longer wanted.
"""

import sqlite3
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import sqlalchemy as sa

from orbitdb.store.codes import NAMES, Parameters, bound_names, check_words
from orbitdb.store.connection import add_code, driver
from orbitdb.store.schema import SHARED, TABLES, VIEWS
from orbitdb.store.selection import SelectionError
from orbitdb.store.tables import catalogue
from orbitdb.text import guess, line, shortened

SECONDS = 60.0
"""Time limit in seconds for a statement, or for a query with a free expression."""

STEPS_BETWEEN_LOOKS = 200_000
"""SQLite steps between checks, a few milliseconds; a check has to wait while Python is busy."""
_STEPS_BETWEEN_SIGNALS = 1_000_000

READABLE = (*VIEWS, *TABLES)
"""The views and tables, with the views first, which people use most."""

_BLOCK = 2000
_ALLOWED = {
    sqlite3.SQLITE_SELECT,
    sqlite3.SQLITE_READ,
    sqlite3.SQLITE_FUNCTION,
    sqlite3.SQLITE_RECURSIVE,
}
_OF_CLASSES = SHARED.keys() - {"cycle"}  # an index on ids would change the order of the rows
_STOPPED = ("interrupted", "not authorized", "prohibited", "user-defined function")
"""Parts of the messages of SQLite if a function of Python fails or refuses to go on."""


def never() -> bool:
    """Return False: the query is never cancelled."""
    return False


class CancelledError(Exception):
    """The answer is no longer wanted."""


class Patience:
    """How long a query may still run: for a number of seconds from now, unless it is cancelled.

    The `deadline` is a time on the clock of `time.monotonic`. A caller that fetches rows in blocks adds the
    time that passes between the blocks. SQLite calls `look` and `authorize`; if one of them stops the query,
    it leaves the `reason`. Without a reason, it was Ctrl-C that made the call fail.
    """

    def __init__(self, seconds: float | None = None, cancelled: Callable[[], bool] = never) -> None:
        self.deadline = time.monotonic() + (SECONDS if seconds is None else seconds)
        self.cancelled = cancelled
        self.was_cancelled = False
        self.reason = ""

    def look(self) -> bool:
        """Tell SQLite whether to stop, because the time is up or the query has been cancelled."""
        self.was_cancelled = self.cancelled()
        if self.was_cancelled:
            self.reason = "cancelled"
        elif time.monotonic() > self.deadline:
            self.reason = f"it took more than {SECONDS:g} s"
        return bool(self.reason)

    def authorize(self, action: int, _: str | None, name: str | None, *_others: str | None) -> int:
        """Tell SQLite whether the user's SQL may do this."""
        if action in _ALLOWED and name != "load_extension":
            return sqlite3.SQLITE_OK
        self.reason = "it may only read"
        return sqlite3.SQLITE_DENY


@contextmanager
def watched(
    connection: sqlite3.Connection, patience: Patience, sql: str | None = None, what: str = "where"
) -> Iterator[None]:
    """Run a query under a time limit; with `sql`, written by a user, let it only read.

    To fetch more rows later, open another such context with the same `patience`. Raises `CancelledError` if
    the query is cancelled, `KeyboardInterrupt` on Ctrl-C, and a `SelectionError` about the `sql` for any
    other error.
    """
    connection.set_progress_handler(patience.look, STEPS_BETWEEN_LOOKS)
    if sql is not None:
        connection.set_authorizer(patience.authorize)
    try:
        yield
    except (sa.exc.DBAPIError, sqlite3.Error, sqlite3.Warning, ValueError, OverflowError) as error:
        if patience.was_cancelled:
            raise CancelledError from error
        message = str(getattr(error, "orig", error))
        if not patience.reason and any(part in message for part in _STOPPED):
            raise KeyboardInterrupt from error
        if sql is None or isinstance(error, SelectionError):
            raise
        raise SelectionError(_refusal(sql, patience.reason or message, what)) from error
    finally:
        with suppress(sqlite3.ProgrammingError):  # SQLAlchemy closes a connection on Ctrl-C
            connection.set_authorizer(None)
            connection.set_progress_handler(never, _STEPS_BETWEEN_SIGNALS)


# expressions


def check(where: str, parameters: Parameters) -> None:
    """Raise `SelectionError` if an expression is invalid."""
    of_classes(where, parameters)


def of_classes(where: str, parameters: Parameters) -> bool:
    """Check an expression; tell whether it has the same value for all words of a class.

    It does if it contains no subquery and reads only columns that the words of a class share.

    Raises
    ------
    SelectionError
        If SQLite cannot compile it, a name has no value, or a code is compared with a number.
    """
    patience, stage = Patience(), _stage()
    columns: set[str | None] = set()
    queries = 0

    def note(action: int, table: str | None, column: str | None, *names: str | None) -> int:
        nonlocal queries
        queries += action == sqlite3.SQLITE_SELECT
        if action == sqlite3.SQLITE_READ and table == catalogue.name:
            columns.add(column)
        return patience.authorize(action, table, column, *names)

    with watched(stage, patience, where):
        stage.set_authorizer(note)
        for text in (where, f"(\n{where}\n)"):  # the first refuses a bracket too many
            queries = 0
            stage.execute(f"EXPLAIN SELECT 1 FROM catalogue WHERE {text}", dict(parameters))
        _check_names(where, parameters)
    check_words(where, parameters)
    return columns <= _OF_CLASSES and queries == 1


def expression(where: str, parameters: Parameters) -> sa.TextClause:
    """Return an expression as an SQL clause, bound to its named values."""
    text = NAMES.sub(lambda name: name[0] if name[1] in parameters else name[0].replace(":", "\\:"), where)
    return sa.text(f"(\n{text}\n)").bindparams(**parameters)


def _check_names(sql: str, parameters: Parameters) -> None:
    """Raise `ValueError` unless the names in SQL are those of the values."""
    if idle := parameters.keys() - set(bound_names(sql)):
        raise ValueError(f"it has no :{', :'.join(sorted(idle))}: leave out its value")


_kept = threading.local()


def _stage() -> sqlite3.Connection:
    """Return an empty database, in which a table stands in for the view ``catalogue``."""
    stage: sqlite3.Connection | None = getattr(_kept, "stage", None)
    if stage is None:
        stage = sqlite3.connect(":memory:")
        for text in (*TABLES.values(), *(text for name, text in VIEWS.items() if name != catalogue.name)):
            stage.execute(text)
        columns = ", ".join(catalogue.c.keys())
        stage.execute(f"CREATE TABLE catalogue ({columns}, PRIMARY KEY (a, p, code)) WITHOUT ROWID")
        add_code(stage)
        _kept.stage = stage
    return stage


# statements


def run_statement(
    connection: sa.Connection, statement: str, parameters: Parameters
) -> tuple[tuple[str, ...], Iterator[tuple[Any, ...]]]:
    """Run a SELECT; return the names of its columns, and an iterator over its rows.

    Raises `SelectionError` if the statement is not a single SELECT, gives two columns the same name, or takes
    too long.
    """
    patience, own = Patience(), driver(connection)
    check_words(statement, parameters)
    with watched(own, patience, statement, "sql"):
        _check_names(statement, parameters)
        cursor = own.execute(statement, dict(parameters))
        if cursor.description is None:
            raise ValueError("write a single SELECT")
    names = tuple(column for column, *_ in cursor.description)
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(
            _refusal(statement, f"column {twice[0]!r} occurs twice: rename one of them with AS", "sql")
        )
    return names, _fetched(own, statement, cursor, patience)


def _fetched(
    connection: sqlite3.Connection, statement: str, cursor: sqlite3.Cursor, patience: Patience
) -> Iterator[tuple[Any, ...]]:
    while True:
        with watched(connection, patience, statement, "sql"):
            block = cursor.fetchmany(_BLOCK)
        if not block:
            return
        begun = time.monotonic()
        # BLOBs become hexadecimal digits, which every format can write
        yield from (tuple(v.hex() if isinstance(v, bytes) else v for v in row) for row in block)
        patience.deadline += time.monotonic() - begun  # the time that the caller took


def _refusal(sql: str, message: str, what: str) -> str:
    """Return a message that says which SQL was refused, why, and what to change."""
    _, no_table, name = message.partition("no such table: ")
    if no_table:
        message = f"{message}: {guess(name, READABLE)}it can read {', '.join(READABLE)}"
    elif "no such column" in message:
        name = message.split()[-1]
        where_from = "only catalogue has it; " if name in catalogue.c else guess(name, catalogue.c.keys())
        message = f"{message}; {where_from}'orbitdb columns' lists all columns"
    elif "binding" in message.lower():
        message = f"{message.rstrip('.')}: give each :name a value, with -P name=value or in parameters"
    elif message == "it may only read":
        message = "it may only read, with a single SELECT"
    return line(f"{what} {shortened(sql, 200)!r}: {message}")
