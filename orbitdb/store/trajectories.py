"""References from random trajectories, kept for each a."""

from dataclasses import asdict, fields

import sqlalchemy as sa

from orbitdb.store.catalogue import Catalogue
from orbitdb.store.rows import unsound
from orbitdb.store.schema import stadium, trajectory
from orbitdb.store.writer import Writer
from orbitdb.trajectory import Reference


def add_reference(writer: Writer, a: float, found: Reference) -> None:
    """Store the averages over an ensemble of random trajectories."""
    values = asdict(found) | {"seed": str(found.seed)}
    with writer.writing() as connection:
        key = {"stadium": writer.stadium_id(connection, a), "run": writer.run_id(connection)}
        connection.execute(sa.insert(trajectory).values(**key, **values))


def best_reference(catalogue: Catalogue, a: float) -> Reference | None:
    """Return the reference with the smallest error that is stored for one a, if there is one."""
    names = [field.name for field in fields(Reference)]
    query = (
        sa.select(*(trajectory.c[name] for name in names))
        .join(stadium)
        .where(stadium.c.a == a)
        .order_by(trajectory.c.lambda_d_error)
        .limit(1)
    )
    with catalogue.reading() as connection:
        row = connection.execute(query).mappings().first()
    if row is None:
        return None
    if not row["seed"].isdecimal():
        raise unsound("a seed that is none:", row["seed"])
    return Reference(**{**row, "seed": int(row["seed"])})
