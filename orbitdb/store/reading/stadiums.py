"""The stadiums of a catalogue, and the one that is meant where none is named."""

from collections.abc import Sequence

import sqlalchemy as sa

from orbitdb.errors import InputError
from orbitdb.store.asking.selection import USUAL_A
from orbitdb.store.file.schema import fill, orbit, stadium, sweep
from orbitdb.store.reading.fills import exact


def a_filled(connection: sa.Connection) -> list[float]:
    """Return the values of a at which periods are filled, whole or in part, in order."""
    return _a_with(connection, sa.exists().where(fill.c.stadium == stadium.c.id))


def a_stored(connection: sa.Connection) -> list[float]:
    """Return the values of a at which there are orbits, be it of single words, or sums of them, in order."""
    tables = (table.c.stadium == stadium.c.id for table in (fill, sweep, orbit))
    return _a_with(connection, sa.or_(*(sa.exists().where(has) for has in tables)))


def _a_with(connection: sa.Connection, condition: sa.ColumnElement[bool]) -> list[float]:
    return list(connection.scalars(sa.select(stadium.c.a).where(condition).order_by(stadium.c.a)))


def meant(values: Sequence[float]) -> float:
    """Return the a that is meant where none is named: the only one there is, else 1.6.

    Raises
    ------
    InputError
        If there are several, and 1.6 is none of them.
    """
    if len(values) == 1:
        return values[0]
    if values and USUAL_A not in values:
        known = ", ".join(map(exact, values))
        raise InputError(f"orbits are stored at a = {known}: name one with --a, or with a= in Python")
    return USUAL_A
