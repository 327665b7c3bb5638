"""References from random trajectories, kept for each a."""

from dataclasses import asdict

import sqlalchemy as sa

from orbitdb.store.file.tables import trajectory
from orbitdb.store.writing.writer import Writer
from orbitdb.trajectories.ensemble import Reference


def add_reference(writer: Writer, a: float, found: Reference) -> None:
    """Store the averages over an ensemble of random trajectories."""
    values = asdict(found) | {"seed": str(found.seed)}
    with writer.writing() as connection:
        key = {"stadium": writer.stadium_id(connection, a), "run": writer.run_id(connection)}
        connection.execute(sa.insert(trajectory).values(**key, **values))
