"""Enumeration of cyclic words: pieces of a period, all primitive words, and which words close to cycles.

Words of one order stand in the order of their packed codes, which is that of their texts. A `Span` is
a piece of this order; the pieces of a period can be enumerated apart from one another, by several
processes, and need no memory of what came before.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.automaton import automaton
from orbitdb.symbols.words import BITS, unpack

MAX_PERIOD = 20
"""The highest period that is enumerated (more than 10^9 words there)."""

CHUNK = 1 << 14


class Span(NamedTuple):
    """The words of order p behind one packed word and up to another.

    Attributes
    ----------
    p : int
    after : int
        The packed word behind which the span begins; -1 for the first word of all.
    upto : int
        The packed word at which it ends, included.
    """

    p: int
    after: int
    upto: int

    @classmethod
    def whole(cls, p: int, after: int = -1) -> "Span":
        """Return all words of order p, or those behind one."""
        return cls(p, after, (1 << BITS * p) - 1)


def primitive_words(p: int, after: int = -1) -> Iterator[NDArray[np.uint8]]:
    """Generate all primitive cyclic words of order p, pruned or not, as least rotations, in order.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.
    after : int, optional
        Begin behind this packed word.

    Yields
    ------
    ndarray of uint8, shape (n, p)
        The next words; n is at most a few times `CHUNK`, so that memory is bounded.

    Notes
    -----
    Least rotations of primitive words are Lyndon words. Their prefixes are extended a symbol at a
    time, thousands at once, by the rule of Fredricksen, Kessler and Maiorana: a prefix whose longest
    Lyndon prefix has m symbols goes on with a symbol not below the one m places back.
    """
    stack = [(1, np.arange(6), np.ones(6, np.int64))]
    while stack:
        n, codes, lyndon = stack.pop()
        if n == p:
            whole = (lyndon == p) & (codes > after)
            if whole.any():
                yield unpack(codes[whole], p)
            continue
        later = codes >= after >> BITS * (p - n)
        codes, lyndon = codes[later], lyndon[later]
        for start in reversed(range(0, len(codes), CHUNK)):
            chunk = slice(start, start + CHUNK)
            stack.append((n + 1, *_extended(codes[chunk], lyndon[chunk], n)))


def _extended(
    codes: NDArray[np.int64], lyndon: NDArray[np.int64], n: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return all prefixes that are a symbol longer, and the lengths of their Lyndon prefixes."""
    back = codes >> BITS * (lyndon - 1) & 7
    parent, symbol = np.nonzero(np.arange(6) >= back[:, None])
    longest = np.where(symbol == back[parent], lyndon[parent], n + 1)
    return codes[parent] << BITS | symbol, longest


def closes(codes: NDArray[np.int64], states: NDArray[np.int8], p: int) -> NDArray[np.intp]:
    """Return the places of words that the rules allow as cyclic words, too.

    Parameters
    ----------
    codes : ndarray of int64, shape (N,)
        Packed words of order p that the automaton has read once.
    states : ndarray of int8, shape (N,)
        The states they lead to.
    p : int
    """
    kept, table = automaton()
    rooted = np.array([state.left is not None for state in kept])  # 02 is not, and rule 3 forbids it
    state = states.astype(np.intp)
    alive = rooted[state] if p > 1 else np.zeros(len(state), np.bool_)  # 1, 3, 4 and 5 stay on one side
    places = np.flatnonzero(alive)
    codes, state = codes[places], state[places]
    for place in range(p - 1, -1, -1):
        state = table[state, codes >> BITS * place & 7].astype(np.intp)
        alive = state >= 0
        if not alive.all():
            places, codes, state = places[alive], codes[alive], state[alive]
    return places
