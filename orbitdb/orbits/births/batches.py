"""Words of several orders, cut once and followed together: what a chain does depends on no order."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import Chain, Legs, cut
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.births.brackets import PROVED_SIGNS, Signs, statuses
from orbitdb.orbits.newton import newton

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

JOINTS = ("bottom left", "bottom right", "top left", "top right")
"""Where a straight wall and a semicircle meet."""


class Batch:
    """Words of several orders, numbered through, and their chains.

    Parameters
    ----------
    orders : sequence of ndarray of uint8, shape (N_i, p_i) each
        Admissible words in any rotation.
    """

    def __init__(self, orders: Sequence[NDArray[np.uint8]]) -> None:
        self.orders = orders
        self.starts = np.cumsum([0, *map(len, orders)])
        self.longest = max((words.shape[1] for words in orders if len(words)), default=0)
        parts: dict[int, list[tuple[Rows, Legs]]] = {}
        for start, words in zip(self.starts.tolist(), orders, strict=False):
            for rows, legs in cut(words) if len(words) else ():
                parts.setdefault(len(legs.k), []).append((start + rows, legs))
        self._groups = [_joined(parts[m]) for m in sorted(parts)]

    def __len__(self) -> int:
        return int(self.starts[-1])

    def groups(self, rows: Rows) -> Iterator[tuple[Rows, Chain]]:
        """Yield some words as groups of equally many legs: their numbers, rising, and their chains."""
        for known, chain in self._groups:
            places = np.flatnonzero(np.isin(known, rows, assume_unique=True))
            if len(places):
                yield known[places], chain.chain(places)

    def of_order(self, rows: Rows) -> Iterator[tuple[Rows, NDArray[np.uint8]]]:
        """Yield which of some words, which may repeat, are of each order, and these words' symbols."""
        for start, end, words in zip(self.starts[:-1], self.starts[1:], self.orders, strict=True):
            here = np.flatnonzero((rows >= start) & (rows < end))
            if len(here):
                yield here, words[rows[here] - start]

    def signs(self, rows: Rows, legs: Chain, a: Floats, alpha: Floats) -> Signs:
        """Tell which words are orbits, each at its own a, in doubles or, where these leave it open, in balls.

        Parameters
        ----------
        rows : ndarray of intp, shape (N,)
        legs : Chain
            Their chains.
        a : ndarray, shape (N,)
        alpha : ndarray, shape (m, N)
            Directions near the maximum.
        """
        found = statuses(legs, a, alpha)
        unknown = np.flatnonzero(found == 0)
        if len(unknown):
            found[unknown] = self.signs_at(rows[unknown], a[unknown])
        return found

    def signs_at(self, rows: Rows, a: Floats) -> Signs:
        """Tell in ball arithmetic which words are orbits, each at its own a, shape (N,).

        1 for an orbit, -1 for none, 0 for one exactly through a joint, or undecided.
        """
        from orbitdb.orbits.balls.enclosure import enclose_all  # 30 ms to load, and seldom needed

        signs = np.zeros(len(rows), np.int8)
        for here, words in self.of_order(rows):
            for places, legs in cut(words):
                chosen = here[places]
                start = newton(legs, a[chosen]).alpha
                for at in np.unique(a[chosen]).tolist():
                    same = np.flatnonzero(a[chosen] == at)
                    found = enclose_all(legs.rows(same), Stadium(at), start[:, same])
                    signs[chosen[same]] = [PROVED_SIGNS.get(each.status, 0) for each in found]
        return signs

    def places(self, rows: Rows, slack: Rows) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return what smooth slacks are about, shape (K,): the bounce, counted from 1, and the joint.

        Parameters
        ----------
        rows, slack : ndarray of int, shape (K,)
            Words, and which of their slacks, as rows of `orbitdb.orbits.births.continuation.Station.slack`.
        """
        bounce, joint = np.zeros(len(rows), np.int64), np.zeros(len(rows), np.int64)
        for here, words in self.of_order(rows):
            for places, legs in cut(words):
                bounce[here[places]], joint[here[places]] = _places(legs, slack[here[places]])
        return bounce, joint


def _joined(parts: Sequence[tuple[Rows, Legs]]) -> tuple[Rows, Chain]:
    """Return the words and chains of several orders that have equally many legs."""
    names = ("k", "d", "n", "s")
    rows = np.concatenate([rows for rows, _ in parts])
    return rows, Chain(
        *(np.concatenate([getattr(legs, each) for _, legs in parts], axis=1) for each in names)
    )


def _places(legs: Legs, slack: Rows) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the bounce, counted from 1, and the joint that one slack of each word is about."""
    kind, i = np.divmod(slack, len(legs.k))
    own = i, np.arange(len(slack))
    k, n, s, parity = (part[own] for part in (legs.k, legs.n, legs.s, legs.parity))
    on_wall, at_end = kind >= 4, np.isin(kind, (2, 3, 5))
    place = np.where(at_end, np.where(on_wall, n, k) - 1, 0)
    bounce = ((legs.run == i) & (legs.place == place) & (legs.straight == on_wall)).argmax(axis=0) + 1
    right = (i + (kind == 5)) % 2 == 1
    top = np.where(on_wall, np.where(at_end, -s * parity, s) > 0, kind % 2 == 0)
    return bounce, 2 * top + right
