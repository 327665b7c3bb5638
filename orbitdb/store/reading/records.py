"""Read entropy bounds and averages over random trajectories, and measure the size of rows."""

from dataclasses import fields
from itertools import groupby
from typing import TYPE_CHECKING

import sqlalchemy as sa

from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.entropy.bounds import BALLS, DOUBLES, EntropyBounds
from orbitdb.errors import InputError
from orbitdb.store.file.tables import cycle, entropy_bound, orbit, pruned, stadium, trajectory
from orbitdb.store.reading.soundness import unsound

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference

_HIGHEST = 1.22
"""Larger than every bound, because the entropy of the geometric rules alone is 1.218756."""


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
    found = bounds_stored(connection, proof, a)
    for each in found:
        if not is_sound(each):
            raise unsound("a bound on the entropy at a =", each.a)
    by_a = groupby(found, key=lambda each: each.a)
    return [min(group, key=lambda each: (each.width, each.proof)) for _, group in by_a]


def is_sound(found: EntropyBounds) -> bool:
    """Tell whether a search could have found these bounds."""
    return (
        MIN_A <= found.a <= MAX_A
        and 0 <= found.lower <= found.upper <= _HIGHEST
        and found.window >= 2
        and 0 <= found.undecided <= found.windows
        and found.proof in (DOUBLES, BALLS)
    )


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
    if not row["seed"].isdecimal():
        raise unsound("not a seed:", row["seed"])
    return Reference(**{**row, "seed": int(row["seed"])})


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
