"""Blocks of births: pieces of periods of which the changes are found apart, by whatever process.

Few words take almost as long as thousands, so that small periods go into one block together.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.orbits.births.changes import Changes, find_changes_together
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import all_least_words, class_spans, least_words
from orbitdb.symbols.members import joined_words
from orbitdb.symbols.words import unpack

BLOCK = 1 << 17
"""Words of a block: some seconds of work. A third of a second goes into any block, however small."""

_WORDS_A_CLASS = 8
_BLOCKS_A_JOB = 3
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

    def solved(self) -> "SolvedBirths":
        """Find its classes and their changes."""
        classes, by = [all_least_words(span) for span in self.spans], arithmetic()
        least = [unpack(each.codes, span.p) for each, span in zip(classes, self.spans, strict=True)]
        stabilisers = [each.stabiliser for each in classes]
        words = [joined_words(*each, span.p) for each, span in zip(classes, self.spans, strict=True)]
        parts = zip(self.spans, least, stabilisers, words, find_changes_together(least), strict=True)
        return SolvedBirths(tuple(SolvedSpan(*part, by) for part in parts), by)


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


@dataclass(frozen=True, eq=False)
class SolvedBirths:
    """What became of a block.

    Attributes
    ----------
    parts : tuple of SolvedSpan
    arithmetic : str
        What computed it (`orbitdb.arithmetic.arithmetic`).
    """

    parts: tuple[SolvedSpan, ...]
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
        room, size = block, block
        if jobs > 1:
            size = min(block, max(total // (_BLOCKS_A_JOB * jobs), block // _SMALLEST))
        most = size // _WORDS_A_CLASS
        yield from (BirthBlock((span,)) for span in _joined(class_spans(p, most, after), most))
    if small:
        yield BirthBlock(tuple(small))


def _joined(spans: Iterable[Span], most: int) -> Iterator[Span]:
    """Join neighbours as long as they have no more classes together; most least words are low ones."""
    held, count = None, 0
    for span in spans:
        more = sum(len(each.codes) for each in least_words(span))
        if held is not None and count + more > most:
            yield held
            held, count = None, 0
        held = span if held is None else held._replace(upto=span.upto)
        count += more
    if held is not None:
        yield held
