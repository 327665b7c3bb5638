"""Free expressions over the catalogue: what ``--where`` may do, and how long."""

import re
import sqlite3
import time
from collections.abc import Callable, Iterator, Set
from contextlib import closing, contextmanager

import sqlalchemy as sa

from orbitdb.selection import SelectionError
from orbitdb.store.schema import catalogue

SECONDS = 60.0
"""How long a query with a free expression may take."""

_LONGEST_VALUE = 1_000_000
_STEPS_BETWEEN_LOOKS = 100_000
Parameters = dict[str, str | int | float]
_TABLES_OF_VIEW = {"sequence", "cycle", "stadium", "orbit"}
_Authorizer = Callable[[int, str | None, str | None, str | None, str | None], int]
_NAME = re.compile(r"(?<!:):(\w+)")


def expression(where: str, parameters: set[str]) -> sa.TextClause:
    """Return a free expression as SQL; only names among the parameters are bound."""
    text = _NAME.sub(lambda name: name[0] if name[1] in parameters else "\\" + name[0], where)
    return sa.text(f"(\n{text}\n)")


def check(where: str, parameters: Parameters) -> None:
    """Refuse what is not one expression over the view.

    Raises
    ------
    SelectionError
        With the reason, in one line.
    """
    try:
        _compile(where, parameters, _authorize)
    except (sqlite3.Error, sqlite3.Warning, ValueError) as error:
        raise refusal(where, str(error)) from error


def same_for_class(where: str, parameters: Parameters, shared: Set[str]) -> bool:
    """Tell whether a checked expression has one value for all words of a symmetry class.

    Parameters
    ----------
    where, parameters
        The expression.
    shared : set of str
        The columns of the view that all words of a class share.
    """
    columns, functions, selects = set(), set(), 0

    def note(action: int, first: str | None, second: str | None, _base: str | None, view: str | None) -> int:
        nonlocal selects
        if action == sqlite3.SQLITE_READ and first == "catalogue":
            columns.add(second)
        elif action == sqlite3.SQLITE_FUNCTION:
            functions.add(second)
        elif action == sqlite3.SQLITE_SELECT and view is None:
            selects += 1
        return sqlite3.SQLITE_OK

    _compile(where, parameters, note)
    return columns <= shared and selects == 1 and not functions & {"random", "randomblob"}


def _compile(where: str, parameters: Parameters, authorize: _Authorizer) -> None:
    """Compile an expression where there is nothing but an empty table in place of the view."""
    with closing(sqlite3.connect(":memory:")) as stage:
        stage.execute(f"CREATE TABLE catalogue ({', '.join(catalogue.c.keys())})")
        stage.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST_VALUE)
        stage.set_authorizer(authorize)
        stage.execute(f"EXPLAIN SELECT 1 FROM catalogue WHERE {where}\n", parameters)


def refusal(where: str, message: str) -> SelectionError:
    """Return the error that tells the user what is wrong with an expression."""
    if any(part in message for part in ("not authorized", "prohibited", "no such table")):
        message = "it may read the columns of the catalogue and nothing else"
    elif "no such column" in message:
        message += f"; the columns are {', '.join(catalogue.c.keys())}"
    elif "interrupted" in message:
        message = f"it took more than {SECONDS:g} s"
    elif "binding" in message:
        message = f"{message.rstrip('.')}: give each name a value with -P name=value"
    return SelectionError(f"where {where!r}: {message}")


@contextmanager
def confined(connection: sa.Connection) -> Iterator[None]:
    """Let a connection run a checked expression, for a limited time and with values of limited size."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    deadline = time.monotonic() + SECONDS
    longest = driver.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST_VALUE)
    driver.set_authorizer(_authorize_checked)
    driver.set_progress_handler(lambda: time.monotonic() > deadline, _STEPS_BETWEEN_LOOKS)
    try:
        yield
    finally:
        driver.set_progress_handler(None, 0)
        driver.set_authorizer(None)
        driver.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, longest)


def _authorize(
    action: int, first: str | None, second: str | None, _base: str | None, view: str | None
) -> int:
    """Allow reading the view, and SQLite's own functions."""
    if action == sqlite3.SQLITE_SELECT:
        return sqlite3.SQLITE_OK
    if action == sqlite3.SQLITE_READ:
        return sqlite3.SQLITE_OK if "catalogue" in (first, view) else sqlite3.SQLITE_DENY
    if action == sqlite3.SQLITE_FUNCTION and second != "load_extension":
        return sqlite3.SQLITE_OK
    return sqlite3.SQLITE_DENY


def _authorize_checked(
    action: int, first: str | None, second: str | None, base: str | None, view: str | None
) -> int:
    """Allow, too, what a query over a checked expression needs: the tables of the view themselves.

    SQLite reports a table of which no column is used without the view's name.
    """
    if action == sqlite3.SQLITE_READ and first in _TABLES_OF_VIEW:
        return sqlite3.SQLITE_OK
    return _authorize(action, first, second, base, view)
