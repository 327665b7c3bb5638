"""Blocks of births: pieces of periods of which the changes are found apart, by whatever process.

Few words take almost as long as thousands, so that small periods go into one block together.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.equality import ByValue
from orbitdb.orbits.births import Changes, find_changes_together
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span, admissible_words, spans
from orbitdb.symbols.symmetry import classify
from orbitdb.symbols.words import BITS, pack
from orbitdb.version import __version__

BLOCK = 1 << 15
"""Words of a block: a second of work or two."""

_BLOCKS_A_JOB = 3
_FIRST_LIGHT, _LIGHTER = 2, 8
"""From 02 on hardly a word is the least of its class, as a mirror image or the reverse begins with 01."""
_SOON = 8
"""The first block has at most this part of a full one, so that something is stored soon."""

_SMALLEST = 4
"""Where several processes work, a period is cut into blocks down to this part of a full one."""


@dataclass(frozen=True)
class BirthBlock:
    """Words of which the changes are to be found.

    Attributes
    ----------
    spans : tuple of Span
        The words, each span of another period.
    """

    spans: tuple[Span, ...]

    def solved(self) -> "SolvedBirths":
        """Find its words, their symmetry classes, and the changes of the classes whose least words it has."""
        words, stabilisers, counts = [], [], []
        for span in self.spans:
            none = np.zeros((0, span.p), dtype=np.uint8)
            here = np.concatenate([none, *admissible_words(*span)])
            classes = classify(here)
            least = classes.representative == pack(here)
            words.append(here[least])
            stabilisers.append(classes.stabiliser[least])
            counts.append(len(here))
        parts = zip(self.spans, counts, words, stabilisers, find_changes_together(words), strict=True)
        return SolvedBirths(tuple(SolvedSpan(*part) for part in parts), __version__, arithmetic())


@dataclass(frozen=True, eq=False)
class SolvedSpan(ByValue):
    """What became of one span.

    Attributes
    ----------
    span : Span
    count : int
        How many words it has.
    words : ndarray of uint8, shape (N, p)
        Those of them that are the least of their classes, in order.
    stabiliser : ndarray of uint8, shape (N,)
        Their stabilisers.
    changes : Changes
        Their births and deaths.
    """

    span: Span
    count: int
    words: NDArray[np.uint8]
    stabiliser: NDArray[np.uint8]
    changes: Changes


@dataclass(frozen=True, eq=False)
class SolvedBirths(ByValue):
    """What became of a block.

    Attributes
    ----------
    parts : tuple of SolvedSpan
    version, arithmetic : str
        Of the orbitdb that solved it, and what computed there (`orbitdb.arithmetic.arithmetic`).
    """

    parts: tuple[SolvedSpan, ...]
    version: str
    arithmetic: str


def birth_blocks(periods: Sequence[tuple[int, int]], block: int, jobs: int) -> Iterator[BirthBlock]:
    """Cut periods into blocks, in order.

    Parameters
    ----------
    periods : sequence of (int, int)
        Rising periods, each with the packed word behind which it is to be searched, -1 for all of it.
    block : int
        Words of a block, at most.
    jobs : int
        How many are solved at once: for several of them the highest periods make smaller blocks.
    """
    small: list[Span] = []
    room = block // _SOON
    for p, after in periods:
        total = count_admissible(p)
        if small and (after >= 0 or total > room):
            yield BirthBlock(tuple(small))
            small, room = [], block
        if after < 0 and total <= room:
            small.append(Span.whole(p))
            room -= total
            continue
        room, size = 0, block
        if jobs > 1:
            size = min(block, max(total // (_BLOCKS_A_JOB * jobs), block // _SMALLEST))
        yield from (BirthBlock((span,)) for span in _spans(p, size, after))
    if small:
        yield BirthBlock(tuple(small))


def _spans(p: int, size: int, after: int) -> Iterator[Span]:
    """Cut the words of a period behind one into spans that have about equally many least words of classes."""
    light = _FIRST_LIGHT << BITS * (p - 2)
    for span in spans(p, size, after):
        if span.after >= light:
            yield from spans(p, _LIGHTER * size, span.after)
            return
        yield span
