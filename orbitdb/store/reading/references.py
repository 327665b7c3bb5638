"""References from random trajectories, as they are stored for each a."""

from dataclasses import fields

import sqlalchemy as sa

from orbitdb.store.file.tables import stadium, trajectory
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import unsound
from orbitdb.trajectories.ensemble import Reference


def best_reference(reader: Reader, a: float) -> Reference | None:
    """Return the reference with the smallest error that is stored for one a, if there is one."""
    names = [field.name for field in fields(Reference)]
    query = (
        sa.select(*(trajectory.c[name] for name in names))
        .join(stadium)
        .where(stadium.c.a == a)
        .order_by(trajectory.c.lambda_d_error)
        .limit(1)
    )
    with reader.reading() as connection:
        row = connection.execute(query).mappings().first()
    if row is None:
        return None
    if not row["seed"].isdecimal():
        raise unsound("a seed that is none:", row["seed"])
    return Reference(**{**row, "seed": int(row["seed"])})
