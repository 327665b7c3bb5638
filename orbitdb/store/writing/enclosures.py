"""Storing proved bounds on the topological entropy."""

from typing import TYPE_CHECKING

import sqlalchemy as sa

from orbitdb.store.file.tables import entropy_bound
from orbitdb.store.writing.writer import Writer

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds


def keep_bounds(writer: Writer, found: "EntropyBounds", proof: str, computed: str | None = None) -> bool:
    """Store what windows of one length prove, unless just that is stored; tell whether it was not.

    Parameters
    ----------
    writer : Writer
    found : EntropyBounds
    proof : str
        What has decided the windows: `orbitdb.store.file.schema.DOUBLES` or `BALLS`.
    computed : str, optional
        The arithmetic that has found it, if it was another process (`Writer.run_id`).
    """
    table = entropy_bound.c
    values = {name: getattr(found, name) for name in ("lower", "upper", "windows", "undecided")}
    here = (table.a == found.a) & (table.proof == proof) & (table.edges == found.window)
    with writer.writing() as connection:
        old = connection.execute(sa.select(*(table[name] for name in values)).where(here)).first()
        if old is not None and tuple(old) == tuple(values.values()):
            return False
        key = {
            "a": found.a,
            "proof": proof,
            "edges": found.window,
            "run": writer.run_id(connection, computed),
        }
        connection.execute(sa.insert(entropy_bound).prefix_with("OR REPLACE").values(**key, **values))
    return True
