"""Delete what is stored at one value of a."""

from collections.abc import Sequence
from contextlib import closing, suppress
from pathlib import Path

import sqlalchemy as sa

from orbitdb.errors import StoreError
from orbitdb.store.file.database import open_to_write, plain_errors
from orbitdb.store.file.tables import (
    birth_fill,
    certificate,
    change,
    cycle,
    entropy_bound,
    fill,
    level,
    level_fill,
    orbit,
    stadium,
    sweep,
    sweep_block,
    trajectory,
)
from orbitdb.store.writing.writer import Writer


def delete(path: Path, a: float, spans: Sequence[tuple[int, int]] = ()) -> None:
    """Delete what is stored at a given a, and give the room that it took back to the disk.

    With `spans`, ranges of periods, only orbits, fills and sweeps of these periods are deleted. Classes stay
    as long as an orbit at another a, or births, need them.
    """
    # references are kept here, because SQLite would look through all orbits for each class that goes
    with (
        closing(Writer(path, {"command": "delete"}, references=False)) as writer,
        writer.writing() as connection,
    ):
        number = connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))
        chosen = sa.or_(*(cycle.c.p.between(*span) for span in spans)) if spans else sa.true()
        classes = sa.select(cycle.c.id).where(chosen)
        for table in (certificate, orbit):
            connection.execute(sa.delete(table).where(table.c.stadium == number, table.c.cycle.in_(classes)))
        for table in (fill, sweep_block, sweep):
            own = sa.or_(*(table.c.p.between(*span) for span in spans)) if spans else sa.true()
            connection.execute(sa.delete(table).where(table.c.stadium == number, own))
        if not spans:
            connection.execute(sa.delete(trajectory).where(trajectory.c.stadium == number))
            for table in (entropy_bound, level_fill, level):
                connection.execute(sa.delete(table).where(table.c.a == a))
        _drop_unused(connection)
    with suppress(StoreError), plain_errors(path), closing(open_to_write(path)) as own_connection:
        own_connection.execute("VACUUM")  # unless the disk is full or another process writes


def _drop_unused(connection: sa.Connection) -> None:
    """Delete the classes without orbits and births, and the stadiums to which nothing refers."""
    born = sa.select(birth_fill.c.p)  # births need all classes of their period, also those never born
    needed = sa.union(sa.select(orbit.c.cycle), sa.select(change.c.cycle))
    connection.execute(sa.delete(cycle).where(cycle.c.p.not_in(born), cycle.c.id.not_in(needed)))
    used = sa.union(*(sa.select(table.c.stadium) for table in (orbit, fill, sweep, trajectory)))
    connection.execute(sa.delete(stadium).where(stadium.c.id.not_in(used)))
