"""The pruning rules as a finite automaton that reads a word symbol by symbol.

It is used twice: to prune prefixes while words are generated (`orbitdb.symbols.least_words`), and as a
transfer matrix whose traces count words of any order without generating one (`orbitdb.symbols.counting`).
"""

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
