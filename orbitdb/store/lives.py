"""Lives, the ranges of a in which stored classes are orbits, and the counts of orbits at any a."""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np
from sqlalchemy import Connection, select

from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Record
from orbitdb.orbits.status import Status
from orbitdb.store import tables as t
from orbitdb.store.tables import BORN
from orbitdb.store.views import life
from orbitdb.symbols.pruning import count_admissible
from orbitdb.symbols.words import from_strings, keys_of_period, word_of

if TYPE_CHECKING:
    from orbitdb.orbits.exponents import Tally


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
