"""Births and deaths: the values of a at which words begin and cease to be orbits.

Two things are proved: that a word changes inside its bracket (`orbitdb.orbits.births.brackets`), and whether
it is an orbit at the smallest possible a and at the lowest and highest a of the grid. It is only numerical
that there are no further pairs of changes between two points of the grid, below the smallest a or above the
highest.
"""

from dataclasses import dataclass, replace

import numpy as np

from orbitdb.arrays import Floats, Integers, Marks, Words
from orbitdb.billiard.legs import Chain, centre_directions, cut, direction_limits
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.equality import ByValue
from orbitdb.errors import WorkError
from orbitdb.orbits.births.brackets import Bracketed, Signs, bracket, signs
from orbitdb.orbits.births.continuation import follow
from orbitdb.orbits.births.crossings import candidates, refine
from orbitdb.orbits.newton import newton
from orbitdb.symbols.words import to_strings

Stretch = tuple[float, float | None]

JOINTS = ("bottom left", "bottom right", "top left", "top right")
"""The points at which a straight wall and a semicircle meet."""

LOW = 1e-3
"""Lowest a of the grid; below it, doubles show spurious zeros, because some slacks behave like a^5."""
_HIGH, _HIGH_A_SQUARE = 60.0, 0.2
"""The grid ends at the larger of 60 and 0.2 p^2; the largest birth of period p is near 0.13 p^2."""
_CELL = 0.275
"""Step of the grid in ln a."""
FINER = (1, 4, 16)
"""Refinement factors of the grid, tried in this order."""
_NONE = Bracketed(*(np.zeros(0, kind) for kind in (int, float, float, bool, int, float)))
_BATCH = 1 << 14
"""Number of words followed at once: fewer take almost as long, and more do not fit into the cache."""


@dataclass(frozen=True, eq=False)
class Changes(ByValue):
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
    found = Bracketed.joined([_NONE, *parts])
    found = found.rows(np.lexsort((found.a, found.word)))
    places = joints(words[found.word], found.slack)
    return Changes(least, found.word, found.a, found.error, found.born, *places, found.slope)


def _signs(words: Words, legs: Chain, a: float, start: Floats) -> tuple[Signs, Floats]:
    """Tell which words are orbits at a given a; also return their directions, found from nearby ones."""
    alpha = newton(legs, a, start=np.clip(start, *direction_limits(legs, a))).alpha
    return signs(words, legs, np.full(len(words), a), alpha), alpha


def joints(words: Words, slack: Integers) -> tuple[Integers, Integers]:
    """Return the bounce, counted from 1, and the joint that a smooth slack of each word belongs to.

    `slack`, shape (N,), contains the row of each slack in `orbitdb.orbits.births.continuation.Station.slack`.
    """
    bounce, joint = np.zeros((2, len(words)), np.int64)
    for rows, legs in cut(words):
        kind, i = np.divmod(slack[rows], len(legs.k))
        own = i, np.arange(len(rows))
        k, n, s, parity = (part[own] for part in (legs.k, legs.n, legs.s, legs.parity))
        on_wall, at_end = kind >= 4, np.isin(kind, (2, 3, 5))
        place = np.where(at_end, np.where(on_wall, n, k) - 1, 0)
        run, places, straight = legs.bounces
        here = (run == i) & (places == place) & (straight == on_wall)
        bounce[rows] = here.argmax(axis=0) + 1
        top = np.where(on_wall, np.where(at_end, -s * parity, s) > 0, kind % 2 == 0)
        joint[rows] = 2 * top + (i + (kind == 5)) % 2
    return bounce, joint


def _search(words: Words, always: Marks, foot: Floats, high: float, rows: Integers, level: int) -> Bracketed:
    """Return the changes of the given words; repeat those whose changes are inconsistent on a finer grid."""
    if level == len(FINER):
        word = to_strings(words[rows[:1]])[0]
        raise WorkError(f"the births and deaths of {word} cannot be separated: please report this word")
    found = []
    for low in (LOW, MIN_A):
        here = rows[foot[rows] == low]
        cells = int(np.ceil(FINER[level] * np.log(high / low) / _CELL))
        grid = np.linspace(np.log(high), np.log(low), cells + 1)
        for places, legs in cut(words[here]):
            own = here[places]
            part = bracket(words[own], legs, refine(legs, candidates(legs, follow(legs, grid))))
            found.append(replace(part, word=own[part.word]))
    changes = _merged(Bracketed.joined([_NONE, *found]))
    odd = _inconsistent(changes, always)
    missing = rows[~always[rows] & ~np.isin(rows, changes.word)]
    again = np.union1d(odd, missing)
    if not len(again):
        return changes
    sound = changes.rows(~np.isin(changes.word, again))
    return Bracketed.joined([sound, _search(words, always, foot, high, again, level + 1)])


def _merged(found: Bracketed) -> Bracketed:
    """Merge changes of the same word and kind whose brackets overlap, keeping the narrowest bracket."""
    order = np.lexsort((found.a, found.word))
    found = found.rows(order)
    low, high = found.a - found.error, found.a + found.error
    fresh = np.ones(len(found.a), dtype=bool)
    fresh[1:] = (found.word[1:] != found.word[:-1]) | (low[1:] > high[:-1])
    fresh[1:] |= found.born[1:] != found.born[:-1]
    group = fresh.cumsum()
    narrow = np.lexsort((found.error, group))
    _, first = np.unique(group[narrow], return_index=True)
    return found.rows(narrow[first])


def _inconsistent(found: Bracketed, always: Marks) -> Integers:
    """Return the words whose changes do not alternate, or after whose last change they are not orbits."""
    word, born = found.word, found.born
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
