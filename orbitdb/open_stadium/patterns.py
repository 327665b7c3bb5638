"""Patterns of symbols through which trajectories escape: the automaton that finds them symbol by symbol."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orbitdb.arrays import Floats, Indices
from orbitdb.symbols.words import SYMBOLS

DEAD = -1
"""The state after a pattern is complete."""


@dataclass(frozen=True)
class Patterns:
    """Patterns of consecutive symbols, and the automaton of Aho and Corasick that finds the first of them.

    A state is the longest end of the symbols so far that begins a pattern; state 0 is the empty one.
    """

    texts: tuple[str, ...]

    @cached_property
    def states(self) -> tuple[str, ...]:
        """The beginnings of patterns, without those that contain one."""
        starts = dict.fromkeys(text[:n] for text in self.texts for n in range(len(text)))
        kept = (start for start in starts if not any(text in start for text in self.texts))
        return tuple(sorted(kept, key=len))

    @cached_property
    def step(self) -> Indices:
        """The state after each state and symbol, shape (states, 6), `DEAD` if a pattern is complete."""
        return np.array([[self._after(state + symbol) for symbol in SYMBOLS] for state in self.states])

    def _after(self, text: str) -> int:
        if any(text.endswith(pattern) for pattern in self.texts):
            return DEAD
        return next(self.states.index(text[n:]) for n in range(len(text) + 1) if text[n:] in self.states)

    @cached_property
    def period(self) -> int:
        """Number of alternating walls after which states repeat with every second wall."""
        return 2 * len(self.states) + 2

    @cached_property
    def along_walls(self) -> tuple[Indices, Floats]:
        """The states after 0 to `period` + 1 alternating walls, and the number of the fatal one, inf if none.

        Shapes (states, 2, period + 2) and (states, 2): state before, and whether the first wall is the top.
        """
        after = np.full((len(self.states), 2, self.period + 2), DEAD)
        fatal = np.full((len(self.states), 2), np.inf)
        for start in range(len(self.states)):
            for top in range(2):
                state = after[start, top, 0] = start
                for number in range(1, self.period + 2):
                    state = self.step[state, 2 * ((top + number - 1) % 2)]
                    if state == DEAD:
                        fatal[start, top] = number
                        break
                    after[start, top, number] = state
        return after, fatal

    def cross(self, state: Indices, top: Indices, walls: Floats) -> tuple[Indices, Floats]:
        """Follow N states along alternating walls, first the top one where `top` is 1.

        Returns the states afterwards, and the number of the fatal wall, inf if none.
        """
        after, fatal = self.along_walls
        beyond = walls > self.period
        number = np.where(beyond, self.period + (walls - self.period) % 2, walls).astype(np.intp)
        deadly = fatal[state, top]
        return after[state, top, number], np.where(deadly <= walls, deadly, np.inf)

    def forbid(self, before: str, middle: str, after: str) -> bool:
        """Tell whether a pattern occurs in a text between endless repetitions of one text and of another."""
        times = max(map(len, self.texts)) + 1
        text = before * times + middle + after * times
        return any(pattern in text for pattern in self.texts)


def patterns_of(texts: Sequence[str]) -> Patterns | None:
    """Return the automaton of some patterns, or None if there are none."""
    return Patterns(tuple(texts)) if texts else None
