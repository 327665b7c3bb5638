"""Cursors: how far the work on a period has come, in `fill`, `pruned_fill`, `sweep` and `birth_fill`.

A cursor's row is stored before the work begins, and must still be there, unmoved, whenever a block is stored.
So neither another process nor a deletion can make rows of one stadium or period appear as another's.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import sqlalchemy as sa
from sqlalchemy import ColumnElement, Table, func, select

from orbitdb.store import tables as t
from orbitdb.store.tables import DONE, FILLING
from orbitdb.store.writer import replace_row
from orbitdb.symbols.enumeration import Span


class OvertakenError(Exception):
    """The cursor was moved or deleted by another process, so it must be read again."""


@dataclass(frozen=True)
class Cursor:
    """Progress of the work on one period: a row of one of these tables."""

    table: Table
    row: dict[str, Any]

    @property
    def p(self) -> int:
        """The period."""
        return int(self.row["p"])

    @property
    def done(self) -> bool:
        """Whether the period is complete."""
        return bool(self.row["state"] == DONE)

    @property
    def words(self) -> int:
        """Number of words in the stored classes."""
        return int(self.row["words"])

    @property
    def after(self) -> int:
        """The packed symbols after which the work continues; they need not be a word of the period.

        All classes whose representatives come before or at this point are stored.
        """
        return -1 if self.row["cursor"] is None else int(self.row["cursor"], 8)

    def own(self, table: Table) -> ColumnElement[bool]:
        """Return the condition for the rows of a table that have the stadium and period of this cursor."""
        names = [name for name in ("stadium", "p") if name in self.row]
        return sa.and_(*(table.c[name] == self.row[name] for name in names))


def open_cursor(connection: sa.Connection, table: Table, **begun: object) -> Cursor:
    """Return the stored progress of a period; store a row with the given values and zero counts if new."""
    zero = {column.name: 0 for column in table.c if not column.nullable and not column.primary_key}
    cursor = Cursor(table, {**zero, "cursor": None, **begun, "state": FILLING})
    stored = connection.execute(select(table).where(cursor.own(table))).mappings().one_or_none()
    if stored is not None:
        return Cursor(table, dict(stored))
    replace_row(connection, table, cursor.row)
    return cursor


def hold(connection: sa.Connection, cursor: Cursor) -> None:
    """Raise `OvertakenError` if the cursor's row was moved or deleted; during this transaction, it stays."""
    own = cursor.table.c
    stored = connection.execute(select(own.state, own.cursor).where(cursor.own(cursor.table))).one_or_none()
    if stored is None or tuple(stored) != (FILLING, cursor.row["cursor"]):
        raise OvertakenError


def move(connection: sa.Connection, cursor: Cursor, span: Span, spent: Mapping[str, float]) -> Cursor:
    """Move a cursor to the end of the next span, and add the counts and times of that span."""
    row = cursor.row
    added = {name: row[name] + value for name, value in spent.items()} | {"cursor": f"{span.upto:0{span.p}o}"}
    return keep(connection, cursor, added)


def keep(connection: sa.Connection, cursor: Cursor, values: Mapping[str, Any]) -> Cursor:
    """Store new values of a cursor's row, and return the cursor with them."""
    row = cursor.row | dict(values)
    replace_row(connection, cursor.table, row)
    return replace(cursor, row=row)


def sums_of_blocks(connection: sa.Connection, cursor: Cursor) -> tuple[list[bytes], str]:
    """Return the sums of all blocks of a sweep, in order, and who computed them."""
    block = t.sweep_block
    query = select(block.c.sums).where(cursor.own(block)).order_by(block.c.number)
    name = func.json_extract(t.run.c.parameters, "$.arithmetic")
    by = select(name).distinct().join_from(t.run, block).where(cursor.own(block)).order_by(name)
    return [*connection.scalars(query)], " | ".join(connection.scalars(by))


def delete_blocks(connection: sa.Connection, cursor: Cursor) -> None:
    """Delete the blocks of a sweep, whose sums are now in its row."""
    connection.execute(sa.delete(t.sweep_block).where(cursor.own(t.sweep_block)))
