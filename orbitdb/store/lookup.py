"""Look up single words in a catalogue, and find its default a."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy import REAL, Connection, Integer, and_, bindparam, cast, func, or_, select, true

from orbitdb.billiard import USUAL_A
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Orbit, pruned_word
from orbitdb.orbits.orbits import NUMBERS
from orbitdb.orbits.status import Status
from orbitdb.store import tables as t
from orbitdb.store.file import reading
from orbitdb.store.views import classes, life
from orbitdb.symbols import symmetry
from orbitdb.symbols.words import MAX_KEYED, key, keys_of_period
from orbitdb.text import format_float

Lives = tuple[tuple[float, float | None], ...]

# Statements that are asked word by word are built once, which takes longer than their answer.
_NUMBER, _HALF_LENGTH = bindparam("number", type_=Integer), bindparam("half_length", type_=REAL)
_STORED = (
    select(
        t.cycle.c.time_reversal,
        t.cycle.c.symmetry,
        t.cycle.c.class_size,
        *(t.orbit.c[name] for name in ("status", "coordinates", "solver", *NUMBERS)),
    )
    .join_from(t.orbit, t.cycle, t.cycle.c.id == t.orbit.c.cycle)
    .where(t.orbit.c.cycle == _NUMBER, t.at_a(t.orbit, _HALF_LENGTH))
)
_LIVES = (
    select(func.coalesce(life.c.born, 0.0), life.c.dies).where(life.c.cycle == _NUMBER).order_by(life.c.born)
)


def find_word(connection: Connection, word: str, a: float) -> Orbit | None:
    """Return the stored orbit of a primitive word at a given a, in the given rotation, or None."""
    if (pruned := pruned_word(word, a)) is not None:
        own = (t.pruned.c.p == pruned.p, t.pruned.c.word == pruned.representative)
        present = connection.scalar(select(t.pruned.c.id).where(*own))
        return None if present is None else replace(pruned, stored=True)
    family = symmetry.class_of(word)
    number = t.class_id(connection, family.representative)
    stored = connection.execute(_STORED, {"number": number, "half_length": a}).mappings().one_or_none()
    if stored is None:
        return None
    row = dict(stored)
    coordinates = None
    if row["area"] is not None:
        row["area"] = float(symmetry.act_on_areas(family.element, row["area"]))
    if row["coordinates"] is not None:
        places = np.frombuffer(row["coordinates"], dtype="<f8")[None, :]
        least = [family.representative]
        coordinates = symmetry.image_coordinates([word], least, family.element, places)[0]
    exists = lives_of(connection, family.representative)
    found = {"status": Status(row["status"]), "coordinates": coordinates, "stored": True, "exists": exists}
    return Orbit(**{"code": word, "representative": family.representative, "a": a, **row, **found})


def lives_of(connection: Connection, representative: str) -> Lives | None:
    """Return the ranges of a in which a class is an orbit, or None if no births of it are stored."""
    if len(representative) > MAX_KEYED:
        return None
    rows = connection.execute(_LIVES, {"number": key(representative)})
    return tuple((born, dies) for born, dies in rows) or None


def certificate_of(connection: Connection, representative: str, a: float) -> tuple[float, int] | None:
    """Return the radius and the number of bits of a class's certificate, or None if it has none."""
    number = t.class_id(connection, representative)
    own = t.certificate
    query = select(own.c.radius, own.c.bits).where(own.c.cycle == number, t.at_a(own, a))
    proof = connection.execute(query).one_or_none()
    return None if proof is None else (proof.radius, proof.bits)


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


def born_with(connection: Connection, orbit: Orbit) -> list[tuple[float, list[str]]]:
    """Return each stored birth of an orbit, with the representatives of the classes born on the same path.

    Classes with another period are left out, such as a shorter word that the orbit goes round twice.
    """
    if orbit.p > MAX_KEYED:
        return []
    by_birth: dict[float, list[str]] = {}
    own, other = t.change.alias(), t.change.alias()
    query = (
        select(own.c.a, t.cycle.c.word)
        .join_from(own, other, and_(other.c.event == own.c.event, other.c.cycle != own.c.cycle))
        .join(t.cycle, t.cycle.c.id == other.c.cycle)
        .where(own.c.cycle == key(orbit.representative), own.c.kind == t.BORN)
        .where(other.c.cycle.between(*keys_of_period(orbit.p)))
        .order_by(own.c.a, t.cycle.c.word)
    )
    for a, word in connection.execute(query):
        by_birth.setdefault(a, []).append(word)
    return list(by_birth.items())


def orbits_of_length(
    connection: Connection, a: float, length: float, within: float, least: float, limit: int
) -> Iterator[tuple[Any, ...]]:
    """Yield the orbits at a whose length, times a number of traversals, is a given length; the nearest first.

    Yields the representative, period, class size, number of traversals, length, error of the length, lambda,
    and how much longer all traversals are. Orbits shorter than `least` do not count.
    """
    repetitions = cast(func.round(length / classes.c.length), Integer)
    rows = select(classes, repetitions.label("repetitions")).subquery()
    own = rows.c
    difference = own.repetitions * own.length - length
    allowed = within + own.repetitions * func.coalesce(own.length_error, 0.0)
    columns = (own.representative, own.p, own.class_size, own.repetitions, own.length, own.length_error)
    query = (
        select(*columns, own.lyapunov, difference.label("difference"))
        .where(own.a == a, own.status == Status.ORBIT.value, own.length >= least, own.repetitions >= 1)
        .where(func.abs(difference) <= allowed)
        .order_by(func.abs(difference), own.p, own.representative)
        .limit(limit)
    )
    yield from (tuple(row) for row in connection.execute(query))


WITH_ORBITS = ("fill", "sweep", "orbit")
"""The tables that have rows at each a with orbits or sweeps."""


def a_values(connection: Connection, tables: Sequence[str] = ()) -> list[float]:
    """Return the stored values of a in order; with `tables`, only those with rows in one of them."""
    named = [t.TABLES[name] for name in tables]
    used = [select(table).where(table.c.stadium == t.stadium.c.id).exists() for table in named]
    query = select(t.stadium.c.a).where(or_(*used) if used else true()).order_by(t.stadium.c.a)
    return list(connection.scalars(query))


def default_a(connection: Connection) -> float:
    """Return the default a of a catalogue (`default_among`)."""
    return default_among(a_values(connection, WITH_ORBITS))


def default_among(values: Sequence[float]) -> float:
    """Return the default a: the only stored value if there is just one, otherwise 1.6.

    Raises `InputError` if there are several values but 1.6 is not one of them.
    """
    if len(values) == 1:
        return values[0]
    if values and USUAL_A not in values:
        stored = ", ".join(map(format_float, values))
        raise InputError(f"orbits are stored at a = {stored}: name one with --a, or with a= in Python")
    return USUAL_A
