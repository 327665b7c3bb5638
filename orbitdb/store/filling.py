"""Writing to a catalogue: batches of words and orbits, each in one transaction."""

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb import symmetry
from orbitdb.arithmetic import arithmetic
from orbitdb.errors import StoreError
from orbitdb.orbits import NUMBERS, Orbits, Status
from orbitdb.store.database import plain_errors, writing_engine
from orbitdb.store.schema import cycle, fill, orbit, run, stadium
from orbitdb.words import from_strings, to_strings

DONE, FILLING = "done", "filling"


class Writer:
    """A catalogue opened for writing, on behalf of one run of the program.

    Parameters
    ----------
    path : Path
        A catalogue of the newest schema.
    parameters : dict
        What the run was asked to do; kept as its provenance, with the machine's `arithmetic`.
    version : str
        The program's version.
    """

    def __init__(self, path: Path, parameters: dict[str, Any], version: str) -> None:
        self.path = path
        self._engine = writing_engine(path)
        provenance = parameters | {"arithmetic": arithmetic()}
        self._run = {"version": version, "parameters": json.dumps(provenance, sort_keys=True)}
        self._run_id: int | None = None

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """Give a connection that holds the write lock; all is written, or nothing."""
        with plain_errors(self.path), self._engine.begin() as connection:
            yield connection

    def close(self) -> None:
        """Close the file, so that no journal stays beside it."""
        self._engine.dispose()

    def run_id(self, connection: sa.Connection) -> int:
        """Return the number of this run, noting it on its first write."""
        if self._run_id is None:
            started = datetime.now(UTC).isoformat(timespec="seconds")
            fresh = sa.insert(run).values(started=started, **self._run).returning(run.c.id)
            self._run_id = int(connection.execute(fresh).scalar_one())
        return self._run_id

    def stadium_id(self, connection: sa.Connection, a: float) -> int:
        """Return the number of a stadium, adding it if it is new."""
        connection.execute(sa.insert(stadium).prefix_with("OR IGNORE").values(a=a))
        return int(connection.execute(sa.select(stadium.c.id).where(stadium.c.a == a)).scalar_one())


@dataclass(frozen=True)
class Cursor:
    """How far a fill of one period at one a has come.

    Attributes
    ----------
    stadium, p : int
        What is filled.
    state : str
        ``filling`` or ``done``.
    word : str or None
        The last word that is stored.
    sequences_done : bool
        Whether all words of the period are stored, by a fill at any a.
    """

    stadium: int
    p: int
    state: str
    word: str | None
    sequences_done: bool


def open_fill(writer: Writer, connection: sa.Connection, a: float, p: int) -> Cursor:
    """Return where the fill of a period stands, beginning it if need be."""
    key = {"stadium": writer.stadium_id(connection, a), "p": p}
    fresh = sa.insert(fill).prefix_with("OR IGNORE").values(**key, state=FILLING, seconds=0.0)
    connection.execute(fresh)
    state, word = connection.execute(
        sa.select(fill.c.state, fill.c.cursor).filter_by(**key)
    ).one()  # fmt: skip
    complete = sa.select(fill.c.p).where(fill.c.p == p, fill.c.state == DONE).limit(1)
    return Cursor(**key, state=state, word=word, sequences_done=connection.scalar(complete) is not None)


def move_cursor(connection: sa.Connection, cursor: Cursor, word: str, seconds: float) -> Cursor:
    """Note that all words up to one are stored.

    Raises
    ------
    StoreError
        If another process has moved the same cursor.
    """
    key = (fill.c.stadium == cursor.stadium, fill.c.p == cursor.p)
    moved = connection.execute(
        sa.update(fill)
        .where(*key, fill.c.state == FILLING, fill.c.cursor.is_not_distinct_from(cursor.word))
        .values(cursor=word, seconds=fill.c.seconds + seconds)
    )
    if moved.rowcount != 1:
        raise StoreError(
            f"another process is filling period {cursor.p}: let it finish, or stop it and try again"
        )
    return Cursor(cursor.stadium, cursor.p, cursor.state, word, cursor.sequences_done)


def close_fill(connection: sa.Connection, cursor: Cursor, counts: dict[str, int]) -> None:
    """Note that a period is complete, with its counts."""
    key = (fill.c.stadium == cursor.stadium, fill.c.p == cursor.p)
    connection.execute(sa.update(fill).where(*key).values(state=DONE, **counts))


def count_statuses(connection: sa.Connection, cursor: Cursor) -> dict[str, tuple[int, int]]:
    """Return for each status the number of words and of classes among a period's orbits."""
    query = (
        sa.select(orbit.c.status, sa.func.sum(cycle.c.class_size), sa.func.count())
        .join(cycle, cycle.c.id == orbit.c.cycle)
        .where(orbit.c.stadium == cursor.stadium, cycle.c.p == cursor.p)
        .group_by(orbit.c.status)
    )
    return {status: (words, classes) for status, words, classes in connection.execute(query)}


def add_cycles(
    connection: sa.Connection, words: NDArray[np.uint8], stabilisers: NDArray[np.uint8]
) -> list[int]:
    """Store symmetry classes by their least words, shape (N, p); return their numbers in order."""
    first = (connection.scalar(sa.select(sa.func.max(cycle.c.id))) or 0) + 1
    ids = list(range(first, first + len(words)))
    kinds = {
        mask: (symmetry.class_size(mask), symmetry.time_reversal(mask), symmetry.label(mask))
        for mask in np.unique(stabilisers).tolist()
    }
    walls = ((words == 0) | (words == 2)).sum(axis=1).tolist()
    p = words.shape[1]
    rows = [
        (number, p, word, kinds[mask][0], count, *kinds[mask][1:])
        for number, word, count, mask in zip(ids, to_strings(words), walls, stabilisers.tolist(), strict=True)
    ]
    _insert(connection, "INSERT INTO cycle VALUES (?, ?, ?, ?, ?, ?, ?)", rows)
    return ids


def add_class(connection: sa.Connection, family: symmetry.SymmetryClass) -> int:
    """Store one symmetry class of any order and all its words, unless they are there; return its number."""
    word = family.representative
    known = connection.scalar(sa.select(cycle.c.id).where(cycle.c.p == len(word), cycle.c.word == word))
    if known is not None:
        return int(known)
    stabilisers = np.array([family.stabiliser], dtype=np.uint8)
    (number,) = add_cycles(connection, from_strings([word]), stabilisers)
    members = symmetry.members(word).items()
    add_sequences(connection, [(len(word), image, number, element) for image, element in members])
    return number


def add_sequences(connection: sa.Connection, rows: Sequence[tuple[int, str, int, int]]) -> None:
    """Store admissible words: (p, least rotation, class, element)."""
    _insert(connection, "INSERT OR IGNORE INTO sequence (p, word, cycle, element) VALUES (?, ?, ?, ?)", rows)


def add_pruned(connection: sa.Connection, rows: Sequence[tuple[int, str, str]]) -> None:
    """Store geometrically pruned words: (p, least rotation, rules broken)."""
    _insert(connection, "INSERT OR IGNORE INTO sequence (p, word, rules) VALUES (?, ?, ?)", rows)


def add_orbits(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    cycles: Sequence[int],
    orbits: Orbits,
    solver: str,
) -> None:
    """Store what became of some classes; ``orbits`` holds their least words."""
    kept = np.isin(orbits.status, [Status.ORBIT.value, Status.BOUNDARY.value])
    columns = [_or_none(getattr(orbits, name), kept | (name == "margin")) for name in NUMBERS]
    blobs = _blobs(orbits.coordinates, kept)
    number = writer.run_id(connection)
    rows = [
        (stadium_id, key, status, blob, *values, steps, solver, number)
        for key, status, blob, steps, *values in zip(
            cycles, orbits.status.tolist(), blobs, orbits.iterations.tolist(), *columns, strict=True
        )
    ]
    marks = ", ".join("?" * 14)
    _insert(connection, f"INSERT OR IGNORE INTO orbit VALUES ({marks})", rows)


def _or_none(values: NDArray[np.float64], kept: NDArray[np.bool_]) -> list[float | None]:
    return [
        value if keep else None
        for value, keep in zip(values.tolist(), (kept & np.isfinite(values)).tolist(), strict=True)
    ]


def _blobs(coordinates: NDArray[np.float64], kept: NDArray[np.bool_]) -> list[bytes | None]:
    data = np.ascontiguousarray(coordinates, dtype="<f8").tobytes()
    width = 8 * coordinates.shape[1]
    return [data[i * width : (i + 1) * width] if keep else None for i, keep in enumerate(kept.tolist())]


def _insert(connection: sa.Connection, statement: str, rows: Sequence[tuple[Any, ...]]) -> None:
    if rows:
        connection.exec_driver_sql(statement, list(rows))
