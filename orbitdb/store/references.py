"""Stored averages over random trajectories: the reference beside averages over orbits."""

from typing import TYPE_CHECKING

import sqlalchemy as sa

from orbitdb.store.schema import stadium, trajectory
from orbitdb.trajectory import Reference

if TYPE_CHECKING:
    from orbitdb.store.catalogue import Catalogue

_NAMES = (
    "lambda_d", "lambda_d_error", "lambda_c", "lambda_c_error", "mean_free_path", "mean_free_path_error",
    "bounces", "groups",
)  # fmt: skip


def read_reference(catalogue: "Catalogue", a: float) -> Reference | None:
    """Return the longest stored simulation at one a, None if there is none."""
    query = (
        sa.select(trajectory)
        .join(stadium, stadium.c.id == trajectory.c.stadium)
        .where(stadium.c.a == a)
        .order_by(trajectory.c.bounces.desc(), trajectory.c.id.desc())
        .limit(1)
    )
    with catalogue.reading() as connection:
        row = connection.execute(query).mappings().first()
    if row is None:
        return None
    return Reference(**{name: row[name] for name in _NAMES}, seed=int(row["seed"]))
