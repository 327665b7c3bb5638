"""Stored levels of the stadium, and which are missing."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import sqlalchemy as sa

from orbitdb.quantum.levels import Levels
from orbitdb.quantum.weyl import Parity
from orbitdb.store.file.tables import level, level_fill
from orbitdb.store.reading.soundness import unsound


def stored(connection: sa.Connection, a: float, parity: Parity) -> list[Levels]:
    """Return the levels of one parity that are stored, window by window.

    Raises
    ------
    StoreError
        If the rows are none that were found so.
    """
    fills, levels = level_fill.c, level.c
    query = sa.select(fills.low, fills.high, fills.below, fills.seconds).where(
        fills.a == a, fills.parity == str(parity)
    )
    rows = sa.select(levels.number, levels.k, levels.error).where(levels.a == a, levels.parity == str(parity))
    known = np.array([tuple(row) for row in connection.execute(rows)], np.float64).reshape(-1, 3)
    found = []
    for low, high, below, seconds in connection.execute(query):
        number, k, error = known[(known[:, 1] >= low) & (known[:, 1] < high)].T
        if not np.array_equal(number, np.arange(below + 1, below + 1 + len(k))) or (np.diff(k) < 0).any():
            raise unsound(f"levels {parity} at a = {a:g} in a window from k =", low)
        found.append(Levels(a, parity, low, high, below, k, error, seconds))
    for one, other in pairwise(found):
        whole = one.below + len(one.k) == other.below
        if one.high > other.low or (one.high == other.low and not whole):
            raise unsound(f"levels {parity} at a = {a:g} in a window from k =", other.low)
    if sum(len(each.k) for each in found) != len(known):
        raise unsound(f"levels {parity} outside all windows at a =", a)
    return found


def missing(known: Sequence[Levels], low: float, high: float) -> Iterator[tuple[float, float]]:
    """Yield the ranges of k between two values that no window covers."""
    for each in known:
        if each.high <= low:
            continue
        if each.low >= high:
            break
        if each.low > low:
            yield low, each.low
        low = each.high
    if low < high:
        yield low, high


def joined(known: Sequence[Levels]) -> Levels | None:
    """Return the levels of one parity from k = 0 to the first gap; None if there is none at its beginning."""
    chain: Levels | None = None
    for each in known:
        if each.low == (0.0 if chain is None else chain.high):
            chain = each if chain is None else replace(
                chain,
                high=each.high,
                k=np.concatenate([chain.k, each.k]),
                error=np.concatenate([chain.error, each.error]),
                seconds=chain.seconds + each.seconds,
            )  # fmt: skip
    return chain
