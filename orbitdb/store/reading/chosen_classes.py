"""A chosen subset as symmetry classes, for averages over orbits: no word and no coordinate is read."""

from dataclasses import dataclass, replace

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.averages.fixed_points import ClassRows
from orbitdb.equality import ByValue
from orbitdb.orbits.orbit import Status
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.file.schema import catalogue as view
from orbitdb.store.file.schema import sequence
from orbitdb.store.reading.class_view import class_view, same_for_classes
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.soundness import unsound

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_MEASURED = (Status.ORBIT, Status.BOUNDARY)
"""The statuses whose sequences have a length and lambda."""

_IMPOSSIBLE = 1e15
"""A thousand times the length of an orbit of a million bounces at the largest a."""

_ROW = np.dtype("i8,i8,i8,f8,f8,i8,i8")
"""The fields of `ChosenClasses`."""


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
    number : ndarray of int, shape (N,)
        The class's number, which says its least word (`orbitdb.symbols.words.key`) if that is short.
    """

    p: Integers
    class_size: Integers
    chosen: Integers
    length: Floats
    lyapunov: Floats
    walls: Integers
    number: Integers

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


def read_classes(reader: Reader, selection: Selection) -> ChosenClasses:
    """Return the chosen classes that have a length and lambda (`Catalogue.classes`)."""
    if without := [status for status in selection.statuses if status not in _MEASURED]:
        raise SelectionError(
            f"averages and lengths are of orbits (and boundary): status {', '.join(without)} has none"
        )
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
    lyapunov = sa.func.coalesce(source.lyapunov, 0)  # none is as wrong as 0
    numbers = (source.length, lyapunov, source.walls, source.cycle)
    query = query.add_columns(source.p, source.class_size, chosen, *numbers)
    with reader.selecting(selection, source) as (connection, conditions):
        rows = connection.execute(query.where(*conditions, source.length.is_not(None))).cursor
        found = np.fromiter(iter(rows.fetchone, None), _ROW)  # all tuples at once take four times the room
    columns = [found[name].copy() for name in _ROW.names or ()]
    *positive, walls, _ = columns
    if not all((values > 1 / _IMPOSSIBLE).all() for values in positive) or not all(
        (abs(values) < _IMPOSSIBLE).all() for values in (*positive, walls)
    ):
        raise unsound("impossible numbers among", selection.describe())
    return ChosenClasses(*columns)


def _words_containing(selection: Selection) -> sa.Subquery:
    """Return how many words of each class contain the selection's factor, where any does."""
    twice = sequence.c.word.op("||")(sequence.c.word)
    query = sa.select(sequence.c.cycle, sa.func.count().label("chosen"))
    query = query.where(sa.func.instr(twice, selection.contains) > 0).group_by(sequence.c.cycle)
    if selection.periods:
        query = query.where(sa.or_(*(sequence.c.p.between(*ends) for ends in selection.periods)))
    return query.subquery("counts")
