"""Which of the chosen words are orbits at any a, as the stored births and deaths of their classes tell."""

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.conditions import NEAR
from orbitdb.store.file.schema import BORN
from orbitdb.store.file.tables import change
from orbitdb.store.reading.chosen import Chosen
from orbitdb.store.reading.finding import periods_of
from orbitdb.store.reading.soundness import is_written, unsound
from orbitdb.symbols.words import from_strings, word_of

if TYPE_CHECKING:
    from orbitdb.store.reading.catalogue import Catalogue


class Standing(IntEnum):
    """What a word is at one a, as far as births tell.

    A word that is no longer an orbit may be one again at a greater a.
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
        """The standing as a table says it."""
        return self.name.lower().replace("_", " ")


_ROW = np.dtype([("cycle", "i8"), ("a", "f8"), ("error", "f8"), ("born", "i8")])

_SOLVED = {
    Status.ORBIT: Standing.ORBIT,
    Status.BOUNDARY: Standing.BOUNDARY,
    Status.UNRESOLVED: Standing.UNRESOLVED,
}


@dataclass(frozen=True, eq=False)
class Standings(ByValue):
    """The births and deaths of the classes of a subset.

    Attributes
    ----------
    cycles : ndarray of int64, shape (C,)
        The numbers of the classes of which births are stored, rising.
    starts : ndarray of intp, shape (C,)
        Where the changes of each class begin.
    a, error : ndarray, shape (K,)
        The changes, class by class by rising a, and the bounds on their errors.
    born : ndarray of bool, shape (K,)
        Whether it is a birth; else it is a death.
    places : ndarray of intp, shape (N,)
        For each class of a subset its place among the C; C where its births are not stored, C + 1 for a word
        that is pruned geometrically and never an orbit.
    """

    cycles: NDArray[np.int64]
    starts: NDArray[np.intp]
    a: NDArray[np.float64]
    error: NDArray[np.float64]
    born: NDArray[np.bool_]
    places: NDArray[np.intp]

    @property
    def known(self) -> NDArray[np.bool_]:
        """For each class whether its births are stored, shape (N,)."""
        return self.places < len(self.cycles)

    def at(self, a: float) -> NDArray[np.uint8]:
        """Return a `Standing` a class at one a, shape (N,).

        Where a is so near to a change that the change's error does not tell, the class is solved.
        """
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
        found = np.where(births > deaths, Standing.ORBIT, gone).astype(np.uint8)
        near = np.abs(self.a - a) <= NEAR * self.error
        for place in np.flatnonzero(np.logical_or.reduceat(near, self.starts)):
            found[place] = _solved(int(self.cycles[place]), a, Standing(gone[place]))
        return found


def _solved(cycle: int, a: float, gone: Standing) -> Standing:
    """Return what a class is that is at a change of its own, within the error of that."""
    from orbitdb.orbits.newton import solve  # seldom needed

    word = word_of(cycle)
    if not is_written(word, len(word)):
        raise unsound("a class with births", cycle)
    status = solve(from_strings([word]), Stadium(a)).status[0]
    return _SOLVED.get(Status(status), gone)


def sums(standing: NDArray[np.uint8], counts: NDArray[np.uint8]) -> list[int]:
    """Return how many words there are of each `Standing`: each class has one, and some words."""
    return np.bincount(standing, counts, len(Standing)).astype(np.int64).tolist()


def load_standings(catalogue: "Catalogue", chosen: Chosen) -> Standings:
    """Read the births and deaths of the classes of a subset."""
    columns = (change.c.cycle, change.c.a, change.c.error, change.c.kind == BORN)
    query = sa.select(*columns).order_by(change.c.cycle, change.c.number)
    with catalogue.reading() as connection:
        rows = connection.execute(query).cursor
        found = np.fromiter(iter(rows.fetchone, None), _ROW)  # all tuples at once take four times the room
    found = found[np.isin(found["cycle"], chosen.ids)]
    cycles, starts = np.unique(found["cycle"], return_index=True)
    places = np.searchsorted(cycles, chosen.ids)
    known = np.append(cycles, 0)[places] == chosen.ids
    pruned = chosen.ids < 0
    places = np.where(pruned, len(cycles) + 1, np.where(known, places, len(cycles)))
    return Standings(
        cycles, starts, found["a"].copy(), found["error"].copy(), found["born"].astype(bool), places
    )


def periods_without(catalogue: "Catalogue", chosen: Chosen, standings: Standings) -> list[int]:
    """Return the periods of the rows of which no births are stored."""
    lacking = chosen.ids[standings.places == len(standings.cycles)]
    return np.unique(periods_of(catalogue, lacking)).tolist()
