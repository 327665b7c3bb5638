"""Storing the levels of the stadium, a window of k at a time."""

import sqlalchemy as sa

from orbitdb.quantum.levels import Levels
from orbitdb.store.file.tables import level, level_fill
from orbitdb.store.writing.writer import Writer


def keep_levels(writer: Writer, found: Levels) -> bool:
    """Store the levels of a window, unless some of it is stored; tell whether it was not."""
    of, own = level_fill.c, {"a": found.a, "parity": str(found.parity)}
    stored = (of.a == found.a) & (of.parity == own["parity"]) & (of.low < found.high) & (of.high > found.low)
    with writer.writing() as connection:
        if connection.scalar(sa.select(sa.exists().where(stored))):
            return False
        window = {name: getattr(found, name) for name in ("low", "high", "below", "seconds")}
        run = writer.run_id(connection, found.arithmetic)
        connection.execute(sa.insert(level_fill).values(**own, **window, run=run))
        rows = [
            {**own, "number": found.below + n, "k": k, "error": error}
            for n, (k, error) in enumerate(zip(found.k.tolist(), found.error.tolist(), strict=True), 1)
        ]
        if rows:
            connection.execute(sa.insert(level), rows)
    return True
