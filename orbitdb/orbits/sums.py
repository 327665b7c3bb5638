"""Lengths and exponents of many orbits, and no coordinates: what sums over whole periods need.

The statuses are proved as those of `orbitdb.orbits.newton.solve_admissible`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import (
    Chain,
    Derivatives,
    Legs,
    cut,
    length,
)
from orbitdb.billiard.stability import exponent
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.newton import newton
from orbitdb.orbits.orbit import Status
from orbitdb.orbits.status import decide
from orbitdb.symbols.words import unpack

Floats = NDArray[np.float64]

_BATCH = 1 << 12
"""Words at a time: their legs stay in the processor's cache."""


@dataclass(frozen=True, eq=False)
class Exponents(ByValue):
    """Words of one number of runs: what has become of them, and the numbers of the orbits among them.

    Attributes
    ----------
    orbits, boundary, unresolved : ndarray of intp
        Their places among all words that were given; all others are dynamical.
    length, lyapunov : ndarray, shape (N,)
        Of the orbits.
    legs : Chain
        The runs and legs of the orbits.
    slopes : Derivatives
        The derivatives of their lengths.
    """

    orbits: NDArray[np.intp]
    boundary: NDArray[np.intp]
    unresolved: NDArray[np.intp]
    length: Floats
    lyapunov: Floats
    legs: Chain
    slopes: Derivatives

    def of_orbits(self, chosen: NDArray[np.intp]) -> "Exponents":
        """Return them with some of the orbits alone."""
        return replace(
            self,
            orbits=self.orbits[chosen],
            length=self.length[chosen],
            lyapunov=self.lyapunov[chosen],
            legs=self.legs.chain(chosen),
            slopes=self.slopes.rows(chosen),
        )


def exponents(codes: NDArray[np.int64], p: int, stadium: Stadium) -> Iterator[Exponents]:
    """Find the orbits among packed admissible words of order p <= 20, and their exponents.

    Parameters
    ----------
    codes : ndarray of int64, shape (N,)
    p : int
    stadium : Stadium

    Yields
    ------
    Exponents
        Of some of the words at a time, in the end of all.
    """
    for rows, legs in cut(unpack(codes, p)):
        for start in range(0, len(rows), _BATCH):
            here = slice(start, start + _BATCH)
            yield _decided(codes[rows[here]], p, rows[here], legs.rows(here), stadium)


def _decided(
    codes: NDArray[np.int64], p: int, rows: NDArray[np.intp], legs: Legs, stadium: Stadium
) -> Exponents:
    """Solve some words, and prove what becomes of them."""
    a = stadium.a
    alpha = newton(legs, a).alpha
    verdict = decide(legs, a, alpha)
    slopes, status = verdict.slopes, verdict.status
    lengths, exponents_ = length(legs, a, alpha), exponent(slopes)
    for place in np.flatnonzero(status == Status.UNRESOLVED):
        from orbitdb.orbits.balls.enclosure import as_orbits, enclose  # 30 ms to load, and seldom needed

        word = unpack(codes[place : place + 1], p)[0]
        found = as_orbits(word, stadium, enclose(word, stadium))
        status[place], lengths[place], exponents_[place] = found.status[0], found.length[0], found.lyapunov[0]
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
