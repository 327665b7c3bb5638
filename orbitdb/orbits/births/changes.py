"""Births and deaths: the values of a at which words begin and cease to be orbits.

What is proved, and what is not. That a word changes inside its bracket, and what it is at both of the
bracket's ends, is proved (`orbitdb.orbits.births.brackets`). So is what it is at the lowest and the highest a
of the grid and at the smallest a there is; between all these the changes of a word follow one another as
births and deaths do, or it is searched again on finer grids. That there is no further pair of changes
between two points of the grid, none below the smallest a, and none above the highest is numerical.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain, direction_limits
from orbitdb.billiard.stadium import MAX_A, MIN_A
from orbitdb.equality import ByValue, Columns
from orbitdb.errors import WorkError
from orbitdb.orbits.births.batches import Batch
from orbitdb.orbits.births.brackets import Signs, bracket
from orbitdb.orbits.births.continuation import follow
from orbitdb.orbits.births.crossings import candidates, refine
from orbitdb.orbits.newton import newton
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
_BATCH = 1 << 14
"""Words that are followed at once: few take almost as long, and of more the arrays leave the cache."""


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
        The joint, as a place in `orbitdb.orbits.births.batches.JOINTS`.
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
        """Return for each word the ranges of a in which it is an orbit; None for no end."""
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
    (found,) = find_changes_together([words])
    return found


def find_changes_together(orders: Sequence[NDArray[np.uint8]]) -> list[Changes]:
    """Find where words of several orders change, as `find_changes` does for those of one.

    Few words take almost as long as thousands: those of small orders are best followed together.

    Parameters
    ----------
    orders : sequence of ndarray of uint8, shape (N_i, p_i) each
    """
    batch = Batch(orders)
    ends = _ends(batch)
    rows = np.arange(len(batch))
    parts = [_search(batch, ends, part, 0) for part in np.split(rows, range(_BATCH, len(rows), _BATCH))]
    joined = _join(parts)
    joined = joined.rows(np.lexsort((joined.a, joined.word)))
    bounce, joint = batch.places(joined.word, joined.slack)
    of_order = np.searchsorted(joined.word, batch.starts)
    found = []
    for low, high, start, end in zip(of_order, of_order[1:], batch.starts, batch.starts[1:], strict=False):
        here = slice(low, high)
        own = joined.rows(here)
        found.append(Changes(ends.always[start:end], own.word - start, own.a, own.error, own.born,
                             bounce[here], joint[here], own.slope))  # fmt: skip
    return found


@dataclass(frozen=True, eq=False)
class _Ends(ByValue):
    """What N words are where the search ends.

    Attributes
    ----------
    always : ndarray of bool, shape (N,)
        Whether the word is an orbit at the smallest a there is.
    early : ndarray of bool, shape (N,)
        Whether it changes between there and `LOW`.
    high : float
        An a at which all words are orbits.
    """

    always: Flags
    early: Flags
    high: float


def _ends(batch: Batch) -> _Ends:
    """Tell what the words of a batch are at the smallest a, at `LOW`, and where all of them are orbits."""
    signs = np.zeros((2, len(batch)), np.int8)
    high = max(_HIGH, _HIGH_A_SQUARE * batch.longest**2)
    for rows, legs in batch.groups(np.arange(len(batch))):
        alpha = None
        for sign, a in zip(signs, (LOW, MIN_A), strict=True):
            sign[rows], alpha = _signs(batch, rows, legs, a, alpha)
        while high < MAX_A and (_signs(batch, rows, legs, high, None)[0] < 1).any():
            high *= 2
    low, least = signs > 0
    return _Ends(least, low != least, high)


def _signs(batch: Batch, rows: Integers, legs: Chain, a: float, start: Floats | None) -> tuple[Signs, Floats]:
    """Tell which words are orbits at one a; return their directions there, too, found from others."""
    if start is not None:
        start = np.clip(start, *direction_limits(legs, a))
    at, alpha = np.full(len(rows), a), newton(legs, a, start=start).alpha
    return batch.signs(rows, legs, at, alpha), alpha


@dataclass(frozen=True, eq=False)
class _Found(Columns):
    """Bracketed changes of the words of a batch, one entry each, and which of their slacks changes sign."""

    word: Integers
    a: Floats
    error: Floats
    born: Flags
    slack: Integers
    slope: Floats


_COLUMNS = tuple(each.name for each in fields(_Found))


def _join(parts: list[_Found]) -> _Found:
    none = _Found(*(np.zeros(0, kind) for kind in (int, float, float, bool, int, float)))
    return _Found(*(np.concatenate([getattr(part, name) for part in [none, *parts]]) for name in _COLUMNS))


def _search(batch: Batch, ends: _Ends, rows: Integers, level: int) -> _Found:
    """Return the changes of some words; those whose changes make no sense are searched on a finer grid."""
    if level == len(_FINER):
        ((_, words),) = batch.of_order(rows[:1])
        word = to_strings(words)[0]
        raise WorkError(f"the births and deaths of {word} cannot be separated: please report this word")
    found = []
    for low, here in ((LOW, rows[~ends.early[rows]]), (MIN_A, rows[ends.early[rows]])):
        cells = int(np.ceil(_FINER[level] * np.log(ends.high / low) / _CELL))
        grid = np.linspace(np.log(ends.high), np.log(low), cells + 1)
        found += list(_changes(batch, here, grid))
    changes = _merged(_join(found))
    odd = _inconsistent(changes, ends.always)
    missing = rows[~ends.always[rows] & ~np.isin(rows, changes.word)]
    again = np.union1d(odd, missing)
    if not len(again):
        return changes
    sound = changes.rows(~np.isin(changes.word, again))
    return _join([sound, _search(batch, ends, again, level + 1)])


def _changes(batch: Batch, rows: Integers, grid: Floats) -> Iterator[_Found]:
    """Yield the bracketed changes of some words, group by group, several for one where slacks coincide."""
    for numbers, legs in batch.groups(rows):
        zeros = refine(legs, candidates(legs, follow(legs, grid)))

        def surely(words: Integers, a: Floats, own: Integers = numbers) -> Signs:
            return batch.signs_at(own[words], a)

        proved = bracket(legs, zeros, surely)
        error = np.maximum(proved.high - proved.a, proved.a - proved.low)
        found = _Found(numbers[zeros.word], proved.a, error, proved.after > 0, zeros.slack, proved.slope)
        yield found.rows(np.flatnonzero(proved.before * proved.after == -1))


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
