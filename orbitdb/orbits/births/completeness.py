"""Proof that no birth or death of a word is missing between two values of a.

This is a second method, which shares only the equations with `orbitdb.orbits.births.changes`. Instead of
searching for zeros, it cuts ln a into cells in which a word can be born at most once, or die at most once, or
neither (`orbitdb.orbits.births.cells`), and counts.
"""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Places, Words
from orbitdb.billiard.legs import Chain, centre_directions, cut
from orbitdb.orbits.births.brackets import signs
from orbitdb.orbits.births.cells import Kind, judge
from orbitdb.orbits.newton import newton

LOW, HIGH = 0.02, 1000.0
"""Range of a in which a proof is attempted."""


Segment = tuple[int, float, float]
"""A value of `Kind`, and the two ends of the range of ln a in which it holds."""

KnownChange = tuple[float, float, bool]
"""The two ends of a bracket in ln a, and whether the word is born there."""

_CONSTANT = (Kind.ALIVE, Kind.DEAD)

_FIRST, _HALVINGS, _MOST = 0.07, 24, 1500
"""Radius of the first cells in ln a, most halvings of a cell, and most undecided cells of a word at a time.

As a goes to 0, some slacks behave like a^5. Cells would have to be as small as a^(5/2) there, so they are
left undecided.
"""


class Verdict(IntEnum):
    """What is proved about the known births and deaths of a word."""

    WRONG = -1
    UNDECIDED = 0
    PROVED = 1


def prove_all(words: Words, changes: Sequence[Sequence[KnownChange]]) -> tuple[NDArray[np.int8], int]:
    """Tell whether the known changes of words are complete between `LOW` and `HIGH`.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible primitive words of the same period.
    changes : sequence of sequence of KnownChange
        The changes of each word, by ascending a.

    Returns
    -------
    verdict : ndarray of int8, shape (N,)
        Values of `Verdict`.
    cells : int
        Number of cells examined.
    """
    verdict, cells = np.zeros(len(words), np.int8), 0
    for rows, legs in cut(words):
        first = signs(words[rows], legs, np.full(len(rows), LOW), newton(legs, LOW).alpha)
        word, kind, low, high, looked = stretches(legs, float(np.log(LOW)), float(np.log(HIGH)))
        cells += looked
        ends = np.searchsorted(word, np.arange(len(rows) + 1)).tolist()
        segments = list(zip(kind.tolist(), low.tolist(), high.tolist(), strict=True))
        for row, sign, start, end in zip(rows.tolist(), first.tolist(), ends, ends[1:], strict=False):
            state = None if sign == 0 else sign > 0
            verdict[row] = walk(segments[start:end], changes[row], state)
    return verdict, cells


def stretches(legs: Chain, low: float, high: float) -> tuple[Places, NDArray[np.int8], Floats, Floats, int]:
    """Cut [low, high] in ln a, for each word, into cells in which something is proved about it, if possible.

    Returns
    -------
    word, kind, low, high : ndarray, shape (K,)
        Ranges sorted by word and ascending a: the index of the word, the value of `Kind`, and the two ends in
        ln a.
    cells : int
        Number of cells examined.
    """
    count, cells = int(np.ceil((high - low) / (2 * _FIRST))), 0
    x = np.tile(low + (np.arange(count) + 0.5) * (high - low) / count, len(legs))
    word, r = np.repeat(np.arange(len(legs)), count), np.full(len(x), (high - low) / (2 * count))
    start = centre_directions(legs.chain(word), np.exp(x))
    known = []
    for halved in range(_HALVINGS + 1):
        kind, alpha, drift = judge(legs.chain(word), x, r, start)
        cells += len(kind)
        many = np.bincount(word, kind == Kind.OPEN, minlength=len(legs)) > _MOST
        told = (kind != Kind.OPEN) | many[word] | (halved == _HALVINGS)
        known.append((word[told], x[told] - r[told], x[told] + r[told], kind[told]))
        left = np.flatnonzero(~told)
        if not len(left):
            break
        r = r[left] / 2
        shift, here = np.clip(drift.take(left, axis=1), -1, 1) * r, alpha.take(left, axis=1)
        start = np.concatenate([here - shift, here + shift], axis=1)
        word, x, r = np.tile(word[left], 2), np.concatenate([x[left] - r, x[left] + r]), np.tile(r, 2)
    word, begin, end, kind = map(np.concatenate, zip(*known, strict=True))
    order = np.lexsort((begin, word))
    word, begin, end, kind = word[order], begin[order], end[order], kind[order]
    fresh = np.ones(len(word), bool)
    fresh[1:] = (word[1:] != word[:-1]) | (kind[1:] != kind[:-1])  # neighbours of the same kind are joined
    first = np.flatnonzero(fresh)
    return word[first], kind[first], begin[first], end[np.append(first[1:], len(word)) - 1], cells


def walk(segments: Sequence[Segment], changes: Sequence[KnownChange], alive: bool | None) -> Verdict:
    """Tell whether the known changes are all the changes that the segments allow.

    The segments, which are adjacent, and the changes are sorted by ascending a; changes outside the segments
    are ignored. `alive` tells whether the word is an orbit where the segments begin; None means unknown.
    """
    left = [each for each in changes if segments[0][1] < (each[0] + each[1]) / 2 < segments[-1][2]]
    sure = True
    for place, (kind, _, high) in enumerate(segments):
        if kind in _CONSTANT:
            if alive is (kind != Kind.ALIVE) or (left and left[0][1] < high):
                return Verdict.WRONG
            alive = kind == Kind.ALIVE
            continue
        here = [each for each in left if each[0] <= high]
        left = left[len(here) :]
        if kind == Kind.OPEN:
            alive, sure = None, False
            continue
        way = kind == Kind.RISING
        if len(here) > 1 or any(born != way for *_, born in here) or (here and alive is way):
            return Verdict.WRONG
        if here:
            alive = way
        elif alive is not way:
            after = segments[place + 1][0] if place + 1 < len(segments) else Kind.OPEN
            if after not in _CONSTANT:
                alive, sure = None, False
            elif (after == Kind.ALIVE) is way and alive is not None:
                return Verdict.WRONG
            else:
                sure = sure and (after == Kind.ALIVE) is not way
                alive = after == Kind.ALIVE
    return Verdict.PROVED if sure and not left else Verdict.UNDECIDED
