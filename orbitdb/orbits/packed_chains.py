"""Packed words cut into runs and legs, by operations on whole words.

It gives what `orbitdb.billiard.legs.cut` gives, but for where each bounce stands, in a third of the time.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain
from orbitdb.symbols.words import BITS, unpack

Integers = NDArray[np.int64]

_UNITS = int("1" * 20, 8)
"""The lowest bit of each symbol."""


def cut_packed(codes: Integers, p: int) -> Iterator[tuple[NDArray[np.intp], Chain]]:
    """Cut packed admissible words of order p <= 20 into runs and legs.

    Parameters
    ----------
    codes : ndarray of int64, shape (N,)
    p : int

    Yields
    ------
    rows : ndarray of intp
        The places of the words that have one number of runs.
    chain : Chain
        Their structure.
    """
    turned = _run_first(codes, p)
    starts, ends = (_places(mask, p) for mask in _run_ends(turned, p))
    symbols = unpack(turned, p).ravel()
    wall = np.append(symbols, 0)[ends + 1]  # the one behind the run, if there is one
    first = symbols[starts]
    bounces = ends - starts + 1
    walls = np.diff(starts, append=symbols.size) - bounces
    runs = np.bincount(starts // p, minlength=len(codes))
    parts = (bounces.astype(float), np.where(first > 3, -1.0, 1.0), walls.astype(float),
             np.where(walls > 0, wall - 1.0, 0.0))  # fmt: skip
    before = runs.cumsum() - runs
    for m in np.flatnonzero(np.bincount(runs)).tolist():
        rows = np.flatnonzero(runs == m)
        place = before[rows] + np.arange(m)[:, None]
        yield rows, Chain(*(part[place] for part in parts))


def _sides(codes: Integers, p: int) -> tuple[Integers, Integers]:
    """Return a bit for each bounce on the left, and on the right semicircle."""
    units = np.int64(_UNITS & ((1 << BITS * p) - 1))
    low, middle, high = (codes >> place & units for place in range(BITS))
    right = low & (high | middle)
    return (low | high) & ~right, right


def _run_first(codes: Integers, p: int) -> Integers:
    """Return the words turned so that they begin with a run on the left, the first that there is."""
    left, _ = _sides(codes, p)
    begins = left & ~(left >> BITS | (left & 1) << BITS * (p - 1))
    below = begins
    for shift in (1, 2, 4, 8, 16):
        below = below | below >> BITS * shift
    highest = below & ~(below >> BITS)
    behind = np.frexp(highest.astype(np.float64))[1] - 1  # bits behind the first symbol of the run
    ahead = (BITS * (p - 1) - behind).astype(np.int64)
    whole = np.int64((1 << BITS * p) - 1)
    turned: Integers = (codes << ahead & whole) | codes >> (behind + BITS).astype(np.int64)
    return turned


def _run_ends(turned: Integers, p: int) -> tuple[Integers, Integers]:
    """Return a bit for the first, and for the last bounce of each run of words that begin with a run."""
    left, right = _sides(turned, p)
    first = np.int64(1 << BITS * (p - 1))
    begins = left & ~(left >> BITS) | right & ~(right >> BITS) | first
    return begins, left & ~(left << BITS) | right & ~(right << BITS) | (left | right) & (begins << BITS)


def _places(mask: Integers, p: int) -> NDArray[np.intp]:
    """Return the places of the bits among all bounces of all words."""
    shifts = BITS * np.arange(p - 1, -1, -1, dtype=np.int64)
    return np.flatnonzero((mask[:, None] >> shifts & 1).astype(np.bool_))
