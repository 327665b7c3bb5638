"""Blocks of a sweep: classes of a period that are enumerated, solved and added up apart from one another."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from time import thread_time

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import arithmetic
from orbitdb.averages.fixed_points import ClassRows, PeriodSums
from orbitdb.averages.sum_rules import orbits_of_exponents
from orbitdb.averages.tilt_moments import TiltedOrbits, TiltMoments
from orbitdb.billiard.stadium import Stadium
from orbitdb.equality import ByValue
from orbitdb.orbits.sums import Exponents, Tally, exponents
from orbitdb.store.asking.choosing import chosen_words, within_ranges
from orbitdb.store.asking.selection import Selection
from orbitdb.store.asking.sweepable import selection_of
from orbitdb.symbols.enumeration import Span
from orbitdb.symbols.least_words import LeastWords, all_least_words
from orbitdb.symbols.symmetry import SIZES

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SweptBlock(ByValue):
    """Classes of one period to be solved and added up at one a.

    Attributes
    ----------
    a : float
        The stadium.
    span : Span
        The least words of the classes.
    tilts : dict of int to ndarray
        By level, those that moments are wanted around (`orbitdb.averages.sum_rules`).
    selection : str
        Of which orbits the sums are: the canonical text of a subset, empty for all orbits.
    """

    a: float
    span: Span
    tilts: Mapping[int, Floats] = field(default_factory=dict)
    selection: str = ""

    def solved(self) -> "SweptSums":
        """Find its classes, what becomes of them, and the sums over their orbits."""
        clock = thread_time()
        classes, chosen = all_least_words(self.span), selection_of(self.selection, self.a)
        summed = _summed(classes, self.span.p, chosen, self.tilts)
        return SweptSums(self.span, *summed, thread_time() - clock, arithmetic())


@dataclass(frozen=True, eq=False)
class SweptSums:
    """What became of a block.

    Attributes
    ----------
    span : Span
        The block's.
    tally : Tally
    sums : PeriodSums
        Over its orbits.
    moments : dict of int to TiltMoments
        By level, around the tilts that the block has named.
    processor : float
        What it took (seconds of a processor).
    arithmetic : str
        What computed it (`orbitdb.arithmetic.arithmetic`).
    """

    span: Span
    tally: Tally
    sums: PeriodSums
    moments: dict[int, TiltMoments]
    processor: float
    arithmetic: str


def _summed(
    part: LeastWords, p: int, selection: Selection, centres: Mapping[int, Floats]
) -> tuple[Tally, PeriodSums, dict[int, TiltMoments]]:
    """Solve the chosen ones of some classes and add up, each with the number of its chosen words."""
    words = chosen_words(part, p, selection)
    rows = np.flatnonzero(words)
    sizes = words[rows]
    found = list(_solved(part.codes[rows], p, selection))
    none = (np.zeros(0, int), np.zeros(0), np.zeros(0), np.zeros(0, bool))
    columns = [
        (sizes[each.orbits], each.length, each.lyapunov, each.legs.n.sum(axis=0) % 2 == 1) for each in found
    ]
    size, length, lyapunov, inverse = (np.concatenate(of) for of in zip(none, *columns, strict=True))
    of_orbits = ClassRows(np.full(len(size), p), size, length, lyapunov, inverse)
    moments = {}
    if centres:
        parts = (orbits_of_exponents(sizes[each.orbits], each, selection.a) for each in found)
        orbits = TiltedOrbits.joined(parts)
        moments = {level: TiltMoments.of(mu, orbits.held(level)) for level, mu in centres.items()}
    tally = replace(Tally.of(sizes, found), words=int(SIZES[part.stabiliser].sum()))
    return tally, PeriodSums.of(of_orbits, p), moments


def _solved(codes: NDArray[np.int64], p: int, selection: Selection) -> Iterator[Exponents]:
    """Find the orbits among packed words that are within the ranges of a subset."""
    for found in exponents(codes, p, Stadium(selection.a)) if len(codes) else ():
        if selection.ranges:
            inside = within_ranges(codes[found.orbits], p, found.length, found.lyapunov, selection)
            yield found.of_orbits(np.flatnonzero(inside))
        else:
            yield found
