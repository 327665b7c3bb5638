"""Lengths, exponents and counts of many orbits without coordinates, for sums over whole periods.

The statuses are proved as in `orbitdb.orbits.newton.solve_admissible`. Most words without an orbit are
decided after one step of Newton's method, and dropped there.
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
"""Words at a time, which bounds the memory; more are no faster."""


@dataclass(frozen=True, eq=False)
class Exponents(ByValue):
    """Words with one number of runs: their statuses, and the numbers of the orbits."""

    orbits: Places  # their places among the given words
    boundary: Places  # those of words through a joint
    unresolved: Places  # and of undecided ones; all others are dynamical
    length: Floats  # of the orbits, shape (N,)
    lyapunov: Floats
    legs: Chain  # their runs and legs
    slopes: Derivatives  # the derivatives of their lengths

    def of_orbits(self, chosen: Places) -> "Exponents":
        """Return them with some of the orbits alone."""
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

    Yields some of the words at a time, until all are done.
    """
    a = stadium.a
    for rows, legs in cut(unpack(codes, p)):
        for start in range(0, len(rows), _BATCH):
            here = np.arange(start, min(start + _BATCH, len(rows)))
            part = legs.chain(here)
            alpha, limits = centre_directions(part, a), direction_limits(part, a)
            alpha = np.clip(alpha + newton_step(part, a, alpha, limits), *limits)  # rounding may lead beyond
            left = np.flatnonzero(decide(part, a, alpha).status != Status.DYNAMICAL)
            if len(left):
                own = rows[here[left]]
                yield _decided(codes[own], p, own, part.chain(left), stadium, alpha.take(left, axis=1))


def _decided(
    codes: Integers, p: int, rows: Places, legs: Chain, stadium: Stadium, start: Floats
) -> Exponents:
    """Solve some words from nearby directions, and prove their statuses."""
    a = stadium.a
    alpha = newton(legs, a, start=start).alpha
    verdict = decide(legs, a, alpha)
    slopes, status = verdict.slopes, verdict.status
    lengths, exponents_ = length(legs, a, alpha), exponent(slopes)
    left = np.flatnonzero(status == Status.UNRESOLVED)
    if len(left):
        found = solve_in_balls(unpack(codes[left], p), stadium)
        status[left], lengths[left], exponents_[left] = found.status, found.length, found.lyapunov
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
    """Numbers of words by status."""

    words: int = 0  # all admissible words
    n_c: int = 0  # orbits
    classes: int = 0  # symmetry classes of the orbits
    boundary: int = 0  # words through a joint
    unresolved: int = 0  # undecided words; all others are dynamical

    @classmethod
    def of(cls, sizes: Integers, found: Iterable[Exponents]) -> "Tally":
        """Count over classes of some sizes."""
        counts = np.zeros(4, np.int64)
        for part in found:
            orbits, *others = (sizes[each].sum() for each in (part.orbits, part.boundary, part.unresolved))
            counts += orbits, len(part.orbits), *others
        return cls(int(sizes.sum()), *counts.tolist())
