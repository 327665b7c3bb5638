"""Store symmetry classes with all their words, orbits, births and deaths, many rows at a time.

`orbitdb.store.file.ids` explains the ids of classes.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Marks
from orbitdb.orbits.births import JOINTS, Changes, events
from orbitdb.orbits.status import EXISTING, NUMBERS, Orbits
from orbitdb.store.file.database import driver
from orbitdb.store.file.ids import id_of_class, ids_of_pruned
from orbitdb.store.file.schema import BORN, DIED, DONE
from orbitdb.store.file.tables import birth_fill, change, cycle, fill, orbit, pruned
from orbitdb.store.writing.writer import Writer
from orbitdb.symbols import symmetry
from orbitdb.symbols.symmetry import joined_members
from orbitdb.symbols.words import from_strings, keys_of_period

NULL = float("nan")
"""SQLite stores NaN as NULL. It replaces None, because Python's driver looks for an adapter for each None and
each bytes (not bytearray), which takes longer than everything else."""


def add_classes(
    connection: sa.Connection,
    numbers: Sequence[int],
    least: NDArray[np.uint8],
    stabilisers: NDArray[np.uint8],
    words: Sequence[str],
) -> None:
    """Store N classes, given their ids, representatives, shape (N, p), stabilisers and words.

    The words of each class are joined to one text, as by `orbitdb.symbols.symmetry.joined_words`.
    """
    p, masks = least.shape[1], stabilisers.tolist()
    sizes, reversals, labels = (
        list(map({mask: say(mask) for mask in set(masks)}.__getitem__, masks))
        for say in (symmetry.class_size, symmetry.time_reversal, symmetry.label)
    )
    walls = ((least == 0) | (least == 2)).sum(axis=1).tolist()
    texts = [joined[:p] for joined in words]
    insert(connection, cycle, {
        "id": numbers, "p": repeat(p, len(texts)), "word": texts, "class_size": sizes, "walls": walls,
        "time_reversal": reversals, "symmetry": labels, "words": words,
    })  # fmt: skip


def add_class(connection: sa.Connection, family: symmetry.SymmetryClass) -> int:
    """Store a class of any period, unless it is stored already; return its id."""
    word = family.representative
    number = id_of_class(driver(connection), word)
    stabilisers = np.array([family.stabiliser], dtype=np.uint8)
    add_classes(connection, [number], from_strings([word]), stabilisers, [joined_members(word)])
    return number


def classes_stored(connection: sa.Connection, p: int) -> bool:
    """Tell whether all classes of a period are stored, by a fill at any a or by births."""
    done = sa.union_all(
        *(sa.select(table.c.p).where(table.c.p == p, table.c.state == DONE) for table in (fill, birth_fill))
    )
    return connection.execute(done.limit(1)).first() is not None


def add_pruned(connection: sa.Connection, p: int, words: Sequence[str], rules: Sequence[str]) -> None:
    """Store geometrically pruned words of period p, as least rotations, with the rules that they break."""
    numbers = ids_of_pruned(driver(connection), p, words)
    insert(connection, pruned, {"id": numbers, "p": repeat(p, len(words)), "word": words, "rules": rules})


def add_orbits(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    cycles: Sequence[int],
    orbits: Orbits,
    solver: str,
    computed: str | None = None,
) -> None:
    """Store the orbits of representatives; `cycles` are the ids of their classes.

    `computed` names the arithmetic that computed them, by default that of this machine.
    """
    count = len(orbits)
    kept = np.logical_or.reduce(
        [orbits.status == status for status in EXISTING]
    )  # faster than isin, which sorts
    numbers = {name: _or_null(getattr(orbits, name), kept | (name == "margin")) for name in NUMBERS}
    insert(connection, orbit, {
        "stadium": repeat(stadium_id, count), "cycle": cycles, "status": orbits.status.tolist(),
        "coordinates": _blobs(orbits.coordinates, kept), **numbers, "iterations": orbits.iterations.tolist(),
        "solver": repeat(solver, count), "run": repeat(writer.run_id(connection, computed), count),
    })  # fmt: skip


def add_changes(
    writer: Writer,
    connection: sa.Connection,
    numbers: Sequence[int],
    changes: Changes,
    computed: str | None = None,
) -> None:
    """Store the births and deaths of the classes with the given ids, and the arithmetic that computed them.

    A class that is an orbit from a = 0 on is stored with a birth at 0.
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
        named = ("cycle", "number", "a", "error", "kind", "bounce", "joint", "event", "slope", "run")
        insert(connection, change, dict(zip(named, zip(*rows, strict=True), strict=True)))


def number_events(connection: sa.Connection, p: int) -> Sequence[Any]:
    """Number the events of a period whose births and deaths are complete; return the births and deaths."""
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


def _or_null(values: Floats, kept: Marks) -> list[float]:
    found: list[float] = np.where(kept & np.isfinite(values), values, NULL).tolist()
    return found


def _blobs(coordinates: Floats, kept: Marks) -> list[bytearray | float]:
    data = bytearray(np.ascontiguousarray(coordinates, dtype="<f8").tobytes())
    width = 8 * coordinates.shape[1]
    return [data[i * width : (i + 1) * width] if keep else NULL for i, keep in enumerate(kept.tolist())]


def insert(connection: sa.Connection, table: sa.Table, columns: Mapping[str, Iterable[Any]]) -> None:
    """Insert rows, given as columns, directly through the driver; skip rows whose keys are already stored.

    Raises `sqlite3.IntegrityError` if a row breaks any other constraint.
    """
    marks = ", ".join("?" * len(columns))
    statement = f"INSERT INTO {table.name} ({', '.join(columns)}) VALUES ({marks}) ON CONFLICT DO NOTHING"
    driver(connection).executemany(statement, list(zip(*columns.values(), strict=True)))
