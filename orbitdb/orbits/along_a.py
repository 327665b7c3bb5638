"""Follow orbits as a varies: the maxima of the length, and the slacks of their bounces.

Let x = ln a. The maximum moves as d alpha/dx = (-H)^-1 (-2 a sin alpha), which takes one additional
right-hand side in the solver's linear system. A word is an orbit if and only if the six *smooth slacks* of
each run and its leg are positive (`orbitdb.billiard.legs.smooth_slacks`). They are linear in alpha and
independent of a, so their slopes in x follow from d alpha/dx by the same linear map.

Between two stations, every slack is approximated by the cubic with the same values and slopes at both ends.
If it is not clear how many zeros the cubic has, the cell is halved. The Illinois method then finds the zeros,
solving the words again at every step.

Everything here is numerical; `orbitdb.orbits.births` proves each change that is found. Whether all are found
depends on the grid, and is proved by `orbitdb.orbits.missing_births`.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orbitdb.arrays import Batch, Floats, Indices, Marks
from orbitdb.billiard.legs import (
    Chain,
    derivatives,
    direction_limits,
    pressed_directions,
    slack_changes,
    smooth_slacks,
)
from orbitdb.orbits.newton import newton, responses

_ON_THE_WAY = 2e-3
"""Step (radians) at which Newton's method stops; the error, about its square, is harmless between zeros."""
_PLAIN_STEPS = 4


@dataclass(frozen=True, eq=False)
class Station(Batch):
    """State of N words at one grid point x = ln a."""

    x: float  # ln a
    alpha: Floats  # directions of the legs (radians), shape (m, N)
    velocity: Floats  # d alpha/dx
    slack: Floats  # the smooth slacks (radians), shape (6 m, N); missing slacks are infinite
    slope: Floats  # derivatives of the slacks in x

    @classmethod
    def at(cls, legs: Chain, x: float, alpha: Floats, velocity: Floats) -> "Station":
        """Return a station with the slacks that belong to the given directions and velocity."""
        return cls(x, alpha, velocity, *slacks_and_slopes(legs, alpha, velocity))


def hermite(t: float | Floats, h: float, ends: Sequence[Floats], slopes: Sequence[Floats]) -> Floats:
    """Return a cubic at fraction t of an interval of width h, given its values and slopes at the ends."""
    near, far = (1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)
    bent = h * t * (1 - t) * ((1 - t) * slopes[0] - t * slopes[1])
    return near * ends[0] + far * ends[1] + bent


def motion(
    legs: Chain, a: float | Floats, alpha: Floats, limits: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Return Newton's step and the velocity of words at directions within their limits, each of shape (m, N).

    The velocity is d alpha/dx with x = ln a. It is zero for directions pressed against a limit.
    """
    slopes = derivatives(legs, a, alpha)
    pressed = pressed_directions(alpha, slopes, limits)
    step, velocity = responses(legs, slopes, pressed, slopes.gradient, -2 * a * np.sin(alpha))
    return step, velocity


def follow_in_a(legs: Chain, grid: Floats) -> Iterator[Station]:
    """Follow N words along a grid of x = ln a; yield a station for each point of the grid.

    Newton's method starts from an extrapolation of the last two stations.
    """
    first = float(np.exp(grid[0]))
    alpha = newton(legs, first).alpha
    _, velocity = motion(legs, first, alpha, direction_limits(legs, first))
    bend = np.zeros_like(velocity)
    yield Station.at(legs, float(grid[0]), alpha, velocity)
    for x, h in zip(grid[1:].tolist(), np.diff(grid).tolist(), strict=True):
        a = float(np.exp(x))
        limits = direction_limits(legs, a)
        before, start = velocity, np.clip(alpha + h * (velocity + h / 2 * bend), *limits)
        alpha, velocity = _settle(legs, a, start, limits)
        bend = (velocity - before) / h
        yield Station.at(legs, x, alpha, velocity)


def _settle(legs: Chain, a: float, start: Floats, limits: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Solve words, starting from nearby directions; return directions and velocity, each of shape (m, N)."""
    alpha, velocity = start.copy(), np.empty_like(start)
    part, old, active = legs, start, np.arange(len(legs))
    for _ in range(_PLAIN_STEPS):
        step, velocity[:, active] = motion(part, a, old, limits)
        new = np.clip(old + step, *limits)
        alpha[:, active] = new
        going = np.flatnonzero(np.abs(new - old).max(axis=0) > _ON_THE_WAY)
        if not len(going):
            return alpha, velocity
        active, old, part = active[going], new.take(going, axis=1), part.chain(going)
        limits = (limits[0].take(going, axis=1), limits[1].take(going, axis=1))
    alpha[:, active] = newton(part, a, start=old).alpha
    _, velocity[:, active] = motion(part, a, alpha[:, active], limits)
    return alpha, velocity


def slacks_and_slopes(legs: Chain, alpha: Floats, velocity: Floats) -> tuple[Floats, Floats]:
    """Return the smooth slacks and their slopes in x, each of shape (6 m, N)."""
    slack, slope = smooth_slacks(legs, alpha), slack_changes(legs, velocity)
    shape = (6 * len(alpha), len(legs))
    return slack.reshape(shape), slope.reshape(shape)


def between(legs: Chain, start: Station, end: Station) -> Station:
    """Return the station halfway between two stations of the same words."""
    x, h = (start.x + end.x) / 2, end.x - start.x
    a = float(np.exp(x))
    limits = direction_limits(legs, a)
    guess = (start.alpha + end.alpha) / 2 + h / 8 * (start.velocity - end.velocity)
    alpha, velocity = _settle(legs, a, np.clip(guess, *limits), limits)
    return Station.at(legs, x, alpha, velocity)


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

    word: Indices  # the index of the word
    slack: Indices  # the smooth slack, as a row index of `Station.slack`
    far: Floats  # one end of the cell in x = ln a
    x: Floats  # the other end, or the zero
    alpha: Floats  # directions at x (radians), shape (m, K)

    def __len__(self) -> int:
        return len(self.word)


def candidates(legs: Chain, stations: Iterable[Station]) -> Zeros:
    """Find the cells in which a slack of a word changes its sign and no other is negative throughout.

    The stations are those of the N words along the grid (`orbitdb.orbits.along_a.follow_in_a`).
    """
    none, nothing = np.zeros(0, np.intp), np.zeros(0)
    cells, before = [Zeros(none, none, nothing, nothing, np.zeros((len(legs.k), 0)))], None
    for station in stations:
        if before is not None:
            cells += list(_search(legs, np.arange(len(legs)), before, station, 0))
        before = station
    return Zeros.joined(cells)


def _search(legs: Chain, word: Indices, start: Station, end: Station, halved: int) -> Iterator[Zeros]:
    """Search the same cell for all given words; yield the slacks that cross zero in it."""
    turning = start.slope * end.slope < 0
    below, above = (start.slack < 0) & (end.slack < 0), (start.slack > 0) & (end.slack > 0)
    dull = (below & ~turning).any(axis=0) | (above & ~turning).all(axis=0)
    if dull.all():
        return
    kept = np.flatnonzero(~dull)
    part, word, start, end = legs.chain(kept), word[kept], start.rows(kept), end.rows(kept)
    crossings, dead, doubtful = _crossings(start, end)
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


def _crossings(start: Station, end: Station) -> tuple[Marks, Marks, Marks]:
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


def _solved(legs: Chain, slack: Indices, x: Floats, start: Floats) -> tuple[Floats, Floats]:
    """Return the chosen slack of each word at its own x, and the directions there, found from nearby ones."""
    a = np.exp(x)
    alpha = newton(legs, a, _INNER, np.clip(start, *direction_limits(legs, a))).alpha
    return slacks_and_slopes(legs, alpha, alpha)[0][slack, np.arange(len(x))], alpha
