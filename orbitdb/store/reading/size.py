"""What a catalogue takes: bytes a row, as they are."""

from dataclasses import dataclass

import sqlalchemy as sa

from orbitdb.store.file.tables import cycle, orbit
from orbitdb.store.reading.reader import Reader


@dataclass(frozen=True)
class Room:
    """The room that the rows of a catalogue take, indexes and free places among them.

    Attributes
    ----------
    classes, orbits : int
        Rows: symmetry classes with their words, and what became of each at one a.
    per_class, per_orbit : float or None
        Bytes a row; None where there are no rows, or SQLite was built without its `dbstat`.
    """

    classes: int
    orbits: int
    per_class: float | None
    per_orbit: float | None


def room(reader: Reader) -> Room:
    """Measure the room that classes and orbits take."""
    counts = [sa.select(sa.func.count()).select_from(table).scalar_subquery() for table in (cycle, orbit)]
    with reader.reading() as connection:
        classes, orbits = connection.execute(sa.select(*counts)).one()
        pages = _bytes_of_tables(connection)
    per_class = pages["cycle"] / classes if pages and classes else None
    per_orbit = pages["orbit"] / orbits if pages and orbits else None
    return Room(classes, orbits, per_class, per_orbit)


def _bytes_of_tables(connection: sa.Connection) -> dict[str, int]:
    """Return the sizes of tables and indexes; nothing if SQLite cannot tell."""
    try:
        rows = connection.exec_driver_sql("SELECT name, pgsize FROM dbstat WHERE aggregate = TRUE").all()
    except sa.exc.OperationalError:
        return {}
    return {str(row.name): int(row.pgsize) for row in rows}
