"""What a catalogue takes: bytes a row as they are, and what a fill is going to need."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import sqlalchemy as sa

from orbitdb.counting import count_admissible
from orbitdb.errors import StoreError
from orbitdb.store.catalogue import Catalogue
from orbitdb.store.database import check_file
from orbitdb.store.fills import DONE, Fill
from orbitdb.store.schema import SCHEMA_VERSION, orbit, sequence

LARGE = 1_000_000
"""From so many sequences on, a fill says first what it is going to take."""

_BYTES, _ENUMERATING, _SOLVING, _STORING = 62.0, 1.4e-6, 1.6e-6, 3.6e-6
"""Of one sequence, at p = 15 and on one core of a 2020 server; used until the catalogue knows its own."""

_ENOUGH = 50_000
"""Sequences that a catalogue must have for rates of its own."""

_JOURNAL = 64 << 20
"""Room for what is written ahead of the database, at most."""


@dataclass(frozen=True)
class Need:
    """What a fill is going to take.

    Attributes
    ----------
    sequences : int
        Symbol sequences to come.
    bytes : int
        Disk space.
    seconds : float
        Time.
    """

    sequences: int
    bytes: int
    seconds: float


def need(path: Path, a: float, periods: Sequence[int], jobs: int) -> Need:
    """Estimate what a fill needs, at the rates of the catalogue's own fills if it has large ones.

    Parameters
    ----------
    path : Path
        The catalogue; it need not exist.
    a : float
        The stadium.
    periods : sequence of int
    jobs : int
        Number of processes that solve.
    """
    version = check_file(path)
    catalogue = Catalogue(path) if version == SCHEMA_VERSION else None
    fills = [] if catalogue is None else [f for b in catalogue.a_values() for f in catalogue.fills(b)]
    stored = {} if catalogue is None else {f.p: f.words for f in catalogue.fills(a)}
    known = {f.p for f in fills if f.state == DONE}
    left = {p: count_admissible(p) - stored.get(p, 0) for p in periods}
    sequences = sum(left.values())
    enumerating, solving, storing = _rates(fills)
    new = sum(count for p, count in left.items() if p not in known)
    solvers = (enumerating * new + solving * sequences) / jobs
    writer = storing * sequences
    seconds = max(solvers, writer) if jobs > 1 else solvers + writer
    return Need(sequences, round(_BYTES * sequences), seconds)


def _rates(fills: Sequence[Fill]) -> tuple[float, float, float]:
    """Return the processor time a sequence that enumerating, solving and storing take."""
    large = [f for f in fills if f.words >= _ENOUGH and f.storing and f.enumerating]
    words = sum(f.words for f in large)
    if not words:
        return _ENUMERATING, _SOLVING, _STORING
    enumerating, solving, storing = (
        sum(getattr(f, name) for f in large) / words for name in ("enumerating", "solving", "storing")
    )
    return enumerating, solving, storing


def check_room(path: Path, needed: Need) -> None:
    """Refuse a fill that the disk has no room for.

    Raises
    ------
    StoreError
        If the free space is smaller than the estimate.
    """
    folder = next(parent for parent in path.resolve().parents if parent.exists())
    free = shutil.disk_usage(folder).free
    if needed.bytes + min(needed.bytes, _JOURNAL) > free:
        raise StoreError(
            f"no room for {path}: {needed.sequences} sequences take about {gigabytes(needed.bytes)}, "
            f"{gigabytes(free)} are free: free some, or name a file on another disk with --db"
        )


def gigabytes(count: float) -> str:
    """Write a number of bytes."""
    return f"{count / 1e9:.2g} GB" if count >= 1e9 else f"{count / 1e6:.3g} MB"


@dataclass(frozen=True)
class Room:
    """The room that the rows of a catalogue take, indexes and free places among them.

    Attributes
    ----------
    sequences, orbits : int
        Rows: symbol sequences, and symmetry classes at one a each.
    per_sequence, per_orbit : float or None
        Bytes a row; None where there are no rows, or SQLite was built without its `dbstat`.
    """

    sequences: int
    orbits: int
    per_sequence: float | None
    per_orbit: float | None


def room(catalogue: Catalogue) -> Room:
    """Measure the room that sequences and orbits take."""
    counts = [sa.select(sa.func.count()).select_from(table).scalar_subquery() for table in (sequence, orbit)]
    with catalogue.reading() as connection:
        sequences, orbits = connection.execute(sa.select(*counts)).one()
        pages = _bytes_of_tables(connection)
    per_sequence = pages["sequence"] / sequences if pages and sequences else None
    per_orbit = pages["orbit"] / orbits if pages and orbits else None
    return Room(sequences, orbits, per_sequence, per_orbit)


def _bytes_of_tables(connection: sa.Connection) -> dict[str, int]:
    """Return the sizes of tables and indexes; nothing if SQLite cannot tell."""
    try:
        rows = connection.exec_driver_sql("SELECT name, pgsize FROM dbstat WHERE aggregate = TRUE").all()
    except sa.exc.OperationalError:
        return {}
    return {str(row.name): int(row.pgsize) for row in rows}
