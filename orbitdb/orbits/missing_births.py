"""Proof that no birth or death of a word is missing between two values of a.

This is a second method, which shares only the equations with `orbitdb.orbits.births`. Instead of searching
for zeros, it cuts x = ln a into cells in which a word can be born at most once, or die at most once, or
neither (`orbitdb.orbits.cells`), and counts. The bounds hold at every a in a cell.
"""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Indices, Words
from orbitdb.billiard.legs import Chain, centre_directions, cut
from orbitdb.orbits.births import signs
from orbitdb.orbits.cells import Kind, kinds_in_cells
from orbitdb.orbits.newton import newton

LOW, HIGH = 0.02, 1000.0
"""Range of a in which a proof is attempted."""


Segment = tuple[int, float, float]
"""A value of `Kind`, and the two ends of the range of ln a in which it holds."""

KnownChange = tuple[float, float, bool]
"""The two ends of a bracket in ln a, and whether the word is born there."""

_CONSTANT: dict[int, bool] = {Kind.ALIVE: True, Kind.DEAD: False}
"""Whether a word is an orbit in cells in which that does not change."""

_FIRST, _HALVINGS, _MOST = 0.07, 24, 1500
"""Radius of the first cells in ln a, most halvings of a cell, and most undecided cells of a word at a time.

As a goes to 0, some slacks behave like a^5. Cells would have to be as small as a^(5/2) there, so they are
left undecided.
"""


class Completeness(IntEnum):
    """What is proved about the known births and deaths of a word."""

    WRONG = -1
    UNDECIDED = 0
    PROVED = 1


def prove_all(words: Words, changes: Sequence[Sequence[KnownChange]]) -> NDArray[np.int8]:
    """Tell whether the known changes of words are complete between `LOW` and `HIGH`.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible primitive words of the same period.
    changes : sequence of sequence of KnownChange
        The changes of each word, by ascending a.

    Returns
    -------
    ndarray of int8, shape (N,)
        Values of `Completeness`.
    """
    proved = np.zeros(len(words), np.int8)
    for rows, legs in cut(words):
        first = signs(words[rows], legs, np.full(len(rows), LOW), newton(legs, LOW).alpha)
        word, kind, low, high = stretches(legs, float(np.log(LOW)), float(np.log(HIGH)))
        ends = np.searchsorted(word, np.arange(len(rows) + 1)).tolist()
        segments = list(zip(kind.tolist(), low.tolist(), high.tolist(), strict=True))
        for row, sign, start, end in zip(rows.tolist(), first.tolist(), ends, ends[1:], strict=False):
            state = None if sign == 0 else sign > 0
            proved[row] = walk(segments[start:end], changes[row], state)
    return proved


def stretches(legs: Chain, low: float, high: float) -> tuple[Indices, NDArray[np.int8], Floats, Floats]:
    """Cut [low, high] in ln a, for each word, into cells in which something is proved about it, if possible.

    Returns
    -------
    word, kind, low, high : ndarray, shape (K,)
        Ranges sorted by word and ascending a: the index of the word, the value of `Kind`, and the two ends in
        ln a.
    """
    count = int(np.ceil((high - low) / (2 * _FIRST)))
    x = np.tile(low + (np.arange(count) + 0.5) * (high - low) / count, len(legs))
    word, r = np.repeat(np.arange(len(legs)), count), np.full(len(x), (high - low) / (2 * count))
    start = centre_directions(legs.chain(word), np.exp(x))
    finished = []
    for halved in range(_HALVINGS + 1):
        kind, alpha, velocity = kinds_in_cells(legs.chain(word), x, r, start)
        many = np.bincount(word, kind == Kind.OPEN, minlength=len(legs)) > _MOST
        done = (kind != Kind.OPEN) | many[word] | (halved == _HALVINGS)
        finished.append((word[done], x[done] - r[done], x[done] + r[done], kind[done]))
        left = np.flatnonzero(~done)
        if not len(left):
            break
        r = r[left] / 2
        shift, middle = np.clip(velocity.take(left, axis=1), -1, 1) * r, alpha.take(left, axis=1)
        start = np.concatenate([middle - shift, middle + shift], axis=1)
        word, x, r = np.tile(word[left], 2), np.concatenate([x[left] - r, x[left] + r]), np.tile(r, 2)
    word, begin, end, kind = map(np.concatenate, zip(*finished, strict=True))
    order = np.lexsort((begin, word))
    word, begin, end, kind = word[order], begin[order], end[order], kind[order]
    fresh = np.ones(len(word), bool)
    fresh[1:] = (word[1:] != word[:-1]) | (kind[1:] != kind[:-1])  # neighbours of the same kind are joined
    first = np.flatnonzero(fresh)
    return word[first], kind[first], begin[first], end[np.append(first[1:], len(word)) - 1]


def walk(segments: Sequence[Segment], changes: Sequence[KnownChange], alive: bool | None) -> Completeness:
    """Tell whether the known changes are all the changes that the segments allow.

    The segments, which are adjacent, and the changes are sorted by ascending a; changes outside the segments
    are ignored. `alive` tells whether the word is an orbit where the segments begin; None means unknown.
    """
    begin, end = segments[0][1], segments[-1][2]
    word = _Walk([change for change in changes if begin < (change[0] + change[1]) / 2 < end], alive)
    following = [kind for kind, *_ in segments[1:]] + [Kind.OPEN]
    for (kind, _, high), after in zip(segments, following, strict=True):
        if kind == Kind.OPEN:
            possible = word.pass_open(high)
        elif kind in _CONSTANT:
            possible = word.pass_constant(_CONSTANT[kind], high)
        else:
            possible = word.pass_moving(kind == Kind.RISING, _CONSTANT.get(after), high)
        if not possible:
            return Completeness.WRONG
    return Completeness.PROVED if word.sure and not word.ahead else Completeness.UNDECIDED


class _Walk:
    """A word that passes segment after segment as a grows.

    Attributes
    ----------
    ahead : list of KnownChange
        The known changes that are still to come.
    alive : bool or None
        Whether the word is an orbit here; None if that is unknown.
    sure : bool
        Whether no further change was possible so far.

    Notes
    -----
    Each method passes a segment that ends at `high`, and returns False if it contradicts the known changes.
    """

    def __init__(self, changes: list[KnownChange], alive: bool | None) -> None:
        self.ahead, self.alive, self.sure = changes, alive, True

    def pass_constant(self, alive: bool, high: float) -> bool:
        """Pass a segment in which the word is an orbit everywhere or nowhere."""
        changes_inside = bool(self.ahead) and self.ahead[0][1] < high
        possible = self.alive is not (not alive) and not changes_inside
        self.alive = alive
        return possible

    def pass_moving(self, rising: bool, after: bool | None, high: float) -> bool:
        """Pass a segment in which the word can only be born, if `rising`, or can only die.

        `after` tells whether it is an orbit in the next segment; None means unknown.
        """
        inside = self._reach(high)
        if len(inside) > 1 or any(born != rising for *_, born in inside):
            return False
        if inside:
            possible, self.alive = self.alive is not rising, rising
            return possible
        if self.alive is rising:
            return True
        unknown, self.alive = self.alive is None, after
        if after is not (not rising):  # it may have changed here, though no change is known
            self.sure = False
        return unknown or after is not rising

    def pass_open(self, high: float) -> bool:
        """Pass a segment in which nothing is proved."""
        self._reach(high)
        self.alive, self.sure = None, False
        return True

    def _reach(self, high: float) -> list[KnownChange]:
        """Go on to the end of a segment, and return the changes that begin before it."""
        inside = [change for change in self.ahead if change[0] <= high]
        self.ahead = self.ahead[len(inside) :]
        return inside
