"""The pruning rules as a finite automaton that reads a word symbol by symbol.

It is used three times: to tell at once which of many words are admissible, to prune prefixes while words
are generated (`orbitdb.symbols.enumeration`), and as a transfer matrix whose traces count words of any
order without generating one (`orbitdb.symbols.counting`).
"""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.pruning import RULES

RULE_NUMBERS = frozenset(rule.number for rule in RULES)
STRAIGHT_SYMBOLS, LEFT_SYMBOLS = (0, 2), (1, 4)

_LEFT, _RIGHT = 1, 2
_SIDES = np.array([0, _LEFT, 0, _RIGHT, _LEFT, _RIGHT, 0], dtype=np.uint8)
"""Bits that say which semicircle a symbol is on; the last entry is for what is no symbol."""


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


def admissible(words: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Tell which words, shape (N, p), break no rule, as `orbitdb.symbols.pruning.rules_broken` does.

    Far quicker for many words. Numbers that are no symbols may stand in them: they break a rule.
    """
    columns = np.minimum(words, len(_SIDES) - 1).T
    table = _closed_table()
    state = columns[0].copy()
    for column in (*columns[1:], *columns):  # twice around: the first bounce has neighbours, too
        state = table[state, column]
    sides = np.bitwise_or.reduce(_SIDES[columns], axis=0)
    found: NDArray[np.bool_] = (state < len(table) - 1) & (sides == (_LEFT | _RIGHT))
    return found


@cache
def _closed_table() -> NDArray[np.uint8]:
    """Return the table of transitions under all rules with one more state, the last, for broken words.

    It has one more column, too, for what is no symbol.
    """
    _, table = automaton()
    closed = np.full((len(table) + 1, len(_SIDES)), len(table), dtype=np.uint8)
    closed[:-1, :-1] = np.where(table < 0, len(table), table)
    return closed
