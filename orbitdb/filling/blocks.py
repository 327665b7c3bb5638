"""Blocks: pieces of a period that are enumerated and solved apart, by whatever process.

What becomes of a block depends on nothing but what it is given, so that it is the same wherever and in
whatever order blocks are solved.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.filling.workers import Task
from orbitdb.orbits.newton import solve_admissible
from orbitdb.orbits.orbit import Orbits
from orbitdb.orbits.relaxation import relax
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import all_least_words, class_spans
from orbitdb.symbols.members import joined_words
from orbitdb.symbols.words import unpack


@dataclass(frozen=True)
class Method:
    """What turns words of one order, shape (N, p), into orbits, so many in about half a second."""

    solve: Callable[[NDArray[np.uint8], Stadium], Orbits]
    words: int


_WORDS_A_CLASS = 4
"""Half of what most classes have: spans are cut by what their prefixes may become, and most get less."""

_BLOCKS_A_JOB = 3
_SMALLEST = 4
"""Part of a full block: smaller ones cost more a word."""

METHODS = {
    "newton": Method(partial(solve_admissible, every=False), 1 << 16),
    "relaxation": Method(relax, 1 << 8),
}


@dataclass(frozen=True, eq=False)
class SolvedBlock:
    """What became of the N classes of a span, in the order of their least words.

    Attributes
    ----------
    span : Span
    stabiliser : ndarray of uint8, shape (N,)
    words : list of str, length N, or None
        All words of each class (`orbitdb.symbols.members.joined_words`); None if they are stored already.
    orbits : Orbits
    enumerating, solving : float
        Processor time spent on words and classes, and on their orbits (seconds).
    arithmetic : str
        What computed them (`orbitdb.arithmetic.arithmetic`).
    """

    span: Span
    stabiliser: NDArray[np.uint8]
    words: list[str] | None
    orbits: Orbits
    enumerating: float
    solving: float
    arithmetic: str


def solve_block(a: float, method: str, known: bool, span: Span) -> SolvedBlock:
    """Find classes, unless they are known with all their words, and what becomes of them at one a."""
    clock, p = [thread_time()], span.p
    codes, stabiliser = all_least_words(span)
    words = None if known else joined_words(codes, stabiliser, p)
    clock.append(thread_time())
    orbits = METHODS[method].solve(unpack(codes, p), Stadium(a))
    clock.append(thread_time())
    enumerating, solving = np.diff(clock).tolist()
    return SolvedBlock(span, stabiliser, words, orbits, enumerating, solving, arithmetic())


def block_size(most: int, p: int, jobs: int, smallest: int) -> int:
    """Return how many words make a block of a period.

    For several jobs a small period makes smaller blocks, so that all of them have work till its end, down to
    a part of a full block.
    """
    share = count_admissible(p) // (_BLOCKS_A_JOB * jobs)
    return min(most, max(share, most // smallest)) if jobs > 1 else most


def cut_into_blocks(
    a: float, method: str, p: int, after: int = -1, jobs: int = 1, known: bool = False
) -> Iterator[Task[SolvedBlock]]:
    """Cut a period, or what of it is behind a packed word, into blocks, in order."""
    most = block_size(METHODS[method].words, p, jobs, _SMALLEST)
    spans = class_spans(p, max(most // _WORDS_A_CLASS, 1), after)
    return (partial(solve_block, a, method, known, span) for span in spans)
