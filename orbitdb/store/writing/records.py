"""Storing results other than orbits: proofs, bounds, references and levels."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

import sqlalchemy as sa

from orbitdb.store.file.tables import entropy_bound, level, level_fill, trajectory
from orbitdb.store.writing.writer import Writer

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.quantum.levels import Levels
    from orbitdb.trajectories.ensemble import Reference


def replace_certificates(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    tried: Sequence[int],
    proved: Sequence[tuple[int, float, int]],
    version: str,
) -> None:
    """Store the certificates of the classes that were proved, and drop older ones of all that were tried.

    A proof is a class, the radius, and the bits of the arithmetic; `version` is the program's.
    """
    keys = [(stadium_id, cycle) for cycle in tried]
    connection.exec_driver_sql("DELETE FROM certificate WHERE stadium = ? AND cycle = ?", keys)
    if proved:
        number = writer.run_id(connection)
        rows = [(stadium_id, cycle, radius, bits, version, number) for cycle, radius, bits in proved]
        connection.exec_driver_sql("INSERT INTO certificate VALUES (?, ?, ?, ?, ?, ?)", rows)


def add_reference(writer: Writer, a: float, found: "Reference") -> None:
    """Store the averages over an ensemble of random trajectories."""
    values = asdict(found) | {"seed": str(found.seed)}
    with writer.writing() as connection:
        key = {"stadium": writer.stadium_id(connection, a), "run": writer.run_id(connection)}
        connection.execute(sa.insert(trajectory).values(**key, **values))


def keep_bounds(writer: Writer, found: "EntropyBounds", proof: str, computed: str | None = None) -> bool:
    """Store what windows of one length prove, unless just that is stored; tell whether it was not.

    `proof` is what has decided the windows, `orbitdb.entropy.bounds.DOUBLES` or `BALLS`, and
    `computed` the arithmetic that has found it, if it was another process (`Writer.run_id`).
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


def keep_levels(writer: Writer, found: "Levels") -> bool:
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
