"""Geometric pruning: the paper's rules 1-6 as data.

A rule speaks of a cyclic word and holds for every a. Words that break none are *admissible*.

Source: Biham and Kvale, appendix.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.symbols.words import SYMBOLS, WordError, from_strings, to_strings

Words = NDArray[np.uint8]

FAMILY = "02"
"""The bouncing-ball orbits: marginal, not isolated, never counted."""

_NONE, _LEFT, _RIGHT = 0, 1, 2
_SIDE = np.array([_NONE, _LEFT, _NONE, _RIGHT, _LEFT, _RIGHT], dtype=np.uint8)


@dataclass(frozen=True)
class Rule:
    """One geometric pruning rule.

    Attributes
    ----------
    number : int
        The number in the paper's appendix.
    sentence : str
        What the word does that no orbit can do.
    broken : callable
        From words, shape (N, p), to booleans, shape (N,): which of them break the rule.
    """

    number: int
    sentence: str
    broken: Callable[[Words], NDArray[np.bool_]]


def _before(words: Words) -> Words:
    return np.roll(words, 1, axis=1)


def _after(words: Words) -> Words:
    return np.roll(words, -1, axis=1)


def _somewhere(marks: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Tell which words have a mark at some bounce."""
    found: NDArray[np.bool_] = np.logical_or.reduce(marks, axis=1)
    return found


def _same_wall_twice(words: Words) -> NDArray[np.bool_]:
    return _somewhere((_SIDE[words] == _NONE) & (words == _after(words)))


def _isolated_downward(words: Words) -> NDArray[np.bool_]:
    return _somewhere((words >= 4) & (words != _before(words)) & (words != _after(words)))


def _misses_a_semicircle(words: Words) -> NDArray[np.bool_]:
    sides = _SIDE[words]
    return ~((sides == _LEFT).any(axis=1) & (sides == _RIGHT).any(axis=1))


def _turns_on_a_semicircle(words: Words) -> NDArray[np.bool_]:
    sides = _SIDE[words]
    return _somewhere((sides != _NONE) & (sides == _after(sides)) & (words != _after(words)))


def _walls_between_visits(words: Words) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return, for each bounce, the walls hit since the last semicircle, and whether it was this one."""
    p = words.shape[1]
    sides = _SIDE[words]
    twice = np.concatenate([sides, sides], axis=1)
    places = np.where(twice != _NONE, np.arange(2 * p), -1)
    last = np.maximum.accumulate(places, axis=1)[:, p - 1 : -1]
    walls = np.arange(p, 2 * p) - last - 1
    again = np.take_along_axis(twice, last, axis=1) == sides
    return walls, again & (sides != _NONE) & (last >= 0)


def _returns_after_one_wall(words: Words) -> NDArray[np.bool_]:
    walls, same = _walls_between_visits(words)
    return _somewhere(same & (walls == 1))


def _returns_after_walls(words: Words) -> NDArray[np.bool_]:
    walls, same = _walls_between_visits(words)
    return _somewhere(same & (walls >= 2))


RULES = (
    Rule(1, "hits one straight wall twice in succession", _same_wall_twice),
    Rule(2, "has an isolated 4 or 5 (a single bounce on a semicircle is written 1 or 3)", _isolated_downward),
    Rule(3, "does not hit both semicircles", _misses_a_semicircle),
    Rule(4, "goes from a semicircle to one wall and back to the same semicircle", _returns_after_one_wall),
    Rule(5, "changes its sense of rotation along a semicircle", _turns_on_a_semicircle),
    Rule(6, "goes from a semicircle over two or more walls back to the same one", _returns_after_walls),
)


def rules_broken(words: Words) -> NDArray[np.uint8]:
    """Return for each word, shape (N, p), the bit mask of the rules it breaks (bit number - 1)."""
    mask = np.zeros(len(words), dtype=np.uint8)
    for rule in RULES:
        mask |= rule.broken(words).astype(np.uint8) << np.uint8(rule.number - 1)
    return mask


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
