"""Store classes, orbits, births, certificates, and results such as bounds, averages and levels."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import repeat
from typing import TYPE_CHECKING, Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray
from sqlalchemy import Connection, Table, select
from sqlalchemy.dialects import sqlite

from orbitdb.arrays import Floats, Marks
from orbitdb.orbits.births import JOINTS, Changes, events
from orbitdb.orbits.orbits import NUMBERS, Orbits
from orbitdb.orbits.status import EXISTING
from orbitdb.store import tables as t
from orbitdb.store.tables import BORN, DIED, DONE
from orbitdb.store.writer import Writer, replace_row
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import from_strings, keys_of_period

if TYPE_CHECKING:
    from orbitdb.entropy_bounds.bounds import EntropyBounds
    from orbitdb.open_stadium.escape import Escape
    from orbitdb.quantum.exact_levels import LevelWindow
    from orbitdb.trajectories.ensemble import Reference


def replace_certificates(
    writer: Writer,
    connection: Connection,
    stadium_id: int,
    tried: Sequence[int],
    proved: Sequence[tuple[int, int, float, int]],
    version: str,
) -> None:
    """Delete the certificates of all classes that were tried, and store those of the proved classes.

    A proof consists of the ids of a class and of the run that stored its orbit, the radius, and the number of
    bits of the arithmetic. It is left out if others have deleted or replaced the orbit meanwhile.
    """
    own = t.certificate
    for cycle in tried:
        connection.execute(sa.delete(own).where(own.c.stadium == stadium_id, own.c.cycle == cycle))
    of_tried = t.orbit.c.stadium == stadium_id, t.orbit.c.cycle.in_(tried)
    query = select(t.orbit.c.cycle, t.orbit.c.run).where(*of_tried)
    stored = {(cycle, run) for cycle, run in connection.execute(query)}
    if proved := [proof for proof in proved if proof[:2] in stored]:
        cycles, _, radii, bits = zip(*proved, strict=True)
        number = writer.run_id(connection)
        insert_new(connection, own, {
            "stadium": repeat(stadium_id, len(cycles)), "cycle": cycles, "radius": radii, "bits": bits,
            "version": repeat(version, len(cycles)), "run": repeat(number, len(cycles)),
        })  # fmt: skip


def keep_reference(writer: Writer, reference: "Reference") -> None:
    """Store averages over random trajectories, unless the same ones are stored."""
    values = reference.row() | {"seed": str(reference.seed)}
    with writer.transaction() as connection:
        values["stadium"] = writer.stadium_id(connection, values.pop("a"))
        _keep_new(writer, connection, t.trajectory, values)  # the same seed gives the same averages


def keep_bounds(writer: Writer, bounds: "EntropyBounds", computed: str | None = None) -> bool:
    """Store the bounds from windows of a given length; return whether they were new.

    `computed` is as in `Writer.run_id`.
    """
    values = {
        name: getattr(bounds, name) for name in ("a", "edges", "lower", "upper", "windows", "undecided")
    }
    values["proof"] = bounds.arithmetic
    with writer.transaction() as connection:
        return _keep_new(writer, connection, t.entropy_bound, values, computed)


def keep_escape(writer: Writer, found: "Escape") -> None:
    """Store what escapes from an open stadium, unless the same result is stored."""
    names = set(t.open_stadium.c.keys()) - {"run", "survival"}
    values = {name: getattr(found, name) for name in names} | {"seed": str(found.seed)}
    values |= {name: " ".join(map(str, getattr(found, name))) for name in ("opening", "without")}
    arrays = [part for by in (found.bounce, found.time, found.leg) for part in (by.survival, by.error)]
    values["survival"] = np.concatenate(arrays).astype("<f8").tobytes()
    with writer.transaction() as connection:
        _keep_new(writer, connection, t.open_stadium, values)


def _keep_new(
    writer: Writer,
    connection: Connection,
    table: Table,
    values: Mapping[str, Any],
    computed: str | None = None,
) -> bool:
    """Store a row and the id of this run, unless the same values are stored; return whether they were new."""
    same = [table.c[name] == value for name, value in values.items()]
    if connection.scalar(select(select(table).where(*same).exists())):
        return False
    replace_row(connection, table, {**values, "run": writer.run_id(connection, computed)})
    return True


def keep_levels(writer: Writer, levels: "LevelWindow") -> bool:
    """Store the levels of a window, without ranges that are stored already; return whether any were new."""
    own, fill = {"a": levels.a, "parity": str(levels.parity)}, t.level_fill.c
    query = select(fill.low, fill.high).where(fill.a == own["a"], fill.parity == own["parity"])
    with writer.transaction() as connection:
        stored = connection.execute(query.order_by(fill.low))  # by another process since this one began, too
        parts = [*levels.without(stored)]
        for part in parts:
            window = {name: getattr(part, name) for name in ("low", "high", "below", "seconds")}
            run = writer.run_id(connection, levels.arithmetic)
            replace_row(connection, t.level_fill, {**own, **window, "run": run})
            count = len(part.k)
            insert_new(connection, t.level, {
                **{name: repeat(value, count) for name, value in own.items()},
                "number": range(part.below + 1, part.below + 1 + count),
                "k": part.k.tolist(), "error": part.error.tolist(),
            })  # fmt: skip
    return bool(parts)


# classes, orbits, births and deaths; many rows at a time


NULL = float("nan")
"""SQLite stores NaN as NULL. It replaces None, because Python's driver looks for an adapter for each None and
each bytes (not bytearray), which takes longer than everything else."""


def add_classes(
    connection: Connection,
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
    insert_new(connection, t.cycle, {
        "id": numbers, "p": repeat(p, len(texts)), "word": texts, "class_size": sizes, "walls": walls,
        "time_reversal": reversals, "symmetry": labels, "words": words,
    })  # fmt: skip


def add_families(connection: Connection, families: Sequence[symmetry.SymmetryClass]) -> list[int]:
    """Store classes of one period, which may be too long to pack; return their ids."""
    least = [family.representative for family in families]
    ids = t.class_ids(connection, least)
    stabilisers = np.array([family.stabiliser for family in families], dtype=np.uint8)
    words = ["".join(family.words) for family in families]
    add_classes(connection, [*ids.values()], from_strings(least), stabilisers, words)
    return [*ids.values()]


def classes_stored(connection: Connection, p: int) -> bool:
    """Tell whether all classes of a period are stored, by a fill at any a or by births."""
    tables = (t.fill, t.birth_fill)
    done = [select(table).where(table.c.p == p, table.c.state == DONE).exists() for table in tables]
    return bool(connection.scalar(select(sa.or_(*done))))


def add_pruned(connection: Connection, p: int, words: Sequence[str], rules: Sequence[str]) -> None:
    """Store geometrically pruned words of period p, as least rotations, with the rules that they break."""
    numbers = t.pruned_ids(connection, p, words)
    insert_new(
        connection, t.pruned, {"id": numbers, "p": repeat(p, len(words)), "word": words, "rules": rules}
    )


def add_orbits(
    writer: Writer,
    connection: Connection,
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
    # isin would sort, which takes longer
    kept = np.logical_or.reduce([orbits.status == status for status in EXISTING])
    numbers = {name: _or_null(getattr(orbits, name), kept | (name == "margin")) for name in NUMBERS}
    insert_new(connection, t.orbit, {
        "stadium": repeat(stadium_id, count), "cycle": cycles, "status": orbits.status.tolist(),
        "coordinates": _blobs(orbits.coordinates, kept), **numbers, "iterations": orbits.iterations.tolist(),
        "solver": repeat(solver, count), "run": repeat(writer.run_id(connection, computed), count),
    })  # fmt: skip


def add_changes(
    writer: Writer,
    connection: Connection,
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
        insert_new(connection, t.change, dict(zip(named, zip(*rows, strict=True), strict=True)))


def number_events(connection: Connection, p: int) -> None:
    """Number the events of a period whose births and deaths are complete."""
    own = t.change.c
    query = select(own.cycle, own.number, own.a, own.error).where(
        own.cycle.between(*keys_of_period(p)), own.a > 0
    )
    if moving := connection.execute(query).all():
        cycles, numbers, *births = zip(*moving, strict=True)
        found = events(*map(np.array, births)).tolist()
        keyed = (own.cycle == sa.bindparam("of_class"), own.number == sa.bindparam("nth"))
        numbered = [
            {"of_class": cycle, "nth": number, "event": event}
            for cycle, number, event in zip(cycles, numbers, found, strict=True)
        ]
        connection.execute(sa.update(t.change).where(*keyed), numbered)


def _or_null(values: Floats, kept: Marks) -> list[float]:
    numbers: list[float] = np.where(kept & np.isfinite(values), values, NULL).tolist()
    return numbers


def _blobs(coordinates: Floats, kept: Marks) -> list[bytearray | float]:
    data = bytearray(np.ascontiguousarray(coordinates, dtype="<f8").tobytes())
    width = 8 * coordinates.shape[1]
    return [data[i * width : (i + 1) * width] if keep else NULL for i, keep in enumerate(kept.tolist())]


def insert_new(connection: Connection, table: Table, columns: Mapping[str, Iterable[Any]]) -> None:
    """Insert rows, given as columns, directly through the driver; skip rows whose keys are already stored.

    SQLAlchemy would take six times as long for rows as dicts. Raises `sqlite3.IntegrityError` if a row
    breaks any other constraint.
    """
    statement, names = _insertion(table, tuple(columns))
    rows = list(zip(*(columns[name] for name in names), strict=True))
    if rows:
        connection.exec_driver_sql(statement, rows)


@cache
def _insertion(table: Table, names: tuple[str, ...]) -> tuple[str, Sequence[str]]:
    """Return the statement that inserts rows with these columns, and their order in it."""
    statement = sqlite.insert(table).on_conflict_do_nothing()
    compiled = statement.compile(dialect=sqlite.dialect(), column_keys=list(names))
    return str(compiled), compiled.positiontup or ()
