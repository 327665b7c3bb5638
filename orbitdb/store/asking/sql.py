"""Run a SELECT statement that a user wrote (`orbitdb sql`).

`orbitdb.store.asking.where` has the functions that it may call, `orbitdb.store.asking.limits` its time limit.
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
    """Run a SELECT over `READABLE`; return the names of its columns, and an iterator over its rows.

    It may call random() and the functions that expressions may call (`orbitdb.store.asking.where`), and
    ``code('1232131')`` to find a word in any rotation. Raises `SelectionError` if the statement is not a
    single SELECT, reads anything else, gives two columns the same name, or takes too long.
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
        raise _refusal(statement, f"column {twice[0]!r} occurs twice: rename one of them with AS")
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
        patience.deadline += time.monotonic() - begun  # the time that the caller took


def _check(statement: str, parameters: free.Parameters) -> None:
    """Raise `ValueError` unless this is a SELECT that cannot grow without limit and uses all values."""
    found = meaningful(statement)
    if not found or found[0].keyword != "SELECT":
        raise ValueError("write a single SELECT")
    free.check_size(statement, parameters)
    if any(token.keyword == "WITH" for token in found):
        raise ValueError("WITH may not be used")
    free.check_names(statement, parameters)


def _answering(connection: sa.Connection, statement: str, patience: Patience) -> AbstractContextManager[None]:
    return confined(connection, patience, partial(_refusal, statement), _authorize)
