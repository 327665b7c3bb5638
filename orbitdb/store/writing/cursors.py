"""Cursors: the progress of work on a period. They move in the transaction that stores the results.

Fills, sweeps and births each have a table of cursors with a state, the word up to which everything is stored,
and the counts and times so far.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa
from sqlalchemy.dialects.sqlite import insert

from orbitdb.store.file.schema import DONE, FILLING
from orbitdb.symbols.enumeration import Span


class OvertakenError(Exception):
    """Another process moved the same cursor, which must be read again."""


@dataclass(frozen=True)
class Cursor:
    """Progress of the work on one period: its row of `fill`, `sweep` or `birth_fill`.

    It is the stored row, or the initial one.
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
        """Number of words in the stored classes."""
        return int(self.row["words"])

    @property
    def after(self) -> int:
        """The packed word after which the work continues; it need not be a word itself.

        All classes with representatives up to it are stored.
        """
        return -1 if self.row["cursor"] is None else int(self.row["cursor"], 8)

    def rows(self, table: sa.Table) -> sa.ColumnElement[bool]:
        """Return the condition on rows of a table that agree in all columns of the key."""
        return sa.and_(*(table.c[column.name] == self.row[column.name] for column in self.table.primary_key))


def open_cursor(connection: sa.Connection, table: sa.Table, **begun: object) -> Cursor:
    """Return the progress of a period, possibly none.

    The key and other initial values of its row are given; sums begin at 0.
    """
    zero = {c.name: 0 for c in table.c if not (c.nullable or c.primary_key)}
    cursor = Cursor(table, zero | {"cursor": None} | begun | {"state": FILLING})
    row = connection.execute(sa.select(table).where(cursor.rows(table))).mappings().first()
    return cursor if row is None else Cursor(table, dict(row))


def hold(connection: sa.Connection, cursor: Cursor) -> None:
    """Check that a cursor is unchanged; nobody can move it during this transaction.

    Raises `OvertakenError` if another process moved it.
    """
    columns = cursor.table.c.state, cursor.table.c.cursor
    row = connection.execute(sa.select(*columns).where(cursor.rows(cursor.table))).first()
    if tuple(row or (FILLING, None)) != (FILLING, cursor.row["cursor"]):
        raise OvertakenError


def move(connection: sa.Connection, cursor: Cursor, span: Span, spent: Mapping[str, float]) -> Cursor:
    """Record that the classes of the span after a cursor are stored, and add its counts and times."""
    table, row = cursor.table, dict(cursor.row)
    added = {name: row[name] + value for name, value in spent.items()} | {"cursor": f"{span.upto:0{span.p}o}"}
    if row["cursor"] is None:
        connection.execute(insert(table).values(**row).on_conflict_do_nothing())
    connection.execute(sa.update(table).where(cursor.rows(table)).values(**added))
    return replace(cursor, row=row | added)


def close(connection: sa.Connection, cursor: Cursor, values: Mapping[str, object]) -> None:
    """Record that a period is complete, with its final values."""
    table = cursor.table
    connection.execute(sa.update(table).where(cursor.rows(table)).values(state=DONE, **values))
