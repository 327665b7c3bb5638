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
    """Find the classes of a span, and what becomes of them.

    Parameters
    ----------
    a : float
        The stadium.
    method : str
        One of `METHODS`.
    known : bool
        Whether the classes are stored already, so that nobody needs their words.
    span : Span
        Their least words.
    """
    clock, p = [thread_time()], span.p
    codes, stabiliser = all_least_words(span)
    words = None if known else joined_words(codes, stabiliser, p)
    clock.append(thread_time())
    orbits = METHODS[method].solve(unpack(codes, p), Stadium(a))
    clock.append(thread_time())
    enumerating, solving = np.diff(clock).tolist()
    return SolvedBlock(span, stabiliser, words, orbits, enumerating, solving, arithmetic())


def cut(p: int, after: int, words: int, jobs: int) -> Iterator[Span]:
    """Cut a period, or what of it is behind a packed word, into spans of about so many words, in order.

    For several jobs a small period makes smaller ones, so that all of them have work till its end.
    """
    if jobs > 1:
        words = min(words, max(count_admissible(p) // (_BLOCKS_A_JOB * jobs), words // _SMALLEST))
    return class_spans(p, max(words // _WORDS_A_CLASS, 1), after)


def cut_into_blocks(
    a: float, method: str, p: int, after: int = -1, jobs: int = 1, known: bool = False
) -> Iterator[Task[SolvedBlock]]:
    """Cut a period, or what of it is behind a packed word, into blocks, in order."""
    spans = cut(p, after, METHODS[method].words, jobs)
    return (partial(solve_block, a, method, known, span) for span in spans)
