"""Scars: how strongly the waves of levels concentrate along orbits."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from orbitdb.answers.completeness import no_orbits
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.criteria import unknown_column
from orbitdb.errors import InputError, check_number, check_text
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import solve_word
from orbitdb.orbits.status import Status
from orbitdb.progress import Tell, nobody
from orbitdb.quantum.waves import scar_strengths
from orbitdb.quantum.weyl import Parity, k_range, wavenumber, weyl
from orbitdb.selection import Selection
from orbitdb.store.lookup import find_words
from orbitdb.store.select import Words, rows_of
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


_ORDER = re.compile(r"(-?)(\w+)(?: (asc|desc))?", re.IGNORECASE)


def order_of_scars(order: str | None, named: bool) -> list[tuple[str, bool]]:
    """Return the columns to sort scars by, each with whether it descends; `named` if orbits were named."""
    keys = []
    if order is not None:
        check_text("order", order, "above desc")
    for part in (order or ("above desc" if named else "k")).split(","):
        key = _ORDER.fullmatch(part.strip())
        if key is None:
            raise InputError(f"order {order!r:.40}: write columns such as 'above desc' or 'k,strength desc'")
        if key[2] not in Scar._fields:
            raise unknown_column(key[2], Scar._fields)
        keys.append((key[2], bool(key[1]) != ((key[3] or "").lower() == "desc")))
    return keys


def scars_of(
    orbits: Sequence[Orbit],
    k: Any,
    parities: Iterable[Parity],
    order: Sequence[tuple[str, bool]],
    strongest: int | None = None,
    tell: Tell = nobody,
) -> list[Scar]:
    """Return scars of orbits at all levels in a range of k, or at the level of each parity nearest to one k.

    Of the orbits, each level has the `strongest`, by default all. Empty values are sorted last.
    """
    low, high = (float(k), None) if isinstance(k, Real) else k_range(k)
    check_number("k", low)
    scars = []
    for parity in parities:
        for at_level in _scars(orbits, low, high, parity, tell):
            at_level.sort(key=lambda scar: (scar.above is None, -(scar.above or 0.0), -scar.strength))
            scars += at_level[:strongest]
    for name, falls in reversed([*order, ("k", False)]):
        scars.sort(key=lambda scar: _key(getattr(scar, name), falls), reverse=falls)
    return scars


def _key(value: float | str | None, falls: bool) -> tuple[bool, float | str]:
    return ((value is None) != falls, 0.0 if value is None else value)


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


def check_scarring(orbits: Iterable[Orbit]) -> None:
    """Raise `InputError` if a word is neither an orbit nor the family of bouncing balls."""
    for orbit in orbits:
        if orbit.points is None and orbit.status is not Status.FAMILY:
            code = shortened(orbit.code)
            raise InputError(f"{code} at a = {format_float(orbit.a)} scars nothing: {orbit.status.sentence}")
