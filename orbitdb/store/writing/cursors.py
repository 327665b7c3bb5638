"""Cursors: how far the work on a period has come. They move in the transaction that stores the results.

Fills, sweeps and births each have a table of them: a state, the word up to which everything is
stored, and the counts and times so far.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.sqlite import insert

from orbitdb.store.file.schema import DONE, FILLING
from orbitdb.symbols.enumeration import Span


class OvertakenError(Exception):
    """Another process has moved the same cursor: what it says is to be read again."""


@dataclass(frozen=True)
class Cursor:
    """How far the work on one period has come: its row of `fill`, `sweep` or `birth_fill`.

    The row is as it is, or as it is going to begin.
    """

    table: sa.Table
    row: Mapping[str, Any]

    @property
    def p(self) -> int:
        """The period."""
        return int(self.row["p"])

    @property
    def done(self) -> bool:
        """Whether nothing is missing."""
        return bool(self.row["state"] == DONE)

    @property
    def words(self) -> int:
        """How many words the stored classes have."""
        return int(self.row["words"])

    @property
    def after(self) -> int:
        """The packed word behind which the work goes on; it need not be a word itself.

        All classes whose least words are up to it are stored.
        """
        return -1 if self.row["cursor"] is None else int(self.row["cursor"], 8)

    def rows(self, table: sa.Table) -> sa.ColumnElement[bool]:
        """Say which rows of a table belong to it: those that agree in all columns of its key."""
        return sa.and_(*(table.c[column.name] == self.row[column.name] for column in self.table.primary_key))


def open_cursor(connection: sa.Connection, table: sa.Table, **begun: object) -> Cursor:
    """Return how far a period has come, which may be nothing.

    The key of its row and what else it begins with are given; what it adds up begins at 0.
    """
    zero = {c.name: 0 for c in table.c if not (c.nullable or c.primary_key)}
    cursor = Cursor(table, zero | {"cursor": None} | begun | {"state": FILLING})
    row = connection.execute(sa.select(table).where(cursor.rows(table))).mappings().first()
    return cursor if row is None else Cursor(table, dict(row))


def hold(connection: sa.Connection, cursor: Cursor) -> None:
    """Make sure that a cursor still says what it did; nobody can move it while this transaction lasts.

    `OvertakenError` tells that another process has moved it.
    """
    columns = cursor.table.c.state, cursor.table.c.cursor
    row = connection.execute(sa.select(*columns).where(cursor.rows(cursor.table))).first()
    if tuple(row or (FILLING, None)) != (FILLING, cursor.row["cursor"]):
        raise OvertakenError


def move(connection: sa.Connection, cursor: Cursor, span: Span, spent: Mapping[str, float]) -> Cursor:
    """Note that the classes of the span behind a cursor are stored, and add what was counted and spent."""
    table, row = cursor.table, dict(cursor.row)
    added = {name: row[name] + value for name, value in spent.items()} | {"cursor": f"{span.upto:0{span.p}o}"}
    if row["cursor"] is None:
        connection.execute(insert(table).values(**row).on_conflict_do_nothing())
    connection.execute(sa.update(table).where(cursor.rows(table)).values(**added))
    return replace(cursor, row=row | added)


def close(connection: sa.Connection, cursor: Cursor, values: Mapping[str, object]) -> None:
    """Note that a period is complete, with what is known of it then."""
    table = cursor.table
    connection.execute(sa.update(table).where(cursor.rows(table)).values(state=DONE, **values))
