"""Run one SELECT statement written by a user (`orbitdb sql`).

What it may call is in `orbitdb.store.asking.where`, how long it may take in `orbitdb.store.asking.limits`.
"""

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from functools import partial
from typing import Any

import sqlalchemy as sa

from orbitdb.store.asking import where as free
from orbitdb.store.asking.codes import spelled_out
from orbitdb.store.asking.limits import TABLES_OF_VIEW, Patience, confined
from orbitdb.store.file.schema import VIEWS
from orbitdb.store.file.tokens import meaningful

READABLE = (*VIEWS, "pruned")
"""The views and tables that a statement may read."""

_BLOCK = 2000
_refusal = partial(free.refusal, what="sql", readable=READABLE)
_authorize = free.allowing(set(READABLE), VIEWS.keys(), TABLES_OF_VIEW, "random", VIEWS.keys())


def run_statement(
    connection: sa.Connection, statement: str, parameters: free.Parameters
) -> tuple[tuple[str, ...], Iterator[tuple[Any, ...]]]:
    """Run one SELECT over `READABLE`; return the names of its columns, and its rows.

    It may call random() and the functions of expressions (`orbitdb.store.asking.where`);
    ``code('1232131')`` finds a word in any rotation. Raises `SelectionError` if it is not one SELECT, reads
    anything else, gives two columns the same name, or takes too long.
    """
    try:
        _check(statement, parameters)
        plain = spelled_out(statement, parameters)
    except ValueError as error:
        raise _refusal(statement, str(error)) from error
    patience = Patience()
    with _answering(connection, statement, patience):
        result = connection.exec_driver_sql(plain, parameters)
        names = tuple(result.keys())
    if twice := [name for place, name in enumerate(names) if name in names[:place]]:
        raise _refusal(statement, f"column {twice[0]!r} comes twice: name one of them with AS")
    return names, _fetched(connection, statement, result, patience)


def _fetched(
    connection: sa.Connection, statement: str, result: sa.CursorResult[Any], patience: Patience
) -> Iterator[tuple[Any, ...]]:
    while True:
        with _answering(connection, statement, patience):
            block = result.fetchmany(_BLOCK)
        if not block:
            return
        begun = time.monotonic()
        # BLOBs become hexadecimal digits, which every format can write
        yield from (tuple(v.hex() if isinstance(v, bytes) else v for v in row) for row in block)
        patience.deadline += time.monotonic() - begun  # time that the caller spent


def _check(statement: str, parameters: free.Parameters) -> None:
    """Raise `ValueError`, before SQLite runs it, for what could grow without end or values without a name."""
    found = meaningful(statement)
    if not found or found[0].keyword != "SELECT":
        raise ValueError("write one SELECT")
    free.check_size(statement, parameters)
    if any(token.keyword == "WITH" for token in found):
        raise ValueError("WITH may not be used")
    free.check_names(statement, parameters)


def _answering(connection: sa.Connection, statement: str, patience: Patience) -> AbstractContextManager[None]:
    return confined(connection, patience, partial(_refusal, statement), _authorize)
