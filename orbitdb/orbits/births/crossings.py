"""Search the cells of a grid in x = ln a for zeros of the smooth slacks.

Between two stations, every slack is approximated by the cubic with the same values and slopes at both ends.
If it is not clear how many zeros the cubic has, the cell is halved. The Illinois method then finds the zeros,
solving the words again at every step. This is numerical: `orbitdb.orbits.births.brackets` proves the zeros,
but whether they are complete depends on the grid.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from orbitdb.arrays import Floats, Marks, Places
from orbitdb.billiard.legs import Chain, direction_limits
from orbitdb.equality import Batch
from orbitdb.orbits.births.continuation import Station, between, hermite, slacks_and_slopes
from orbitdb.orbits.newton import newton

_NEAR = 0.02
"""A cubic with an extremum this close to zero (radians) is not trusted."""
_HALVINGS = 8
_PLACES = np.linspace(0, 1, 9)[:, None, None]
_STEPS = 80
_SETTLED = 1e-12
"""Steps in x smaller than this are only rounding."""
_INNER = 1e-12
"""Error of the directions (radians) during the search for a zero."""
_BEYOND = 1e-5
"""Distance in x that the search extends beyond a cell, because the slacks of stations are not exact."""
_CLOSE = 1e-9
"""A zero counts if all other slacks are greater than minus this (radians)."""


@dataclass(frozen=True, eq=False)
class Zeros(Batch):
    """K zeros of individual slacks, or the cells that contain them, stored as arrays of shape (K,)."""

    word: Places  # the index of the word
    slack: Places  # the smooth slack, as a row index of `Station.slack`
    far: Floats  # one end of the cell in x = ln a
    x: Floats  # the other end, or the zero
    alpha: Floats  # directions at x (radians), shape (m, K)

    def __len__(self) -> int:
        return len(self.word)


def candidates(legs: Chain, stations: Iterable[Station]) -> Zeros:
    """Find the cells in which a slack of a word changes its sign and no other is negative throughout.

    The stations are those of the N words along the grid (`orbitdb.orbits.births.continuation.follow`).
    """
    none, nothing = np.zeros(0, np.intp), np.zeros(0)
    found, before = [Zeros(none, none, nothing, nothing, np.zeros((len(legs.k), 0)))], None
    for station in stations:
        if before is not None:
            found += list(_search(legs, np.arange(len(legs)), before, station, 0))
        before = station
    return Zeros.joined(found)


def _search(legs: Chain, word: Places, start: Station, end: Station, halved: int) -> Iterator[Zeros]:
    """Search the same cell for all given words; yield the slacks that cross zero in it."""
    turning = start.slope * end.slope < 0
    below, above = (start.slack < 0) & (end.slack < 0), (start.slack > 0) & (end.slack > 0)
    dull = (below & ~turning).any(axis=0) | (above & ~turning).all(axis=0)
    if dull.all():
        return
    kept = np.flatnonzero(~dull)
    part, word, start, end = legs.chain(kept), word[kept], start.rows(kept), end.rows(kept)
    crossings, dead, doubtful = _judge(start, end)
    if halved < _HALVINGS and (doubtful & ~dead).any():
        again = np.flatnonzero(doubtful & ~dead)
        halves, ends = part.chain(again), (start.rows(again), end.rows(again))
        middle = between(halves, *ends)
        yield from _search(halves, word[again], ends[0], middle, halved + 1)
        yield from _search(halves, word[again], middle, ends[1], halved + 1)
        dead = dead | doubtful
    slack, column = np.nonzero(crossings & ~dead)
    if len(column):
        far, near = (np.full(len(column), x) for x in (start.x, end.x))
        yield Zeros(word[column], slack, far, near, end.alpha[:, column])


def _judge(start: Station, end: Station) -> tuple[Marks, Marks, Marks]:
    """Tell which slacks cross zero, which words are not orbits in the entire cell, and which are doubtful."""
    f0, f1 = start.slack, end.slack
    crossings = (f0 < 0) != (f1 < 0)
    with np.errstate(invalid="ignore"):
        cubic = hermite(_PLACES, end.x - start.x, (f0, f1), (start.slope, end.slope))
        signs = (np.diff(cubic > 0, axis=0) != 0).sum(axis=0)
        least, most = cubic.min(axis=0), cubic.max(axis=0)
    turning = start.slope * end.slope < 0
    outside = (f0 < 0) & (f1 < 0)
    dead = (outside & (most < -_NEAR)).any(axis=0)
    inside = (f0 > 0) & (f1 > 0)
    doubtful = outside | (inside & turning & (least <= _NEAR)) | (crossings & (signs > 1))
    return crossings, dead, doubtful.any(axis=0)


def refine(legs: Chain, cells: Zeros) -> Zeros:
    """Find the zeros in the cells, and keep those at which no slack is clearly negative.

    The Illinois method does not leave the cell. Newton's method in x could cycle, because the slope of a
    slack jumps when a direction reaches or leaves a limit.
    """
    part, beyond = legs.chain(cells.word), _BEYOND * np.sign(cells.x - cells.far)
    far, x = cells.far - beyond, cells.x + beyond
    f_far, _ = _solved(part, cells.slack, far, cells.alpha)
    f, alpha = _solved(part, cells.slack, x, cells.alpha)
    crossing = (f > 0) != (f_far > 0)
    active = np.flatnonzero(crossing)
    for _ in range(_STEPS):
        last, f_last, f_other = x[active], f[active], f_far[active]
        step = f_last * (far[active] - last) / (f_last - f_other)
        x[active], start = last + step, alpha.take(active, axis=1)
        f[active], alpha[:, active] = _solved(part.chain(active), cells.slack[active], x[active], start)
        crossed = (f[active] > 0) != (f_last > 0)
        far[active] = np.where(crossed, last, far[active])
        f_far[active] = np.where(crossed, f_last, f_other / 2)
        active = active[np.abs(step) > _SETTLED]
        if not len(active):
            break
    slack, _ = slacks_and_slopes(part, alpha, alpha)
    kept = np.flatnonzero(crossing & (slack > -_CLOSE).all(axis=0))
    return replace(cells, x=x, alpha=alpha).rows(kept)


def _solved(legs: Chain, slack: Places, x: Floats, start: Floats) -> tuple[Floats, Floats]:
    """Return the chosen slack of each word at its own x, and the directions there, found from nearby ones."""
    a = np.exp(x)
    alpha = newton(legs, a, _INNER, np.clip(start, *direction_limits(legs, a))).alpha
    return slacks_and_slopes(legs, alpha, alpha)[0][slack, np.arange(len(x))], alpha
