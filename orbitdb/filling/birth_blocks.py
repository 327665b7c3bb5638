"""Blocks of births: pieces of periods of which the changes are found apart, by whatever process."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.filling.blocks import block_size
from orbitdb.orbits.births.changes import Changes, find_changes
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import all_least_words, class_spans
from orbitdb.symbols.members import joined_words
from orbitdb.symbols.words import unpack

BLOCK = 1 << 18
"""Words of a block: some seconds of work."""

_WORDS_A_CLASS = 8
_SMALLEST = 2
"""Where several processes work, a period is cut into blocks down to this part of a full one."""


@dataclass(frozen=True)
class BirthBlock:
    """Classes of one period of which the changes are to be found.

    Attributes
    ----------
    span : Span
        Their least words.
    """

    span: Span

    def solved(self) -> "SolvedSpan":
        """Find its classes and their changes."""
        p, (codes, stabiliser) = self.span.p, all_least_words(self.span)
        least, words = unpack(codes, p), joined_words(codes, stabiliser, p)
        return SolvedSpan(self.span, least, stabiliser, words, find_changes(least), arithmetic())


@dataclass(frozen=True, eq=False)
class SolvedSpan:
    """What became of one span.

    Attributes
    ----------
    span : Span
    least : ndarray of uint8, shape (N, p)
        The least words of its classes, in order.
    stabiliser : ndarray of uint8, shape (N,)
        Their stabilisers.
    words : list of str, length N
        All words of each class (`orbitdb.symbols.members.joined_words`).
    changes : Changes
        Their births and deaths.
    arithmetic : str
        What computed them (`orbitdb.arithmetic.arithmetic`).
    """

    span: Span
    least: NDArray[np.uint8]
    stabiliser: NDArray[np.uint8]
    words: list[str]
    changes: Changes
    arithmetic: str


def birth_blocks(p: int, after: int, block: int, jobs: int) -> Iterator[BirthBlock]:
    """Cut a period, or what of it is behind a packed word, into blocks, in order.

    Parameters
    ----------
    p, after : int
    block : int
        Words of a block, about.
    jobs : int
        How many are solved at once: for several of them blocks are smaller.
    """
    size = block_size(block, p, jobs, _SMALLEST) // _WORDS_A_CLASS
    return (BirthBlock(span) for span in class_spans(p, max(size, 1), after))
