"""Lengths and exponents of many orbits, without coordinates, for averages, sweeps and spectra.

`OrbitClasses` holds symmetry classes as arrays; `exponents` finds the orbits among all words of a period.

The statuses are proved as in `orbitdb.orbits.admissible.solve_admissible`. Most words that are not orbits are
recognised, and dropped, after a single step of Newton's method.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Integers, Marks
from orbitdb.billiard.legs import Chain, centre_directions, cut, direction_limits, length
from orbitdb.billiard.stability import exponent
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import data_frame
from orbitdb.orbits.admissible import solve_in_balls
from orbitdb.orbits.newton import newton, newton_step
from orbitdb.orbits.status import Status, decide
from orbitdb.symbols.words import unpack
from orbitdb.text import several

if TYPE_CHECKING:
    import pandas

_BATCH = 1 << 13
"""Number of words solved at a time, which limits the memory; larger batches are no faster."""


@dataclass(frozen=True, eq=False)
class ClassifiedBatch:
    """Statuses of words with the same number of runs, with the lengths and exponents of the orbits."""

    orbits: Indices  # indices of the orbits among the given words
    boundary: Indices  # indices of the words through a joint
    unresolved: Indices  # indices of the undecided words; all other words are dynamical
    length: Floats  # of the orbits, shape (N,)
    lyapunov: Floats
    legs: Chain  # the runs and legs of the orbits

    def of_orbits(self, chosen: Indices) -> "ClassifiedBatch":
        """Return the same statuses and numbers with only the chosen orbits."""
        return replace(
            self,
            orbits=self.orbits[chosen],
            length=self.length[chosen],
            lyapunov=self.lyapunov[chosen],
            legs=self.legs.chain(chosen),
        )


def exponents(codes: Integers, p: int, stadium: Stadium) -> Iterator[ClassifiedBatch]:
    """Find the orbits among packed admissible words, shape (N,), of period p <= 20, and their exponents.

    Yields the results for a few thousand words at a time.
    """
    a = stadium.a
    for rows, legs in cut(unpack(codes, p)):
        for start in range(0, len(rows), _BATCH):
            batch = np.arange(start, min(start + _BATCH, len(rows)))
            part = legs.chain(batch)
            alpha, limits = centre_directions(part, a), direction_limits(part, a)
            alpha = np.clip(alpha + newton_step(part, a, alpha, limits), *limits)  # rounding may exceed them
            left = np.flatnonzero(decide(part, a, alpha).status != Status.DYNAMICAL)
            if len(left):
                own = rows[batch[left]]
                yield _decided(codes[own], p, own, part.chain(left), stadium, alpha.take(left, axis=1))


def _decided(
    codes: Integers, p: int, rows: Indices, legs: Chain, stadium: Stadium, start: Floats
) -> ClassifiedBatch:
    """Solve words from directions close to their maxima, and prove their statuses."""
    a = stadium.a
    alpha = newton(legs, a, start=start).alpha
    decided = decide(legs, a, alpha)
    status = decided.status
    lengths, exponents_ = length(legs, a, alpha), exponent(decided.slopes)
    left = np.flatnonzero(status == Status.UNRESOLVED)
    if len(left):
        enclosed = solve_in_balls(unpack(codes[left], p), stadium)
        status[left], lengths[left], exponents_[left] = enclosed.status, enclosed.length, enclosed.lyapunov
    orbits = np.flatnonzero(status == Status.ORBIT)
    return ClassifiedBatch(
        rows[orbits],
        rows[status == Status.BOUNDARY],
        rows[status == Status.UNRESOLVED],
        lengths[orbits],
        exponents_[orbits],
        legs.chain(orbits),
    )


@dataclass(frozen=True)
class Tally:
    """Numbers of words with each status."""

    words: int = 0  # all admissible words
    n_c: int = 0  # orbits
    classes: int = 0  # symmetry classes of the orbits
    boundary: int = 0  # words through a joint
    unresolved: int = 0  # undecided words; all other words are dynamical

    @classmethod
    def of(cls, sizes: Integers, parts: Iterable[ClassifiedBatch]) -> "Tally":
        """Count the words of classes of the given sizes, from the results for one word of each class."""
        counts = np.zeros(4, np.int64)
        for part in parts:
            orbits, *others = (sizes[of].sum() for of in (part.orbits, part.boundary, part.unresolved))
            counts += orbits, len(part.orbits), *others
        return cls(int(sizes.sum()), *counts.tolist())


_LEAST = 1e-100
"""No length and no lambda of an orbit is as small, nor as large as its inverse."""


@dataclass(frozen=True, eq=False, repr=False)
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
    symmetry, representative : ndarray of str or object, shape (N,), or None
        Symmetry labels (`orbitdb.symbols.symmetry.STABILISER_OF`), and least words.
    joints : ndarray of int, shape (N,), or None
        Number of bounces exactly at a joint of wall and semicircle; 0 for all if None.

    Raises
    ------
    ValueError
        If the arrays differ in length, or if a period, number of words, length or lambda is not between
        1e-100 and 1e100, so that sums over them might overflow.
    """

    p: Integers
    words: Integers
    length: Floats
    lyapunov: Floats
    walls: Integers
    class_size: Integers | None = None
    number: Integers | None = None
    symmetry: NDArray[Any] | None = None
    representative: NDArray[Any] | None = None
    joints: Integers | None = None

    def __post_init__(self) -> None:
        columns: tuple[NDArray[Any], ...] = (self.p, self.words, self.length, self.lyapunov, self.walls)
        if len({column.shape for column in columns}) != 1 or self.p.ndim != 1:
            raise ValueError("the columns of classes must be vectors of the same length")
        if not all(((column > _LEAST) & (column < 1 / _LEAST)).all() for column in columns[:4]):
            raise ValueError("classes need a positive period, number of words, length and lambda")

    def __len__(self) -> int:
        return len(self.p)

    def __repr__(self) -> str:
        return f"<{several(len(self), 'class', 'classes')} of {several(int(self.words.sum()), 'orbit')}>"

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a data frame with one row per class (extra ``pandas``)."""
        return data_frame({name: values for name, values in vars(self).items() if values is not None})

    @property
    def maslov(self) -> Integers:
        """Maslov indices of one traversal, shape (N,)."""
        return 3 * self.p - self.walls

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
