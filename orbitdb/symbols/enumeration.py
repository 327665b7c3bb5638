"""Enumeration of cyclic words, admissible ones above all, whole periods or parts of them.

Words of one order stand in the order of their packed codes, which is that of their texts. A `Span` is
a piece of this order; the pieces of a period can be enumerated apart from one another, by several
processes, and need no memory of what came before.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.automaton import automaton
from orbitdb.symbols.words import BITS, unpack

MAX_PERIOD = 20
"""The highest period that is enumerated (more than 10^9 words there)."""

CHUNK = 1 << 14

_FIRST_SYMBOLS = 4
"""Symbols read again that show of nearly every word whether it closes."""

_DEAD, _CLOSED, _OPEN = 0, 1, 2


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
    whole = Span.whole(p, after)
    for codes in admissible_codes(whole if upto is None else whole._replace(upto=upto)):
        yield unpack(codes, p)


def admissible_codes(span: Span) -> Iterator[NDArray[np.int64]]:
    """Generate the words of a span as `admissible_words` does, packed."""
    p = span.p
    if p < 2:  # 1, 3, 4 and 5 stay on one side
        return
    _, table = automaton()
    for prefixes in _prefixes(span, p - 1, table):
        for start in range(0, len(prefixes.codes), CHUNK):
            codes = _closed_by_one(prefixes.rows(slice(start, start + CHUNK)), p, table)
            inside = (codes > span.after) & (codes <= span.upto)
            if inside.any():
                yield codes if inside.all() else codes[inside]


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
    _, table = automaton()
    head, verdicts = _verdicts(codes, p, min(_FIRST_SYMBOLS, p), table)
    verdict = verdicts.ravel().take(len(table) * head + states)
    return _read_on(codes, states, p, verdict)


def _closed_by_one(prefixes: "_Prefixes", p: int, table: NDArray[np.int8]) -> NDArray[np.int64]:
    """Return the Lyndon words of order p, packed, that prefixes grow to by one symbol and that close."""
    codes, _, states = prefixes
    head, verdicts = _verdicts(codes << BITS, p, min(_FIRST_SYMBOLS, p - 1), table)
    after = np.where(table < 0, 0, table)
    closing = (table >= 0) & (verdicts[:, after] != _DEAD)
    chosen = _as_integers(closing).ravel().take(len(table) * head + states)
    places = np.flatnonzero((chosen & _ABOVE[_back(prefixes)]).view(np.bool_))
    parent, symbol = places >> BITS, places & 7
    words, ends = codes[parent] << BITS | symbol, after[states[parent], symbol]
    verdict = verdicts.ravel().take(len(table) * head[parent] + ends)
    return words[_read_on(words, ends, p, verdict)]


def _verdicts(
    codes: NDArray[np.int64], p: int, first: int, table: NDArray[np.int8]
) -> tuple[NDArray[np.intp], NDArray[np.int8]]:
    """Tell what reading the first symbols of words again, in any state, says of whether they close.

    Parameters
    ----------
    codes : ndarray of int64, shape (N,)
        Packed words of order p; what is looked at are so many first symbols.

    Returns
    -------
    head : ndarray of intp, shape (N,)
        The number of each word's first symbols among those that follow one another.
    verdicts : ndarray of int8, shape (heads, states)
        `_CLOSED` where the state is then the one that it was when they were read for the first time: what
        follows has been read, too. `_OPEN` where it is another.
    """
    heads = codes >> BITS * (p - first)
    fresh = np.concatenate([np.ones(min(len(heads), 1), dtype=bool), heads[1:] != heads[:-1]])
    different = heads[fresh]
    kept, _ = automaton()
    rooted = np.array([state.left is not None for state in kept])
    again = np.tile(np.arange(len(table)), (len(different), 1))
    once = different >> BITS * (first - 1)  # the states after one symbol have its number
    for place in range(first - 1, -1, -1):
        again = _read(different[:, None], again, [place], table)
        once = once if place == first - 1 else _read(different, once, [place], table)
    alive = (again >= 0) & rooted  # only 02 has no root, and rule 3 forbids it
    verdicts = np.where(alive, np.where(again == once[:, None], _CLOSED, _OPEN), _DEAD).astype(np.int8)
    return fresh.cumsum() - 1, verdicts


def _read_on(
    codes: NDArray[np.int64], states: NDArray[np.int8], p: int, verdict: NDArray[np.int8]
) -> NDArray[np.intp]:
    """Return the places of words that close, of which verdicts are known: read those that are open again."""
    still = np.flatnonzero(verdict == _OPEN)
    if len(still):
        _, table = automaton()
        state = _read(codes[still], states[still].astype(np.intp), range(p - 1, -1, -1), table)
        verdict[still] = np.where(state >= 0, _CLOSED, _DEAD)
    return np.flatnonzero(verdict == _CLOSED)


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
    back = _back(prefixes)
    chosen = _as_integers(table >= 0)[states] & _NOT_BELOW[back]
    places = np.flatnonzero(chosen.view(np.bool_))
    parent, symbol = places >> BITS, places & 7
    repeats = symbol == back[parent]
    return _Prefixes(
        codes[parent] << BITS | symbol,
        np.where(repeats, lyndon[parent], np.int8(n + 1)),
        table[states[parent], symbol],
    )


def _back(prefixes: _Prefixes) -> NDArray[np.int64]:
    """Return the symbol of each prefix that the next one must not be below."""
    return (prefixes.codes >> (BITS * (prefixes.lyndon.astype(np.int64) - 1))) & 7


def _as_integers(chosen: NDArray[np.bool_]) -> NDArray[np.uint64]:
    """Return marks of symbols, shape (..., 6), as one integer for all of them, a byte each: shape (...)."""
    marks = np.zeros((*chosen.shape[:-1], 8), dtype=bool)
    marks[..., : chosen.shape[-1]] = chosen
    return marks.view(np.uint64)[..., 0]


_NOT_BELOW = _as_integers(np.arange(6) >= np.arange(6)[:, None])
_ABOVE = _as_integers(np.arange(6) > np.arange(6)[:, None])
"""The symbols that are not below, and that are above, each symbol."""
