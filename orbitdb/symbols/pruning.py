"""Geometric pruning: the paper's rules 1-6 as data.

A rule speaks of a cyclic word and holds for every a. Words that break none are *admissible*.

Source: Biham and Kvale, appendix.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.words import SYMBOLS, WordError, from_strings, to_strings

Words = NDArray[np.uint8]

FAMILY = "02"
"""The bouncing-ball orbits: marginal, not isolated, never counted."""

_NONE, _LEFT, _RIGHT = 0, 1, 2
_SIDE = np.array([_NONE, _LEFT, _NONE, _RIGHT, _LEFT, _RIGHT], dtype=np.uint8)


class Rule(NamedTuple):
    """A geometric pruning rule: its number in the paper, and what a word does that no orbit can do."""

    number: int
    sentence: str


RULES = (
    Rule(1, "hits one straight wall twice in succession"),
    Rule(2, "has an isolated 4 or 5 (a single bounce on a semicircle is written 1 or 3)"),
    Rule(3, "does not hit both semicircles"),
    Rule(4, "goes from a semicircle to one wall and back to the same semicircle"),
    Rule(5, "changes its sense of rotation along a semicircle"),
    Rule(6, "goes from a semicircle over two or more walls back to the same one"),
)


def rules_broken(words: Words) -> NDArray[np.uint8]:
    """Return for each word, shape (N, p), the bit mask of the rules it breaks (bit number - 1)."""
    before, after = np.roll(words, 1, axis=1), np.roll(words, -1, axis=1)
    sides = _SIDE[words]
    curved, other = sides != _NONE, words != after
    walls, same = _walls_since(sides)
    one_sided = ~((sides == _LEFT).any(axis=1) & (sides == _RIGHT).any(axis=1))
    broken = (
        _somewhere(~curved & ~other),
        _somewhere((words >= 4) & (words != before) & other),
        one_sided,
        _somewhere(same & (walls == 1)),
        _somewhere(curved & (sides == _SIDE[after]) & other),
        _somewhere(same & (walls >= 2)),
    )
    return np.packbits(broken, axis=0, bitorder="little")[0]


def _somewhere(marks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which words have a mark at some bounce."""
    found: NDArray[np.bool_] = np.logical_or.reduce(marks, axis=1)
    return found


def _walls_since(sides: NDArray[np.uint8]) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return, for each bounce, the walls hit since the last semicircle, and whether it is on that one."""
    p = sides.shape[1]
    twice = np.concatenate([sides, sides], axis=1)
    places = np.where(twice != _NONE, np.arange(2 * p), -1)
    last = np.maximum.accumulate(places, axis=1)[:, p - 1 : -1]
    again = np.take_along_axis(twice, last, axis=1) == sides
    return np.arange(p, 2 * p) - last - 1, again & (sides != _NONE) & (last >= 0)


def rule_numbers(mask: int) -> list[int]:
    """Return the numbers of the rules in a bit mask of `rules_broken`."""
    return [rule.number for rule in RULES if mask >> (rule.number - 1) & 1]


def rules_of(word: str) -> list[int]:
    """Return the numbers of the rules that one word breaks; empty if it is admissible."""
    return rule_numbers(int(rules_broken(from_strings([word]))[0]))


def need_admissible(words: Words) -> None:
    """Raise unless words are an array, shape (N, p), of admissible ones.

    Raises
    ------
    WordError
        With the first that is not admissible.
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
