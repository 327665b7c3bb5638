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
from numpy.typing import NDArray

from orbitdb import __version__
from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.errors import StoreError
from orbitdb.orbits.births import JOINTS, Changes, events
from orbitdb.orbits.status import EXISTING, NUMBERS, Orbits
from orbitdb.store.connection import (
    Connection,
    Moment,
    open_to_read,
    open_to_write,
    plain_errors,
    transaction,
)
from orbitdb.store.file import need_newest
from orbitdb.store.fills import of_spans
from orbitdb.store.paths import Place, absolute_path, need_place, place, places_beside, remove_journal_of
from orbitdb.store.schema import BORN, DIED, DONE, id_of_class, ids_of_pruned
from orbitdb.symbols import symmetry
from orbitdb.symbols.symmetry import joined_members
from orbitdb.symbols.words import from_strings, keys_of_period

if TYPE_CHECKING:
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.quantum.levels import LevelWindow
    from orbitdb.trajectories.ensemble import Reference


class Writer:
    """A catalogue with the latest schema, open for writing by one run of the program.

    The parameters of the run and its `arithmetic` are stored as provenance. `open_to_write` explains
    `references`. A writer never creates a file (`orbitdb.store.file` does).
    """

    def __init__(self, path: Path, parameters: dict[str, Any], references: bool = True) -> None:
        need_newest(path)
        self.path = absolute_path(path)
        self._parameters, self._references = parameters, references
        self._connection: Connection | None = None
        self._run_ids: dict[str, int] = {}
        self._place = place(self.path)
        self._journal: dict[Path, Place | None] = {}

    @contextmanager
    def writing(self) -> Iterator[Connection]:
        """Yield a connection that has the write lock, in a single transaction.

        Raises
        ------
        StoreError
            If the file cannot be written, or is no longer at its path.
        """
        noted = dict(self._run_ids)
        try:
            self._need_place()
            with plain_errors(self.path):
                if self._connection is None:
                    self._connection = open_to_write(self.path, self._references)
                with transaction(self._connection, "BEGIN IMMEDIATE"):
                    yield self._connection
                    own = next(iter(self._run_ids.values()), None)
                    self._connection.execute("UPDATE run SET commits = commits + 1 WHERE id = ?", (own,))
                    self._need_place()
                    self._journal = places_beside(self.path)
        except BaseException:
            self._run_ids = noted  # the runs recorded since then were rolled back
            raise

    @contextmanager
    def reading(self) -> Iterator[Moment]:
        """Yield a connection that sees the file as it is now, even while others write."""
        self._need_place()
        with plain_errors(self.path), closing(open_to_read(self.path)) as moment, transaction(moment):
            yield moment

    def try_to_write(self) -> None:
        """Check that the file is writable without writing to it; raise `StoreError` if not."""
        with self.writing() as connection:
            connection.execute("DELETE FROM run WHERE FALSE")

    def close(self) -> None:
        """Move the journal into the file and close it, even while others read it.

        Raises
        ------
        StoreError
            If the file is no longer at its path.
        """
        if self._connection is not None:
            with suppress(sqlite3.Error):
                self._connection.execute("PRAGMA wal_checkpoint")
            self._connection.close()
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

    def run_id(self, connection: Connection, computed: str | None = None) -> int:
        """Return the id of this run; the first call stores the run.

        A run has a separate id for each arithmetic that its workers use, by default that of this machine.
        """
        computed = computed or arithmetic()
        if computed not in self._run_ids:
            provenance = json.dumps(self._parameters | {"arithmetic": computed}, sort_keys=True)
            started = datetime.now(UTC).isoformat()  # to the microsecond, to distinguish runs
            values = {"started": started, "version": __version__, "parameters": provenance}
            self._run_ids[computed] = insert_row(connection, "run", values)
        return self._run_ids[computed]

    def stadium_id(self, connection: Connection, a: float) -> int:
        """Return the id of the stadium with a given a, after storing it if it is new."""
        connection.execute("INSERT INTO stadium (a) VALUES (?) ON CONFLICT DO NOTHING", (a,))
        return int(connection.scalar("SELECT id FROM stadium WHERE a = ?", (a,)))


def insert_row(connection: Connection, table: str, values: Mapping[str, Any]) -> int:
    """Store a row, in place of one with the same key, and return its id."""
    names = ", ".join(f":{name}" for name in values)
    statement = f"INSERT OR REPLACE INTO {table} ({', '.join(values)}) VALUES ({names})"
    return int(connection.execute(statement, values).lastrowid or 0)


def replace_certificates(
    writer: Writer,
    connection: Connection,
    stadium_id: int,
    tried: Sequence[int],
    proved: Sequence[tuple[int, float, int]],
    version: str,
) -> None:
    """Delete the certificates of all classes that were tried, and store those of the proved classes.

    A proof consists of the id of a class, the radius, and the number of bits of the arithmetic.
    """
    keys = [(stadium_id, cycle) for cycle in tried]
    connection.executemany("DELETE FROM certificate WHERE stadium = ? AND cycle = ?", keys)
    if proved:
        number = writer.run_id(connection)
        rows = [(stadium_id, cycle, radius, bits, version, number) for cycle, radius, bits in proved]
        connection.executemany("INSERT INTO certificate VALUES (?, ?, ?, ?, ?, ?)", rows)


def add_reference(writer: Writer, reference: "Reference") -> None:
    """Store averages over random trajectories."""
    values = asdict(reference) | {"seed": str(reference.seed)}
    a = values.pop("a")
    with writer.writing() as connection:
        key = {"stadium": writer.stadium_id(connection, a), "run": writer.run_id(connection)}
        insert_row(connection, "trajectory", key | values)


def keep_bounds(writer: Writer, bounds: "EntropyBounds", proof: str, computed: str | None = None) -> bool:
    """Store the bounds from windows of a given length; return whether they were new.

    `proof` is `orbitdb.entropy.bounds.DOUBLES` or `BALLS`; `computed` is as in `Writer.run_id`.
    """
    values = {name: getattr(bounds, name) for name in ("lower", "upper", "windows", "undecided")}
    key = {"a": bounds.a, "proof": proof, "edges": bounds.window}
    of_key = " AND ".join(f"{name} = :{name}" for name in key)
    query = f"SELECT {', '.join(values)} FROM entropy_bound WHERE {of_key}"
    with writer.writing() as connection:
        if connection.execute(query, key).fetchone() == tuple(values.values()):
            return False
        run = writer.run_id(connection, computed)
        insert_row(connection, "entropy_bound", {**key, **values, "run": run})
    return True


def keep_levels(writer: Writer, levels: "LevelWindow") -> bool:
    """Store the levels of a window, unless it overlaps a stored one; return whether they were stored."""
    own = (levels.a, str(levels.parity))
    overlapping = "SELECT 1 FROM level_fill WHERE a = ? AND parity = ? AND low < ? AND high > ?"
    with writer.writing() as connection:
        if connection.scalar(overlapping, (*own, levels.high, levels.low)):
            return False
        window = {name: getattr(levels, name) for name in ("low", "high", "below", "seconds")}
        run = writer.run_id(connection, levels.arithmetic)
        insert_row(connection, "level_fill", {"a": own[0], "parity": own[1], **window, "run": run})
        numbered = enumerate(zip(levels.k.tolist(), levels.error.tolist(), strict=True), levels.below + 1)
        rows = [(*own, number, k, error) for number, (k, error) in numbered]
        connection.executemany("INSERT INTO level VALUES (?, ?, ?, ?, ?)", rows)
    return True


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
    insert(connection, "cycle", {
        "id": numbers, "p": repeat(p, len(texts)), "word": texts, "class_size": sizes, "walls": walls,
        "time_reversal": reversals, "symmetry": labels, "words": words,
    })  # fmt: skip


def add_class(connection: Connection, family: symmetry.SymmetryClass) -> int:
    """Store a class of any period, unless it is stored already; return its id."""
    word = family.representative
    number = id_of_class(connection, word)
    stabilisers = np.array([family.stabiliser], dtype=np.uint8)
    add_classes(connection, [number], from_strings([word]), stabilisers, [joined_members(word)])
    return number


def classes_stored(connection: Connection, p: int) -> bool:
    """Tell whether all classes of a period are stored, by a fill at any a or by births."""
    tables = ("fill", "birth_fill")
    return any(
        connection.scalar(f"SELECT 1 FROM {table} WHERE p = ? AND state = ?", (p, DONE)) for table in tables
    )


def add_pruned(connection: Connection, p: int, words: Sequence[str], rules: Sequence[str]) -> None:
    """Store geometrically pruned words of period p, as least rotations, with the rules that they break."""
    numbers = ids_of_pruned(connection, p, words)
    insert(connection, "pruned", {"id": numbers, "p": repeat(p, len(words)), "word": words, "rules": rules})


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
    kept = np.logical_or.reduce(
        [orbits.status == status for status in EXISTING]
    )  # faster than isin, which sorts
    numbers = {name: _or_null(getattr(orbits, name), kept | (name == "margin")) for name in NUMBERS}
    insert(connection, "orbit", {
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
        insert(connection, "change", dict(zip(named, zip(*rows, strict=True), strict=True)))


def number_events(connection: Connection, p: int) -> None:
    """Number the events of a period whose births and deaths are complete."""
    query = "SELECT cycle, number, a, error FROM change WHERE cycle BETWEEN ? AND ? AND a > 0"
    if moving := list(connection.records(query, keys_of_period(p))):
        numbers = events(*(np.array([row[name] for row in moving]) for name in ("a", "error")))
        numbered = zip(numbers.tolist(), moving, strict=True)
        connection.executemany(
            "UPDATE change SET event = ? WHERE cycle = ? AND number = ?",
            [(event, row["cycle"], row["number"]) for event, row in numbered],
        )


def _or_null(values: Floats, kept: Marks) -> list[float]:
    numbers: list[float] = np.where(kept & np.isfinite(values), values, NULL).tolist()
    return numbers


def _blobs(coordinates: Floats, kept: Marks) -> list[bytearray | float]:
    data = bytearray(np.ascontiguousarray(coordinates, dtype="<f8").tobytes())
    width = 8 * coordinates.shape[1]
    return [data[i * width : (i + 1) * width] if keep else NULL for i, keep in enumerate(kept.tolist())]


def insert(connection: Connection, table: str, columns: Mapping[str, Iterable[Any]]) -> None:
    """Insert rows, given as columns, directly through the driver; skip rows whose keys are already stored.

    Raises `sqlite3.IntegrityError` if a row breaks any other constraint.
    """
    marks = ", ".join("?" * len(columns))
    statement = f"INSERT INTO {table} ({', '.join(columns)}) VALUES ({marks}) ON CONFLICT DO NOTHING"
    connection.executemany(statement, list(zip(*columns.values(), strict=True)))


# deleting


def delete(path: Path, a: float, spans: Sequence[tuple[int, int]] = ()) -> None:
    """Delete what is stored at a given a, and return its space to the disk.

    With `spans`, ranges of periods, only orbits, fills and sweeps of these periods are deleted. Classes stay
    as long as an orbit at another a, or births, need them.
    """
    chosen = of_spans(spans)
    # without SQLite's checks of references, which would search all orbits for each deleted class
    with (
        closing(Writer(path, {"command": "delete"}, references=False)) as writer,
        writer.writing() as connection,
    ):
        number = connection.scalar("SELECT id FROM stadium WHERE a = ?", (a,))
        own = {
            "certificate": f"cycle IN (SELECT id FROM cycle WHERE {chosen})",
            "orbit": f"cycle IN (SELECT id FROM cycle WHERE {chosen})",
            "fill": chosen,
            "sweep_block": chosen,
            "sweep": chosen,
        }
        if not spans:
            own["trajectory"] = "TRUE"
            for table in ("entropy_bound", "level_fill", "level"):
                connection.execute(f"DELETE FROM {table} WHERE a = ?", (a,))
        for table, rows in own.items():
            connection.execute(f"DELETE FROM {table} WHERE stadium = ? AND {rows}", (number,))
        for statement in _UNUSED:
            connection.execute(statement)
    with suppress(StoreError), plain_errors(path), closing(open_to_write(path)) as own_connection:
        own_connection.execute("VACUUM")  # unless the disk is full or another process writes


_UNUSED = (
    "DELETE FROM cycle WHERE p NOT IN (SELECT p FROM birth_fill)"
    " AND id NOT IN (SELECT cycle FROM orbit UNION SELECT cycle FROM change)",
    "DELETE FROM stadium WHERE id NOT IN (SELECT stadium FROM orbit UNION SELECT stadium FROM fill"
    " UNION SELECT stadium FROM sweep UNION SELECT stadium FROM trajectory)",
)
"""Delete the classes without orbits and births, and the stadiums to which nothing refers.

Births need all classes of their period, also those that are never born."""
