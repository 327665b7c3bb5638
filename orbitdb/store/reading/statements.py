"""Whole SELECT statements over the views of a catalogue: for a limited time, and nothing else is touched."""

import sqlite3
from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import partial
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from orbitdb.store.asking import expressions as free
from orbitdb.store.asking.codes import spelled_out
from orbitdb.store.asking.confinement import TABLES_OF_VIEW, Patience, confined
from orbitdb.store.asking.selection import SelectionError
from orbitdb.store.file.schema import VIEWS
from orbitdb.store.file.tokens import meaningful

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue

READABLE = (*VIEWS, "pruned")
"""What a statement may read."""

_BLOCK = 2000


def run_statement(
    catalogue: "Catalogue", statement: str, parameters: free.Parameters
) -> tuple[tuple[str, ...], Iterator[tuple[Any, ...]]]:
    """Run one SELECT over `READABLE`; return the names of its columns, and its rows.

    Parameters
    ----------
    catalogue : Catalogue
        As it is at one moment (`Catalogue.at_one_moment`), until all rows are fetched.
    statement : str
        It may call the functions that an expression may call (`orbitdb.store.asking.expressions`), and
        ``code('1232131')`` finds a word in any rotation.
    parameters : dict
        What the names (``:name``) in it stand for.

    Raises
    ------
    SelectionError
        If it is not one SELECT, reads something else, names two columns alike, or takes too long.
    """
    _check(statement, parameters)
    try:
        plain = spelled_out(statement, parameters)
    except ValueError as error:
        raise free.refusal(statement, str(error), "sql") from error
    patience = Patience()
    with catalogue.reading() as connection, _answering(connection, statement, patience):
        result = connection.exec_driver_sql(plain, parameters)
        names = tuple(result.keys())
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise free.refusal(statement, f"column {twice[0]!r} comes twice: name one of them with AS", "sql")
    return names, _fetched(catalogue, statement, result, patience)


def _fetched(
    catalogue: "Catalogue", statement: str, result: sa.CursorResult[Any], patience: Patience
) -> Iterator[tuple[Any, ...]]:
    while True:
        with catalogue.reading() as connection, _answering(connection, statement, patience):
            block = result.fetchmany(_BLOCK)
        if not block:
            return
        yield from (tuple(_legible(value) for value in row) for row in block)


def _legible(value: Any) -> Any:
    """Return a value of SQL as what every format can write: a blob as its hexadecimal digits."""
    return value.hex() if isinstance(value, bytes) else value


def _check(statement: str, parameters: free.Parameters) -> None:
    """Refuse what could grow without end before SQLite runs any of it, and values that have no name."""
    found = meaningful(statement)
    size = len(statement) + sum(len(str(value)) for value in parameters.values())
    message = ""
    if not found or found[0].keyword != "SELECT":
        message = "write one SELECT"
    elif size > free.LONGEST:
        message = f"it has {size} characters with its values; {free.LONGEST} are allowed"
    elif any(token.keyword == "WITH" for token in found):
        message = "WITH may not be used"
    elif idle := [name for name in parameters if name not in free.names_in(statement)]:
        message = f"it has no :{', :'.join(idle)}: leave out what is given for it"
    if message:
        raise free.refusal(statement, message, "sql")


def _answering(connection: sa.Connection, statement: str, patience: Patience) -> AbstractContextManager[None]:
    return confined(connection, patience, partial(_refusal, statement), _authorize)


def _refusal(statement: str, message: str) -> SelectionError:
    """Return the error that tells the user what is wrong with a statement."""
    foreign = any(part in message for part in ("not authorized", "prohibited", "no such table"))
    if foreign and "function" not in message:
        message = f"it may read {', '.join(READABLE)}, and nothing else"
    return free.refusal(statement, message, "sql")


def _authorize(
    action: int, first: str | None, column: str | None, _base: str | None, view: str | None
) -> int:
    """Allow what computes, and reading the views; their tables only through them.

    SQLite reads no column of a table, and names no view, where it but looks whether there is a row.
    """
    reading = action == sqlite3.SQLITE_READ
    allowed = (
        action == sqlite3.SQLITE_SELECT
        or (reading and (first in READABLE or view in VIEWS))
        or (reading and first in TABLES_OF_VIEW and not column)
        or (action == sqlite3.SQLITE_FUNCTION and column in free.FUNCTIONS)
    )
    return sqlite3.SQLITE_OK if allowed else sqlite3.SQLITE_DENY
