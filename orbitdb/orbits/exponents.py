"""Lengths, exponents and counts of many orbits, without coordinates, for sums over entire periods.

The statuses are proved as in `orbitdb.orbits.newton.solve_admissible`. Most words that are not orbits are
recognised, and dropped, after a single step of Newton's method.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from orbitdb.arrays import Floats, Integers, Places
from orbitdb.billiard.legs import Chain, Derivatives, centre_directions, cut, direction_limits, length
from orbitdb.billiard.stability import exponent
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.newton import newton, newton_step, solve_in_balls
from orbitdb.orbits.status import Status, decide
from orbitdb.symbols.words import unpack

_BATCH = 1 << 13
"""Number of words solved at a time, which limits the memory; larger batches are no faster."""


@dataclass(frozen=True, eq=False)
class Exponents(ByValue):
    """Statuses of words with the same number of runs, with the lengths and exponents of the orbits."""

    orbits: Places  # indices of the orbits among the given words
    boundary: Places  # indices of the words through a joint
    unresolved: Places  # indices of the undecided words; all other words are dynamical
    length: Floats  # of the orbits, shape (N,)
    lyapunov: Floats
    legs: Chain  # the runs and legs of the orbits
    slopes: Derivatives  # the derivatives of the lengths of the orbits

    def of_orbits(self, chosen: Places) -> "Exponents":
        """Return the same statuses and numbers with only the chosen orbits."""
        return replace(
            self,
            orbits=self.orbits[chosen],
            length=self.length[chosen],
            lyapunov=self.lyapunov[chosen],
            legs=self.legs.chain(chosen),
            slopes=self.slopes.rows(chosen),
        )


def exponents(codes: Integers, p: int, stadium: Stadium) -> Iterator[Exponents]:
    """Find the orbits among packed admissible words, shape (N,), of period p <= 20, and their exponents.

    Yields the results for a few thousand words at a time.
    """
    a = stadium.a
    for rows, legs in cut(unpack(codes, p)):
        for start in range(0, len(rows), _BATCH):
            here = np.arange(start, min(start + _BATCH, len(rows)))
            part = legs.chain(here)
            alpha, limits = centre_directions(part, a), direction_limits(part, a)
            alpha = np.clip(alpha + newton_step(part, a, alpha, limits), *limits)  # rounding may exceed them
            left = np.flatnonzero(decide(part, a, alpha).status != Status.DYNAMICAL)
            if len(left):
                own = rows[here[left]]
                yield _decided(codes[own], p, own, part.chain(left), stadium, alpha.take(left, axis=1))


def _decided(
    codes: Integers, p: int, rows: Places, legs: Chain, stadium: Stadium, start: Floats
) -> Exponents:
    """Solve words from directions close to their maxima, and prove their statuses."""
    a = stadium.a
    alpha = newton(legs, a, start=start).alpha
    verdict = decide(legs, a, alpha)
    slopes, status = verdict.slopes, verdict.status
    lengths, exponents_ = length(legs, a, alpha), exponent(slopes)
    left = np.flatnonzero(status == Status.UNRESOLVED)
    if len(left):
        enclosed = solve_in_balls(unpack(codes[left], p), stadium)
        status[left], lengths[left], exponents_[left] = enclosed.status, enclosed.length, enclosed.lyapunov
    orbits = np.flatnonzero(status == Status.ORBIT)
    return Exponents(
        rows[orbits],
        rows[status == Status.BOUNDARY],
        rows[status == Status.UNRESOLVED],
        lengths[orbits],
        exponents_[orbits],
        legs.chain(orbits),
        slopes.rows(orbits),
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
    def of(cls, sizes: Integers, parts: Iterable[Exponents]) -> "Tally":
        """Count the words of classes of the given sizes, from the results for one word of each class."""
        counts = np.zeros(4, np.int64)
        for part in parts:
            orbits, *others = (sizes[each].sum() for each in (part.orbits, part.boundary, part.unresolved))
            counts += orbits, len(part.orbits), *others
        return cls(int(sizes.sum()), *counts.tolist())
