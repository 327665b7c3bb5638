"""Geometric pruning: the paper's rules 1-6, and an automaton that applies them symbol by symbol.

The rules apply to cyclic words and hold for every a. Words that break no rule are *admissible*. The automaton
prunes prefixes while words are generated (`orbitdb.symbols.enumeration`). Its transition table also serves as
a transfer matrix, whose traces count the words of any period without generating them.

Source: Biham and Kvale, appendix.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats, Indices, Marks, Masks, Words
from orbitdb.billiard.stadium import SIDE
from orbitdb.symbols.words import SYMBOLS, WordError, from_strings, symbols_after, symbols_before, to_strings

FAMILY = "02"
"""The word of the bouncing-ball orbits, which are marginal and not isolated, and so never counted."""


class Rule(NamedTuple):
    """A geometric pruning rule: its number in the paper, and how a word breaks it."""

    number: int
    sentence: str


RULES = (
    Rule(1, "hits the same straight wall twice in succession"),
    Rule(2, "has an isolated 4 or 5 (a single bounce on a semicircle is written 1 or 3)"),
    Rule(3, "does not hit both semicircles"),
    Rule(4, "goes from a semicircle to one wall and back to the same semicircle"),
    Rule(5, "changes its sense of rotation along a semicircle"),
    Rule(6, "goes from a semicircle to two or more walls and back to the same semicircle"),
)


def rules_broken(words: Words) -> Masks:
    """Return bit masks of the rules that words, shape (N, p), break; bit n - 1 stands for rule n.

    It states the rules a second time, for whole words: the automaton takes a step a symbol, which is slow for
    a word of a million bounces. Fills of pruned words compare the two.
    """
    before, after = symbols_before(words), symbols_after(words)
    sides = SIDE[words]
    curved, other = sides != 0, words != after
    walls, same = _walls_since(sides)
    one_sided = ~((sides < 0).any(axis=1) & (sides > 0).any(axis=1))
    broken = (
        (~curved & ~other).any(axis=1),
        ((words >= 4) & (words != before) & other).any(axis=1),
        one_sided,
        (same & (walls == 1)).any(axis=1),
        (curved & (sides == SIDE[after]) & other).any(axis=1),
        (same & (walls >= 2)).any(axis=1),
    )
    return np.packbits(broken, axis=0, bitorder="little")[0]


def _walls_since(sides: Floats) -> tuple[Indices, Marks]:
    """For each bounce, count the walls since the last semicircle; tell whether it is on that one again."""
    p = sides.shape[1]
    twice = np.concatenate([sides, sides], axis=1)
    places = np.where(twice != 0, np.arange(2 * p), -1)
    last = np.maximum.accumulate(places, axis=1)[:, p - 1 : -1]
    again = np.take_along_axis(twice, last, axis=1) == sides
    return np.arange(p, 2 * p) - last - 1, again & (sides != 0) & (last >= 0)


def rule_numbers(mask: int) -> list[int]:
    """Return the numbers of the rules in a bit mask of `rules_broken`."""
    return [rule.number for rule in RULES if mask >> (rule.number - 1) & 1]


def rules_of(word: str) -> list[int]:
    """Return the numbers of the rules that a word breaks, an empty list if it is admissible."""
    return rule_numbers(int(rules_broken(from_strings([word]))[0]))


def rules_of_pattern(pattern: str) -> list[Rule]:
    """Return the rules that every word with these consecutive symbols breaks."""
    state, broken = _first(int(pattern[0])), set[int]()
    for symbol in pattern[1:]:
        state, new = _follow(state, int(symbol))
        broken |= new
    return [rule for rule in RULES if rule.number in broken]


def need_admissible(words: object) -> None:
    """Raise `WordError` unless the argument is an array of admissible words, shape (N, p).

    Raises
    ------
    WordError
        If the argument is not an array of words, or for the first word that is not admissible.
    """
    if not isinstance(words, np.ndarray) or words.ndim != 2 or words.dtype.kind not in "iu":
        raise WordError(
            "give words as an array of shape (N, p), such as orbitdb.symbols.words.from_strings returns"
        )
    if words.size and not 0 <= words.min() <= words.max() < len(SYMBOLS):
        raise WordError("words may contain only the symbols 0 to 5")
    if (masks := rules_broken(words)).any():
        row = int(np.flatnonzero(masks)[0])
        broken = ", ".join(map(str, rule_numbers(int(masks[row]))))
        raise WordError(f"word {row}, {to_strings(words[row : row + 1])[0]:.40}, is pruned by rule {broken}")


RULE_NUMBERS = frozenset(rule.number for rule in RULES)
STRAIGHT_SYMBOLS, LEFT_SYMBOLS = (0, 2), (1, 4)


class PrefixState(NamedTuple):
    """What a prefix implies about the symbols that may follow it."""

    symbol: int  # the last symbol
    left: bool | None  # whether the last semicircle was the left one; None if there was none yet
    walls: int  # number of straight bounces since then; 2 stands for two or more
    lone: bool  # whether the last symbol is a 4 or 5 that differs from the one before it


def _first(symbol: int) -> PrefixState:
    """Return the state after the first symbol of a word, whose cyclic predecessor is not yet known."""
    straight = symbol in STRAIGHT_SYMBOLS
    return PrefixState(symbol, None if straight else symbol in LEFT_SYMBOLS, int(straight), False)


def _follow(state: PrefixState, symbol: int) -> tuple[PrefixState, set[int]]:
    """Return the state after one more symbol, and the numbers of the rules that this symbol breaks."""
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
        return PrefixState(symbol, state.left, min(state.walls + 1, 2), False), broken
    return PrefixState(symbol, symbol in LEFT_SYMBOLS, 0, symbol >= 4 and symbol != state.symbol), broken


@cache
def automaton(rules: frozenset[int] = RULE_NUMBERS) -> tuple[tuple[PrefixState, ...], NDArray[np.int8]]:
    """Return all states and the transition table, with -1 for transitions that the given rules forbid."""
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
    """Count all primitive cyclic words of period p over 6 symbols (Moreau's formula)."""
    return count_cycles(p, lambda n: 6**n)


def count_admissible(p: int, rules: frozenset[int] = RULE_NUMBERS) -> int:
    """Count the primitive cyclic words of any period p that break none of the given rules.

    With all rules, the default, this is the paper's N_t(p).
    """
    return count_cycles(p, lambda n: _count_rooted(n, rules))


def count_pruned(p: int) -> int:
    """Count the primitive cyclic words of period p that break a geometric rule, without the family 02."""
    return count_primitive(p) - count_admissible(p) - (p == len(FAMILY))


def count_cycles(p: int, rooted: Callable[[int], int]) -> int:
    """Return the number of primitive cyclic words of period p, given the number of rooted words by length."""
    primitive: dict[int, int] = {}  # number of closed walks that do not repeat a shorter one, by length
    for n in (d for d in range(1, p + 1) if p % d == 0):
        primitive[n] = rooted(n) - sum(count for d, count in primitive.items() if n % d == 0)
    return primitive[p] // p


def _count_rooted(n: int, rules: frozenset[int]) -> int:
    """Count the words of length n that obey the given rules, rotations and repetitions included."""
    every = _closed_walks(n, rules, tuple(range(6)))
    if 3 not in rules:
        return every
    one_sided = _closed_walks(n, rules, _NO_RIGHT) + _closed_walks(n, rules, _NO_LEFT)
    return every - one_sided + _closed_walks(n, rules, STRAIGHT_SYMBOLS)


@cache
def _closed_walks(n: int, rules: frozenset[int], symbols: tuple[int, ...]) -> int:
    """Return the trace of the n-th power of the transfer matrix restricted to the given symbols.

    A word that hits a semicircle determines the state in which its closed walk begins. A word of walls alone
    has three closed walks (the automaton remembers the left semicircle, the right one, or none) but must
    count once, so two of them are subtracted.
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
