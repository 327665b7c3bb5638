"""Scars: how strongly the waves of levels concentrate along orbits."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from orbitdb.answers.completeness import no_orbits
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, check_number
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import solve_word
from orbitdb.orbits.status import Status
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.waves import scar_strengths
from orbitdb.quantum.weyl import Parity, wavenumber, weyl
from orbitdb.store.lookup import find_words
from orbitdb.store.select import Words, rows_of
from orbitdb.store.selection import Selection
from orbitdb.store.sqlite import Connection
from orbitdb.text import format_float, shortened

SHORTEST = 20
"""Number of words to try by default: the representatives of the shortest orbits, besides bouncing balls."""
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


ORDERS = ("above", "strength", "k")


def scars_of(
    orbits: Sequence[Orbit],
    low: float,
    high: float | None,
    parities: Iterable[Parity],
    order: str = "above",
    tell: Tell = nobody,
) -> list[Scar]:
    """Return scars of orbits at all levels with low <= k < high.

    Without `high`, only the level of each parity nearest to `low` is taken. Of several orbits, each level has
    the `STRONGEST`, and the levels are sorted by k. Scars of a single orbit are sorted in the given order: k,
    or the largest `above` or `strength` first.
    """
    if order not in ORDERS:
        raise InputError(f"order {order!r:.40}: use {', '.join(ORDERS)}")
    for end in (low, low if high is None else high):
        check_number("k", end)
    if high is not None and not 0 <= low < high < np.inf:
        raise InputError(f"k from {low:g} to {high:g} is not a range: give the lower end first")
    scars = []
    for parity in parities:
        for at_level in _scars(orbits, low, high, parity, tell):
            at_level.sort(key=lambda scar: _rank(scar, order))
            scars += at_level[:STRONGEST]
    return sorted(scars, key=lambda scar: _rank(scar, order) if len(orbits) == 1 else (scar.k,))


def _rank(scar: Scar, order: str) -> tuple[float, ...]:
    if order == "k":
        return (scar.k,)
    above = -np.inf if scar.above is None else scar.above
    return (-above, -scar.strength) if order == "above" else (-scar.strength,)


def _scars(
    orbits: Sequence[Orbit], low: float, high: float | None, parity: Parity, tell: Tell
) -> list[list[Scar]]:
    """Return the scars at each level of one parity in a range of k; neighbours may lie outside the range."""
    stadium = Stadium(orbits[0].a)
    smooth, end = weyl(stadium, parity), low if high is None else high
    first = min(low, wavenumber(smooth, smooth(low) - NEIGHBOURS))
    last = max(end, wavenumber(smooth, smooth(end) + NEIGHBOURS))
    levels, strength = scar_strengths(stadium, first, last, parity, orbits, tell)
    wanted = np.flatnonzero((low <= levels) & (levels < end))
    if high is None:
        wanted = np.abs(levels - low).argsort()[:1]
    scars = []
    for n in wanted.tolist():
        others = np.delete(strength[max(n - NEIGHBOURS, 0) : n + NEIGHBOURS + 1], min(n, NEIGHBOURS), axis=0)
        scars.append(
            [
                Scar(float(levels[n]), parity, orbit.code, float(own), _above(own, of_others))
                for orbit, own, of_others in zip(orbits, strength[n], others.T, strict=True)
            ]
        )
    return scars


def _above(own: float, others: Floats) -> float | None:
    """Return how far a strength is above the mean of others, in units of their standard deviation."""
    spread = float(others.std()) if len(others) >= _ENOUGH else 0.0
    return float(own - others.mean()) / spread if spread > _ROUNDING else None


def shortest_orbits(connection: Connection, a: float) -> list[Orbit]:
    """Return the bouncing balls and the shortest stored orbits, one of each class."""
    chosen = replace(Selection(a), statuses=(Status.ORBIT,), where="code = representative")
    rows = rows_of(connection, Words(chosen, "length"), ("code",), 0, SHORTEST)
    words = [word for (word,) in rows]
    orbits = [orbit for orbit in find_words(connection, words, a) if orbit is not None]
    if not orbits:
        raise no_orbits(a)
    return [solve_word("02", a), *orbits]


def check_scarring(orbit: Orbit) -> None:
    """Raise `InputError` if a word is neither an orbit nor the family of bouncing balls."""
    if orbit.points is None and orbit.status is not Status.FAMILY:
        code = shortened(orbit.code)
        raise InputError(f"{code} at a = {format_float(orbit.a)} scars nothing: {orbit.status.sentence}")
