"""The levels of a stadium: those that are stored, and those from its orbits."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from orbitdb.answers.complete_periods import read_classes
from orbitdb.answers.completeness import highest_filled, no_orbits
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, NotStoredError
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.orbits.status import Status
from orbitdb.quantum.comparison import CUTOFF
from orbitdb.quantum.exact_levels import LARGEST_A, LEAST_A, Levels, LevelWindow, ranges_not_stored
from orbitdb.quantum.levels_from_orbits import CUTOFFS, Staircase, levels_of, reliable_end, staircase
from orbitdb.quantum.radius_fit import WIDEST
from orbitdb.quantum.weyl import Parity, k_ends, parities_of, weyl
from orbitdb.selection import Selection
from orbitdb.store.periods import read_fills
from orbitdb.store.sqlite import Connection
from orbitdb.store.stored_values import stored_levels
from orbitdb.text import format_float, several

Parities: TypeAlias = Parity | str | Iterable[Parity | str] | None

_LEAST, _ENOUGH = 8, 12
"""Levels need all orbits up to the first of these periods, and improve up to the second."""
_MOST_K = 300.0
_MARGIN = 1.0
"""Range of k beyond the ends of a list for which the staircase is computed."""


def levels_in_catalogue(connection: Connection, a: float, parity: Parities = None, k: Any = None) -> Levels:
    """Return the stored levels in a range of k, by default from 0 to the first gap (`Catalogue.levels`)."""
    parities, (low, end) = parities_of(parity), (0.0, None) if k is None else k_ends(k)
    windows_of = {one: stored_levels(connection, a, one) for one in parities}
    ends = {one: next(ranges_not_stored(windows, low, math.inf))[0] for one, windows in windows_of.items()}
    last = min(ends.values())
    high = last if end is None else end
    if not low < high <= last:
        of = "" if len(parities) == len(Parity) else f" of parity {', '.join(parities)}"
        to = low + 30 if end is None else end
        command = f"`catalogue.fill_levels(k=({low:g}, {to:g}), a={format_float(a)})`"
        if max(ends.values()) > low == last:
            some = ", ".join(one for one, end in ends.items() if end > low)
            raise NotStoredError(
                f"only {some} levels are stored at a = {format_float(a)}: choose one of these, or find "
                f"the others with {command}"
            )
        start = f" from k = {low:g} on" if low == last else f" from k = {low:g} to {last:g} only"
        stored = f"{'no ' if low == last else ''}levels{of} are stored{start}"
        raise NotStoredError(f"{stored} at a = {format_float(a)}: {command} finds them")
    return Levels.joined(a, low, high, windows_of)


def levels_to_gap(connection: Connection, a: float, parity: Parity | None) -> tuple[Floats, float] | None:
    """Return the stored levels from k = 0 to the first gap, and the k of this gap; None without levels."""
    try:
        levels = levels_in_catalogue(connection, a, parity)
    except InputError:
        return None
    return levels.k, levels.high


def levels_from_orbits(connection: Connection, a: float, parity: Parities = None, k: Any = None) -> Levels:
    """Return the levels in a range of k, computed from the stored orbits (`Catalogue.levels`)."""
    stadium, named, (low, high) = Stadium(a), parities_of(parity), (0.0, None) if k is None else k_ends(k)
    classes, highest = classes_for_levels(connection, stadium.a)
    reliable = min(reliable_end(stadium, parity) for parity in named)
    end = math.floor(reliable * 10) / 10 if high is None else high
    if not low < end <= _MOST_K:
        raise InputError(f"k from {low:g} to {end:g}: give a range of k that ends below {_MOST_K:g}")
    windows = {}
    for parity in named:
        k_of, error = levels_of(staircase(stadium, classes, end + 1.0, parity), end)
        windows[parity] = [LevelWindow(stadium.a, parity, 0.0, end, 0, k_of, error)]
    basis = [
        f"from {several(len(classes), 'class', 'classes')} of orbits, all up to period {highest}, "
        f"with cutoffs X = {CUTOFFS[0]:g} to {CUTOFFS[-1]:g}"
    ]
    if highest < _ENOUGH:
        basis.append(
            f"period {_ENOUGH} reduces the errors: `catalogue.fill(p={_ENOUGH}, a={format_float(stadium.a)})`"
        )
    if end > reliable:
        basis.append(f"above k = {reliable:.1f} the rms error is more than a fifth of the mean spacing")
    return replace(Levels.joined(stadium.a, low, end, windows), basis="; ".join(basis))


def stored_counterparts(connection: Connection, levels: Levels) -> list[float | None]:
    """Return, for each level from orbits, the stored level with the same number, or None."""
    exact_k: dict[tuple[str, int], float] = {}
    for parity in levels.parities:
        for window in stored_levels(connection, levels.a, parity):
            exact_k.update(((str(parity), window.below + n), k) for n, k in enumerate(window.k.tolist(), 1))
    numbers = dict.fromkeys(map(str, levels.parities), 0)
    values = []
    for parity in levels.parity.tolist():
        numbers[parity] += 1
        values.append(exact_k.get((parity, numbers[parity])))
    return values


def classes_for_levels(connection: Connection, a: float) -> tuple[OrbitClasses, int]:
    """Return the orbits at a, and the period up to which all are filled; raise if this period is too low."""
    if not LEAST_A <= a <= LARGEST_A:
        raise InputError(
            f"no levels at a = {format_float(a)}: give a half length from {LEAST_A:g} to {LARGEST_A:g}"
        )
    classes, highest = read_orbits(connection, Selection(a))
    if highest < _LEAST:
        raise NotStoredError(
            f"periods are complete only up to {highest} at a = {format_float(a)}, but levels need {_LEAST} "
            f"or more: `catalogue.fill(p={_ENOUGH}, a={format_float(a)})` finds their orbits"
        )
    return classes, highest


def read_orbits(connection: Connection, chosen: Selection) -> tuple[OrbitClasses, int]:
    """Return the chosen orbits by class, with their symmetries and representatives, and the highest period.

    All periods up to the highest one are filled (`highest_filled`).
    """
    statuses = (Status.ORBIT, Status.BOUNDARY)
    texts = ("symmetry", "representative")
    classes = read_classes(connection, replace(chosen, statuses=statuses), texts)
    if not len(classes):
        raise no_orbits(chosen.a)
    classes = _with_joints(classes, read_classes(connection, replace(chosen, statuses=statuses[1:]), texts))
    return classes, highest_filled(read_fills(connection, chosen.a), chosen)


def _with_joints(classes: OrbitClasses, boundary: OrbitClasses) -> OrbitClasses:
    """Return classes with the number of bounces at joints.

    All 2^n words of an orbit with n bounces at joints are stored: in half of the words, such a bounce is on a
    wall, in the others on a semicircle.
    """
    if not len(boundary):
        return classes
    joints = np.zeros(len(classes), np.int64)
    assert classes.number is not None
    assert boundary.number is not None
    own = np.isin(classes.number, boundary.number)
    same = np.stack([classes.p, np.rint(classes.length * 1e7).astype(np.int64)], axis=1)
    for one in np.unique(same[own], axis=0):
        some = own & (same == one).all(axis=1)
        joints[some] = classes.walls[some].max() - classes.walls[some].min()
    return replace(classes, joints=joints)


def notes_on_windows(levels: Levels, parts: Mapping[Parity, Sequence[LevelWindow]]) -> tuple[str, ...]:
    """Return a line for each parity that compares its levels, found in some windows, with Weyl's law."""
    notes, low, high = [], levels.low, levels.high
    for parity, windows in parts.items():
        below = min(part.below + int((part.k < low).sum()) for part in windows if part.high > low)
        of_parity = levels.parity == str(parity)
        own, error = levels.k[of_parity], levels.error[of_parity]
        places = np.linspace(low, high, 2000)
        smooth = weyl(Stadium(levels.a), parity)(places)
        off = float((below + np.searchsorted(own, places) - smooth).mean())
        worst = f", errors up to {error.max():.0e}" if len(own) else ""
        count = several(len(own), "level")
        notes.append(f"{parity}: {count}, none missing; on average {off:+.2f} from Weyl's law{worst}")
    return tuple(notes)


def orbits_for(
    stadium: Stadium,
    classes: OrbitClasses,
    parity: Parity | None,
    k: Floats,
    window: bool = False,
    wider: float = WIDEST,
    period: int | None = None,
) -> Staircase:
    """Return the staircase for comparison with the levels k; for a window, on its range only.

    The range allows for radii wrong by the fraction `wider`. All periods up to `period` are filled.
    """
    low = max(float(k[0]) * (1 - 2 * wider) - _MARGIN, 0.0) if window else 0.0
    high = float(k[-1]) * (1 + 2 * wider) + _MARGIN
    return staircase(stadium, classes, high, parity, (CUTOFF,), low, period)
