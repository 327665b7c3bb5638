"""The length spectrum from what a catalogue holds: orbits, and levels if they are there."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.orbits.orbit import Status
from orbitdb.quantum.amplitudes import Classes
from orbitdb.quantum.levels import Levels
from orbitdb.quantum.spectrum import Spectrum, spectrum
from orbitdb.quantum.weyl import Parity
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.levels import joined, stored
from orbitdb.store.reading.reader import Reader

Floats = NDArray[np.float64]

_COLUMNS = ("p", "walls", "length", "lyapunov", "symmetry", "representative")
_USUAL_K_MAX = 30.0


def read_levels(reader: Reader, a: float, parity: Parity | None) -> tuple[Floats, float] | None:
    """Return the stored levels from 0 to the first gap, and the k where that begins; None without levels."""
    found: list[Levels] = []
    with reader.at_one_moment() as still, still.reading() as connection:
        for each in Parity if parity is None else (parity,):
            known = joined(stored(connection, a, each))
            if known is None:
                return None
            found.append(known)
    high = min(each.high for each in found)
    k = np.sort(np.concatenate([each.k for each in found]))
    return k[k < high], high


def read_classes(reader: Reader, chosen: Selection) -> tuple[Classes, NDArray[np.object_], int]:
    """Return all orbits at one a, their representatives, and up to which period none is missing.

    Raises
    ------
    InputError
        If there are none.
    """
    with reader.at_one_moment() as still:
        found = still.choose(replace(chosen, statuses=(Status.ORBIT, Status.BOUNDARY)), columns=_COLUMNS)
        filled = {fill.p for fill in still.fills(chosen.a) if fill.whole and not fill.unresolved}
    if not len(found.ids):
        raise InputError(f"no orbits at a = {chosen.a:g}: 'orbitdb fill --p 11 --a {chosen.a:g}' finds some")
    highest = 1
    while highest + 1 in filled:
        highest += 1
    values, words = found.values, found.counts.astype(np.int64)
    p, walls = (values[name].astype(np.int64) for name in ("p", "walls"))
    classes = Classes(p, walls, words, values["length"], values["lyapunov"], values["symmetry"])
    return classes, values["representative"], highest


def read_spectrum(
    reader: Reader,
    a: float,
    lengths: Floats,
    k_max: float | None,
    levels: Floats | None,
    parity: Parity | None,
) -> Spectrum:
    """Return the length spectrum (`Catalogue.spectrum`).

    Raises
    ------
    InputError
        If there are no orbits, or no levels up to `k_max`.
    """
    with reader.at_one_moment() as still:
        orbits = read_classes(still, Selection(a))
        known = read_levels(still, a, parity) if levels is None else (levels, float(levels[-1]))
    end = _USUAL_K_MAX if known is None else known[1]
    if k_max is not None and known is not None and k_max > end:
        raise InputError(
            f"the levels end at k = {end:.6g}: give a smaller k_max than {k_max:g}, or more levels"
        )
    end = end if k_max is None else k_max
    return spectrum(Stadium(a), *orbits, lengths, end, None if known is None else known[0], parity)
