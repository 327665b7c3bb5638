"""A part, which is a catalogue attached to another one as ``part``, and copying of its rows.

Classes of long words and runs have other ids in the part; `Attached` translates them.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import sqlalchemy as sa
from sqlalchemy import ColumnElement, Connection, Integer, MetaData, Row, Table, func, insert, select

from orbitdb.store import tables as t
from orbitdb.store.writer import replace_row

_attached = MetaData()
PART = {
    table: table.to_metadata(_attached, schema="part").alias(f"their_{table.name}")
    for table in t.metadata.sorted_tables
}
"""The tables of the part, by those of the target."""

_ids = MetaData()


def _ids_of(name: str) -> Table:
    columns = (sa.Column("part", Integer, primary_key=True), sa.Column("own", Integer))
    return Table(name, _ids, *columns, prefixes=["TEMPORARY"])


_classes, _runs = _ids_of("own_class"), _ids_of("own_run")
"""The ids in the target of classes of long words, and of runs, by those in the part."""


def _own_id(ids: Table, column: ColumnElement[int]) -> ColumnElement[int]:
    return select(ids.c.own).where(ids.c.part == column).correlate_except(ids).scalar_subquery()


def _translated(table: Table, own: Mapping[str, Any]) -> dict[str, ColumnElement[Any]]:
    """Return the columns of a table of the part as the target has them, which knows the values `own`."""
    theirs = PART[table].c
    values: dict[str, ColumnElement[Any]] = {**theirs}
    values |= {name: sa.literal(value) for name, value in own.items()}
    if "cycle" in theirs:
        values["cycle"] = func.coalesce(_own_id(_classes, theirs.cycle), theirs.cycle)
    if "run" in theirs:
        values["run"] = _own_id(_runs, theirs.run)
    return values


def same(table: Table, key: Iterable[str], **own: Any) -> ColumnElement[bool]:
    """Return the condition that a row of the target has the key of one of the part."""
    theirs = _translated(table, own)
    return sa.and_(*(table.c[name] == theirs[name] for name in key))


def lacking(table: Table, key: Iterable[str], **own: Any) -> ColumnElement[bool]:
    """Return the condition that the target has no row with the key of one of the part."""
    return ~sa.exists().select_from(table).where(same(table, key, **own)).correlate_except(table)


class Attached:
    """The attached part in one transaction.

    In the methods, `own` are values of the target that differ from those of the part, such as ``stadium``.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection, self._ask = connection, connection.execute
        _ids.create_all(connection, checkfirst=False)  # they go with a transaction that fails

    def forget(self) -> None:
        """Drop the ids of the part."""
        _ids.drop_all(self._connection, checkfirst=False)

    def copy(self, table: Table, *chosen: ColumnElement[bool], or_: str = "ABORT", **own: Any) -> int:
        """Copy chosen rows, with `own` values in place of the part's; return how many."""
        values = _translated(table, own)
        rows = select(*values.values()).select_from(PART[table]).where(*chosen)
        return self._ask(insert(table).prefix_with(f"OR {or_}").from_select([*values], rows)).rowcount

    def differing(
        self, table: Table, key: Iterable[str], differ: ColumnElement[bool], **own: Any
    ) -> Row[Any] | None:
        """Return a row for which the target has one with the same key that differs, if any."""
        pairs = PART[table].join(table, same(table, key, **own))
        return self._ask(select(PART[table]).select_from(pairs).where(differ).limit(1)).first()

    def word_of(self, row: Row[Any]) -> str | None:
        """Return the word of the class to which a row belongs."""
        theirs = PART[t.cycle].c
        return self._connection.scalar(select(theirs.word).where(theirs.id == row.cycle))

    def copy_classes(self, chosen: ColumnElement[bool]) -> None:
        """Copy the classes that the target lacks; those of long words get ids of their own there."""
        theirs = PART[t.cycle]
        short = theirs.c.id < t.LONG
        self.copy(t.cycle, short, chosen, or_="IGNORE")
        if long := self._ask(select(theirs).where(~short, chosen)).mappings().all():
            own = t.class_ids(self._connection, [row["word"] for row in long])
            rows = [{**row, "id": own[row["word"]]} for row in long]
            self._ask(insert(t.cycle).prefix_with("OR IGNORE"), rows)
            self._ask(insert(_classes), [{"part": row["id"], "own": own[row["word"]]} for row in long])

    def copy_runs(self) -> None:
        """Copy the runs that wrote rows, unless the target has them."""
        theirs, own = PART[t.run].c, t.run.c
        used = sa.union(*(select(table.c.run) for table in PART.values() if "run" in table.c))
        query = select(theirs.id, theirs.started, theirs.version, theirs.parameters)
        for number, *row in self._ask(query.where(theirs.id.in_(used))).all():
            values = dict(zip(("started", "version", "parameters"), row, strict=True))
            known = select(own.id).where(*(own[name] == value for name, value in values.items()))
            found = self._connection.scalar(known) or replace_row(self._connection, t.run, values)
            self._ask(insert(_runs).values(part=number, own=found))
