"""Lives, the ranges of a in which stored classes are orbits, and the counts of orbits at any a."""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.extras import Record
from orbitdb.orbits.status import Status
from orbitdb.store.connection import Connection
from orbitdb.store.schema import BORN, DIED, DONE
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


def read_birth_fills(connection: Connection) -> list[BirthFill]:
    """Return how far births and deaths are stored, in order of period."""
    names = ", ".join(column.name for column in fields(BirthFill))
    return [BirthFill(*row) for row in connection.execute(f"SELECT {names} FROM birth_fill ORDER BY p")]


def read_lives(connection: Connection, p: int) -> list[Life]:
    """Return the lives of all classes of a period, in order of birth."""
    names = ", ".join(column.name for column in fields(Life))
    query = f"SELECT {names} FROM life WHERE cycle BETWEEN ? AND ? ORDER BY born, word"
    return [Life(*row) for row in connection.execute(query, keys_of_period(p))]


NEAR = 2.0
"""Within this many error bounds of a birth or death, births and deaths do not decide the status of a word."""

_ROW = np.dtype([("cycle", "i8"), ("size", "i8"), ("a", "f8"), ("error", "f8"), ("born", "i8")])


_COUNTS = """\
SELECT sum(iif(number = 1, class_size, 0)) AS words,
       count(DISTINCT cycle) AS classes,
       count(iif(kind = :born AND a > 0, 1, NULL)) AS births,
       count(DISTINCT iif(kind = :died AND a > 0, cycle, NULL)) AS deaths,
       count(iif(a = 0, 1, NULL)) AS always,
       min(iif(kind = :born AND a > 0, a, NULL)) AS least,
       max(iif(kind = :born AND a > 0, a, NULL)) AS largest
FROM change JOIN cycle ON cycle.id = change.cycle WHERE p = :p"""


def count_births(connection: Connection, p: int) -> dict[str, Any]:
    """Count what the row of a period in `birth_fill` counts, from the births and deaths of the period."""
    (counts,) = connection.records(_COUNTS, {"p": p, "born": BORN, "died": DIED})
    return counts


def counts_at(connection: Connection, a: float, p: int) -> "Tally":
    """Count the orbits of a period at a given a; the births of the period must be complete.

    A class within the error of a birth or death is solved at this a, in ball arithmetic if necessary, so that
    orbits through a joint are recognised as they are in a fill.
    """
    from orbitdb.orbits.exponents import Tally

    query = """SELECT cycle.id, cycle.class_size, change.a, change.error, change.kind = ?
        FROM change JOIN cycle ON cycle.id = change.cycle
        WHERE change.cycle BETWEEN ? AND ? ORDER BY change.cycle, change.number"""
    rows = connection.execute(query, (BORN, *keys_of_period(p)))
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
