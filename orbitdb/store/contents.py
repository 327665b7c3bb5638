"""What a catalogue contains: at a value of a, as a whole, and how much room the rows take."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from typing import Any

import sqlalchemy as sa
from sqlalchemy import ColumnElement, Connection, Table, func, select
from sqlalchemy.exc import OperationalError

from orbitdb.store import tables as t
from orbitdb.store.selection import written_periods
from orbitdb.text import several


@dataclass(frozen=True)
class Contents:
    """What is stored at one value of a, in all periods or in some.

    Attributes
    ----------
    words : int
        Number of words with an orbit or a status.
    filled, swept : tuple of int
        Periods that are filled or swept, completely or in part.
    levels, bounds, trajectories : int
        Number of quantum levels, bounds on the entropy, and averages over random trajectories; 0 if only some
        periods were asked for.
    """

    words: int
    filled: tuple[int, ...]
    swept: tuple[int, ...]
    levels: int = 0
    bounds: int = 0
    trajectories: int = 0

    def __bool__(self) -> bool:
        return any(getattr(self, field.name) for field in fields(self))

    def __str__(self) -> str:
        parts = [several(self.words, "word")] if self.words else []
        for noun, periods in (("fill", self.filled), ("sweep", self.swept)):
            if periods:
                parts.append(f"{several(len(periods), noun)} ({written_periods(periods)})")
        parts += [several(self.levels, "quantum level")] if self.levels else []
        parts += [several(self.bounds, "bound") + " on the entropy"] if self.bounds else []
        parts += [several(self.trajectories, "average") + " over trajectories"] if self.trajectories else []
        return ", ".join(parts) or "nothing"


def contents(connection: Connection, a: float, spans: Sequence[tuple[int, int]] = ()) -> Contents:
    """Return what is stored at a given a, in the periods of `spans` or in all."""

    def periods(table: Table) -> tuple[int, ...]:
        own = (t.at_a(table, a), t.in_spans(table.c.p, spans))
        return tuple(connection.scalars(select(table.c.p).where(*own).order_by(table.c.p)))

    def count(table: Table, own: ColumnElement[bool]) -> int:
        return connection.scalar(select(func.count()).select_from(table).where(own)) or 0

    words = select(func.sum(t.cycle.c.class_size)).join_from(
        t.orbit, t.cycle, t.cycle.c.id == t.orbit.c.cycle
    )
    stored = connection.scalar(words.where(t.at_a(t.orbit, a), t.in_spans(t.cycle.c.p, spans))) or 0
    rest = (
        (t.level, t.level.c.a == a),
        (t.entropy_bound, t.entropy_bound.c.a == a),
        (t.trajectory, t.at_a(t.trajectory, a)),
    )
    counts = () if spans else (count(*condition) for condition in rest)
    return Contents(stored, periods(t.fill), periods(t.sweep), *counts)


_SIZES = sa.table("dbstat", sa.column("name"), sa.column("pgsize"), sa.column("aggregate"))
"""SQLite's own table of the space that each table takes."""


def room(connection: Connection) -> dict[str, tuple[int, float | None]]:
    """Return the numbers of classes, orbits and pruned words, each with the bytes per row.

    The bytes are None if there are no rows, or if SQLite was built without `dbstat`.
    """
    pages: dict[str, int] = {}
    with suppress(OperationalError):
        sizes = connection.execute(select(_SIZES.c.name, _SIZES.c.pgsize).where(_SIZES.c.aggregate == 1))
        pages = dict(tuple(row) for row in sizes)
    rows = {}
    for name, stored in {"classes": t.cycle, "orbits": t.orbit, "pruned words": t.pruned}.items():
        count = connection.scalar(select(func.count()).select_from(stored)) or 0
        if count or stored is not t.pruned:
            rows[name] = count, pages[stored.name] / count if pages and count else None
    return rows


def schema_version(connection: Connection) -> int:
    """Return the schema version of the file."""
    return int(connection.exec_driver_sql("PRAGMA user_version").scalar_one())


def sqlite_version(connection: Connection) -> str:
    """Return the version of SQLite that reads the catalogue."""
    return str(connection.scalar(select(func.sqlite_version())))


def class_rows(
    connection: Connection, names: Sequence[str], periods: Collection[int]
) -> list[tuple[Any, ...]]:
    """Return columns of the table `cycle` for all stored classes of some periods, in order."""
    query = select(*(t.cycle.c[name] for name in names)).where(t.cycle.c.p.in_(periods))
    return [tuple(row) for row in connection.execute(query.order_by(t.cycle.c.id))]


def runs(connection: Connection) -> list[tuple[str, str]]:
    """Return the version and the parameters, as JSON, of every run that wrote to the file."""
    query = select(t.run.c.version, t.run.c.parameters).order_by(t.run.c.id)
    return [(version, parameters) for version, parameters in connection.execute(query)]


def pruned_periods(connection: Connection) -> set[int]:
    """Return the periods with stored geometrically pruned words."""
    return set(connection.scalars(select(t.pruned.c.p).distinct()))
