"""A chosen subset as symmetry classes, for averages over orbits: no word and no coordinate is read."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.equality import ByValue
from orbitdb.fixed_points import ClassRows
from orbitdb.orbits import NUMBERS
from orbitdb.selection import Selection
from orbitdb.store import where as free
from orbitdb.store.rows import unsound
from orbitdb.store.schema import catalogue as view
from orbitdb.store.schema import cycle, orbit, sequence, stadium

if TYPE_CHECKING:
    from orbitdb.store.catalogue import Catalogue

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_IMPOSSIBLE = 1e15
"""A thousand times the length of an orbit of a million bounces at the largest a."""


@dataclass(frozen=True, eq=False)
class ChosenClasses(ByValue):
    """The symmetry classes that have chosen words, one entry each, for averages over orbits.

    Attributes
    ----------
    p, class_size : ndarray of int, shape (N,)
        Period, and number of words in the class.
    chosen : ndarray of int, shape (N,)
        How many of these words are in the subset.
    length, lyapunov : ndarray, shape (N,)
        Of one traversal, the length in units of the radius.
    walls : ndarray of int, shape (N,)
        Number of straight bounces; the eigenvalues of M are negative where it is odd.
    """

    p: Integers
    class_size: Integers
    chosen: Integers
    length: Floats
    lyapunov: Floats
    walls: Integers

    def __len__(self) -> int:
        return len(self.p)

    def rows(self) -> ClassRows:
        """Return them as the averages want them, each class with the number of its chosen words."""
        return ClassRows(self.p, self.chosen, self.length, self.lyapunov, self.inverse)

    @property
    def inverse(self) -> NDArray[np.bool_]:
        """Whether the eigenvalues of M are negative."""
        odd: NDArray[np.bool_] = self.walls % 2 == 1
        return odd


def class_view() -> sa.Subquery:
    """Return the columns of the view that all words of a class share, one row a stadium and class."""
    return (
        sa.select(
            stadium.c.a,
            cycle.c.id.label("cycle"),
            cycle.c.p,
            cycle.c.word.label("representative"),
            *(cycle.c[name] for name in ("class_size", "walls", "time_reversal", "symmetry")),
            orbit.c.status,
            *(orbit.c[name] for name in (*NUMBERS, "iterations", "solver")),
            (orbit.c.lyapunov / cycle.c.p).label("lambda_d"),
            (orbit.c.lyapunov / orbit.c.length).label("lambda_c"),
            orbit.c.coordinates,
        )
        .join_from(orbit, cycle, cycle.c.id == orbit.c.cycle)
        .join(stadium, stadium.c.id == orbit.c.stadium)
        .subquery("catalogue")
    )


def read_classes(catalogue: "Catalogue", selection: Selection) -> ChosenClasses:
    """Return the chosen classes that have a length and lambda (`Catalogue.classes`)."""
    if same_for_classes(selection):
        classes = class_view()
        source, chosen, query = classes.c, classes.c.class_size, sa.select().select_from(classes)
        if selection.contains is not None:
            counts = _words_containing(selection)
            chosen, query = counts.c.chosen, query.join(counts, counts.c.cycle == classes.c.cycle)
            selection = replace(selection, contains=None)
    else:
        source, chosen = view.c, sa.func.count().label("chosen")
        query = sa.select().select_from(view).group_by(view.c.cycle)
    names = ("p", "class_size", "walls", "length", "lyapunov")
    query = query.add_columns(chosen, *(source[name] for name in names))
    with catalogue.selecting(selection, source) as (connection, conditions):
        rows = connection.execute(query.where(*conditions, source.length.is_not(None))).cursor.fetchall()
    columns = np.array(rows, dtype=np.float64).reshape(-1, 1 + len(names)).T
    if not ((columns[[0, 1, 2, 4, 5]] > 1 / _IMPOSSIBLE).all() and (abs(columns) < _IMPOSSIBLE).all()):
        raise unsound("impossible numbers among", selection.describe())
    chosen_words, p, size, walls = columns[:4].astype(np.int64)
    return ChosenClasses(p, size, chosen_words, columns[4].copy(), columns[5].copy(), walls)


def same_for_classes(selection: Selection) -> bool:
    """Tell whether a subset takes all words of a class or none, but for those that contain a factor."""
    if selection.where is None:
        return True
    shared = set(class_view().c.keys()) & set(view.c.keys()) - {"cycle"}
    parameters = dict(selection.parameters)
    free.check(selection.where, parameters)
    return free.same_for_class(selection.where, parameters, shared)


def _words_containing(selection: Selection) -> sa.Subquery:
    """Return how many words of each class contain the selection's factor, where any does."""
    twice = sequence.c.word.op("||")(sequence.c.word)
    query = sa.select(sequence.c.cycle, sa.func.count().label("chosen"))
    query = query.where(sa.func.instr(twice, selection.contains) > 0).group_by(sequence.c.cycle)
    if selection.periods:
        query = query.where(sa.or_(*(sequence.c.p.between(*ends) for ends in selection.periods)))
    return query.subquery("counts")
