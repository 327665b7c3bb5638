"""Free expressions over the catalogue: what ``--where`` may do, and how long."""

import re
import sqlite3
import time
from collections.abc import Iterator
from contextlib import contextmanager

import sqlalchemy as sa

from orbitdb.selection import SelectionError
from orbitdb.store.schema import catalogue

SECONDS = 60.0
"""How long a query with a free expression may take."""

_LONGEST_VALUE = 1_000_000
_STEPS_BETWEEN_LOOKS = 100_000
_TABLES = {"sequence", "cycle", "stadium", "orbit"}
_NAME = re.compile(r"(?<!:):(\w+)")


def expression(where: str, parameters: set[str]) -> sa.TextClause:
    """Return a free expression as SQL; only names among the parameters are bound."""
    text = _NAME.sub(lambda name: name[0] if name[1] in parameters else "\\" + name[0], where)
    return sa.text(f"(\n{text}\n)")


def check(connection: sa.Connection, where: str, parameters: dict[str, str | int | float]) -> None:
    """Refuse what is not one expression over the view.

    Raises
    ------
    SelectionError
        With the reason, in one line.
    """
    with confined(connection) as driver:
        try:
            driver.execute(f"EXPLAIN SELECT 1 FROM catalogue WHERE {where}\n", parameters)
        except (sqlite3.Error, sqlite3.Warning, ValueError) as error:
            raise refusal(where, str(error)) from error


def refusal(where: str, message: str) -> SelectionError:
    """Return the error that tells the user what is wrong with an expression."""
    if "not authorized" in message or "prohibited" in message:
        message = "it may read the columns of the catalogue and nothing else"
    elif "no such column" in message:
        message += f"; the columns are {', '.join(catalogue.c.keys())}"
    elif "interrupted" in message:
        message = f"it took more than {SECONDS:g} s"
    elif "binding" in message:
        message = f"{message.rstrip('.')}: give each name a value with -P name=value"
    return SelectionError(f"where {where!r}: {message}")


@contextmanager
def confined(connection: sa.Connection) -> Iterator[sqlite3.Connection]:
    """Let a connection read the view and nothing else, for a limited time."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, sqlite3.Connection)
    deadline = time.monotonic() + SECONDS
    longest = driver.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST_VALUE)
    driver.set_authorizer(_authorize)
    driver.set_progress_handler(lambda: time.monotonic() > deadline, _STEPS_BETWEEN_LOOKS)
    try:
        yield driver
    finally:
        driver.set_progress_handler(None, 0)
        driver.set_authorizer(None)
        driver.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, longest)


def _authorize(
    action: int, first: str | None, second: str | None, _base: str | None, view: str | None
) -> int:
    if action == sqlite3.SQLITE_SELECT:
        return sqlite3.SQLITE_OK
    if action == sqlite3.SQLITE_READ:
        no_column = (
            first in _TABLES and not second
        )  # how SQLite names a joined table when it inlines the view
        return sqlite3.SQLITE_OK if "catalogue" in (first, view) or no_column else sqlite3.SQLITE_DENY
    if action == sqlite3.SQLITE_FUNCTION and second != "load_extension":
        return sqlite3.SQLITE_OK
    return sqlite3.SQLITE_DENY
