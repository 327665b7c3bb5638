"""Births and deaths: the values of a at which words begin and cease to be orbits.

Two things are proved: that a word changes inside its bracket, and whether it is an orbit at the smallest
possible a and at the lowest and highest a of the grid. It is only numerical that there are no further pairs
of changes between two points of the grid, below the smallest a or above the highest.

At both ends of a bracket, error bounds decide whether the word is an orbit. The slacks are continuous in a,
so the change lies in the bracket, however it was found. If rounding hides the status at one end, the bracket
is widened; if this does not help, the status is decided in ball arithmetic.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Batch, Floats, Indices, Integers, Marks, Words
from orbitdb.billiard.legs import Chain, centre_directions, cut, derivatives, direction_limits, slack_errors
from orbitdb.billiard.stadium import MAX_A, MIN_A, Stadium
from orbitdb.errors import InputError, WorkError, check_number
from orbitdb.orbits.admissible import certificates
from orbitdb.orbits.along_a import Zeros, candidates, follow_in_a, motion, refine, slacks_and_slopes
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.newton import newton
from orbitdb.orbits.status import Status, decide
from orbitdb.symbols.words import to_strings

Signs = NDArray[np.int8]

_WIDER = 4.0
_NARROWEST = 2.0**-51
_WIDEST = 1e-11
"""Relative width above which brackets are not widened but decided in ball arithmetic."""
_SAFETY = 1.05
_POLISH = 1e-9
"""Largest step in ln a when a converged zero is polished."""

_SIGNS = {Status.ORBIT: 1, Status.DYNAMICAL: -1}


@dataclass(frozen=True, eq=False)
class Bracketed(Batch):
    """K proved changes of words, stored as arrays of shape (K,)."""

    word: Indices  # the index of the word that changes
    a: Floats  # the value of a at which it changes
    error: Floats  # proved bound on the error of a
    born: Marks  # True if it begins to be an orbit as a increases, False if it ceases
    slack: Indices  # the smooth slack that changes sign (`orbitdb.orbits.along_a.Zeros`)
    slope: Floats  # derivative of this slack with respect to ln a (radians)


def bracket(words: Words, legs: Chain, zeros: Zeros) -> Bracketed:
    """Bracket zeros of slacks in a; keep those at which the words, shape (N, p), are proved to change."""
    part = legs.chain(zeros.word)
    zero = _polished(part, zeros)
    (low, before), (high, after) = _widened(part, zero, _half_widths(part, zero))
    for side, ends in ((before, low), (after, high)):
        unknown = np.flatnonzero(side == 0)
        if len(unknown):
            side[unknown] = proved_signs(words[zeros.word[unknown]], ends[unknown])
    error = np.maximum(high - zero.a, zero.a - low)
    changes = Bracketed(zeros.word, zero.a, error, after > 0, zeros.slack, zero.slope)
    return changes.rows(np.flatnonzero(before * after == -1))


class _Polished(NamedTuple):
    """K zeros of slacks, as close as doubles allow."""

    a: Floats  # shape (K,)
    alpha: Floats  # the directions there, shape (m, K)
    velocity: Floats  # d alpha / d ln a, shape (m, K)
    slack: Floats  # what is left of the slack, shape (K,)
    slope: Floats  # its derivative in ln a, shape (K,)

    def beside(self, rows: Indices, way: Floats) -> tuple[Floats, Floats]:
        """Return half lengths beside some zeros, off by a factor of 1 + `way`, and directions there."""
        return self.a[rows] * (1 + way), self.alpha.take(rows, axis=1) + way * self.velocity.take(
            rows, axis=1
        )


def _polished(part: Chain, zeros: Zeros) -> _Polished:
    """Improve zeros by Newton's method in the directions and in a."""
    own = zeros.slack, np.arange(len(zeros))
    a, alpha = np.exp(zeros.x), zeros.alpha
    for _ in range(2):  # once to get as close to the zero as doubles allow, and again there
        step, velocity = motion(part, a, alpha, direction_limits(part, a))
        alpha = alpha + step
        slack, slopes = slacks_and_slopes(part, alpha, velocity)
        with np.errstate(divide="ignore", invalid="ignore"):
            shift = np.nan_to_num(-slack[own] / slopes[own], posinf=0.0, neginf=0.0)
        shift = np.clip(shift, -_POLISH, _POLISH)
        a, alpha = a * (1 + shift), alpha + shift * velocity
    slack, _ = slacks_and_slopes(part, alpha, velocity)
    return _Polished(a, alpha, velocity, slack[own], slopes[own])


def _half_widths(part: Chain, zero: _Polished) -> Floats:
    """Return half the relative widths of brackets at whose ends doubles should decide the status."""
    alpha_error = direction_errors(part, zero.a, zero.alpha, derivatives(part, zero.a, zero.alpha))
    error = slack_errors(part, alpha_error).max(axis=(0, 1))
    with np.errstate(divide="ignore"):
        delta = _SAFETY * (np.abs(zero.slack) + 2 * error) / np.abs(zero.slope)
    return np.clip(delta, _NARROWEST, _WIDEST)


def _widened(part: Chain, zero: _Polished, delta: Floats) -> tuple[tuple[Floats, Signs], ...]:
    """Widen brackets until doubles decide the status at both ends, or they are as wide as `_WIDEST`.

    Returns the lower and the upper ends, each with the `statuses` there.
    """
    ends = [(zero.a * (1 + way * delta), np.zeros(len(delta), np.int8)) for way in (-1, 1)]
    rows = np.arange(len(delta))
    while len(rows):
        chains = part.chain(rows)
        for way, (a, sign) in zip((-1, 1), ends, strict=True):
            a[rows], alpha = zero.beside(rows, way * delta[rows])
            sign[rows] = statuses(chains, a[rows], alpha)
        unclear = ends[0][1][rows] * ends[1][1][rows] == 0
        rows = rows[unclear & (delta[rows] < _WIDEST)]
        delta[rows] = np.minimum(_WIDER * delta[rows], _WIDEST)
    return tuple(ends)


def statuses(legs: Chain, a: Floats, alpha: Floats) -> Signs:
    """Return 1 for each word that is an orbit at its own a, -1 if it is not, 0 if doubles cannot decide.

    The half lengths a have shape (N,). The directions alpha, shape (m, N), are near the maximum; the verdicts
    do not depend on them.
    """
    limits = direction_limits(legs, a)
    alpha = np.clip(alpha, *limits)
    alpha = np.clip(alpha + motion(legs, a, alpha, limits)[0], *limits)
    status = decide(legs, a, alpha).status
    return (status == Status.ORBIT).astype(np.int8) - (status == Status.DYNAMICAL).astype(np.int8)


def signs(words: Words, legs: Chain, a: Floats, alpha: Floats) -> Signs:
    """Return the same as `statuses`, but decide in ball arithmetic where doubles cannot."""
    sign = statuses(legs, a, alpha)
    unknown = np.flatnonzero(sign == 0)
    if len(unknown):
        sign[unknown] = proved_signs(words[unknown], a[unknown])
    return sign


def proved_signs(words: Words, a: Floats) -> Signs:
    """Decide in ball arithmetic which words are orbits, each at its own a, shape (N,).

    Return 1 for an orbit and -1 if the word is not one; 0 for an orbit exactly through a joint, or if
    undecided.
    """
    sign = np.zeros(len(words), np.int8)
    for at in np.unique(a).tolist():
        same = np.flatnonzero(a == at)
        sign[same] = [_SIGNS.get(ball.status, 0) for ball in certificates(words[same], Stadium(at))]
    return sign


Stretch = tuple[float, float | None]

JOINTS = ("bottom left", "bottom right", "top left", "top right")
"""The points at which a straight wall and a semicircle meet."""

LOW = 1e-3
"""Lowest a of the grid; below it, doubles show spurious zeros, because some slacks behave like a^5."""
_HIGH, _HIGH_A_SQUARE = 60.0, 0.2
"""The grid ends at the larger of 60 and 0.2 p^2; the largest a at which a word of period 30 is born is
0.148 p^2."""
_CELL = 0.275
"""Step of the grid in ln a."""
FINER = (1, 4, 16)
"""Refinement factors of the grid, tried in this order."""
_NONE = Bracketed(*(np.zeros(0, kind) for kind in (int, float, float, bool, int, float)))
_BATCH = 1 << 14
"""Number of words followed at once: fewer take almost as long, and more do not fit into the cache."""


@dataclass(frozen=True, eq=False)
class Changes:
    """Births and deaths of N words, K in total, as a structure of arrays sorted by word and ascending a."""

    always: Marks  # whether the word is an orbit from a = 0 on, shape (N,)
    word: Integers  # the index of the word that changes, shape (K,)
    a: Floats  # the value of a at which it changes, shape (K,)
    error: Floats  # proved bound on the error of this a, shape (K,)
    born: Marks  # True if it begins to be an orbit as a increases, False if it ceases, shape (K,)
    bounce: Integers  # number, from 1, of a bounce that then passes through a joint, shape (K,)
    joint: Integers  # index of the joint in `JOINTS`, shape (K,)
    slope: Floats  # speed of this bounce at the joint: d slack / d ln a (radians), shape (K,)

    def lives(self) -> list[list[Stretch]]:
        """Return the ranges of a in which each word is an orbit; the end is None if a range has no end."""
        births: list[list[float]] = [[0.0] if always else [] for always in self.always.tolist()]
        deaths: list[list[float | None]] = [[] for _ in births]
        for word, a, born in zip(self.word.tolist(), self.a.tolist(), self.born.tolist(), strict=True):
            (births if born else deaths)[word].append(a)
        return [list(zip(low, [*high, None], strict=True)) for low, high in zip(births, deaths, strict=True)]


def find_changes(words: Words) -> Changes:
    """Find where words begin and cease to be orbits, from a = 0 up to where all of them are orbits.

    The words, shape (N, p), are admissible and primitive and have the same period; any rotation will do.

    Raises
    ------
    WorkError
        If the births and deaths of a word do not alternate even on the finest grid.
    """
    least, low = np.zeros((2, len(words)), dtype=bool)
    high = max(_HIGH, _HIGH_A_SQUARE * words.shape[1] ** 2)
    for rows, legs in cut(words):
        own, alpha = words[rows], centre_directions(legs, LOW)
        for alive, a in ((low, LOW), (least, MIN_A)):
            sign, alpha = _signs(own, legs, a, alpha)
            alive[rows] = sign > 0
        while high < MAX_A and (_signs(own, legs, high, centre_directions(legs, high))[0] < 1).any():
            high *= 2
    foot = np.where(low != least, MIN_A, LOW)
    rows = np.arange(len(words))
    parts = [
        _search(words, least, foot, high, part, 0)
        for part in np.split(rows, range(_BATCH, len(rows), _BATCH))
    ]
    changes = Bracketed.joined([_NONE, *parts])
    changes = changes.rows(np.lexsort((changes.a, changes.word)))
    places = joints(words[changes.word], changes.slack)
    return Changes(least, changes.word, changes.a, changes.error, changes.born, *places, changes.slope)


def _signs(words: Words, legs: Chain, a: float, start: Floats) -> tuple[Signs, Floats]:
    """Tell which words are orbits at a given a; also return their directions, found from nearby ones."""
    alpha = newton(legs, a, start=np.clip(start, *direction_limits(legs, a))).alpha
    return signs(words, legs, np.full(len(words), a), alpha), alpha


def joints(words: Words, slack: Integers) -> tuple[Integers, Integers]:
    """Return the bounce, counted from 1, and the joint that a smooth slack of each word belongs to.

    `slack`, shape (N,), contains the row of each slack in `orbitdb.orbits.along_a.Station.slack`.
    """
    bounce, joint = np.zeros((2, len(words)), np.int64)
    for rows, legs in cut(words):
        kind, i = np.divmod(slack[rows], len(legs.k))
        own = i, np.arange(len(rows))
        k, n, s, parity = (part[own] for part in (legs.k, legs.n, legs.s, legs.parity))
        on_wall, at_end = kind >= 4, np.isin(kind, (2, 3, 5))
        place = np.where(at_end, np.where(on_wall, n, k) - 1, 0)
        run, places, straight = legs.bounces
        at_joint = (run == i) & (places == place) & (straight == on_wall)
        bounce[rows] = at_joint.argmax(axis=0) + 1
        top = np.where(on_wall, np.where(at_end, -s * parity, s) > 0, kind % 2 == 0)
        joint[rows] = 2 * top + (i + (kind == 5)) % 2
    return bounce, joint


def _search(words: Words, always: Marks, foot: Floats, high: float, rows: Integers, level: int) -> Bracketed:
    """Return the changes of the given words; repeat those whose changes are inconsistent on a finer grid."""
    if level == len(FINER):
        word = to_strings(words[rows[:1]])[0]
        raise WorkError(f"the births and deaths of {word} cannot be separated: please report this word")
    parts = []
    for low in (LOW, MIN_A):
        from_low = rows[foot[rows] == low]
        cells = int(np.ceil(FINER[level] * np.log(high / low) / _CELL))
        grid = np.linspace(np.log(high), np.log(low), cells + 1)
        for places, legs in cut(words[from_low]):
            own = from_low[places]
            part = bracket(words[own], legs, refine(legs, candidates(legs, follow_in_a(legs, grid))))
            parts.append(replace(part, word=own[part.word]))
    changes = _merged(Bracketed.joined([_NONE, *parts]))
    odd = _inconsistent(changes, always)
    missing = rows[~always[rows] & ~np.isin(rows, changes.word)]
    again = np.union1d(odd, missing)
    if not len(again):
        return changes
    sound = changes.rows(~np.isin(changes.word, again))
    return Bracketed.joined([sound, _search(words, always, foot, high, again, level + 1)])


def _merged(changes: Bracketed) -> Bracketed:
    """Merge changes of the same word and kind whose brackets overlap, keeping the narrowest bracket."""
    order = np.lexsort((changes.a, changes.word))
    changes = changes.rows(order)
    low, high = changes.a - changes.error, changes.a + changes.error
    fresh = np.ones(len(changes.a), dtype=bool)
    fresh[1:] = (changes.word[1:] != changes.word[:-1]) | (low[1:] > high[:-1])
    fresh[1:] |= changes.born[1:] != changes.born[:-1]
    group = fresh.cumsum()
    narrow = np.lexsort((changes.error, group))
    _, first = np.unique(group[narrow], return_index=True)
    return changes.rows(narrow[first])


def _inconsistent(changes: Bracketed, always: Marks) -> Integers:
    """Return the words whose changes do not alternate, or after whose last change they are not orbits."""
    word, born = changes.word, changes.born
    before = np.empty_like(born)
    before[1:] = born[:-1]
    fresh = np.ones(len(word), dtype=bool)
    fresh[1:] = word[1:] != word[:-1]
    before[fresh] = always[word[fresh]]
    last = np.ones(len(word), dtype=bool)
    last[:-1] = fresh[1:]
    return np.unique(word[(born == before) | (last & ~born)])


def events(a: Floats, error: Floats) -> Integers:
    """Number the events among changes of words of the same period, shape (K,), from 1 by ascending a.

    Changes whose brackets touch belong to the same event. The changes may be in any order.
    """
    order = np.argsort(a, kind="stable")
    reach = np.maximum.accumulate((a + error)[order])
    fresh = np.ones(len(a), dtype=bool)
    fresh[1:] = (a - error)[order][1:] > reach[:-1]
    number = np.empty(len(a), dtype=np.int64)
    number[order] = fresh.cumsum()
    return number


# births in closed form


_RELATIVE = 1e-12
"""Relative accuracy that a birth must have before a closed form is sought."""
_COEFFICIENTS = 60
"""Largest leading and middle coefficient to try; chance hits are then rarer than one in 10^5."""
_DENOMINATORS = 200
"""Largest denominator to try for a rational square."""


def closed_form(a: float) -> str | None:
    """Return `a` as a rational number, the square root of one, or a root of a quadratic; None if none fits.

    Parameters
    ----------
    a : float
        A positive number with a relative error of at most 1e-12, such as the birth or death of an orbit
        (`Catalogue.births`), in units of the radius.

    Returns
    -------
    str or None
        The form in which one types it, such as ``(sqrt(3) - 1)/2``. It is fitted to the digits, not proved.

    Raises
    ------
    InputError
        If `a` is not a positive and finite number.

    Examples
    --------
    >>> closed_form(0.3660254037844386)
    '(sqrt(3) - 1)/2'
    """
    check_number("a", a)
    if not 0 < a < math.inf:
        raise InputError(f"a = {a:g}: give a positive number, such as the birth of an orbit")
    for q in range(1, _DENOMINATORS + 1):
        p = round(a * a * q)
        if p and abs(p / q - a * a) <= 2 * _RELATIVE * a * a:
            return _root(0, 4 * p * q, 2 * q)
    for c2 in range(1, _COEFFICIENTS + 1):
        for c1 in sorted(range(-_COEFFICIENTS, _COEFFICIENTS + 1), key=abs):
            c0 = -round(c2 * a * a + c1 * a)
            size = 2 * c2 * a * a + abs(c1) * a
            if abs(c2 * a * a + c1 * a + c0) <= _RELATIVE * size and abs(c0) <= _COEFFICIENTS * max(1, a * a):
                side = 1 if 2 * c2 * a + c1 > 0 else -1
                return _root(-side * c1, c1 * c1 - 4 * c2 * c0, side * 2 * c2)
    return None


def _root(rational: int, square: int, below: int) -> str:
    """Format (rational + sqrt(square))/below in lowest terms; `below` can have either sign."""
    factor = max(k for k in range(1, math.isqrt(max(square, 1)) + 1) if square % (k * k) == 0)
    square //= factor * factor
    if square == 1:
        rational, factor, square = rational + factor, 0, 0
    sign = 1 if below > 0 else -1
    rational, factor, below = sign * rational, sign * factor, sign * below
    shared = math.gcd(rational, factor, below)
    rational, factor, below = rational // shared, factor // shared, below // shared
    if not factor:
        return f"{rational}" if below == 1 else f"{rational}/{below}"
    surd = f"sqrt({square})" if abs(factor) == 1 else f"{abs(factor)} sqrt({square})"
    if not rational:
        return surd if below == 1 else f"{surd}/{below}"
    above = f"{surd} {'-' if rational < 0 else '+'} {abs(rational)}" if factor > 0 else f"{rational} - {surd}"
    return above if below == 1 else f"({above})/{below}"
