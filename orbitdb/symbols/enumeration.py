"""Enumeration of cyclic words: pieces of a period, and the primitive words in them.

Words of one order stand in the order of their packed codes, which is that of their texts. A `Span` is
a piece of this order; the pieces of a period can be enumerated apart from one another, by several
processes, and need no memory of what came before.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.words import BITS, unpack

Integers = NDArray[np.int64]

MAX_PERIOD = 20
"""The highest period that is enumerated (more than 10^9 words there)."""

CHUNK = 1 << 14

_ANY = np.tile(np.arange(6, dtype=np.int8), (6, 1))
"""Transitions where every symbol may follow every other."""


class Span(NamedTuple):
    """The words of order p behind one packed word and up to another."""

    p: int
    after: int  # the packed word behind which the span begins; -1 for the first word of all
    upto: int  # the packed word at which it ends, included

    @classmethod
    def whole(cls, p: int, after: int = -1) -> "Span":
        """Return all words of order p, or those behind one."""
        return cls(p, after, (1 << BITS * p) - 1)


def primitive_words(p: int) -> Iterator[NDArray[np.uint8]]:
    """Generate all primitive cyclic words of order p, pruned or not, as least rotations, in order.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.

    Yields
    ------
    ndarray of uint8, shape (n, p)
        The next words; n is at most a few times `CHUNK`, so that memory is bounded.
    """
    for codes, lyndon, _ in prefixes(Span.whole(p), p):
        whole = lyndon == p
        if whole.any():
            yield unpack(codes[whole], p)


def prefixes(
    span: Span,
    length: int,
    table: NDArray[np.int8] = _ANY,
    keep: Callable[[Integers], NDArray[np.bool_]] | None = None,
) -> Iterator[tuple[Integers, Integers, NDArray[np.int8]]]:
    """Generate the prefixes of the least rotations in a span, in order.

    Parameters
    ----------
    span : Span
    length : int
        Symbols of a prefix, 1..p.
    table : ndarray of int8, shape (S, 6), optional
        The state that follows each state with each symbol, -1 for none; a word begins in that of its symbol.
    keep : callable, optional
        Tells of packed prefixes of any length which ones to go on with.

    Yields
    ------
    codes, lyndon : ndarray of int64, shape (n,)
        The packed prefixes, and the lengths of their longest Lyndon prefixes: p for a primitive word.
    states : ndarray of int8, shape (n,)
        What they lead to.

    Notes
    -----
    Least rotations of primitive words are Lyndon words. Their prefixes are extended a symbol at a
    time, thousands at once, by the rule of Fredricksen, Kessler and Maiorana: a prefix whose longest
    Lyndon prefix has m symbols goes on with a symbol not below the one m places back.
    """
    stack = [(1, np.arange(6), np.ones(6, np.int64), np.arange(6, dtype=np.int8))]
    while stack:
        n, codes, lyndon, states = stack.pop()
        rest = BITS * (span.p - n)
        inside = (codes >= span.after >> rest) & (codes <= span.upto >> rest)
        kept = np.flatnonzero(inside if keep is None else inside & keep(codes))
        codes, lyndon, states = codes[kept], lyndon[kept], states[kept]
        if n == length:
            yield codes, lyndon, states
            continue
        for start in reversed(range(0, len(codes), CHUNK)):
            part = slice(start, start + CHUNK)
            back = codes[part] >> BITS * (lyndon[part] - 1) & 7
            after = table[states[part]]
            parent, symbol = np.nonzero((after >= 0) & (np.arange(6) >= back[:, None]))
            longest = np.where(symbol == back[parent], lyndon[part][parent], n + 1)
            stack.append((n + 1, codes[part][parent] << BITS | symbol, longest, after[parent, symbol]))
