"""The stadiums of a catalogue, and the one that is meant where none is named."""

import sqlite3
from collections.abc import Sequence

from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.store.asking.selection import USUAL_A


def a_filled(connection: sqlite3.Connection) -> list[float]:
    """Return the values of a at which periods are filled, whole or in part, in order."""
    return _a_with(connection, "fill")


def a_stored(connection: sqlite3.Connection) -> list[float]:
    """Return the values of a at which there are orbits, be it of single words, or sums of them, in order."""
    return _a_with(connection, "fill", "sweep", "orbit")


def _a_with(connection: sqlite3.Connection, *tables: str) -> list[float]:
    known = " OR ".join(
        f"EXISTS (SELECT 1 FROM {table} WHERE {table}.stadium = stadium.id)" for table in tables
    )
    return [a for (a,) in connection.execute(f"SELECT a FROM stadium WHERE {known} ORDER BY a")]


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
