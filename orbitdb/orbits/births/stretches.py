"""[low, high] in x = ln a cut into cells until something is proved of each word in each of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain, centre_directions
from orbitdb.equality import ByValue
from orbitdb.orbits.births.cells import Cells, Kind, judge

Floats = NDArray[np.float64]

_FIRST, _HALVINGS, _MOST = 0.07, 24, 1500
"""Radius of the first cells in ln a, how often a cell is halved, and how many of a word are at most.

As a goes to 0 some slacks go like a^5: there cells would be as small as a^(5/2), and are given up.
"""


@dataclass(frozen=True, eq=False)
class Stretches(ByValue):
    """What is proved of N words on stretches of x = ln a, one entry a stretch, by word and rising x.

    Attributes
    ----------
    word : ndarray of int, shape (K,)
    low, high : ndarray, shape (K,)
        From where to where in ln a.
    kind : ndarray of int8, shape (K,)
        Values of `Kind`.
    cells : int
        How many cells were looked at.
    """

    word: NDArray[np.intp]
    low: Floats
    high: Floats
    kind: NDArray[np.int8]
    cells: int


def stretches(legs: Chain, low: float, high: float) -> Stretches:
    """Cut [low, high] in ln a into cells in which something is proved of each word, as far as that goes.

    Parameters
    ----------
    legs : Chain
        N words.
    low, high : float
    """
    count = int(np.ceil((high - low) / (2 * _FIRST)))
    middle = np.tile(low + (np.arange(count) + 0.5) * (high - low) / count, len(legs))
    word = np.repeat(np.arange(len(legs)), count)
    a = np.exp(middle)
    part = legs.chain(word)
    cells = Cells(word, middle, np.full(len(word), (high - low) / (2 * count)), centre_directions(part, a))
    known: list[tuple[NDArray[np.intp], Floats, Floats, NDArray[np.int8]]] = []
    looked = 0
    for halved in range(_HALVINGS + 1):
        kind, alpha, drift = judge(legs.chain(cells.word), cells)
        looked += len(kind)
        many = np.bincount(cells.word, kind == Kind.OPEN, minlength=len(legs)) > _MOST
        told = (kind != Kind.OPEN) | many[cells.word] | (halved == _HALVINGS)
        known.append((cells.word[told], cells.x[told], cells.radius[told], kind[told]))
        open_ = np.flatnonzero(~told)
        if not len(open_):
            break
        cells = _halves(cells, open_, alpha, drift)
    x, radius = (np.concatenate([part[i] for part in known]) for i in (1, 2))
    word, kind = np.concatenate([part[0] for part in known]), np.concatenate([part[3] for part in known])
    return _joined(Stretches(word, x - radius, x + radius, kind, looked))


def _halves(cells: Cells, chosen: NDArray[np.intp], alpha: Floats, drift: Floats) -> Cells:
    """Cut some cells in two."""
    r = cells.radius[chosen] / 2
    shift = np.clip(drift.take(chosen, axis=1), -1, 1) * r
    here = alpha.take(chosen, axis=1)
    x, word = cells.x[chosen], cells.word[chosen]
    start = np.concatenate([here - shift, here + shift], axis=1)
    return Cells(np.tile(word, 2), np.concatenate([x - r, x + r]), np.tile(r, 2), start)


def _joined(cells: Stretches) -> Stretches:
    """Join neighbouring cells of one kind, in order."""
    order = np.lexsort((cells.low, cells.word))
    word, low, high, kind = cells.word[order], cells.low[order], cells.high[order], cells.kind[order]
    fresh = np.ones(len(word), bool)
    fresh[1:] = (word[1:] != word[:-1]) | (kind[1:] != kind[:-1])
    first = np.flatnonzero(fresh)
    last = np.append(first[1:], len(word)) - 1
    return Stretches(word[first], low[first], high[last], kind[first], cells.cells)
