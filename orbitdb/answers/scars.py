"""Scars: how strongly the waves of levels concentrate along orbits."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import Status
from orbitdb.quantum.waves import waves
from orbitdb.quantum.weyl import Parity, wavenumber, weyl
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

SHORTEST = 20
"""Number of classes, those with the shortest orbits, to try if no word is given."""
STRONGEST = 5
"""Number of orbits to report for each level."""
NEIGHBOURS = 15
"""Number of levels of the same parity, on each side of a level, to compare its strength with."""
_ENOUGH = 5
"""Smallest number of neighbours for a mean."""
_ROUNDING = 1e-9
"""Smaller standard deviations are rounding errors, for example on an axis where all waves are 0."""


class Scar(NamedTuple):
    """How strongly an orbit scars a level.

    Attributes
    ----------
    k : float
        The level, in 1/radius.
    parity : Parity
    code : str
        Word of the orbit.
    strength : float
        Mean of psi^2 along the orbit, times the area; on average 1, or 2 or 0 for an orbit on an axis.
    above : float or None
        Strength minus its mean over up to `NEIGHBOURS` levels of the same parity on each side, in units of
        their standard deviation; None if there are fewer than five, or if all have the same strength.
    """

    k: float
    parity: Parity
    code: str
    strength: float
    above: float | None


def scars_of(orbit: Orbit, low: float, high: float, parities: Iterable[Parity]) -> list[Scar]:
    """Return the scars of one orbit at all levels in a range of k, the strongest first."""
    found = [scar for each in parities for (scar,) in _scars([orbit], low, high, each)]
    return sorted(found, key=lambda scar: -scar.strength)


def scars_of_shortest(
    moment: Moment, a: float, low: float, high: float, parities: Iterable[Parity]
) -> list[Scar]:
    """Return the strongest scars of short stored orbits at each level in a range of k, sorted by k."""
    orbits = _shortest(moment, a)
    found: list[Scar] = []
    for parity in parities:
        for scars in _scars(orbits, low, high, parity):
            found += sorted(scars, key=lambda scar: -scar.strength)[:STRONGEST]
    return sorted(found, key=lambda scar: (scar.k, -scar.strength))


def _scars(orbits: Sequence[Orbit], low: float, high: float, parity: Parity) -> Iterator[list[Scar]]:
    """Yield the scars at each level of one parity in a range of k; neighbours may lie outside the range."""
    stadium = Stadium(orbits[0].a)
    smooth = weyl(stadium, parity)
    first = min(low, wavenumber(smooth, smooth(low) - NEIGHBOURS))
    last = max(high, wavenumber(smooth, smooth(high) + NEIGHBOURS))
    known = [(wave.k, wave.strengths(orbits)) for wave in waves(stadium, first, last, parity)]
    for n, (k, strength) in enumerate(known):
        if low <= k < high:
            others = [
                other for _, other in known[max(n - NEIGHBOURS, 0) : n] + known[n + 1 : n + 1 + NEIGHBOURS]
            ]
            yield [
                Scar(k, parity, orbit.code, float(own), _above(own, np.array(of_others)))
                for orbit, own, of_others in zip(orbits, strength, np.array(others).T, strict=True)
            ]


def _above(own: float, others: Floats) -> float | None:
    """Return how far a strength is above the mean of others, in units of their standard deviation."""
    spread = float(others.std()) if len(others) >= _ENOUGH else 0.0
    return float(own - others.mean()) / spread if spread > _ROUNDING else None


def _shortest(moment: Moment, a: float) -> list[Orbit]:
    """Return the shortest stored orbits, one of each class."""
    chosen = replace(Selection(a), statuses=(Status.ORBIT,), where="code = representative")
    rows = moment.rows(moment.choose(chosen, "length", most=SHORTEST), ("code",), 0, SHORTEST)
    words = [word for (word,) in rows]
    found = [orbit for word in words if (orbit := moment.find(word, a)) is not None]
    if not found:
        raise InputError(f"no orbits at a = {exact(a)}: 'orbitdb fill --p 11 --a {exact(a)}' finds some")
    return found
