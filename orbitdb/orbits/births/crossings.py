"""Where slacks change sign: cells of the grid of x = ln a, searched for zeros of the smooth slacks.

Between two stations every slack is taken for the cubic that has its values and slopes there. Where that
cubic does not tell clearly how often it crosses zero the cell is halved. Zeros are then found by
Newton's method in the directions and x at once, kept in their cell. This is numerical: what it finds is
proved in `orbitdb.orbits.births.brackets`; that nothing is missed rests on the grid.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain, direction_limits
from orbitdb.equality import Columns
from orbitdb.orbits.births.continuation import Station, between, hermite, motion, slacks_and_slopes
from orbitdb.orbits.newton import newton

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_NEAR = 0.02
"""A cubic that turns so near to zero (radians) is not trusted."""
_HALVINGS = 8
_PLACES = np.linspace(0, 1, 9)[:, None, None]
_STEPS, _SURE_STEPS = 12, 80
_SETTLED = 1e-12
"""A Newton step of this size in x leaves nothing but rounding."""
_INNER = 1e-12
"""Error of the directions (radians) at which a zero is looked for step by step."""
_CLOSE = 1e-9
"""A zero is of interest where all other slacks are above minus this (radians)."""


@dataclass(frozen=True, eq=False)
class Zeros(Columns):
    """K zeros of single slacks, as a structure of arrays of shape (K,)."""

    word: Indices  # which word
    slack: Indices  # which of its smooth slacks, as a row of `Station.slack`
    low: Floats  # the cell in x = ln a
    high: Floats
    x: Floats  # the zero
    alpha: Floats  # directions there (radians), shape (m, K)

    def __len__(self) -> int:
        return len(self.word)


def candidates(legs: Chain, stations: Iterable[Station]) -> Zeros:
    """Find the cells in which slacks of words change sign while no other is negative throughout.

    Parameters
    ----------
    legs : Chain
        N words of m legs.
    stations : iterable of Station
        The words on their way, as of `orbitdb.orbits.births.continuation.follow`.

    Returns
    -------
    Zeros
        Guessed from the cubics.
    """
    found, before = [], None
    for station in stations:
        if before is not None:
            found += list(_search(legs, np.arange(len(legs)), before, station, 0))
        before = station
    if not found:
        none, nothing = np.zeros(0, np.intp), np.zeros(0)
        return Zeros(none, none, nothing, nothing, nothing, np.zeros((legs.k.shape[0], 0)))
    return Zeros(*(np.concatenate([getattr(z, each.name) for z in found], axis=-1) for each in fields(Zeros)))


def _search(legs: Chain, word: Indices, start: Station, end: Station, halved: int) -> Iterator[Zeros]:
    """Search one cell of some words; yield what slacks cross zero in it."""
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
        yield _guess(word[column], slack, column, start, end)


def _judge(start: Station, end: Station) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Tell which slacks cross zero, which words are outside all the way, and where that is not clear."""
    f0, f1 = start.slack, end.slack
    crossings = (f0 < 0) != (f1 < 0)
    with np.errstate(invalid="ignore"):
        cubic = hermite(_PLACES, end.x - start.x, (f0, f1), (start.slope, end.slope))
        signs = (np.diff(cubic > 0, axis=0) != 0).sum(axis=0)
        least, most = cubic.min(axis=0), cubic.max(axis=0)
    turning = start.slope * end.slope < 0
    outside = (f0 < 0) & (f1 < 0)
    dead = (outside & (most < -_NEAR)).any(axis=0) | (outside & ~turning).any(axis=0)
    inside = (f0 > 0) & (f1 > 0)
    doubtful = (outside & turning & (most >= -_NEAR)) | (inside & turning & (least <= _NEAR))
    doubtful |= crossings & (signs > 1)
    return crossings, dead, doubtful.any(axis=0)


def _guess(word: Indices, slack: Indices, column: Indices, start: Station, end: Station) -> Zeros:
    """Guess zeros by the chord, and the directions there by the cubics between the stations."""
    f0, f1 = start.slack[slack, column], end.slack[slack, column]
    t = f0 / (f0 - f1)
    h, ends = end.x - start.x, (start.alpha[:, column], end.alpha[:, column])
    alpha = hermite(t, h, ends, (start.drift[:, column], end.drift[:, column]))
    low, high = (np.full(len(word), edge) for edge in sorted((start.x, end.x)))
    return Zeros(word, slack, low, high, start.x + t * h, alpha)


def refine(legs: Chain, guessed: Zeros) -> Zeros:
    """Find the zeros that were guessed, those that stay in their cell and have no slack far below zero.

    Parameters
    ----------
    legs : Chain
        The N words that the zeros number.
    guessed : Zeros
    """
    x, alpha = guessed.x.copy(), guessed.alpha.copy()
    settled = np.zeros(len(guessed), dtype=bool)
    active = np.arange(len(guessed))
    part = legs.chain(guessed.word)
    for _ in range(_STEPS):
        if not len(active):
            break
        here = guessed.rows(active)
        dx, moved = _zero_step(part, here.slack, x[active], alpha[:, active])
        new = np.clip(x[active] + dx, here.low, here.high)
        alpha[:, active], x[active] = moved, new
        done = np.abs(dx) < _SETTLED
        settled[active[done]] = True
        active, part = active[~done], part.chain(np.flatnonzero(~done))
    stuck = np.flatnonzero(~settled)
    if len(stuck):
        x[stuck], alpha[:, stuck] = _surely(legs.chain(guessed.word[stuck]), guessed.rows(stuck))
    found = Zeros(guessed.word, guessed.slack, guessed.low, guessed.high, x, alpha)
    slack, _ = slacks_and_slopes(legs.chain(found.word), alpha, alpha)
    return found.rows(np.flatnonzero((slack > -_CLOSE).all(axis=0)))


def _zero_step(legs: Chain, slack: Indices, x: Floats, alpha: Floats) -> tuple[Floats, Floats]:
    """Return Newton's step in x, and the directions after it."""
    a = np.exp(x)
    limits = direction_limits(legs, a)
    here = np.clip(alpha, *limits)
    step, drift = motion(legs, a, here, limits)
    own = slack, np.arange(len(x))
    f, gain = (each[own] for each in slacks_and_slopes(legs, here, step))
    slope = slacks_and_slopes(legs, here, drift)[1][own]
    with np.errstate(divide="ignore", invalid="ignore"):
        dx = np.clip(np.nan_to_num(-(f + gain) / slope), -1.0, 1.0)
    return dx, here + step + dx * drift


def _surely(legs: Chain, stuck: Zeros) -> tuple[Floats, Floats]:
    """Find zeros inside their cells by the Illinois method, each word solved anew.

    Where a direction reaches or leaves a limit its slope jumps, and Newton's method may go in circles.
    """
    low, high = stuck.low.copy(), stuck.high.copy()
    f_low, _ = _solved(legs, stuck.slack, low, None)
    f_high, alpha = _solved(legs, stuck.slack, high, None)
    x, last = high.copy(), np.zeros(len(stuck), np.int8)
    active = np.arange(len(stuck))
    for _ in range(_SURE_STEPS):
        a, b, f_a, f_b = low[active], high[active], f_low[active], f_high[active]
        with np.errstate(divide="ignore"):
            new = (a * f_b - b * f_a) / (f_b - f_a)
        new = np.where((new > a) & (new < b), new, (a + b) / 2)
        f, found = _solved(legs.chain(active), stuck.slack[active], new, alpha[:, active])
        moved, x[active], alpha[:, active] = np.abs(new - x[active]), new, found
        left, side = (f > 0) == (f_a > 0), np.where((f > 0) == (f_a > 0), -1, 1)
        again = side == last[active]
        low[active], high[active] = np.where(left, new, a), np.where(left, b, new)
        f_low[active] = np.where(left, f, np.where(again, f_a / 2, f_a))
        f_high[active] = np.where(left, np.where(again, f_b / 2, f_b), f)
        last[active] = side
        active = active[(moved > _SETTLED) & (f != 0)]
        if not len(active):
            break
    return x, alpha


def _solved(legs: Chain, slack: Indices, x: Floats, start: Floats | None) -> tuple[Floats, Floats]:
    """Return one slack of each word, each at its own x, and the directions there."""
    a = np.exp(x)
    if start is not None:
        start = np.clip(start, *direction_limits(legs, a))
    alpha = newton(legs, a, _INNER, start).alpha
    return slacks_and_slopes(legs, alpha, alpha)[0][slack, np.arange(len(x))], alpha
