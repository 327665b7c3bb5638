"""Enumeration of cyclic words, admissible ones above all, whole periods or parts of them.

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

_LAST_SYMBOLS = 5
"""Symbols that a prefix leaves open when a period is cut into spans: some hundred words a prefix."""

_CONTINUATIONS = 3.4
"""Admissible continuations of prefixes for each that closes and is a least rotation, at most."""


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


def spans(p: int, size: int, after: int = -1) -> Iterator[Span]:
    """Cut the admissible words of order p into spans of about ``size`` words or less.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.
    size : int
        Wanted size. Most spans come close to it, those of high first symbols stay below: what is
        counted are the words that continue a prefix, and there fewer of them are least rotations.
    after : int, optional
        Begin behind this packed word.

    Yields
    ------
    Span
        In order, one behind the other; the last one ends with the last word.
    """
    whole = Span.whole(p, after)
    depth = p - _LAST_SYMBOLS
    if depth < 1:
        yield whole
        return
    _, table = automaton()
    weights = _continuations(table, _LAST_SYMBOLS)
    shift = BITS * _LAST_SYMBOLS
    start, room = after, _CONTINUATIONS * size
    for prefixes in _prefixes(whole, depth, table):
        for code, weight in zip(prefixes.codes.tolist(), weights[prefixes.states].tolist(), strict=True):
            before = (code << shift) - 1
            if weight > room and before > start:
                yield Span(p, start, before)
                start, room = before, _CONTINUATIONS * size
            room -= weight
    yield Span(p, start, whole.upto)


def _continuations(table: NDArray[np.int8], symbols: int) -> NDArray[np.int64]:
    """Return how many words of so many symbols may follow each state."""
    steps = np.zeros((len(table), len(table)), dtype=np.int64)
    for state, after in zip(*np.nonzero(table >= 0), strict=True):
        steps[state, table[state, after]] += 1
    counts: NDArray[np.int64] = np.linalg.matrix_power(steps, symbols).sum(axis=1)
    return counts


def admissible_words(p: int, after: int = -1, upto: int | None = None) -> Iterator[NDArray[np.uint8]]:
    """Generate the admissible primitive cyclic words of order p as least rotations, in order.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.
    after : int, optional
        Begin behind this packed word.
    upto : int, optional
        End with this packed word.

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
    states, table = automaton()
    rooted = np.array([state.left is not None for state in states])
    whole = Span.whole(p, after)
    for prefixes in _lyndon_words(whole if upto is None else whole._replace(upto=upto), table):
        end = _read_again(prefixes, p, table)
        closed = (end >= 0) & rooted[end]  # only 02 has no root, and rule 3 forbids it
        if closed.any() and p > 1:  # of the words on one side, only 1, 3, 4 and 5 get here
            yield unpack(prefixes.codes[closed], p)


def primitive_words(p: int, after: int = -1) -> Iterator[NDArray[np.uint8]]:
    """Generate all primitive cyclic words of order p, pruned or not, as `admissible_words` does."""
    free = np.tile(np.arange(6, dtype=np.int8), (6, 1))
    for prefixes in _lyndon_words(Span.whole(p, after), free):
        yield unpack(prefixes.codes, p)


def _read_again(prefixes: "_Prefixes", p: int, table: NDArray[np.int8]) -> NDArray[np.intp]:
    """Return the state after reading each word once more behind itself; -1 where a rule forbids it."""
    width = table.shape[1]
    dead = np.full(width, -1, dtype=np.intp)
    flat = np.concatenate([table.ravel(), dead])  # the last row is also row -1, so take wraps round
    state = prefixes.states.astype(np.intp)
    for place in range(p - 1, -1, -1):
        state = flat.take(width * state + ((prefixes.codes >> BITS * place) & 7), mode="wrap")
    return state


class _Prefixes(NamedTuple):
    codes: NDArray[np.int64]
    lyndon: NDArray[np.int8]
    states: NDArray[np.int8]

    def rows(self, chosen: slice | NDArray[np.bool_]) -> "_Prefixes":
        return _Prefixes(self.codes[chosen], self.lyndon[chosen], self.states[chosen])


def _lyndon_words(span: Span, table: NDArray[np.int8]) -> Iterator[_Prefixes]:
    """Generate the Lyndon words of a span, with the states they lead to."""
    for prefixes in _prefixes(span, span.p, table):
        whole = (prefixes.lyndon == span.p) & (prefixes.codes > span.after)
        if whole.any():
            yield prefixes.rows(whole)


def _prefixes(span: Span, length: int, table: NDArray[np.int8]) -> Iterator[_Prefixes]:
    """Generate the prefixes of a length that Lyndon words of a span may begin with."""
    symbols = np.arange(6)
    first = _Prefixes(symbols.astype(np.int64), np.ones(6, np.int8), symbols.astype(np.int8))
    stack = [(1, first)]
    while stack:
        n, prefixes = stack.pop()
        rest = BITS * (span.p - n)
        floor, ceiling = span.after >> rest, span.upto >> rest
        prefixes = prefixes.rows((prefixes.codes >= floor) & (prefixes.codes <= ceiling))
        if n == length:
            yield prefixes
        elif len(prefixes.codes) > CHUNK:
            starts = range(0, len(prefixes.codes), CHUNK)
            stack += [(n, prefixes.rows(slice(start, start + CHUNK))) for start in reversed(starts)]
        else:
            stack.append((n + 1, _extend(prefixes, n, table)))


def _extend(prefixes: _Prefixes, n: int, table: NDArray[np.int8]) -> _Prefixes:
    """Return all prefixes of n + 1 symbols that grow from those of n symbols, in order."""
    codes, lyndon, states = prefixes
    back = (codes >> (BITS * (lyndon.astype(np.int64) - 1))) & 7
    after = table[states]
    parent, symbol = np.nonzero((after >= 0) & (np.arange(6) >= back[:, None]))
    repeats = symbol == back[parent]
    return _Prefixes(
        codes[parent] << BITS | symbol,
        np.where(repeats, lyndon[parent], np.int8(n + 1)),
        after[parent, symbol],
    )
