"""Counts of cyclic words of any order, from the transfer matrix of the pruning rules."""

from collections.abc import Callable
from functools import cache

import numpy as np

from orbitdb.symbols.automaton import RULE_NUMBERS, STRAIGHT_SYMBOLS, automaton

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
