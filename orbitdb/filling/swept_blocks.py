"""Blocks of a sweep: classes of a period that are enumerated, solved and added up apart from one another."""

from collections.abc import Iterator
from dataclasses import dataclass
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.averages.fixed_points import ClassRows
from orbitdb.averages.period_sums import PeriodSums
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.exponents import exponents
from orbitdb.orbits.tally import Tally
from orbitdb.symbols.counting import count_admissible
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import class_spans, least_words
from orbitdb.symbols.symmetry import ELEMENTS, class_size
from orbitdb.version import __version__

_LEAST = 1 << 15
_BLOCKS = 1 << 10
"""Blocks of a high period, about: they grow with it, so that their overhead does not."""

_PART = 1 << 15
"""Classes at a time: it bounds the memory."""

_SIZES = np.array([class_size(mask) if mask else 0 for mask in range(1 << len(ELEMENTS))])


@dataclass(frozen=True)
class SweptBlock:
    """Classes of one period to be solved and added up at one a.

    Attributes
    ----------
    a : float
        The stadium.
    span : Span
        The least words of the classes.
    """

    a: float
    span: Span

    def solved(self) -> "SweptSums":
        """Find its classes, what becomes of them, and the sums over their orbits."""
        clock = thread_time()
        found = [_summed(part, self.span.p, self.a) for part in _parts(self.span)]
        tally = sum((each for each, _ in found), Tally())
        sums = PeriodSums.joined([each for _, each in found], self.span.p)
        return SweptSums(self.span, tally, sums, thread_time() - clock, __version__, arithmetic())


@dataclass(frozen=True, eq=False)
class SweptSums(ByValue):
    """What became of a block.

    Attributes
    ----------
    span : Span
        The block's.
    tally : Tally
    sums : PeriodSums
        Over its orbits.
    processor : float
        What it took (seconds of a processor).
    version, arithmetic : str
        Of the orbitdb that solved it, and what computed there (`orbitdb.arithmetic.arithmetic`).
    """

    span: Span
    tally: Tally
    sums: PeriodSums
    processor: float
    version: str
    arithmetic: str


def cut_into_swept_blocks(a: float, p: int, after: int = -1) -> Iterator[SweptBlock]:
    """Cut a period, or what of it is behind a block, into blocks, in order.

    How it is cut depends on p alone, so that sums over blocks are the same however they come about.
    """
    size = max(_LEAST, count_admissible(p) // (len(ELEMENTS) * _BLOCKS))
    return (SweptBlock(a, span) for span in class_spans(p, size, after))


def _parts(span: Span) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Yield the packed least words of a span and the sizes of their classes, so many at a time."""
    found = [(part.codes, _SIZES[part.stabiliser]) for part in least_words(span)]
    if found:
        codes, sizes = (np.concatenate(columns) for columns in zip(*found, strict=True))
        for start in range(0, len(codes), _PART):
            yield codes[start : start + _PART], sizes[start : start + _PART]


def _summed(part: tuple[NDArray[np.int64], NDArray[np.int64]], p: int, a: float) -> tuple[Tally, PeriodSums]:
    """Solve some classes and add up."""
    codes, sizes = part
    found = list(exponents(codes, p, Stadium(a)))
    none = (np.zeros(0, int), np.zeros(0), np.zeros(0), np.zeros(0, bool))
    columns = [
        (sizes[each.orbits], each.length, each.lyapunov, each.legs.n.sum(axis=0) % 2 == 1) for each in found
    ]
    size, length, lyapunov, inverse = (np.concatenate(of) for of in zip(none, *columns, strict=True))
    rows = ClassRows(np.full(len(size), p), size, length, lyapunov, inverse)
    return Tally.of(sizes, found), PeriodSums.of(rows, p)
