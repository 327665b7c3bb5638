"""Blocks of births: pieces of periods of which the changes are found apart, by whatever process.

Few words take almost as long as thousands: so small periods, and pieces of large ones with few classes, go
into one block together.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.filling.blocks import block_size
from orbitdb.orbits.births.changes import Changes, find_changes_together
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import all_least_words, class_spans, least_words
from orbitdb.symbols.members import joined_words
from orbitdb.symbols.symmetry import SIZES
from orbitdb.symbols.words import unpack

BLOCK = 1 << 17
"""Words of a block: some seconds of work. A third of a second goes into any block, however small."""

_WORDS_A_CLASS = 8
_SOON = 8
"""The first block has at most this part of a full one, so that something is stored soon."""

_SMALLEST = 2
"""Where several processes work, a period is cut into blocks down to this part of a full one."""


@dataclass(frozen=True)
class BirthBlock:
    """Classes of which the changes are to be found.

    Attributes
    ----------
    spans : tuple of Span
        Their least words, each span of another period.
    """

    spans: tuple[Span, ...]

    def solved(self) -> "tuple[SolvedSpan, ...]":
        """Find its classes and their changes."""
        classes = [all_least_words(span) for span in self.spans]
        least = [unpack(each.codes, span.p) for each, span in zip(classes, self.spans, strict=True)]
        stabilisers = [each.stabiliser for each in classes]
        words = [joined_words(*each, span.p) for each, span in zip(classes, self.spans, strict=True)]
        parts = zip(self.spans, least, stabilisers, words, find_changes_together(least), strict=True)
        return tuple(SolvedSpan(*part, arithmetic()) for part in parts)


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
    held: dict[int, Span] = {}
    count, room = 0, block // _SOON
    for p, after in periods:
        most = block_size(block, p, jobs, _SMALLEST)
        for span in class_spans(p, most // _WORDS_A_CLASS, after):
            more = sum(int(SIZES[each.stabiliser].sum()) for each in least_words(span))
            if held and count + more > min(room, most):
                yield BirthBlock(tuple(held.values()))
                held, count, room = {}, 0, block
            held[p] = held[p]._replace(upto=span.upto) if p in held else span
            count += more
    if held:
        yield BirthBlock(tuple(held.values()))
