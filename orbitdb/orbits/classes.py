"""`OrbitClasses`, symmetry classes of orbits as arrays, for averages, sweeps and spectra."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Integers, Marks
from orbitdb.equality import Batch


@dataclass(frozen=True, eq=False)
class OrbitClasses(Batch):
    """N symmetry classes of isolated orbits, with any periods and in any order.

    Attributes
    ----------
    p, words : ndarray of int, shape (N,)
        Period, and number of words of the class that count.
    length, lyapunov : ndarray, shape (N,)
        Length, in units of the radius, and lambda of one traversal.
    walls : ndarray of int, shape (N,)
        Number of straight bounces.
    class_size, number : ndarray of int, shape (N,), or None
        Number of all words in the class, and its id in a catalogue: the key of its representative
        (`orbitdb.symbols.words.key`), unless that is too long.

    Raises
    ------
    ValueError
        If the arrays differ in length, or if a period, number of words, length or lambda is not positive and
        finite.
    """

    p: Integers
    words: Integers
    length: Floats
    lyapunov: Floats
    walls: Integers
    class_size: Integers | None = None
    number: Integers | None = None

    def __post_init__(self) -> None:
        columns: tuple[NDArray[Any], ...] = (self.p, self.words, self.length, self.lyapunov, self.walls)
        if len({column.shape for column in columns}) != 1 or self.p.ndim != 1:
            raise ValueError("the columns of classes must be vectors of the same length")
        if not all((column > 0).all() and np.isfinite(column).all() for column in columns[:4]):
            raise ValueError("classes need a positive period, number of words, length and lambda")

    def __len__(self) -> int:
        return len(self.p)

    @property
    def negative(self) -> Marks:
        """Whether the eigenvalues of M are negative, because the number of straight bounces is odd."""
        return self.walls % 2 == 1

    def ranges(self) -> Floats:
        """Return the least (row 0) and the greatest (row 1) lambda / p, lambda / L and L / p, shape (2, 3).

        If there are no orbits, the rows are inf and -inf.
        """
        values = np.stack([self.lyapunov / self.p, self.lyapunov / self.length, self.length / self.p])
        return np.stack([values.min(axis=1, initial=np.inf), values.max(axis=1, initial=-np.inf)])

    def by_period(self) -> dict[int, "OrbitClasses"]:
        """Return the classes of each period, keyed by period; periods without classes are left out."""
        order = np.argsort(self.p, kind="stable")
        periods, starts = np.unique(self.p[order], return_index=True)
        parts = np.split(order, starts)[1:]
        return {int(p): self.rows(part) for p, part in zip(periods, parts, strict=True)}
