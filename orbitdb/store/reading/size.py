"""What a catalogue takes: bytes a row, as they are."""

from dataclasses import dataclass

import sqlalchemy as sa

from orbitdb.store.file.schema import orbit, sequence
from orbitdb.store.reading.reader import Reader


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


def room(reader: Reader) -> Room:
    """Measure the room that sequences and orbits take."""
    counts = [sa.select(sa.func.count()).select_from(table).scalar_subquery() for table in (sequence, orbit)]
    with reader.reading() as connection:
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
