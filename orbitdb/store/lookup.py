"""Look up single words in a catalogue, and find its default a."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from orbitdb.billiard import USUAL_A
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit, pruned_word
from orbitdb.orbits.status import NUMBERS, Status
from orbitdb.store.connection import Connection
from orbitdb.store.file import reading
from orbitdb.store.schema import AT_A, id_of_class
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import MAX_KEYED, key, keys_of_period
from orbitdb.text import exact

Lives = tuple[tuple[float, float | None], ...]

_STORED = ", ".join(("time_reversal", "symmetry", "class_size", "status", "coordinates", "solver", *NUMBERS))

_PARTNERS = """\
SELECT own.a, cycle.word FROM change AS own
JOIN change AS other ON other.event = own.event AND other.cycle <> own.cycle
JOIN cycle ON cycle.id = other.cycle
WHERE own.cycle = ? AND own.kind = 'born' AND other.cycle BETWEEN ? AND ?
ORDER BY own.a, cycle.word"""


def find_word(connection: Connection, word: str, a: float) -> Orbit | None:
    """Return the stored orbit of a primitive word at a given a, in the given rotation, or None."""
    if (pruned := pruned_word(word, a)) is not None:
        query = "SELECT 1 FROM pruned WHERE p = ? AND word = ?"
        present = connection.execute(query, (pruned.p, pruned.representative)).fetchone()
        return None if present is None else replace(pruned, stored=True)
    family = symmetry.class_of(word)
    query = f"SELECT {_STORED} FROM orbit JOIN cycle ON cycle.id = orbit.cycle WHERE cycle = ? AND {AT_A}"
    values = id_of_class(connection, family.representative), a
    row = next(connection.records(query, values), None)
    if row is None:
        return None
    coordinates = None
    if row["area"] is not None:
        row["area"] = float(symmetry.act_on_areas(family.element, row["area"]))
    if row["coordinates"] is not None:
        places = np.frombuffer(row["coordinates"], dtype="<f8")[None, :]
        least = [family.representative]
        coordinates = symmetry.image_coordinates([word], least, family.element, places)[0]
    exists = lives_of(connection, family.representative)
    own = {"status": Status(row["status"]), "coordinates": coordinates, "stored": True, "exists": exists}
    return Orbit(**{"code": word, "representative": family.representative, "a": a, **row, **own})


def lives_of(connection: Connection, representative: str) -> Lives | None:
    """Return the ranges of a in which a class is an orbit, or None if no births of it are stored."""
    if len(representative) > MAX_KEYED:
        return None
    query = "SELECT coalesce(born, 0.0), dies FROM life WHERE cycle = ? ORDER BY born"
    return tuple(connection.execute(query, (key(representative),))) or None


def certificate_of(connection: Connection, representative: str, a: float) -> tuple[float, int] | None:
    """Return the radius and the number of bits of a class's certificate, or None if it has none."""
    query = f"SELECT radius, bits FROM certificate WHERE cycle = ? AND {AT_A}"
    values = id_of_class(connection, representative), a
    proof: tuple[float, int] | None = connection.execute(query, values).fetchone()
    return proof


def find_or_solve(path: Path | None, word: str, a: float) -> Orbit:
    """Return the orbit of a primitive word from the catalogue, or solve the word if it is not stored."""
    stored = None
    if path is not None:
        with reading(path) as connection:
            stored = find_word(connection, word, a)
    if stored is not None:
        return stored
    from orbitdb.orbits.solve import solve_word

    return solve_word(word, a)


def with_existence(orbit: Orbit) -> Orbit:
    """Return an orbit with the ranges of a in which it exists, after computing them if necessary.

    The ranges stay unknown for words longer than `orbitdb.orbits.solve.LONGEST`.
    """
    if orbit.exists is not None:
        return orbit
    from orbitdb.orbits.solve import LONGEST, existence

    return orbit if orbit.p > LONGEST else replace(orbit, exists=tuple(existence(orbit.code)))


def born_with(connection: Connection, orbit: Orbit) -> list[tuple[float, list[str]]]:
    """Return each stored birth of an orbit, with the representatives of the classes born on the same path.

    Classes with another period are left out, such as a shorter word that the orbit goes round twice.
    """
    if orbit.p > MAX_KEYED or not orbit.exists:
        return []
    by_birth: dict[float, list[str]] = {}
    values = (key(orbit.representative), *keys_of_period(orbit.p))
    for a, word in connection.execute(_PARTNERS, values):
        by_birth.setdefault(a, []).append(word)
    return list(by_birth.items())


WITH_ORBITS = ("fill", "sweep", "orbit")
"""The tables that have rows at each a with orbits or sweeps."""


def a_values(connection: Connection, tables: Sequence[str] = ()) -> list[float]:
    """Return the stored values of a in order; with `tables`, only those with rows in one of them."""
    used = " OR ".join(f"EXISTS (SELECT 1 FROM {table} WHERE stadium = stadium.id)" for table in tables)
    return [a for (a,) in connection.execute(f"SELECT a FROM stadium WHERE {used or 'TRUE'} ORDER BY a")]


def a_meant(connection: Connection) -> float:
    """Return the default a of a catalogue (`meant`)."""
    return meant(a_values(connection, WITH_ORBITS))


def meant(values: Sequence[float]) -> float:
    """Return the default a: the only stored value if there is just one, otherwise 1.6.

    Raises `InputError` if there are several values but 1.6 is not one of them.
    """
    if len(values) == 1:
        return values[0]
    if values and USUAL_A not in values:
        stored = ", ".join(map(exact, values))
        raise InputError(f"orbits are stored at a = {stored}: name one with --a, or with a= in Python")
    return USUAL_A
