"""Run SQL that users write: expressions for ``where``, and the statements of ``orbitdb sql``.

SQLite itself reads the SQL. It is first run on an empty catalogue in memory, where it may only read and call
functions; then on a connection that cannot write, where it is stopped after `SECONDS` or if it is no longer
wanted.
"""

import re
import sqlite3
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

from sqlalchemy import BindParameter, Connection, TextClause, bindparam, text

from orbitdb.columns import EVERY
from orbitdb.errors import SelectionError
from orbitdb.sql_text import LEXED, Parameters, as_typed, names_in, plain_values
from orbitdb.store import tables as t
from orbitdb.store.file import open_empty
from orbitdb.store.sqlite import (
    STEPS_BETWEEN_SIGNALS,
    Driver,
    add_word_functions,
    driver_of,
    never,
    of_file,
)
from orbitdb.store.views import CLASS_COLUMNS, VIEWS, WORD_COLUMNS
from orbitdb.text import guess, line, shortened

SECONDS = 60.0
"""Time limit in seconds for a statement, or for a query with a free expression."""

STEPS_BETWEEN_LOOKS = 200_000
"""SQLite steps between checks, a few milliseconds; a check has to wait while Python is busy."""

READABLE = (*VIEWS, *t.TABLES)
"""The views and tables, with the views first, which people use most."""

_CANCELLED = "cancelled"
_ONLY_READ = "it may only read, with a single SELECT"
_COLUMNS = (*CLASS_COLUMNS, *WORD_COLUMNS)
_BLOCK = 2000
_ALLOWED = {
    sqlite3.SQLITE_SELECT,
    sqlite3.SQLITE_READ,
    sqlite3.SQLITE_FUNCTION,
    sqlite3.SQLITE_RECURSIVE,
}
_OF_CLASSES = CLASS_COLUMNS.keys() - {"cycle"}  # an index on ids would change the order of the rows
_STOPPED = (sqlite3.SQLITE_INTERRUPT, sqlite3.SQLITE_AUTH)
_FAILED = ("user-defined function raised exception", "not authorized")
"""Codes of SQLite's errors if a function of Python fails or refuses to go on, and what the messages of those
without such a code begin with. Python raises a signal before the first line of the function that SQLite
calls, so no function can keep it."""


class CancelledError(Exception):
    """The answer is no longer wanted."""


class Patience:
    """How long a query may still run: for a number of seconds from now, unless it is cancelled.

    The `deadline` is a time on the clock of `time.monotonic`. A caller that fetches rows in blocks adds the
    time that passes between the blocks. If `look` or the authorizer of `_run` stops the query, it leaves the
    `reason`. Without a reason, it was Ctrl-C that made the call fail.
    """

    def __init__(self, seconds: float | None = None, cancelled: Callable[[], bool] = never) -> None:
        self.deadline = time.monotonic() + (SECONDS if seconds is None else seconds)
        self.cancelled = cancelled
        self.reason = ""

    def look(self) -> bool:
        """Tell SQLite whether to stop, because the time is up or the query has been cancelled."""
        if self.cancelled():
            self.reason = _CANCELLED
        elif time.monotonic() > self.deadline:
            self.reason = f"it took more than {SECONDS:g} s: restrict it, or read Catalogue.engine in Python"
        return bool(self.reason)


@contextmanager
def watched(
    driver: Driver, patience: Patience, sql: str | None = None, what: str = "where"
) -> Iterator[None]:
    """Run a query under a time limit; `sql` is its SQL if a user wrote it.

    To fetch more rows later, open another such context with the same `patience`. Raises `CancelledError` if
    the query is cancelled, `KeyboardInterrupt` on Ctrl-C, and a `SelectionError` about the `sql` for any
    other error.
    """
    driver.failure = None
    driver.set_progress_handler(patience.look, STEPS_BETWEEN_LOOKS)
    try:
        yield
    except (sqlite3.Error, sqlite3.Warning, ValueError, OverflowError) as error:
        if patience.reason == _CANCELLED:
            raise CancelledError from error
        reason = patience.reason or _told(driver)
        if not reason and _was_signal(error):
            raise KeyboardInterrupt from error
        lacking = driver is not _stage() and "no such" in str(error)  # what the stage has, the file lacks
        if sql is None or isinstance(error, SelectionError) or (not reason and (lacking or of_file(error))):
            raise
        raise SelectionError(_refusal(sql, reason or str(error), what)) from error
    finally:
        with suppress(sqlite3.ProgrammingError):  # closed by SQLAlchemy after Ctrl-C
            driver.set_progress_handler(never, STEPS_BETWEEN_SIGNALS)


def _told(driver: Driver) -> str:
    """Return why a function of words failed, which SQLite does not say."""
    return str(driver.failure or "")


def _was_signal(error: Exception) -> bool:
    """Tell whether a signal made SQLite fail, because Python raised it where SQLite calls Python."""
    stopped = getattr(error, "sqlite_errorcode", None) in _STOPPED
    return stopped or str(error).startswith(_FAILED)


# expressions


class Reads(NamedTuple):
    """What an SQL expression or statement reads, as SQLite says.

    Attributes
    ----------
    columns : frozenset of str
        Names of the columns of tables and views; None stands for a table without a named column.
    queries : int
        Number of its SELECTs.
    """

    columns: frozenset[str | None]
    queries: int

    @property
    def of_classes(self) -> bool:
        """Whether an expression has the same value for all words of a class.

        It does if it contains no subquery and reads only columns that the words of a class share.
        """
        return self.columns <= _OF_CLASSES and self.queries == 1


class _Asked(dict[str, Any]):
    """Values of names in SQL, which remembers the names that SQLite has asked for."""

    def __init__(self, values: Parameters) -> None:
        super().__init__(plain_values(values))
        self.names: set[str] = set()

    def __getitem__(self, name: str) -> Any:
        self.names.add(name)
        return super().__getitem__(name)


def check(where: str, parameters: Parameters) -> Reads:
    """Check an expression on an empty catalogue; return what it reads.

    Raises
    ------
    SelectionError
        If SQLite cannot run it, or a name and a value do not belong to one another.
    """
    patience, stage, asked = Patience(), _stage(), _Asked(parameters)
    with watched(stage, patience, where):
        if where.strip().lower() in _COLUMNS:
            raise ValueError("it is a column, not a condition: compare it, as in p > 3")
        _run(stage, f"SELECT 1 FROM catalogue WHERE {where}", asked, patience)  # refuses a bracket too many
        reads = _run(stage, f"SELECT 1 FROM catalogue WHERE (\n{where}\n)", asked, patience)
        _check_names(asked)
        (kind,) = stage.execute(f"SELECT typeof((\n{where}\n)) FROM catalogue", asked).fetchone()
        if kind == "text":  # SQLite would take its beginning for a number
            raise ValueError("it is a text, not a condition: compare it, as in code = code('31')")
    return reads


_STRICT = {"and", "or", "not", "in", "between", "like", "glob", "abs", "length", "substr", "lower", "upper"}
"""Operators and functions that return NULL for NULL, unless the result is the same for every value."""

_RANDOM = {"random", "randomblob"}
"""Functions whose value differs from one call to the next."""


def may_hold(where: str, parameters: Parameters, known: Parameters, unknown: Collection[str]) -> bool:
    """Tell whether an expression may hold for rows with known values in some columns, unknown ones in others.

    The remaining columns are NULL. Unknown values are given to SQLite as NULL, too: if it answers NULL, the
    expression depends on them.
    """
    reads, stage, patience = check(where, parameters), _stage(), Patience()
    depends, names = not reads.columns.isdisjoint(unknown), names_in(where)
    if reads.queries > 1 or names & _RANDOM:
        return True
    if depends and not names <= _STRICT.union(_COLUMNS, ["catalogue", "contains"]):
        return True
    row = ", ".join(f"{known[name]!r} AS {name}" if name in known else f"NULL AS {name}" for name in _COLUMNS)
    with watched(stage, patience, where):
        statement = f"WITH catalogue AS (SELECT {row}) SELECT (\n{where}\n) FROM catalogue"
        (holds,) = stage.execute(statement, plain_values(parameters)).fetchone()
    return depends if holds is None else bool(holds)


def _run(stage: Driver, statement: str, values: Mapping[str, Any], patience: Patience) -> Reads:
    """Run a statement on the empty catalogue, let it only read, and note what it reads."""
    columns: set[str | None] = set()
    queries = 0

    def note(action: int, _table: str | None, name: str | None, *_others: str | None) -> int:
        nonlocal queries
        if action not in _ALLOWED or name == "load_extension":
            patience.reason = _ONLY_READ if action not in _ALLOWED else "it may not load extensions"
            return sqlite3.SQLITE_DENY
        queries += action == sqlite3.SQLITE_SELECT
        if action == sqlite3.SQLITE_READ:
            columns.add(name)
        return sqlite3.SQLITE_OK

    stage.set_authorizer(note)
    try:
        stage.execute(statement, values).fetchone()
    finally:
        stage.set_authorizer(None)
    return Reads(frozenset(columns), queries)


_kept = threading.local()


def _stage() -> Driver:
    """Return a catalogue in memory, with a table of one empty row in place of the view ``catalogue``."""
    stage: Driver | None = getattr(_kept, "stage", None)
    if stage is None:
        stage = open_empty()
        stage.execute("DROP VIEW catalogue")
        stage.execute(f"CREATE TABLE catalogue ({', '.join(_COLUMNS)}, PRIMARY KEY (a)) WITHOUT ROWID")
        stage.execute("INSERT INTO catalogue (a) VALUES (0)")  # or constants would not be evaluated
        add_word_functions(stage, strict=True)
        stage.execute("SELECT 1 FROM json_each('[]'), json_tree('[]')")  # at first use, SQLite registers them
        _kept.stage = stage
    return stage


def expression(where: str, parameters: Parameters) -> TextClause:
    """Return a checked expression as a condition of SQLAlchemy, with its values.

    SQLAlchemy takes ``:x`` for a name even in quotes, so colons are escaped there, and knows neither ``$x``
    nor ``@x``. Names get a prefix, so that they differ from those that SQLAlchemy invents.
    """

    def lexed(part: re.Match[str]) -> str:
        known = part["name"] in parameters
        return f":given_{part['name']}" if known else part[0].replace(":", r"\:")

    values: list[BindParameter[Any]] = [
        bindparam(f"given_{name}", value) for name, value in parameters.items()
    ]
    return text(f"(\n{LEXED.sub(lexed, where)}\n)").bindparams(*values)


# statements


def run_statement(
    connection: Connection, statement: str, parameters: Parameters
) -> tuple[tuple[str, ...], Iterator[tuple[Any, ...]]]:
    """Run a SELECT; return the names of its columns, and an iterator over its rows.

    Raises `SelectionError` if the statement is not a single SELECT, gives two columns the same name, or takes
    too long.
    """
    driver, asked, stage = driver_of(connection), _Asked(parameters), _stage()
    patience = Patience(cancelled=driver.cancelled)
    with watched(stage, patience, statement, "sql"):
        _run(stage, statement, asked, patience)  # refuses code() of a text that is not a word
    with watched(driver, patience, statement, "sql"):
        cursor = driver.execute(statement, asked)
        driver.statements.add(cursor)
        if cursor.description is None:
            raise ValueError("write a single SELECT")
        _check_names(asked)
    names = tuple(column for column, *_ in cursor.description)
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise SelectionError(
            _refusal(statement, f"column {twice[0]!r} occurs twice: rename one of them with AS", "sql")
        )
    return names, _fetched(connection, statement, cursor, patience)


def _fetched(
    connection: Connection, statement: str, cursor: sqlite3.Cursor, patience: Patience
) -> Iterator[tuple[Any, ...]]:
    while True:
        driver = driver_of(connection)  # raises `ClosedError` after the snapshot
        with watched(driver, patience, statement, "sql"):
            block = cursor.fetchmany(_BLOCK)
        if not block:
            return
        begun = time.monotonic()
        # BLOBs become hexadecimal digits, which every format can write
        yield from (tuple(v.hex() if isinstance(v, bytes) else v for v in row) for row in block)
        patience.deadline += time.monotonic() - begun  # the time that the caller took


def _refusal(sql: str, message: str, what: str) -> str:
    """Return a message that says which SQL was refused, why, and what to change."""
    message = as_typed(message, sql)
    _, no_table, name = message.partition("no such table: ")
    if no_table:
        message = f"{message}: {guess(name, READABLE)}it can read {', '.join(READABLE)}"
    elif "no such column" in message:
        name = message.split()[-1]
        if name in EVERY.keys() - set(_COLUMNS):
            message = f"{message}: it is computed afterwards, for the chosen rows"
        else:
            where_from = "only catalogue has it; " if name in _COLUMNS else guess(name, _COLUMNS)
            message = f"{message}; {where_from}`orbitdb.columns.EVERY` lists all columns"
    elif "binding" in message.lower():
        message = (
            f"{message.rstrip('.')}: give each :name a value, with --parameter name=value or in parameters"
        )
    return line(f"{what} {shortened(sql, 200)!r}: {message}")


def _check_names(asked: _Asked) -> None:
    """Raise `ValueError` if SQL lacks the name of a value."""
    if idle := asked.keys() - asked.names:
        raise ValueError(f"it has no :{', :'.join(sorted(idle))}: leave out its value")
