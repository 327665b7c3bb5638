"""A chosen subset as symmetry classes, for averages over orbits, without words and coordinates."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb.averages.fixed_points import ClassRows
from orbitdb.equality import ByValue
from orbitdb.orbits.orbit import EXISTING
from orbitdb.store.asking.selection import Selection, SelectionError
from orbitdb.store.reading.soundness import unsound

if TYPE_CHECKING:
    from orbitdb.catalogue.catalogue import Catalogue

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
    number : ndarray of int, shape (N,)
        The class's id, which is the key of its least word (`orbitdb.symbols.words.key`) if that is short.
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


def read_classes(catalogue: "Catalogue", selection: Selection) -> ChosenClasses:
    """Return the chosen classes that have a length and lambda (`Catalogue.classes`)."""
    if without := [status for status in selection.statuses if status not in EXISTING]:
        raise SelectionError(
            f"averages and lengths are of orbits (and boundary): status {', '.join(without)} has none"
        )
    chosen = catalogue.choose(selection, columns=("p", "class_size", "length", "lyapunov", "walls"))
    found = dict(chosen.values)
    positive = [_sound(selection, found[name], least=True) for name in ("p", "class_size", "length")]
    lyapunov, walls = _sound(selection, found["lyapunov"], least=True), _sound(selection, found["walls"])
    p, size, length = positive
    return ChosenClasses(
        p.astype(np.int64), size.astype(np.int64), chosen.counts.astype(np.int64), length, lyapunov,
        walls.astype(np.int64), chosen.ids,
    )  # fmt: skip


def _sound(selection: Selection, values: NDArray[np.generic], least: bool = False) -> Floats:
    """Return numbers as they are, unless they are none that anything in a catalogue has."""
    try:
        numbers = values.astype(np.float64)
    except (TypeError, ValueError):
        numbers = np.full(len(values), np.nan)
    possible = (np.abs(numbers) < _IMPOSSIBLE) & (not least or numbers > 1 / _IMPOSSIBLE)
    if not possible.all():
        raise unsound("impossible numbers among", selection.describe())
    return numbers
