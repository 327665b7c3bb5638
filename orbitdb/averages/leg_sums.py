"""Sums along each orbit of the terms of lambda whose exact means are known.

They come from the directions of the legs, which Newton's method finds from the words in less time than
a database gives coordinates (`orbitdb.orbits.newton`).
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain, Derivatives, cut, derivatives, preceding
from orbitdb.equality import ByValue
from orbitdb.orbits.newton import newton

Floats = NDArray[np.float64]

_BLOCK = 1 << 15
"""Words at a time: it bounds the memory, and their arrays stay in the cache."""


@dataclass(frozen=True, eq=False)
class LegSums(ByValue):
    """Sums over the legs of N orbits; arrays of shape (N,).

    Attributes
    ----------
    legs : ndarray
        Number of legs, as floats.
    log_drift, log_kick : ndarray
        Sums of ln D and ln K.
    coupling : ndarray
        Sum of c2 = ln(1 + (1/D_before + 1/D_after)/K).
    """

    legs: Floats
    log_drift: Floats
    log_kick: Floats
    coupling: Floats

    def __len__(self) -> int:
        return len(self.legs)

    @classmethod
    def joined(cls, parts: "list[LegSums]") -> "LegSums":
        """Return several as one."""
        empty = [np.zeros(0)]
        columns = ([getattr(part, field.name) for part in parts] for field in fields(cls))
        return cls(*(np.concatenate(empty + column) for column in columns))


def leg_sums(words: NDArray[np.uint8], a: float) -> LegSums:
    """Return the sums of the orbits of words.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible words of one order, in any rotation.
    a : float
        Half the length of a straight wall.
    """
    sums = np.empty((4, len(words)))
    for start in range(0, len(words), _BLOCK):
        for rows, legs in cut(words[start : start + _BLOCK]):
            sums[:, start + rows] = _of_chains(legs, a)
    return LegSums(*sums)


def _of_chains(legs: Chain, a: float) -> Floats:
    """Return the sums of words of m runs, shape (4, N)."""
    return terms_of_legs(derivatives(legs, a, newton(legs, a).alpha))


def terms_of_legs(slopes: Derivatives) -> Floats:
    """Return the number of legs and the sums of ln D, ln K and c2 of words of m runs, shape (4, N)."""
    drift, kick = slopes.beyond, 1 / slopes.stiffness
    coupling = np.log1p((1 / drift + 1 / preceding(drift)) / kick)
    m = np.full(drift.shape[1], float(len(drift)))
    return np.stack([m, np.log(drift).sum(axis=0), np.log(kick).sum(axis=0), coupling.sum(axis=0)])
