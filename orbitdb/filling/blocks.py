"""Blocks: pieces of a period that are enumerated and solved apart, by whatever process.

A block says all that is needed to solve it and depends on nothing but itself, so that its result is
the same wherever and in whatever order blocks are solved.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from time import thread_time
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.newton import solve_for_orbits
from orbitdb.orbits.orbit import Orbits
from orbitdb.orbits.relaxation import relax
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span, admissible_codes, spans
from orbitdb.symbols.symmetry import Classes, classify_packed
from orbitdb.symbols.words import unpack
from orbitdb.version import __version__


class Solved(Protocol):
    """What became of a block, and which orbitdb found it."""

    @property
    def version(self) -> str:
        """Of the orbitdb that solved it."""


Result = TypeVar("Result", bound=Solved)
Result_co = TypeVar("Result_co", bound=Solved, covariant=True)


class Task(Protocol[Result_co]):
    """A block of any kind: it knows how it is solved, and goes to other processes as it is."""

    def solved(self) -> Result_co:
        """Return what becomes of it."""


class Solver(Protocol):
    """A method that turns admissible words of one order into orbits."""

    def __call__(self, words: NDArray[np.uint8], stadium: Stadium) -> Orbits:
        """Return what becomes of words, shape (N, p)."""


@dataclass(frozen=True)
class Method:
    """A solver, and how many words make a block that takes it about half a second."""

    solve: Solver
    words: int


_BLOCKS_A_JOB = 3
_SMALLEST = 1 / 4
"""Of a full block: smaller ones cost more a word."""

METHODS = {"newton": Method(solve_for_orbits, 1 << 16), "relaxation": Method(relax, 1 << 8)}


@dataclass(frozen=True, eq=False)
class Block(ByValue):
    """Words of one period to be solved at one a.

    Attributes
    ----------
    a : float
        The stadium.
    method : str
        One of `METHODS`.
    span : Span
        The words.
    classes : ndarray of int64, shape (N,), or None
        The packed least words of the symmetry classes of which the words are solved, if they are known
        already; else the words are enumerated, and the classes found.
    """

    a: float
    method: str
    span: Span
    classes: NDArray[np.int64] | None = None

    def solved(self) -> "SolvedBlock":
        """Find its words, their symmetry classes, and what becomes of the classes."""
        return solve_block(self)


@dataclass(frozen=True, eq=False)
class SolvedBlock(ByValue):
    """What became of a block.

    Attributes
    ----------
    span : Span
        The block's.
    words : ndarray of int64, shape (N,)
        The words that were enumerated, packed, as least rotations, in order.
    classes : Classes
        Their symmetry classes.
    orbits : Orbits
        What became of the classes whose least words are in the block, or that it named.
    stabiliser : ndarray of uint8, shape (len(orbits),)
        Their stabilisers; empty if the block named its classes.
    enumerating, solving : float
        Processor time spent on words and classes, and on their orbits (seconds).
    version, arithmetic : str
        Of the orbitdb that solved it, and what computed there (`orbitdb.arithmetic.arithmetic`).
    """

    span: Span
    words: NDArray[np.int64]
    classes: Classes
    orbits: Orbits
    stabiliser: NDArray[np.uint8]
    enumerating: float
    solving: float
    version: str
    arithmetic: str


def cut_into_blocks(a: float, method: str, p: int, after: int = -1, jobs: int = 1) -> Iterator[Block]:
    """Cut a period, or what of it is behind a packed word, into blocks, in order.

    For several jobs a small period makes smaller blocks, so that all of them have work till its end.
    """
    most = METHODS[method].words
    if jobs > 1:
        most = min(most, max(count_admissible(p) // (_BLOCKS_A_JOB * jobs), round(_SMALLEST * most)))
    return (Block(a, method, span) for span in spans(p, most, after))


def solve_block(block: Block) -> SolvedBlock:
    """Find the words of a block, their symmetry classes, and what becomes of the classes."""
    clock = [thread_time()]
    words = _enumerate(block)
    classes = classify_packed(words, block.span.p)
    least = classes.representative == words
    chosen = unpack(words[least] if block.classes is None else block.classes, block.span.p)
    clock.append(thread_time())
    orbits = METHODS[block.method].solve(chosen, Stadium(block.a))
    clock.append(thread_time())
    enumerating, solving = np.diff(clock).tolist()
    stabiliser, by = classes.stabiliser[least], (__version__, arithmetic())
    return SolvedBlock(block.span, words, classes, orbits, stabiliser, enumerating, solving, *by)


def _enumerate(block: Block) -> NDArray[np.int64]:
    """Return the words of a block; none if it names its classes."""
    none = np.zeros(0, dtype=np.int64)
    return np.concatenate([none, *(admissible_codes(block.span) if block.classes is None else ())])
