"""The pruning rules as a finite automaton that reads a word symbol by symbol, and counts of words from it.

It is used twice: to prune prefixes while words are generated (`orbitdb.symbols.enumeration`), and as a
transfer matrix whose traces count words of any order without generating one.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.pruning import RULES

RULE_NUMBERS = frozenset(rule.number for rule in RULES)
STRAIGHT_SYMBOLS, LEFT_SYMBOLS = (0, 2), (1, 4)


class State(NamedTuple):
    """What a prefix decides of the symbols that may follow it."""

    symbol: int  # the last one
    left: bool | None  # whether the last semicircle was the left one; None before the first
    walls: int  # straight bounces since then; 2 stands for more, too
    lone: bool  # whether the last symbol is a 4 or 5 that differs from the one before it


def _first(symbol: int) -> State:
    """Return the state after a word's first symbol, whose left neighbour is not known yet."""
    straight = symbol in STRAIGHT_SYMBOLS
    return State(symbol, None if straight else symbol in LEFT_SYMBOLS, int(straight), False)


def _follow(state: State, symbol: int) -> tuple[State, set[int]]:
    """Return the state after one more symbol, and the numbers of the rules this breaks."""
    straight = symbol in STRAIGHT_SYMBOLS
    broken = set()
    if straight and symbol == state.symbol:
        broken.add(1)
    if state.lone and symbol != state.symbol:
        broken.add(2)
    if not straight and state.left == (symbol in LEFT_SYMBOLS):
        if state.walls:
            broken.add(4 if state.walls == 1 else 6)
        elif symbol != state.symbol:
            broken.add(5)
    if straight:
        return State(symbol, state.left, min(state.walls + 1, 2), False), broken
    return State(symbol, symbol in LEFT_SYMBOLS, 0, symbol >= 4 and symbol != state.symbol), broken


@cache
def automaton(rules: frozenset[int] = RULE_NUMBERS) -> tuple[tuple[State, ...], NDArray[np.int8]]:
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


_INT64_LENGTH = 24  # 6^24 < 2^63
_NO_RIGHT, _NO_LEFT = (0, 1, 2, 4), (0, 2, 3, 5)


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
    return every - one_sided + _closed_walks(n, rules, STRAIGHT_SYMBOLS)


@cache
def _closed_walks(n: int, rules: frozenset[int], symbols: tuple[int, ...]) -> int:
    """Return the trace of the n-th power of the transfer matrix over some of the symbols.

    A word with a semicircle fixes the state it returns to. A word of walls alone closes three times,
    for either semicircle remembered and for none, and must count once.
    """
    states, table = automaton(rules)
    exact = np.int64 if n <= _INT64_LENGTH else object
    matrix = np.zeros((len(states), len(states)), dtype=exact)
    for row in range(len(states)):
        for symbol in symbols:
            if table[row, symbol] >= 0:
                matrix[row, table[row, symbol]] += 1
    power = np.linalg.matrix_power(matrix, n)
    rootless = [i for i, state in enumerate(states) if state.left is None]
    return int(np.trace(power)) - 2 * int(sum(power[i, i] for i in rootless))
