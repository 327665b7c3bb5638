"""Births and deaths: the values of a at which words begin and cease to be orbits.

What is proved, and what is not. That a word changes inside its bracket, and what it is at both of the
bracket's ends, is proved (`orbitdb.orbits.brackets`). So is what it is at the lowest and the highest a of
the grid and at the smallest a there is; between all these the changes of a word follow one another as
births and deaths do, or it is searched again on finer grids. That there is no further pair of changes
between two points of the grid, none below the smallest a, and none above the highest is numerical.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Legs, cut
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.equality import ByValue
from orbitdb.errors import WorkError
from orbitdb.orbits.brackets import Bracketed, bracket, signs_at
from orbitdb.orbits.continuation import follow
from orbitdb.orbits.crossings import Zeros, candidates, refine
from orbitdb.symbols.words import to_strings

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Flags = NDArray[np.bool_]

Life = tuple[float, float | None]

LOW = 1e-3
"""Below, doubles show zeros that are none: some slacks go like a^5."""
_HIGH, _HIGH_A_SQUARE = 60.0, 0.2
"""The largest birth of order p is near 0.13 p^2."""
_CELL = 0.275
"""Of the grid, in ln a."""
_FINER = (1, 4, 16)
_BATCH = 8192
"""Words that are followed at once: their arrays stay in the processor's cache."""

JOINTS = ("bottom left", "bottom right", "top left", "top right")
"""Where a straight wall and a semicircle meet."""


@dataclass(frozen=True, eq=False)
class Changes(ByValue):
    """Births and deaths of N words, K in all, as a structure of arrays, by word and rising a.

    Attributes
    ----------
    always : ndarray of bool, shape (N,)
        Whether the word is an orbit from a = 0 on.
    word : ndarray of int, shape (K,)
        Which word changes.
    a, error : ndarray, shape (K,)
        Where, and how far from there it may be, proved.
    born : ndarray of bool, shape (K,)
        Whether it begins to be an orbit as a grows, or ceases to be one.
    bounce : ndarray of int, shape (K,)
        The bounce of the word, counted from 1, that comes through a joint; where several do at once,
        one of them.
    joint : ndarray of int, shape (K,)
        The joint, as a place in `JOINTS`.
    slope : ndarray, shape (K,)
        How fast that bounce leaves the joint: d slack / d ln a (radians).
    """

    always: Flags
    word: Integers
    a: Floats
    error: Floats
    born: Flags
    bounce: Integers
    joint: Integers
    slope: Floats

    def lives(self) -> list[list[Life]]:
        """Return for each word from where to where in a it is an orbit; None where that has no end."""
        births: list[list[float]] = [[0.0] if always else [] for always in self.always.tolist()]
        deaths: list[list[float | None]] = [[] for _ in births]
        for word, a, born in zip(self.word.tolist(), self.a.tolist(), self.born.tolist(), strict=True):
            (births if born else deaths)[word].append(a)
        return [list(zip(low, [*high, None], strict=True)) for low, high in zip(births, deaths, strict=True)]


def find_changes(words: NDArray[np.uint8]) -> Changes:
    """Find where words begin and cease to be orbits, from a = 0 to where all of them are.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible primitive words of one order, in any rotation.

    Raises
    ------
    WorkError
        If births and deaths of a word do not follow one another on the finest grid either.
    """
    always = signs_at(words, MIN_A) > 0
    parts = [_search(words, always, np.arange(i, min(i + _BATCH, len(words))), 0)
             for i in range(0, len(words), _BATCH)]  # fmt: skip
    joined = _join(parts)
    order = np.lexsort((joined.a, joined.word))
    return Changes(always, **{name: getattr(joined, name)[order] for name in _COLUMNS})


@dataclass(frozen=True, eq=False)
class _Found(ByValue):
    """The columns of `Changes` that have one entry a change."""

    word: Integers
    a: Floats
    error: Floats
    born: Flags
    bounce: Integers
    joint: Integers
    slope: Floats

    def rows(self, chosen: Flags | Integers) -> "_Found":
        return _Found(**{name: getattr(self, name)[chosen] for name in _COLUMNS})


_COLUMNS = tuple(each.name for each in fields(_Found))


def _join(parts: list[_Found]) -> _Found:
    none = _Found(*(np.zeros(0, kind) for kind in (int, float, float, bool, int, int, float)))
    return _Found(*(np.concatenate([getattr(part, name) for part in [none, *parts]]) for name in _COLUMNS))


def _search(words: NDArray[np.uint8], always: Flags, rows: Integers, level: int) -> _Found:
    """Return the changes of some words; those whose changes make no sense are searched on a finer grid."""
    if level == len(_FINER):
        word = to_strings(words[rows[:1]])[0]
        raise WorkError(f"the births and deaths of {word} cannot be told apart: please report this word")
    chosen = words[rows]
    high = _highest(chosen)
    early = (signs_at(chosen, LOW) > 0) != always[rows]
    bottom = np.where(early, MIN_A, LOW)
    found = []
    for low in np.unique(bottom):
        here = rows[bottom == low]
        cells = int(np.ceil(_FINER[level] * np.log(high / low) / _CELL))
        found += list(_changes(words, here, np.linspace(np.log(high), np.log(low), cells + 1)))
    changes = _merged(_join(found))
    odd = _inconsistent(changes, always)
    odd = odd[np.isin(odd, rows)] if len(odd) else odd
    missing = rows[~always[rows] & ~np.isin(rows, changes.word)]
    again = np.union1d(odd, missing)
    if not len(again):
        return changes
    sound = changes.rows(~np.isin(changes.word, again))
    return _join([sound, _search(words, always, again, level + 1)])


def _highest(words: NDArray[np.uint8]) -> float:
    """Return an a at which all words are orbits."""
    high = max(_HIGH, _HIGH_A_SQUARE * words.shape[1] ** 2)
    while high < MAX_A and (signs_at(words, high) < 1).any():
        high *= 2
    return high


def _changes(words: NDArray[np.uint8], rows: Integers, grid: Floats) -> Iterator[_Found]:
    """Yield the bracketed changes of some words, group by group, several for one where slacks coincide."""
    chosen = words[rows]
    for places, legs in cut(chosen):
        zeros = refine(legs, candidates(legs, follow(legs, grid)))
        proved = bracket(chosen[places], legs, zeros)
        real = np.flatnonzero(proved.before * proved.after == -1)
        yield _described(rows[places], legs, zeros, proved).rows(real)


def _described(rows: Integers, legs: Legs, zeros: Zeros, proved: Bracketed) -> _Found:
    bounce, joint = _places(legs, zeros)
    error = np.maximum(proved.high - proved.a, proved.a - proved.low)
    return _Found(rows[zeros.word], proved.a, error, proved.after > 0, bounce, joint, proved.slope)


def _places(legs: Legs, zeros: Zeros) -> tuple[Integers, Integers]:
    """Return the bounce, counted from 1, and the joint that each zero is about."""
    m = len(legs.k)
    kind, i = np.divmod(zeros.slack, m)
    k, n, s, parity = (part[i, zeros.word] for part in (legs.k, legs.n, legs.s, legs.parity))
    on_wall, at_end = kind >= 4, np.isin(kind, (2, 3, 5))
    place = np.where(at_end, np.where(on_wall, n, k) - 1, 0)
    run, places, straight = (part[:, zeros.word] for part in (legs.run, legs.place, legs.straight))
    bounce = ((run == i) & (places == place) & (straight == on_wall)).argmax(axis=0) + 1
    right = (i + (kind == 5)) % 2 == 1
    top = np.where(on_wall, np.where(at_end, -s * parity, s) > 0, kind % 2 == 0)
    return bounce, 2 * top + right


def _merged(found: _Found) -> _Found:
    """Return one change where the brackets of several slacks of a word overlap, that of the narrowest."""
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


def _inconsistent(found: _Found, always: Flags) -> Integers:
    """Return the words whose changes do not take turns, or do not end with a life."""
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
    """Number the events among changes: those whose brackets touch one another share one, from 1 by rising a.

    Parameters
    ----------
    a, error : ndarray, shape (K,)
        Changes of words of one order, in any order.

    Returns
    -------
    ndarray of int, shape (K,)
    """
    order = np.argsort(a, kind="stable")
    reach = np.maximum.accumulate((a + error)[order])
    fresh = np.ones(len(a), dtype=bool)
    fresh[1:] = (a - error)[order][1:] > reach[:-1]
    number = np.empty(len(a), dtype=np.int64)
    number[order] = fresh.cumsum()
    return number
