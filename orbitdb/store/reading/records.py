"""Read entropy bounds and averages over random trajectories, and measure the size of rows."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import groupby
from typing import TYPE_CHECKING

import sqlalchemy as sa

from orbitdb.entropy.bounds import BALLS, DOUBLES, EntropyBounds
from orbitdb.errors import InputError
from orbitdb.plaintext import several
from orbitdb.store.asking.selection import written_periods
from orbitdb.store.file.tables import (
    cycle,
    entropy_bound,
    fill,
    level,
    level_fill,
    orbit,
    pruned,
    stadium,
    sweep,
    trajectory,
)

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference


def bounds_stored(
    connection: sa.Connection, proof: str | None = None, a: float | None = None
) -> list[EntropyBounds]:
    """Return the stored bounds, unchecked, in order of a and of window length.

    With `proof` or `a`, only the bounds with this proof or at this a are returned.
    """
    table = entropy_bound.c
    names = (table.a, table.edges, table.lower, table.upper, table.windows, table.undecided, table.proof)
    query = sa.select(*names).order_by(table.a, table.edges, table.proof)
    if proof is not None:
        query = query.where(table.proof == proof)
    if a is not None:
        query = query.where(table.a == a)
    return [EntropyBounds(*row) for row in connection.execute(query)]


def closest(
    connection: sa.Connection, proof: str | None = None, a: float | None = None
) -> list[EntropyBounds]:
    """Return the tightest bounds at each a; if two are equally tight, the one proved in ball arithmetic."""
    if proof not in (None, DOUBLES, BALLS):
        raise InputError(f"proof {proof!r}: use {DOUBLES} or {BALLS}")
    by_a = groupby(bounds_stored(connection, proof, a), key=lambda bounds: bounds.a)
    return [min(group, key=lambda bounds: (bounds.width, bounds.proof)) for _, group in by_a]


def best_reference(connection: sa.Connection, a: float) -> "Reference | None":
    """Return the averages over trajectories with the smallest error at a given a, or None."""
    from orbitdb.trajectories.ensemble import Reference

    names = [field.name for field in fields(Reference)]
    query = (
        sa.select(*(trajectory.c[name] for name in names))
        .join(stadium)
        .where(stadium.c.a == a)
        .order_by(trajectory.c.lambda_d_error)
        .limit(1)
    )
    row = connection.execute(query).mappings().first()
    if row is None:
        return None
    return Reference(**{**row, "seed": int(row["seed"])})


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


def contents(connection: sa.Connection, a: float, spans: Sequence[tuple[int, int]] = ()) -> Contents:
    """Return what is stored at a given a, in the periods of `spans` or in all."""
    own = sa.select(stadium.c.id).where(stadium.c.a == a).scalar_subquery()

    def within(period: sa.Column[int]) -> sa.ColumnElement[bool]:
        return sa.or_(*(period.between(*span) for span in spans)) if spans else sa.true()

    def periods(table: sa.Table) -> tuple[int, ...]:
        query = sa.select(table.c.p).where(table.c.stadium == own, within(table.c.p)).distinct()
        return tuple(connection.scalars(query.order_by(table.c.p)))

    def count(table: sa.Table, where: sa.ColumnElement[bool]) -> int:
        return connection.scalar(sa.select(sa.func.count()).select_from(table).where(where)) or 0

    words = sa.select(sa.func.sum(cycle.c.class_size)).join_from(orbit, cycle)
    stored = connection.scalar(words.where(orbit.c.stadium == own, within(cycle.c.p))) or 0
    rest = (
        (level, level.c.a == a),
        (entropy_bound, entropy_bound.c.a == a),
        (trajectory, trajectory.c.stadium == own),
    )
    return Contents(
        stored, periods(fill), periods(sweep), *(() if spans else (count(*each) for each in rest))
    )


def level_windows(connection: sa.Connection) -> list[tuple[float, str, float, float, int]]:
    """Return a, parity, least and greatest k, and number of levels of each range without a gap."""
    inside = (level.c.a == level_fill.c.a) & (level.c.parity == level_fill.c.parity)
    inside &= (level.c.number > level_fill.c.below) & (level.c.k < level_fill.c.high)
    keys = level_fill.c.a, level_fill.c.parity, level_fill.c.low, level_fill.c.high
    query = sa.select(*keys, sa.func.count(level.c.number)).outerjoin(level, inside).group_by(*keys)
    joined: list[tuple[float, str, float, float, int]] = []
    for a, parity, low, high, count in connection.execute(query.order_by(*keys)):
        if joined and joined[-1][:2] == (a, parity) and joined[-1][3] == low:
            _, _, low, _, before = joined.pop()
            count += before
        joined.append((a, parity, low, high, count))
    return joined


def trajectories(connection: sa.Connection) -> list[tuple[float, int, int]]:
    """Return each a with averages over random trajectories, their number, and the bounces of the longest."""
    query = sa.select(stadium.c.a, sa.func.count(), sa.func.max(trajectory.c.bounces)).join_from(
        trajectory, stadium
    )
    return [(a, count, bounces) for a, count, bounces in connection.execute(query.group_by(stadium.c.a))]


def room(connection: sa.Connection) -> dict[str, tuple[int, float | None]]:
    """Return the numbers of classes, orbits and pruned words, each with the bytes per row.

    The bytes are None if there are no rows, or if SQLite was built without `dbstat`.
    """
    tables = {"classes": cycle, "orbits": orbit, "pruned words": pruned}
    counts = [sa.select(sa.func.count()).select_from(table).scalar_subquery() for table in tables.values()]
    rows, pages = connection.execute(sa.select(*counts)).one(), _bytes_of_tables(connection)
    each = zip(tables.items(), rows, strict=True)
    return {
        name: (count, pages[table.name] / count if pages and count else None)
        for (name, table), count in each
        if count or table is not pruned
    }


def _bytes_of_tables(connection: sa.Connection) -> dict[str, int]:
    try:
        rows = connection.exec_driver_sql("SELECT name, pgsize FROM dbstat WHERE aggregate = TRUE").all()
    except sa.exc.OperationalError:
        return {}
    return {str(row.name): int(row.pgsize) for row in rows}
