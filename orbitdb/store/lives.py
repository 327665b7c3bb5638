"""Lives, the ranges of a in which stored classes are orbits, and the statuses of classes at any a.

If a is within the error of a birth or death of a class, its representative is solved at this a, in ball
arithmetic if necessary, so that orbits through a joint are recognised as they are in a fill.
"""

import sqlite3
from collections.abc import Sequence
from dataclasses import dataclass, fields
from enum import IntEnum
from itertools import groupby
from typing import TYPE_CHECKING, cast

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers, Marks, Places
from orbitdb.billiard.stadium import Stadium
from orbitdb.extras import Record
from orbitdb.orbits.status import Status
from orbitdb.store.schema import BORN, DONE
from orbitdb.store.tables import birth_fill, change, cycle, life
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.words import from_strings, keys_of_period, word_of

if TYPE_CHECKING:
    from orbitdb.orbits.exponents import Tally


@dataclass(frozen=True)
class BirthFill(Record):
    """How far the births and deaths of a period are stored, and their counts.

    Attributes
    ----------
    p : int
    state : str
        ``filling`` or ``done``; the counts exist once it is ``done``.
    words : int
        Number of words whose births and deaths are stored.
    seconds : float
        Elapsed time.
    classes : int or None
        Number of symmetry classes of the period.
    births : int or None
        Number of births at a > 0.
    deaths, always : int or None
        Numbers of classes that die at least once, and of those that are orbits from a = 0 on.
    least, largest : float or None
        The smallest and the largest a at which a class is born.
    """

    p: int
    state: str
    words: int
    seconds: float
    classes: int | None
    births: int | None
    deaths: int | None
    always: int | None
    least: float | None
    largest: float | None

    @property
    def whole(self) -> bool:
        """Whether the births and deaths of all classes of the period are stored."""
        return self.state == DONE


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


def read_birth_fills(connection: sa.Connection) -> list[BirthFill]:
    """Return how far births and deaths are stored, in order of period."""
    names = [column.name for column in fields(BirthFill)]
    query = sa.select(*(birth_fill.c[name] for name in names)).order_by(birth_fill.c.p)
    return [BirthFill(*row) for row in connection.execute(query)]


def read_lives(connection: sa.Connection, p: int) -> list[Life]:
    """Return the lives of all classes of a period, in order of birth."""
    names = [column.name for column in fields(Life)]
    of_period = life.c.cycle.between(*keys_of_period(p))
    query = sa.select(*(life.c[name] for name in names)).where(of_period).order_by(life.c.born, life.c.word)
    return [Life(*row) for row in connection.execute(query)]


class Standing(IntEnum):
    """The status of a word at a given a, as far as births and deaths decide it.

    A word that is no longer an orbit can become an orbit again at a larger a.
    """

    ORBIT = 0
    NOT_YET = 1
    NO_LONGER = 2
    BOUNDARY = 3
    UNRESOLVED = 4
    GEOMETRIC = 5
    UNKNOWN = 6

    @property
    def words(self) -> str:
        """The standing in plain words, such as ``not yet``."""
        return self.name.lower().replace("_", " ")


NEAR = 2.0
"""Within this many error bounds of a birth or death, births and deaths do not decide the status of a word."""

_ROW = np.dtype([("cycle", "i8"), ("a", "f8"), ("error", "f8"), ("born", "i8")])

_SOLVED = {
    Status.ORBIT: Standing.ORBIT,
    Status.BOUNDARY: Standing.BOUNDARY,
    Status.UNRESOLVED: Standing.UNRESOLVED,
}


@dataclass(frozen=True, eq=False)
class Standings:
    """The births and deaths of the classes of a subset.

    Attributes
    ----------
    cycles : ndarray of int64, shape (C,)
        Ids of the classes with stored births, in ascending order.
    starts : ndarray of intp, shape (C,)
        Index of the first birth or death of each class.
    a, error : ndarray, shape (K,)
        Values of a at births and deaths, sorted by class and then by a, and the bounds on their errors.
    born : ndarray of bool, shape (K,)
        Whether each is a birth.
    places : ndarray of intp, shape (N,)
        Index in `cycles` of each class of the subset; C if no births of the class are stored, and C + 1 for
        a geometrically pruned word, which is never an orbit.
    """

    cycles: Integers
    starts: Places
    a: Floats
    error: Floats
    born: Marks
    places: Places

    @property
    def known(self) -> Marks:
        """Whether the births of each class are stored, shape (N,)."""
        return self.places < len(self.cycles)

    def at(self, a: float) -> NDArray[np.uint8]:
        """Return the `Standing` of each class at a given a, shape (N,)."""
        return np.append(self._of_classes(a), [Standing.UNKNOWN, Standing.GEOMETRIC]).astype(np.uint8)[
            self.places
        ]

    def _of_classes(self, a: float) -> NDArray[np.uint8]:
        if not len(self.cycles):
            return np.zeros(0, np.uint8)
        past = self.a < a
        births, deaths = (
            np.add.reduceat(past & kind, self.starts, dtype=int) for kind in (self.born, ~self.born)
        )
        gone = np.where(births == 0, Standing.NOT_YET, Standing.NO_LONGER)
        standings = np.where(births > deaths, Standing.ORBIT, gone).astype(np.uint8)
        near = np.logical_or.reduceat(np.abs(self.a - a) <= NEAR * self.error, self.starts)
        words = {place: word_of(int(self.cycles[place])) for place in np.flatnonzero(near).tolist()}
        for _, group in groupby(words, key=lambda place: len(words[place])):
            members = list(group)
            statuses = _solved([words[place] for place in members], a)
            standings[members] = [
                _SOLVED.get(status, gone[place]) for status, place in zip(statuses, members, strict=True)
            ]
        return standings


def _solved(words: Sequence[str], a: float) -> list[Status]:
    """Solve words of the same period at an a within the error of a birth or death of each."""
    from orbitdb.orbits.newton import solve  # seldom needed

    return [Status(status) for status in solve(from_strings(words), Stadium(a)).status.tolist()]


def sums(standing: NDArray[np.uint8], counts: NDArray[np.integer]) -> list[int]:
    """Return the number of words with each `Standing`, given the standings and sizes of the classes."""
    return np.bincount(standing, counts, len(Standing)).astype(np.int64).tolist()


def load_standings(connection: sa.Connection, ids: Integers, *where: sa.ColumnElement[bool]) -> Standings:
    """Read the births and deaths of the classes with the given ids, if they meet the conditions."""
    columns = (change.c.cycle, change.c.a, change.c.error, change.c.kind == BORN)
    query = sa.select(*columns).where(*where).order_by(change.c.cycle, change.c.number)
    rows = cast(sqlite3.Cursor, connection.execute(query).cursor)
    changes = np.fromiter(rows, _ROW)  # a list of all tuples would take four times the memory
    changes = changes[np.isin(changes["cycle"], ids)]
    cycles, starts = np.unique(changes["cycle"], return_index=True)
    places = np.searchsorted(cycles, ids)
    born = np.append(cycles, 0)[places] == ids
    places = np.where(ids < 0, len(cycles) + 1, np.where(born, places, len(cycles)))
    return Standings(
        cycles, starts, changes["a"].copy(), changes["error"].copy(), changes["born"].astype(bool), places
    )


def counts_at(connection: sa.Connection, a: float, p: int) -> "Tally":
    """Count the orbits of a period at a given a; the births of the period must be complete."""
    from orbitdb.orbits.exponents import Tally

    of_period = change.c.cycle.between(*keys_of_period(p))
    query = sa.select(cycle.c.id, cycle.c.class_size).join_from(change, cycle)
    rows = connection.execute(query.where(of_period, change.c.number == 1)).cursor.fetchall()
    ids, sizes = np.array(rows, np.int64).reshape(-1, 2).T
    standing = load_standings(connection, ids, of_period).at(a)
    classes, words = int((standing == Standing.ORBIT).sum()), sums(standing, sizes)
    orbits, boundary, unresolved = (words[status] for status in _SOLVED.values())
    return Tally(count_admissible(p), orbits, classes, boundary, unresolved)
