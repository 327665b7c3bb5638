"""Scars: how strongly orbits mark levels."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.status import Status
from orbitdb.quantum.amplitudes import Parity
from orbitdb.quantum.waves import Wave, waves
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

SHORTEST = 20
"""Number of shortest classes to try if no word is named."""
STRONGEST = 5
"""Number of them to report for each level."""
_ENOUGH = 5
"""Fewest levels of a parity for a mean."""
_ROUNDING = 1e-9
"""Smaller deviations are rounding, for example on an axis where all waves are 0."""


class Scar(NamedTuple):
    """How strongly an orbit scars a level.

    Attributes
    ----------
    k : float
        The level, in 1/radius.
    parity : Parity
    code : str
        The orbit.
    strength : float
        Mean of psi^2 along the orbit, times the area; 1 on average, 2 or 0 for an orbit on an axis.
    above : float or None
        Strength minus the mean over the levels of this parity in the range, in standard deviations; None
        for fewer than five levels, or if all have the same strength.
    """

    k: float
    parity: Parity
    code: str
    strength: float
    above: float | None


def scars_of(orbit: Orbit, low: float, high: float, parities: Iterable[Parity]) -> list[Scar]:
    """Return how strongly one orbit scars each level in a range of k, the strongest first."""
    found = [
        scar
        for parity in parities
        for (scar,) in _judged(_waves(orbit.a, low, high, parity), [orbit], parity)
    ]
    return sorted(found, key=lambda scar: -scar.strength)


def scars_of_shortest(
    moment: Moment, a: float, low: float, high: float, parities: Iterable[Parity]
) -> list[Scar]:
    """Return the short stored orbits that scar each level in a range of k most, by k."""
    stadium = Stadium(a)
    orbits = _shortest(moment, stadium.a)
    found: list[Scar] = []
    for parity in parities:
        for scars in _judged(_waves(stadium.a, low, high, parity), orbits, parity):
            found += sorted(scars, key=lambda scar: -scar.strength)[:STRONGEST]
    return sorted(found, key=lambda scar: (scar.k, -scar.strength))


def _waves(a: float, low: float, high: float, parity: Parity) -> list[Wave]:
    return list(waves(Stadium(a), low, high, parity))


def _judged(known: Sequence[Wave], orbits: Sequence[Orbit], parity: Parity) -> list[list[Scar]]:
    """Return the scars of each level of one parity."""
    if not known:
        return []
    strength = np.stack([wave.strengths(list(orbits)) for wave in known])
    spread = strength.std(axis=0)
    above = (strength - strength.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    told = (spread > _ROUNDING) & (len(known) >= _ENOUGH)
    return [
        [
            Scar(wave.k, parity, orbit.code, float(s), float(z) if known_mean else None)
            for orbit, s, z, known_mean in zip(orbits, row, far, told, strict=True)
        ]
        for wave, row, far in zip(known, strength, above, strict=True)
    ]


def _shortest(moment: Moment, a: float) -> list[Orbit]:
    """Return the shortest stored orbits, one from each class."""
    chosen = replace(Selection(a), statuses=(Status.ORBIT,), where="code = representative")
    words = [word for (word,) in moment.rows(chosen, ("code",), "length", SHORTEST)]
    found = [orbit for word in words if (orbit := moment.find(word, a)) is not None]
    if not found:
        raise InputError(f"no orbits at a = {exact(a)}: 'orbitdb fill --p 11 --a {exact(a)}' finds some")
    return found
