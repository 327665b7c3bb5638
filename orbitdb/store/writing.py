"""`Writer`, a catalogue open for writing; functions that store certificates, bounds, averages and levels."""

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict
from datetime import UTC, datetime
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray
from sqlalchemy.dialects import sqlite

from orbitdb import __version__
from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.errors import StoreError
from orbitdb.orbits.births import JOINTS, Changes, events
from orbitdb.orbits.status import EXISTING, NUMBERS, Orbits
from orbitdb.store.connection import (
    Place,
    driver,
    need_place,
    open_to_write,
    place,
    places_beside,
    plain_errors,
    reading_engine,
    remove_journal_of,
    writing_engine,
)
from orbitdb.store.file import absolute_path, need_newest
from orbitdb.store.schema import BORN, DIED, DONE, id_of_class, ids_of_pruned
from orbitdb.store.tables import (
    birth_fill,
    certificate,
    change,
    cycle,
    entropy_bound,
    fill,
    level,
    level_fill,
    orbit,
    pruned,
    run,
    stadium,
    sweep,
    sweep_block,
    trajectory,
)
from orbitdb.symbols import symmetry
from orbitdb.symbols.symmetry import joined_members
from orbitdb.symbols.words import from_strings, keys_of_period

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.quantum.levels import LevelWindow
    from orbitdb.trajectories.ensemble import Reference


class Writer:
    """A catalogue with the latest schema, open for writing by one run of the program.

    The parameters of the run and its `arithmetic` are stored as provenance. `writing_engine` explains
    `references`. A writer never creates a file (`orbitdb.store.file` does).
    """

    def __init__(self, path: Path, parameters: dict[str, Any], references: bool = True) -> None:
        need_newest(path)
        self.path = absolute_path(path)
        self._engine, self._reading = writing_engine(self.path, references), reading_engine(self.path)
        self._parameters = parameters
        self._run_ids: dict[str, int] = {}
        self._written = False
        self._place = place(self.path)
        self._journal: dict[Path, Place | None] = {}

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """Yield a connection that has the write lock, in a single transaction.

        Raises
        ------
        StoreError
            If the file cannot be written, or is no longer at its path.
        """
        noted = dict(self._run_ids)
        try:
            self._need_place()
            with plain_errors(self.path), self._engine.begin() as connection:
                yield connection
                if self._run_ids:
                    own = run.c.id == next(iter(self._run_ids.values()))
                    connection.execute(sa.update(run).where(own).values(commits=run.c.commits + 1))
                self._need_place()
                self._journal = places_beside(self.path)
        except BaseException:
            self._run_ids = noted  # the runs recorded since then were rolled back
            raise
        self._written = True

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Yield a connection that sees the file as it is now, even while others write."""
        self._need_place()
        with plain_errors(self.path), self._reading.begin() as connection:
            yield connection

    def try_to_write(self) -> None:
        """Check that the file is writable without writing to it; raise `StoreError` if not."""
        with self.writing() as connection:
            connection.execute(sa.delete(run).where(sa.false()))

    def close(self) -> None:
        """Move the journal into the file and close it, even while others read it.

        Raises
        ------
        StoreError
            If the file is no longer at its path.
        """
        if self._written:
            with (
                suppress(sa.exc.DBAPIError, sqlite3.Error),
                closing(self._engine.raw_connection()) as connection,
            ):
                connection.execute("PRAGMA wal_checkpoint")
        self._engine.dispose()
        remove_journal_of(self.path, self._place, self._journal)
        self._need_place()

    def _need_place(self) -> None:
        """Raise `StoreError` if the file was replaced, moved or deleted since it was opened."""
        need_place(
            self.path,
            self._place,
            "was writing to it: what it stored is in the old file; run the same command again to write to "
            "the file that you mean",
        )

    def run_id(self, connection: sa.Connection, computed: str | None = None) -> int:
        """Return the id of this run; the first call stores the run.

        A run has a separate id for each arithmetic that its workers use, by default that of this machine.
        """
        computed = computed or arithmetic()
        if computed not in self._run_ids:
            provenance = json.dumps(self._parameters | {"arithmetic": computed}, sort_keys=True)
            started = datetime.now(UTC).isoformat()  # to the microsecond, to distinguish runs
            values = {"started": started, "version": __version__, "parameters": provenance}
            fresh = sa.insert(run).values(**values).returning(run.c.id)
            self._run_ids[computed] = int(connection.execute(fresh).scalar_one())
        return self._run_ids[computed]

    def stadium_id(self, connection: sa.Connection, a: float) -> int:
        """Return the id of the stadium with a given a, after storing it if it is new."""
        connection.execute(sqlite.insert(stadium).values(a=a).on_conflict_do_nothing())
        return int(connection.execute(sa.select(stadium.c.id).where(stadium.c.a == a)).scalar_one())


def replace_certificates(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    tried: Sequence[int],
    proved: Sequence[tuple[int, float, int]],
    version: str,
) -> None:
    """Delete the certificates of all classes that were tried, and store those of the proved classes.

    A proof consists of the id of a class, the radius, and the number of bits of the arithmetic.
    """
    keys = [(stadium_id, cycle) for cycle in tried]
    connection.exec_driver_sql("DELETE FROM certificate WHERE stadium = ? AND cycle = ?", keys)
    if proved:
        number = writer.run_id(connection)
        rows = [(stadium_id, cycle, radius, bits, version, number) for cycle, radius, bits in proved]
        connection.exec_driver_sql("INSERT INTO certificate VALUES (?, ?, ?, ?, ?, ?)", rows)


def add_reference(writer: Writer, a: float, reference: "Reference") -> None:
    """Store averages over random trajectories."""
    values = asdict(reference) | {"seed": str(reference.seed)}
    with writer.writing() as connection:
        key = {"stadium": writer.stadium_id(connection, a), "run": writer.run_id(connection)}
        connection.execute(sa.insert(trajectory).values(**key, **values))


def keep_bounds(writer: Writer, bounds: "EntropyBounds", proof: str, computed: str | None = None) -> bool:
    """Store the bounds from windows of a given length; return whether they were new.

    `proof` is `orbitdb.entropy.bounds.DOUBLES` or `BALLS`; `computed` is as in `Writer.run_id`.
    """
    table = entropy_bound.c
    values = {name: getattr(bounds, name) for name in ("lower", "upper", "windows", "undecided")}
    same = (table.a == bounds.a) & (table.proof == proof) & (table.edges == bounds.window)
    with writer.writing() as connection:
        old = connection.execute(sa.select(*(table[name] for name in values)).where(same)).first()
        if old is not None and tuple(old) == tuple(values.values()):
            return False
        key = {
            "a": bounds.a,
            "proof": proof,
            "edges": bounds.window,
            "run": writer.run_id(connection, computed),
        }
        connection.execute(sa.insert(entropy_bound).prefix_with("OR REPLACE").values(**key, **values))
    return True


def keep_levels(writer: Writer, levels: "LevelWindow") -> bool:
    """Store the levels of a window, unless it overlaps a stored one; return whether they were stored."""
    of, own = level_fill.c, {"a": levels.a, "parity": str(levels.parity)}
    stored = (
        (of.a == levels.a) & (of.parity == own["parity"]) & (of.low < levels.high) & (of.high > levels.low)
    )
    with writer.writing() as connection:
        if connection.scalar(sa.select(sa.exists().where(stored))):
            return False
        window = {name: getattr(levels, name) for name in ("low", "high", "below", "seconds")}
        run = writer.run_id(connection, levels.arithmetic)
        connection.execute(sa.insert(level_fill).values(**own, **window, run=run))
        rows = [
            {**own, "number": levels.below + n, "k": k, "error": error}
            for n, (k, error) in enumerate(zip(levels.k.tolist(), levels.error.tolist(), strict=True), 1)
        ]
        if rows:
            connection.execute(sa.insert(level), rows)
    return True


# classes, orbits, births and deaths; many rows at a time


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
    of_period = change.c.cycle.between(*keys_of_period(p))
    changes = connection.execute(
        sa.select(change.c.cycle, change.c.number, change.c.a, change.c.error, change.c.kind).where(of_period)
    ).all()
    moving = [row for row in changes if row.a > 0]
    if moving:
        a, error = (np.array([getattr(row, name) for row in moving]) for name in ("a", "error"))
        numbered = zip(events(a, error).tolist(), moving, strict=True)
        connection.exec_driver_sql(
            "UPDATE change SET event = ? WHERE cycle = ? AND number = ?",
            [(event, row.cycle, row.number) for event, row in numbered],
        )
    return changes


def _or_null(values: Floats, kept: Marks) -> list[float]:
    numbers: list[float] = np.where(kept & np.isfinite(values), values, NULL).tolist()
    return numbers


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


# deleting


def delete(path: Path, a: float, spans: Sequence[tuple[int, int]] = ()) -> None:
    """Delete what is stored at a given a, and return its space to the disk.

    With `spans`, ranges of periods, only orbits, fills and sweeps of these periods are deleted. Classes stay
    as long as an orbit at another a, or births, need them.
    """
    # without SQLite's checks of references, which would search all orbits for each deleted class
    with (
        closing(Writer(path, {"command": "delete"}, references=False)) as writer,
        writer.writing() as connection,
    ):
        number = connection.scalar(sa.select(stadium.c.id).where(stadium.c.a == a))
        chosen = sa.or_(*(cycle.c.p.between(*span) for span in spans)) if spans else sa.true()
        classes = sa.select(cycle.c.id).where(chosen)
        for table in (certificate, orbit):
            connection.execute(sa.delete(table).where(table.c.stadium == number, table.c.cycle.in_(classes)))
        for table in (fill, sweep_block, sweep):
            own = sa.or_(*(table.c.p.between(*span) for span in spans)) if spans else sa.true()
            connection.execute(sa.delete(table).where(table.c.stadium == number, own))
        if not spans:
            connection.execute(sa.delete(trajectory).where(trajectory.c.stadium == number))
            for table in (entropy_bound, level_fill, level):
                connection.execute(sa.delete(table).where(table.c.a == a))
        _drop_unused(connection)
    with suppress(StoreError), plain_errors(path), closing(open_to_write(path)) as own_connection:
        own_connection.execute("VACUUM")  # unless the disk is full or another process writes


def _drop_unused(connection: sa.Connection) -> None:
    """Delete the classes without orbits and births, and the stadiums to which nothing refers."""
    born = sa.select(birth_fill.c.p)  # births need all classes of their period, also those never born
    needed = sa.union(sa.select(orbit.c.cycle), sa.select(change.c.cycle))
    connection.execute(sa.delete(cycle).where(cycle.c.p.not_in(born), cycle.c.id.not_in(needed)))
    used = sa.union(*(sa.select(table.c.stadium) for table in (orbit, fill, sweep, trajectory)))
    connection.execute(sa.delete(stadium).where(stadium.c.id.not_in(used)))
