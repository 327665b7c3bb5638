"""Words as runs and legs: the length as a function of the leg directions, the bounces and their slacks.

An admissible word alternates between *runs* of bounces on the left and on the right semicircle, which are
joined by *legs* with n >= 0 bounces on the straight walls. Unfolded at the walls it hits, a leg is one
straight line. Its direction alpha is its slope angle at the start, seen towards the other side. The
directions of two successive legs fix the position of the run between them. With the directions of the m legs
as unknowns, the length is

    L(alpha) = sum over legs  2 a cos(alpha) + 2 n s sin(alpha)
             + sum over runs  2 k sin(psi / 2k),     psi = pi - d (alpha_in + alpha_out),

where s = -1, +1 stands for the first wall of the leg (bottom, top), k is the number of bounces of the run,
and d = +1, -1 is its sense (up, down). A stationary point of L is an orbit if walls and semicircles are
continued beyond their ends. Between `direction_limits`, L is strictly concave. An orbit is therefore its only
maximum, and no word has two orbits (docs/proof.md).

All arrays with a value for each leg or run have shape (m, N), with one column per word. If words are in
different stadiums, a has shape (N,). Run i precedes leg i; run 0 is on the left.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Marks, Words
from orbitdb.billiard.arithmetic import ABOVE, EPSILON
from orbitdb.billiard.stadium import HALF_PI, SIDE, STRAIGHT

_WIDER = 1.0625
_DOWNWARD = np.array([False, False, False, False, True, True])


@dataclass(frozen=True, eq=False)
class Chain(Batch):
    """N words as cyclic chains of m runs and m legs each, which is all that the length depends on."""

    k: Floats  # number of bounces of each run, shape (m, N)
    d: Floats  # sense of each run: +1 up, -1 down
    n: Floats  # number of straight bounces of each leg
    s: Floats  # first wall of each leg: -1 bottom, +1 top, 0 if it has none

    @cached_property
    def parity(self) -> Floats:
        """The sign (-1)^n of each leg, shape (m, N)."""
        return 1.0 - 2.0 * (self.n - 2 * np.floor(self.n / 2))  # n % 2, but ten times faster

    @cached_property
    def lift(self) -> Floats:
        """2 n s, how much higher the circle centre at the end of each unfolded leg is, shape (m, N)."""
        return 2 * self.n * self.s

    def __len__(self) -> int:
        return self.k.shape[1]

    @classmethod
    def of(cls, parts: "Sequence[Chain]") -> "Chain":
        """Return the chains of several batches with the same number of runs, one after another."""
        columns = zip(*((part.k, part.d, part.n, part.s) for part in parts), strict=True)
        return Chain(*(np.concatenate(column, axis=1) for column in columns))

    def chain(self, words: Indices) -> "Chain":
        """Return the chains of the given words."""
        return Chain(*(part.take(words, axis=1) for part in (self.k, self.d, self.n, self.s)))


class BounceIndex(NamedTuple):
    """Where the bounces of N words are in their runs and legs, as arrays of shape (p, N)."""

    run: Indices  # the index of the run or leg that contains the bounce
    place: Indices  # the index of the bounce in this run or leg, from 0
    straight: Marks  # whether the bounce is on a straight wall


@dataclass(frozen=True, eq=False)
class Legs(Chain):
    """N admissible words of period p, as chains of m runs and m legs."""

    words: Words  # the symbols, shape (p, N)

    @cached_property
    def bounces(self) -> BounceIndex:
        """The run or leg that contains each bounce, and the position of the bounce within it."""
        symbols, origin = _turned(self.words.T)
        fresh, straight = _beginnings(symbols), STRAIGHT[symbols]
        steps = np.arange(fresh.size)
        place = (steps - np.maximum.accumulate(np.where(fresh.ravel(), steps, 0))).reshape(fresh.shape)
        run = (fresh & ~straight).cumsum(axis=1) - 1
        back = (np.arange(symbols.shape[1]) - origin) % symbols.shape[1]
        return BounceIndex(*(np.take_along_axis(x, back, axis=1).T for x in (run, place, straight)))


def preceding(rows: NDArray[Any]) -> NDArray[Any]:
    """Return a copy in which each row is replaced by the one before it, cyclically."""
    return np.concatenate([rows[-1:], rows[:-1]])


def following(rows: NDArray[Any]) -> NDArray[Any]:
    """Return a copy in which each row is replaced by the one after it, cyclically."""
    return np.concatenate([rows[1:], rows[:1]])


def cut(words: Words) -> list[tuple[Indices, Legs]]:
    """Cut admissible words, shape (N, p), in any rotation, into runs and legs.

    Return a pair for each number of runs that occurs: the indices of the words with that number of runs, and
    the runs and legs of these words.
    """
    symbols, _ = _turned(words)
    straight = STRAIGHT[symbols]
    fresh_run = _beginnings(symbols) & ~straight
    begins = np.flatnonzero(fresh_run)
    n = np.add.reduceat(straight.ravel(), begins, dtype=float)
    k = np.diff(begins, append=symbols.size) - n
    d = np.where(_DOWNWARD[symbols.ravel()[begins]], -1.0, 1.0)
    first_wall = np.minimum(begins + k.astype(np.intp), symbols.size - 1)
    s = np.where(n > 0, symbols.ravel()[first_wall] - 1.0, 0.0)
    runs = fresh_run.sum(axis=1)
    first_run = runs.cumsum() - runs
    groups = []
    for m in np.flatnonzero(np.bincount(runs)):
        rows = np.flatnonzero(runs == m)
        chain = first_run[rows] + np.arange(m)[:, None]
        groups.append((rows, Legs(k[chain], d[chain], n[chain], s[chain], words[rows].T)))
    return groups


def _turned(words: Words) -> tuple[Words, Indices]:
    """Rotate words, shape (N, p), to begin with a run on the left; also return where that run began."""
    left = SIDE[words] < 0
    origin = (left & ~np.roll(left, 1, axis=1)).argmax(axis=1)[:, None]
    return np.take_along_axis(words, (np.arange(words.shape[1]) + origin) % words.shape[1], axis=1), origin


def _beginnings(symbols: Words) -> Marks:
    """Tell which bounces start a new run or leg, for words that begin with a run."""
    straight, left = STRAIGHT[symbols], SIDE[symbols] < 0
    fresh = np.ones(symbols.shape, dtype=np.bool_)
    fresh[:, 1:] = straight[:, 1:] != straight[:, :-1]
    fresh[:, 1:] |= ~straight[:, 1:] & (left[:, 1:] != left[:, :-1])
    return fresh


def direction_limits(legs: Chain, a: float | Floats) -> tuple[Floats, Floats]:
    """Return lower and upper bounds on the direction of each leg of an orbit, each of shape (m, N).

    A leg with walls spans 2 a <= dx <= 2 a + 2 and 2 n - 2 <= s dy <= 2 n + 2; without walls, -2 <= dy <= 2.
    So (n - 1) / (a + 1) <= s tan alpha <= (n + 1) / a with walls, and |tan alpha| <= 1 / a without.

    The returned doubles are themselves the limits, in arithmetic of any precision. For n up to a million they
    lie outside the ranges above by more than 5e-14, whereas rounding is below 1e-15; for n = 1, the limit 0
    is exact. Between the limits, and at them, the curvature D of the leg's own term is positive and
    |alpha| < pi/2.
    """
    no_wall = legs.n == 0
    steep = np.arctan(np.where(no_wall, _WIDER, 2 * (legs.n + 1)) / a)
    flat = np.arctan(np.maximum(legs.n - _WIDER, 0) / (a + 1))
    low = np.where(no_wall | (legs.s < 0), -steep, flat)
    return low, np.where(no_wall | (legs.s > 0), steep, -flat)


def centre_directions(legs: Chain, a: float | Floats) -> Floats:
    """Return the directions of the lines between the centres of the unfolded circles, shape (m, N)."""
    return np.arctan(legs.n * legs.s / a)


def half_turns(legs: Chain, alpha: Floats) -> Floats:
    """Return psi / 2k, half the angle by which each run turns at a bounce, shape (m, N).

    It is also the angle between the path and the tangent there.
    """
    return (np.pi - legs.d * (preceding(legs.parity * alpha) + alpha)) / (2 * legs.k)


def add_up(rows: NDArray[Any]) -> Floats:
    """Return the sum over the first axis, computed word by word, shape (N,).

    The bound of `summation_rounding` needs pairwise summation, which NumPy uses only along contiguous rows.
    Word by word, the sum is also the same to the last bit in whatever batch the word is.
    """
    return np.ascontiguousarray(rows.T).sum(axis=1)


def length(legs: Chain, a: float | Floats, alpha: Floats) -> Floats:
    """Return the length L(alpha) of each word, shape (N,)."""
    half = half_turns(legs, alpha)
    return add_up(2 * a * np.cos(alpha) + legs.lift * np.sin(alpha) + 2 * legs.k * np.sin(half))


def summation_rounding(m: int) -> float:
    """Bound the relative rounding error of NumPy's sum over m contiguous positive terms.

    NumPy adds each block of up to 128 terms in 8 partial sums: at most 15 additions each, 3 to combine them,
    and up to 7 for leftover terms. It then adds the blocks in pairs. A term thus passes through at most
    19 + log2(m) additions.
    """
    return min(m, 20 + math.log2(m)) * EPSILON / 2


@dataclass(frozen=True, eq=False)
class Derivatives(Batch):
    """First and second derivatives of L at given directions, all of shape (m, N)."""

    gradient: Floats  # dL/dalpha: how far the ends of the leg miss each other, measured across it
    own_term: Floats  # the leg's own term of the gradient; also dD/dalpha
    between_centres: (
        Floats  # D, minus the second derivative of the leg's term: its part between the centres' feet
    )
    stiffness: Floats  # sin(psi/2k) / 2k, minus the second derivative of its term in alpha_in + alpha_out


def derivatives(legs: Chain, a: float | Floats, alpha: Floats) -> Derivatives:
    """Return the derivatives of L at the directions alpha, shape (m, N)."""
    half = half_turns(legs, alpha)
    across, along = np.sin(alpha), np.cos(alpha)
    pull = -legs.d * np.cos(half)
    lean = legs.lift * along - 2 * a * across
    gradient = lean + pull + legs.parity * following(pull)
    beyond = 2 * a * along + legs.lift * across
    return Derivatives(gradient, lean, beyond, np.sin(half) / (2 * legs.k))


def pressed_directions(alpha: Floats, slopes: Derivatives, limits: tuple[Floats, Floats]) -> Marks:
    """Tell which directions are at a limit and pushed against it by the gradient, shape (m, N)."""
    low, high = limits
    return ((alpha <= low) & (slopes.gradient < 0)) | ((alpha >= high) & (slopes.gradient > 0))


def gradient_rounding(legs: Chain, a: float | Floats, alpha: Floats) -> Floats:
    """Bound the rounding errors of the gradient and of its part `own_term` in doubles, shape (m, N).

    In units of eps, a term of a leg is off by 1 from its sine or cosine, 1/2 from a product, and 1/2 from
    each of the three sums that it passes through. psi is accurate to 5.3 (pi, a sum of size pi, and one of
    size 2pi), and the quotient psi/2k adds 1.6/k, so each pull is accurate to 1 + 4.3/k. The sums add 1.5 for
    both pulls.
    """
    terms = 2 * a * np.abs(np.sin(alpha)) + 2 * legs.n * np.cos(alpha)
    run = 2 + 2 * np.pi / legs.k
    return ABOVE * EPSILON * (3 * terms + run + following(run))


def end_angles(legs: Chain, alpha: Floats) -> tuple[Floats, Floats]:
    """Return the angles of the first and of the last bounce of each run, each of shape (m, N)."""
    middle = (preceding(legs.parity * alpha) - alpha) / 2
    spread = legs.d * half_turns(legs, alpha) * (legs.k - 1)
    return middle - spread, middle + spread


def slacks(legs: Chain, alpha: Floats) -> Floats:
    """Return how far inside its wall or semicircle each end of a run or leg is (radians), shape (4, m, N).

    For each run, the slacks are pi/2 - |t| of its first and of its last bounce. For each leg, they are
    pi/2 - s t - 2 |alpha| at its start and the same expression at its end with the leg reversed, where t is
    the angle of the adjacent bounce on the semicircle. This is the angle from the joint to the bounce that
    would follow if the semicircle were a full circle. A slack that does not exist is infinite: both slacks of
    a leg without walls, and that of the last bounce of a run with only one. All slacks of an orbit are
    positive; a path through a joint has a slack of zero.
    """
    low, high, later, latest, ahead, back = smooth_slacks(legs, alpha)
    return np.stack([np.minimum(low, high), np.minimum(later, latest), ahead, back])


def smooth_slacks(legs: Chain, alpha: Floats) -> Floats:
    """Return the slacks without absolute values, and so linear in the directions, shape (6, m, N).

    For each run, they are pi/2 - t and pi/2 + t for its first bounce, then for its last. For each leg, they
    are pi/2 - 2 s alpha - s t at its start and the same expression at its end with the leg reversed, with t
    as in `slacks`. All are positive if and only if all `slacks` are. A slack that does not exist is infinite.
    """
    return _six(legs, HALF_PI, alpha, *end_angles(legs, alpha), np.inf)


def slack_changes(legs: Chain, change: Floats) -> Floats:
    """Return the change of the smooth slacks, shape (6, m, N), for a given change of the directions.

    The change of a slack that does not exist is zero.
    """
    arriving = preceding(legs.parity * change)
    middle = (arriving - change) / 2
    spread = -(arriving + change) * (legs.k - 1) / (2 * legs.k)
    return _six(legs, 0.0, change, middle - spread, middle + spread, 0.0)


def _six(legs: Chain, base: float, alpha: Floats, first: Floats, last: Floats, none: float) -> Floats:
    several, walled = legs.k > 1, legs.n > 0
    steep = base - 2 * legs.s * alpha
    return np.stack([
        base - first,
        base + first,
        np.where(several, base - last, none),
        np.where(several, base + last, none),
        np.where(walled, steep - legs.s * last, none),
        np.where(walled, steep + legs.s * legs.parity * following(first), none),
    ])  # fmt: skip


def slack_errors(legs: Chain, alpha_error: Floats) -> Floats:
    """Bound the errors of `slacks`, given the errors of the directions, shape (m, N).

    If the two directions beside a run change, the angle at each end of the run changes by 1/2k of one change
    and 1 - 1/2k of the other. The rounding, in units of eps, is as follows: psi is accurate to 5.3, and
    (k - 1)/k of half of it enters the angle at an end; a quotient and a product add 1.6 (k - 1)/k each, and
    two sums 2.4; pi/2 and the sums of a slack add at most 3.5. `allowed` also covers the rounding of the
    bounces between the ends, 4 + 17.4 (k - 1)/k, and of the angles whose heights `coordinates` computes,
    5.1 + 5.8 (k - 1)/k.
    """
    incoming = preceding(alpha_error)
    near, far = 1 / (2 * legs.k), 1 - 1 / (2 * legs.k)
    allowed = EPSILON * (26 - 18 / legs.k)
    first = far * incoming + near * alpha_error + allowed
    last = near * incoming + far * alpha_error + allowed
    tilt = 2 * alpha_error
    return ABOVE * np.stack([first, last, last + tilt, following(first) + tilt])


def margin_distances(legs: Chain, alpha: Floats, slack: Floats) -> Floats:
    """Return the slacks in coordinate units, shape (4, m, N): radians on a semicircle, x on a wall.

    The distance from the joint to the first bounce of a leg is 2 cos(pi/4 + s t/2) sin(slack/2) / sin|alpha|,
    with t as in `slacks`.
    """
    first, last = end_angles(legs, alpha)
    ahead = -legs.s * legs.parity * following(first)
    walled = legs.n > 0
    rise = np.where(walled, np.abs(np.sin(alpha)), 1.0)
    margin = slack.copy()
    for end, t in zip(margin[2:], (legs.s * last, ahead), strict=True):
        width = 2 * np.cos(HALF_PI / 2 + t / 2) / rise
        end[...] = np.where(walled, width * np.sin(np.where(walled, end, 0.0) / 2), np.inf)
    return margin


def coordinates(legs: Legs, a: float, alpha: Floats) -> Floats:
    """Return the coordinates of all bounces in the order of the words, shape (N, p).

    For an unfolded leg, `rise` and `fall` are the vertical distances of its start and of its end from its
    first wall. They are computed from 2 sin^2(pi/4 - t/2), with t measured towards the wall at that end,
    because the difference 1 - sin t would lose digits.
    """
    m, n_words = legs.k.shape
    first, last = end_angles(legs, alpha)
    ahead = following(first)
    rise = 2 * np.sin(HALF_PI / 2 - legs.s * last / 2) ** 2
    fall = 2 * np.sin(HALF_PI / 2 + legs.s * legs.parity * ahead / 2) ** 2 + 2 * (legs.n - 1)
    near, far = a + np.cos(last), a + np.cos(ahead)
    side = (1.0 - 2.0 * (np.arange(m)[:, None] % 2)) / np.where(legs.n > 0, rise + fall, 1.0)
    table = np.concatenate([first, side * (rise * far - fall * near)])
    steps = np.concatenate([2 * legs.d * half_turns(legs, alpha), side * 2 * (near + far)])
    run, place, straight = legs.bounces
    entry = (run + m * straight) * n_words + np.arange(n_words)
    found: Floats = (table.ravel()[entry] + place * steps.ravel()[entry]).T
    return np.ascontiguousarray(found)
