"""The length spectrum of a catalogue's orbits, and of its levels if it has any."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import sqlalchemy as sa
from numpy.typing import NDArray

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.least_values import least_length
from orbitdb.orbits.status import Status
from orbitdb.quantum.amplitudes import Classes, Parity, Terms, orbit_terms
from orbitdb.quantum.lengths import family_terms, of_family, of_levels, of_terms, reach
from orbitdb.quantum.levels import Levels, LevelWindow, parities_of
from orbitdb.quantum.spectrum import Spectrum, check_levels
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import level, level_fill
from orbitdb.store.reading.moment import Moment
from orbitdb.store.reading.soundness import unsound

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


_COLUMNS = ("maslov", "walls", "length", "lyapunov", "symmetry", "representative")
_USUAL_K_MAX = 30.0
_LONGEST, _MOST_POINTS, _MOST_K = 100, 100_000, 1000


def levels_from_zero(
    moment: Moment, a: float, parity: Parity | str | None = None, k_max: float | None = None
) -> Levels:
    """Return the stored levels from k = 0 to the first gap, or to `k_max` below it (`Catalogue.levels`)."""
    parities = list(Parity) if parity is None else parities_of([parity])
    found = {each: stored_levels(moment.connection, a, each) for each in parities}
    ends = {}
    for each, windows in found.items():
        end = 0.0
        for window in windows:
            end = window.high if window.low == end else end
        ends[each] = end
    last = min(ends.values())
    high = last if k_max is None else k_max
    if not 0 < high <= last:
        asked = 30 if k_max is None else k_max
        of = "" if parity is None else f" of parity {parity}"
        known = f"levels{of} are stored up to k = {last:g}" if last else f"no levels{of} are stored"
        command = f"'orbitdb levels --k 0:{asked:g} --a {exact(a)}'"
        if any(ends.values()) and not last:
            some = ", ".join(each for each, end in ends.items() if end)
            raise InputError(
                f"only {some} levels are stored at a = {exact(a)}: choose one parity with --parity, or find "
                f"the others with {command}"
            )
        raise InputError(f"{known} at a = {exact(a)}: {command} finds them")
    return Levels.joined(a, 0.0, high, found)


def read_levels(moment: Moment, a: float, parity: Parity | None) -> tuple[Floats, float] | None:
    """Return the stored levels from k = 0 to the first gap, and the k of this gap; None without levels."""
    try:
        found = levels_from_zero(moment, a, parity)
    except InputError:
        return None
    return found.k, found.high


def read_classes(moment: Moment, chosen: Selection) -> tuple[Classes, NDArray[np.object_], int]:
    """Return the chosen orbits by class, their representatives, and the period up to which all are filled."""
    found = moment.choose(replace(chosen, statuses=(Status.ORBIT, Status.BOUNDARY)), columns=_COLUMNS)
    filled = {fill.p for fill in moment.fills(chosen.a) if fill.whole and not fill.unresolved}
    if not len(found.ids):
        raise InputError(
            f"no orbits at a = {exact(chosen.a)}: 'orbitdb fill --p 11 --a {exact(chosen.a)}' finds some"
        )
    highest = 1
    while highest + 1 in filled:
        highest += 1
    values, words = found.values, found.counts.astype(np.int64)
    maslov, walls = (values[name].astype(np.int64) for name in ("maslov", "walls"))
    classes = Classes(maslov, walls, words, values["length"], values["lyapunov"], values["symmetry"])
    return classes, values["representative"], highest


def read_spectrum(
    moment: Moment,
    a: float,
    lengths: "ArrayLike",
    points: int,
    k_max: float | None = None,
    levels: "ArrayLike | None" = None,
    parity: Parity | str | None = None,
) -> Spectrum:
    """Return the length spectrum (`Catalogue.spectrum`)."""
    ends = np.asarray(lengths, np.float64)
    if ends.shape != (2,) or not 0 <= ends[0] < ends[1] <= _LONGEST or not 2 <= points <= _MOST_POINTS:
        raise InputError(
            f"lengths {lengths!r:.40}, points {points}: give a range within 0..{_LONGEST}, and 2 to "
            f"{_MOST_POINTS} points"
        )
    if k_max is not None and not 1 <= k_max <= _MOST_K:
        raise InputError(f"k_max {k_max:g}: give 1 to {_MOST_K}")
    if parity is not None and parity not in list(Parity):
        raise InputError(f"parity {parity!r:.40}: use ee, eo, oe or oo")
    stadium, of = Stadium(a), None if parity is None else Parity(parity)
    given = None if levels is None else check_levels(levels, stadium, of)
    classes, codes, highest = read_classes(moment, Selection(stadium.a))
    known = read_levels(moment, stadium.a, of) if given is None else (given, float(given[-1]))
    end = _USUAL_K_MAX if known is None else known[1]
    if k_max is not None and known is not None and k_max > end:
        raise InputError(
            f"the levels end at k = {end:.6g}: give a smaller k_max than {k_max:g}, or more levels"
        )
    end = end if k_max is None else k_max
    x, longest = np.linspace(float(ends[0]), float(ends[1]), points), float(ends[1]) + reach(end)
    terms = orbit_terms(classes, longest, of)
    orbits = of_terms(terms, x, end) + of_family(stadium, x, end, of)
    quantum = None if known is None else of_levels(known[0], x, end, stadium, of)
    complete = least_length(highest, stadium.a) if highest > 1 else 0.0
    if of is not None:
        complete /= 2  # because half orbits contribute
    parts = zip(terms, family_terms(stadium, end, longest, of), strict=True)
    both = Terms._make(map(np.concatenate, parts))
    return Spectrum(stadium.a, of, end, x, orbits, quantum, complete, both, codes)


def stored_levels(connection: sa.Connection, a: float, parity: Parity) -> list[LevelWindow]:
    """Return the stored windows of levels of one parity."""
    fills, levels = level_fill.c, level.c
    query = sa.select(fills.low, fills.high, fills.below, fills.seconds).where(
        fills.a == a, fills.parity == str(parity)
    )
    rows = sa.select(levels.number, levels.k, levels.error).where(levels.a == a, levels.parity == str(parity))
    known = np.array([tuple(row) for row in connection.execute(rows)], np.float64).reshape(-1, 3)
    found = []
    for low, high, below, seconds in connection.execute(query):
        number, k, error = known[(known[:, 1] >= low) & (known[:, 1] < high)].T
        if not np.array_equal(number, np.arange(below + 1, below + 1 + len(k))) or (np.diff(k) < 0).any():
            raise unsound(f"levels {parity} at a = {exact(a)} in a window from k =", low)
        found.append(LevelWindow(a, parity, low, high, below, k, error, seconds))
    for one, other in pairwise(found):
        whole = one.below + len(one.k) == other.below
        if one.high > other.low or (one.high == other.low and not whole):
            raise unsound(f"levels {parity} at a = {exact(a)} in a window from k =", other.low)
    if sum(len(each.k) for each in found) != len(known):
        raise unsound(f"levels {parity} outside all windows at a =", a)
    return found


def missing_levels(known: Sequence[LevelWindow], low: float, high: float) -> Iterator[tuple[float, float]]:
    """Yield the ranges of k between `low` and `high` that no window covers."""
    for each in known:
        if low < min(each.low, high):
            yield low, min(each.low, high)
        low = max(low, each.high)
    if low < high:
        yield low, high
