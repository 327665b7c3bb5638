"""Enumeration of cyclic words, admissible ones above all, whole periods or parts of them.

Words of one order stand in the order of their packed codes, which is that of their texts. A `Span` is
a piece of this order; the pieces of a period can be enumerated apart from one another, by several
processes, and need no memory of what came before.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.automaton import automaton
from orbitdb.symbols.words import BITS, unpack

MAX_PERIOD = 20
"""The highest period that is enumerated (more than 10^9 words there)."""

CHUNK = 1 << 14

_LAST_SYMBOLS = 5
"""Symbols that a prefix leaves open when a period is cut into spans: some hundred words a prefix."""

_FIRST_SYMBOLS = 3
"""Symbols read again that show most of the words that do not close."""

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
    _, table = automaton()

    def prefixes(span: Span, length: int) -> Iterator[_Prefixes]:
        return _prefixes(span, length, table)

    return cut_where(Span.whole(p, after), prefixes, _CONTINUATIONS * size)


class Prefixes(Protocol):
    """Beginnings of words, packed, with the states of the automaton that they lead to."""

    @property
    def codes(self) -> NDArray[np.int64]:
        """The symbols of each."""

    @property
    def states(self) -> NDArray[np.int8]:
        """The number of each one's state."""


def cut_where(
    whole: Span, prefixes: Callable[[Span, int], Iterator[Prefixes]], continuations: float
) -> Iterator[Span]:
    """Cut a span so that the prefixes of each part have so many admissible continuations at most.

    Parameters
    ----------
    whole : Span
    prefixes : callable
        Generates the prefixes of a length in a span, in order.
    continuations : float
        A part with more of them has but one prefix.
    """
    p, start, upto = whole
    depth = p - _LAST_SYMBOLS
    if depth < 1:
        yield whole
        return
    _, table = automaton()
    weights = _continuations(table, _LAST_SYMBOLS)
    shift = BITS * _LAST_SYMBOLS
    room = continuations
    for part in prefixes(whole, depth):
        for code, weight in zip(part.codes.tolist(), weights[part.states].tolist(), strict=True):
            before = (code << shift) - 1
            if before + (1 << shift) <= whole.after:
                continue  # so that a span cut off before is cut on as if it had not been
            if weight > room and before > start:
                yield Span(p, start, before)
                start, room = before, continuations
            room -= weight
    yield Span(p, start, upto)


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
    _, table = automaton()
    whole = Span.whole(p, after)
    for prefixes in _lyndon_words(whole if upto is None else whole._replace(upto=upto), table):
        closed = closes(prefixes.codes, prefixes.states, p)
        if len(closed):
            yield unpack(prefixes.codes[closed], p)


def primitive_words(p: int, after: int = -1) -> Iterator[NDArray[np.uint8]]:
    """Generate all primitive cyclic words of order p, pruned or not, as `admissible_words` does."""
    free = np.tile(np.arange(6, dtype=np.int8), (6, 1))
    for prefixes in _lyndon_words(Span.whole(p, after), free):
        yield unpack(prefixes.codes, p)


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
    if p < 2:  # of the words on one side, only 1, 3, 4 and 5 get here
        return np.zeros(0, dtype=np.intp)
    kept, table = automaton()
    rooted = np.array([state.left is not None for state in kept])
    found = np.arange(len(codes))
    first = min(_FIRST_SYMBOLS, p)
    state = states.astype(np.intp)
    for places in (range(p - 1, p - 1 - first, -1), range(p - 1 - first, -1, -1)):
        state = _read(codes[found], state, places, table)
        found, state = found[state >= 0], state[state >= 0]
    return found[rooted[state]]  # only 02 has no root, and rule 3 forbids it


def _read(
    codes: NDArray[np.int64], state: NDArray[np.intp], places: Iterable[int], table: NDArray[np.int8]
) -> NDArray[np.intp]:
    """Return the states after reading some places of words; -1 where a rule forbids it."""
    width = table.shape[1]
    dead = np.full(width, -1, dtype=np.intp)
    flat = np.concatenate([table.ravel(), dead])  # the last row is also row -1, so take wraps round
    for place in places:
        state = flat.take(width * state + ((codes >> BITS * place) & 7), mode="wrap")
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
