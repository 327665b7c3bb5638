"""Storing births and deaths of classes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import sqlalchemy as sa

from orbitdb.orbits.births.changes import JOINTS, Changes, events
from orbitdb.store.file.schema import BORN, DIED
from orbitdb.store.file.tables import change
from orbitdb.store.writing.classes import insert
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols.words import keys_of_period


def add_changes(
    writer: Writer,
    connection: sa.Connection,
    numbers: Sequence[int],
    changes: Changes,
    computed: str | None = None,
) -> None:
    """Store the changes of classes by their numbers, with the arithmetic that computed them.

    Those that are always orbits are born at 0.
    """
    always = np.flatnonzero(changes.always)
    run = writer.run_id(connection, computed)
    rows: list[tuple[Any, ...]] = [
        (numbers[i], 1, 0.0, 0.0, BORN, None, None, None, None, run) for i in always.tolist()
    ]
    count = changes.always.astype(int).tolist()
    names = ("word", "a", "error", "born", "bounce", "joint", "slope")
    columns = (getattr(changes, name).tolist() for name in names)
    for word, a, error, born, bounce, joint, slope in zip(*columns, strict=True):
        count[word] += 1
        kind = BORN if born else DIED
        rows.append((numbers[word], count[word], a, error, kind, bounce, JOINTS[joint], None, slope, run))
    if rows:
        insert(connection, "change", list(zip(*rows, strict=True)))


def number_events(connection: sa.Connection, p: int) -> Sequence[Any]:
    """Number the events of a period whose changes are all stored; return the changes."""
    here = change.c.cycle.between(*keys_of_period(p))
    found = connection.execute(
        sa.select(change.c.cycle, change.c.number, change.c.a, change.c.error, change.c.kind).where(here)
    ).all()
    moving = [row for row in found if row.a > 0]
    if moving:
        a, error = (np.array([getattr(row, name) for row in moving]) for name in ("a", "error"))
        numbered = zip(events(a, error).tolist(), moving, strict=True)
        connection.exec_driver_sql(
            "UPDATE change SET event = ? WHERE cycle = ? AND number = ?",
            [(event, row.cycle, row.number) for event, row in numbered],
        )
    return found
