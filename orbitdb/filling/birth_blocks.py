"""Blocks of births: pieces of periods of which the changes are found apart, by whatever process.

Few words take almost as long as thousands, so that small periods go into one block together.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.equality import ByValue
from orbitdb.orbits.births import Changes, find_changes_together
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span, admissible_words
from orbitdb.symbols.least_words import LeastWords, class_spans, least_words
from orbitdb.symbols.words import unpack
from orbitdb.version import __version__

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
    """Words of which the changes are to be found.

    Attributes
    ----------
    spans : tuple of Span
        The words, each span of another period.
    """

    spans: tuple[Span, ...]

    def solved(self) -> "SolvedBirths":
        """Find its words, their symmetry classes, and the changes of the classes whose least words it has."""
        counts = [sum(map(len, admissible_words(*span))) for span in self.spans]
        classes = [_classes(span) for span in self.spans]
        words = [unpack(each.codes, span.p) for each, span in zip(classes, self.spans, strict=True)]
        stabilisers = [each.stabiliser for each in classes]
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


def _classes(span: Span) -> LeastWords:
    """Return the classes whose least words are in a span."""
    none = LeastWords(np.zeros(0, np.int64), np.zeros(0, np.uint8))
    return LeastWords(*map(np.concatenate, zip(none, *least_words(span), strict=True)))
