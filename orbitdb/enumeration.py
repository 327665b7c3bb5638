"""Enumeration and counts of cyclic words, admissible ones above all.

The pruning rules are a finite automaton that reads a word symbol by symbol. It is used twice: to
prune prefixes while words are generated, and as a transfer matrix whose traces count the admissible
words of any order without generating one.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.pruning import RULES
from orbitdb.words import BITS, unpack

MAX_PERIOD = 20
"""The highest period that is enumerated (more than 10^9 words there)."""

CHUNK = 1 << 14
RULE_NUMBERS = frozenset(rule.number for rule in RULES)
_INT64_LENGTH = 24  # 6^24 < 2^63
_STRAIGHT, _LEFT = (0, 2), (1, 4)
_NO_RIGHT, _NO_LEFT = (0, 1, 2, 4), (0, 2, 3, 5)


class State(NamedTuple):
    """What a prefix decides of the symbols that may follow it.

    Attributes
    ----------
    symbol : int
        The last symbol.
    left : bool or None
        Whether the last semicircle was the left one; None before the first.
    walls : int
        Straight bounces since then; 2 stands for more, too.
    lone : bool
        Whether the last symbol is a 4 or 5 that differs from the one before it.
    """

    symbol: int
    left: bool | None
    walls: int
    lone: bool


def _first(symbol: int) -> State:
    """Return the state after a word's first symbol, whose left neighbour is not known yet."""
    straight = symbol in _STRAIGHT
    return State(symbol, None if straight else symbol in _LEFT, int(straight), False)


def _follow(state: State, symbol: int) -> tuple[State, set[int]]:
    """Return the state after one more symbol, and the numbers of the rules this breaks."""
    straight = symbol in _STRAIGHT
    broken = set()
    if straight and symbol == state.symbol:
        broken.add(1)
    if state.lone and symbol != state.symbol:
        broken.add(2)
    if not straight and state.left == (symbol in _LEFT):
        if state.walls:
            broken.add(4 if state.walls == 1 else 6)
        elif symbol != state.symbol:
            broken.add(5)
    if straight:
        return State(symbol, state.left, min(state.walls + 1, 2), False), broken
    return State(symbol, symbol in _LEFT, 0, symbol >= 4 and symbol != state.symbol), broken


@cache
def _automaton(rules: frozenset[int] = RULE_NUMBERS) -> tuple[tuple[State, ...], NDArray[np.int8]]:
    """Return all states and the table of transitions under some rules (-1: forbidden)."""
    states = [_first(symbol) for symbol in range(6)]
    rows = []
    for state in states:  # grows while it is read
        row = []
        for symbol in range(6):
            new, broken = _follow(state, symbol)
            if broken & rules:
                row.append(-1)
                continue
            if new not in states:
                states.append(new)
            row.append(states.index(new))
        rows.append(row)
    return tuple(states), np.array(rows, dtype=np.int8)


def admissible_words(p: int, after: int = -1) -> Iterator[NDArray[np.uint8]]:
    """Generate the admissible primitive cyclic words of order p as least rotations, in order.

    Parameters
    ----------
    p : int
        Order, 1..`MAX_PERIOD`.
    after : int, optional
        Go on behind this packed word.

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
    states, table = _automaton()
    rooted = np.array([state.left is not None for state in states])
    for prefixes in _lyndon_words(p, table, after):
        end = _read_again(prefixes, p, table)
        closed = (end >= 0) & rooted[end]  # only 02 has no root, and rule 3 forbids it
        if closed.any() and p > 1:  # of the words on one side, only 1, 3, 4 and 5 get here
            yield unpack(prefixes.codes[closed], p)


def primitive_words(p: int, after: int = -1) -> Iterator[NDArray[np.uint8]]:
    """Generate all primitive cyclic words of order p, pruned or not, as `admissible_words` does."""
    free = np.tile(np.arange(6, dtype=np.int8), (6, 1))
    for prefixes in _lyndon_words(p, free, after):
        yield unpack(prefixes.codes, p)


def _read_again(prefixes: "_Prefixes", p: int, table: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return the state after reading each word once more behind itself; -1 where a rule forbids it."""
    dead = np.full((1, table.shape[1]), -1, dtype=np.int8)
    table = np.concatenate([table, dead])  # the last row is also row -1
    state = prefixes.states
    for place in range(p - 1, -1, -1):
        state = table[state, (prefixes.codes >> BITS * place) & 7]
    return state


class _Prefixes(NamedTuple):
    codes: NDArray[np.int64]
    lyndon: NDArray[np.int8]
    states: NDArray[np.int8]

    def rows(self, chosen: slice | NDArray[np.bool_]) -> "_Prefixes":
        return _Prefixes(self.codes[chosen], self.lyndon[chosen], self.states[chosen])


def _lyndon_words(p: int, table: NDArray[np.int8], after: int) -> Iterator[_Prefixes]:
    symbols = np.arange(6)
    first = _Prefixes(symbols.astype(np.int64), np.ones(6, np.int8), symbols.astype(np.int8))
    stack = [(1, first)]
    while stack:
        n, prefixes = stack.pop()
        floor = after >> (BITS * (p - n))
        if n == p:
            whole = (prefixes.lyndon == p) & (prefixes.codes > after)
            if whole.any():
                yield prefixes.rows(whole)
            continue
        prefixes = prefixes.rows(prefixes.codes >= floor)
        if len(prefixes.codes) > CHUNK:
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


def count_primitive(p: int) -> int:
    """Count all primitive cyclic words of order p, 6 symbols (Moreau's formula)."""
    return _count_cycles(p, lambda n: 6**n)


def count_admissible(p: int, rules: frozenset[int] = RULE_NUMBERS) -> int:
    """Count the primitive cyclic words of order p that break none of the rules, for any p.

    Parameters
    ----------
    p : int
        Order.
    rules : frozenset of int, optional
        Numbers of the rules that count; by default all, which makes this the paper's N_t(p).
    """
    return _count_cycles(p, lambda n: _count_rooted(n, rules))


def _count_cycles(p: int, rooted: Callable[[int], int]) -> int:
    """Return the number of primitive cyclic words, given that of closed walks of each length."""
    return sum(_moebius(p // d) * rooted(d) for d in range(1, p + 1) if p % d == 0) // p


def _moebius(n: int) -> int:
    sign = 1
    for prime in range(2, n + 1):
        if n % prime == 0:
            n //= prime
            sign = -sign
            if n % prime == 0:
                return 0
    return sign


def _count_rooted(n: int, rules: frozenset[int]) -> int:
    """Count the words of length n, all rotations and repetitions among them, that obey some rules."""
    every = _closed_walks(n, rules, tuple(range(6)))
    if 3 not in rules:
        return every
    one_sided = _closed_walks(n, rules, _NO_RIGHT) + _closed_walks(n, rules, _NO_LEFT)
    return every - one_sided + _closed_walks(n, rules, _STRAIGHT)


@cache
def _closed_walks(n: int, rules: frozenset[int], symbols: tuple[int, ...]) -> int:
    """Return the trace of the n-th power of the transfer matrix over some of the symbols.

    A word with a semicircle fixes the state it returns to. A word of walls alone closes three times,
    for either semicircle remembered and for none, and must count once.
    """
    states, table = _automaton(rules)
    exact = np.int64 if n <= _INT64_LENGTH else object
    matrix = np.zeros((len(states), len(states)), dtype=exact)
    for row in range(len(states)):
        for symbol in symbols:
            if table[row, symbol] >= 0:
                matrix[row, table[row, symbol]] += 1
    power = np.linalg.matrix_power(matrix, n)
    rootless = [i for i, state in enumerate(states) if state.left is None]
    return int(np.trace(power)) - 2 * int(sum(power[i, i] for i in rootless))
