"""Look up words and their lives in a catalogue, count orbits at any a, and find the default a."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from sqlalchemy import REAL, Connection, Integer, Select, Text, and_, bindparam, cast, func, or_, select, true

from orbitdb.arrays import Floats
from orbitdb.billiard import USUAL_A
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Record
from orbitdb.errors import InputError
from orbitdb.magnetic.action import area_slopes
from orbitdb.orbits.orbit import Orbit, pruned_words
from orbitdb.orbits.orbits import NUMBERS
from orbitdb.orbits.status import Status
from orbitdb.store import tables as t
from orbitdb.store.file import reading
from orbitdb.store.sqlite import cursor_of, path_of
from orbitdb.store.tables import BORN
from orbitdb.store.views import classes, life
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.symmetry import SymmetryClass, act_on_area, class_of, image_coordinates
from orbitdb.symbols.words import MAX_KEYED, from_strings, key, keys_of_period, word_of
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.orbits.exponents import Tally

Lives = tuple[tuple[float, float | None], ...]

# These statements are built once, which takes longer than their answer for a single word.
_NUMBERS, _HALF_LENGTH = bindparam("numbers", type_=Text), bindparam("half_length", type_=REAL)
_STORED = (
    select(
        t.orbit.c.cycle,
        t.cycle.c.time_reversal,
        t.cycle.c.symmetry,
        t.cycle.c.class_size,
        *(t.orbit.c[name] for name in ("status", "coordinates", "solver", *NUMBERS)),
    )
    .join_from(t.orbit, t.cycle, t.cycle.c.id == t.orbit.c.cycle)
    .where(t.in_list(t.orbit.c.cycle, _NUMBERS), t.at_a(t.orbit, _HALF_LENGTH))
)
_LIVES = (
    select(life.c.cycle, func.coalesce(life.c.born, 0.0), life.c.dies)
    .where(t.in_list(life.c.cycle, _NUMBERS))
    .order_by(life.c.cycle, life.c.born)
)


def find_words(connection: Connection, words: Sequence[str], a: float) -> list[Orbit | None]:
    """Return the orbits of primitive words, in the given rotations, at a given a; None if not stored."""
    pruned = pruned_words(words, a)
    stored = _stored_pruned(connection, [one.representative for one in pruned.values()])
    families = {word: class_of(word) for word in words if word not in pruned}
    ids = t.class_ids(connection, [family.representative for family in families.values()])
    numbers = {"numbers": json.dumps([*ids.values()])}
    rows = connection.execute(_STORED, numbers | {"half_length": a}).mappings() if ids else ()
    by_class = {row["cycle"]: dict(row) for row in rows}
    lives = _lives(connection, numbers) if by_class else {}

    def found(word: str) -> Orbit | None:
        if word in pruned:
            return replace(pruned[word], stored=True) if pruned[word].representative in stored else None
        number = ids[families[word].representative]
        if number not in by_class:
            return None
        orbit = _image(word, families[word], by_class[number], a)
        return replace(orbit, exists=lives.get(number))

    return [found(word) for word in words]


def lives_of(connection: Connection, representative: str) -> Lives | None:
    """Return the ranges of a in which a class is an orbit, or None if no births of it are stored."""
    if len(representative) > MAX_KEYED:
        return None
    number = key(representative)
    return _lives(connection, {"numbers": json.dumps([number])}).get(number)


def _lives(connection: Connection, numbers: Mapping[str, str]) -> dict[int, Lives]:
    """Return the ranges of a in which classes are orbits, by their ids; those without births are left out."""
    lives: dict[int, Lives] = {}
    for cycle, born, dies in connection.execute(_LIVES, numbers):
        lives[cycle] = (*lives.get(cycle, ()), (born, dies))
    return lives


def _image(word: str, family: SymmetryClass, stored: Mapping[str, Any], a: float) -> Orbit:
    """Return the orbit of a word, given its class and the row of its class at a."""
    row = {name: value for name, value in stored.items() if name != "cycle"}
    coordinates = None
    if row["area"] is not None:
        row["area"] = act_on_area(family.element, row["area"])
    if row["coordinates"] is not None:
        least = np.frombuffer(row["coordinates"], dtype="<f8")[None, :]
        coordinates = image_coordinates([word], [family.representative], family.element, least)[0]
    row |= {"status": Status(row["status"]), "coordinates": coordinates, "stored": True}
    return Orbit(**{"code": word, "representative": family.representative, "a": a, **row})


def _stored_pruned(connection: Connection, words: Sequence[str]) -> set[str]:
    """Return those of some geometrically pruned words, given as least rotations, that are stored."""
    if not words:
        return set()
    own, keyed = t.pruned.c, [-key(word) for word in words if len(word) <= MAX_KEYED]
    long = and_(own.id <= -t.LONG, t.in_list(own.word, [word for word in words if len(word) > MAX_KEYED]))
    query = select(own.word).where(or_(t.in_list(own.id, keyed), long))
    return set(connection.scalars(query))


def certificate_of(connection: Connection, representative: str, a: float) -> tuple[float, int] | None:
    """Return the radius and the number of bits of a class's certificate, or None if it has none."""
    number = t.class_ids(connection, [representative])[representative]
    own = t.certificate
    query = select(own.c.radius, own.c.bits).where(own.c.cycle == number, t.at_a(own, a))
    proof = connection.execute(query).one_or_none()
    return None if proof is None else (proof.radius, proof.bits)


def find_or_solve(path: Path | None, word: str, a: float) -> Orbit:
    """Return the orbit of a primitive word from the catalogue, or solve the word if it is not stored."""
    stored = None
    if path is not None:
        with reading(path) as connection:
            (stored,) = find_words(connection, [word], a)
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


@dataclass(frozen=True)
class Life(Record):
    """A life of a symmetry class: a range of a in which it is an orbit.

    Attributes
    ----------
    word : str
        The representative.
    p, class_size : int
    born : float or None
        The value of a at its birth; None if it is an orbit from a = 0 on.
    born_error : float
        Bound on the error of `born`.
    dies, dies_error : float or None
        The value of a at its death, and the bound on its error; None if it does not die.
    """

    word: str
    p: int
    class_size: int
    born: float | None
    born_error: float
    dies: float | None
    dies_error: float | None


def read_lives(connection: Connection, p: int) -> list[Life]:
    """Return the lives of all classes of a period, in order of birth."""
    columns = [life.c[field.name] for field in fields(Life)]
    query = select(*columns).where(life.c.cycle.between(*keys_of_period(p)))
    return [Life(*row) for row in connection.execute(query.order_by(life.c.born, life.c.word))]


NEAR = 2.0
"""Within this many error bounds of a birth or death, births and deaths do not decide the status of a word."""

_ROW = np.dtype([("cycle", "i8"), ("size", "i8"), ("a", "f8"), ("error", "f8"), ("born", "i8")])


def counts_at(connection: Connection, a: float, p: int) -> "Tally":
    """Count the orbits of a period at a given a; the births of the period must be complete.

    A class within the error of a birth or death is solved at this a, in ball arithmetic if necessary, so that
    orbits through a joint are recognised as they are in a fill.
    """
    from orbitdb.orbits.exponents import Tally

    own = t.change.c
    query = (
        select(t.cycle.c.id, t.cycle.c.class_size, own.a, own.error, own.kind == BORN)
        .join_from(t.change, t.cycle, t.cycle.c.id == own.cycle)
        .where(own.cycle.between(*keys_of_period(p)))
        .order_by(own.cycle, own.number)
    )
    rows = (tuple(row) for row in connection.execute(query))
    changes = np.fromiter(rows, _ROW)  # a list of all tuples would take four times the memory
    cycles, starts = np.unique(changes["cycle"], return_index=True)
    sizes = changes["size"][starts]
    begun = np.where(changes["a"] < a, np.where(changes["born"], 1, -1), 0)
    near = np.abs(changes["a"] - a) <= NEAR * changes["error"]
    alive = np.add.reduceat(begun, starts) > 0
    status = np.where(alive, Status.ORBIT, Status.DYNAMICAL).astype(object)
    undecided = np.flatnonzero(np.logical_or.reduceat(near, starts))
    if len(undecided):
        from orbitdb.orbits.solve import solve  # seldom needed

        words = from_strings([word_of(number) for number in cycles[undecided].tolist()])
        status[undecided] = solve(words, Stadium(a)).status
    orbits, boundary, unresolved = (
        int(sizes[status == one].sum()) for one in (Status.ORBIT, Status.BOUNDARY, Status.UNRESOLVED)
    )
    return Tally(count_admissible(p), orbits, int((status == Status.ORBIT).sum()), boundary, unresolved)


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


def coordinates_of(connection: Connection, a: float, rows: Mapping[str, Sequence[Any]]) -> Floats:
    """Return the coordinates of words, one word after another.

    Words that have none get a NaN for each bounce. The rows are columns: id, p, representative, code and
    element.
    """
    p, ids = np.array(rows["p"], np.int64), np.array(rows["id"], np.int64)
    own, cycle = t.orbit.c, t.cycle.c
    query = select(cycle.word, own.coordinates).join_from(t.orbit, t.cycle, cycle.id == own.cycle)
    query = query.where(
        t.at_a(t.orbit, a), t.in_list(own.cycle, np.unique(ids).tolist()), own.coordinates.is_not(None)
    )
    blobs = dict(cursor_of(connection, query).fetchall())
    found, start = np.full(p.sum(), np.nan), np.cumsum(p) - p
    groups: dict[tuple[int, int], list[int]] = {}
    for row, (word, element) in enumerate(zip(rows["representative"], rows["element"], strict=True)):
        if word in blobs:
            groups.setdefault((len(word), element), []).append(row)
    for (order, element), chosen in groups.items():
        codes, words = ([rows[name][row] for row in chosen] for name in ("code", "representative"))
        least = np.frombuffer(b"".join(blobs[word] for word in words), dtype="<f8").reshape(-1, order)
        images = image_coordinates(codes, words, element, least)
        found[start[chosen][:, None] + np.arange(order)] = images
    return found


def area_slopes_of(connection: Connection, a: float, rows: Mapping[str, Sequence[Any]]) -> list[float]:
    """Return the derivatives of the areas in the curvature, which the words of a class share."""
    least = [word or code for word, code in zip(rows["representative"], rows["code"], strict=True)]
    own = {**rows, "code": least, "element": [0] * len(least)}
    coordinates, p = coordinates_of(connection, a, own), np.array(rows["p"])
    slopes, start = np.full(len(p), np.nan), np.cumsum(p) - p
    for order in np.unique(p).tolist():
        of_order = np.flatnonzero(p == order)
        words = from_strings([least[row] for row in of_order.tolist()])
        of_words = coordinates[start[of_order][:, None] + np.arange(order)]
        slopes[of_order] = area_slopes(Stadium(a), words, of_words)
    values: list[float] = slopes.tolist()
    return values


WITH_ORBITS = ("fill", "sweep", "orbit")
"""The tables that have rows at each a with orbits or sweeps."""

_WITH_LEVELS = select(t.level_fill.c.a).distinct().order_by(t.level_fill.c.a)


def a_values(connection: Connection, tables: Sequence[str] = ()) -> list[float]:
    """Return the stored values of a in order; with `tables`, only those with rows in one of them."""
    return list(connection.scalars(_values_of(*tables)))


@cache
def _values_of(*tables: str) -> Select[tuple[float]]:
    """Return the query of `a_values`, which takes longer to build than to answer."""
    named = [t.TABLES[name] for name in tables]
    used = [select(table).where(table.c.stadium == t.stadium.c.id).exists() for table in named]
    return select(t.stadium.c.a).where(or_(*used) if used else true()).order_by(t.stadium.c.a)


def with_data(connection: Connection) -> list[float]:
    """Return the values of a, in order, from which the default is chosen.

    They are those with periods, single words or sweeps; if there are none, those with quantum levels.
    """
    return a_values(connection, WITH_ORBITS) or list(connection.scalars(_WITH_LEVELS))


def default_a(connection: Connection) -> float:
    """Return the a of questions that name none: the only stored value if there is just one, otherwise 1.6.

    Raises `InputError` if there are several values but 1.6 is not one of them.
    """
    values = with_data(connection)
    if len(values) == 1:
        return values[0]
    if values and USUAL_A not in values:
        stored = ", ".join(map(format_float, values))
        raise InputError(
            f"orbits are stored at a = {stored}: name one, such as `a={format_float(values[0])}`"
        )
    return USUAL_A


def note_on_a(connection: Connection) -> str | None:
    """Return a line that says which a is the default; None if it is 1.6 and no other one is stored."""
    values, a = with_data(connection), format_float(default_a(connection))
    if values in ([], [USUAL_A]):
        return None
    which = "the only value" if len(values) == 1 else f"of {len(values)} values"
    return f"a = {a}, {which} in {path_of(connection).name}"
