"""Run time of every stage on the way from a period to its orbits."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from orbitdb.billiard.legs import cut
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import certificates, newton
from orbitdb.orbits.orbit import Orbits, Status
from orbitdb.orbits.status import assess
from orbitdb.symbols.least_words import representatives


@dataclass(frozen=True)
class StageTimes:
    """Run time of every stage of the way from a period to its orbits, in seconds.

    Attributes
    ----------
    p : int
    sequences, classes : int
        Admissible cyclic words, and symmetry classes of them.
    enumeration, cutting, newton, assessment, balls : float
        Generate the least words of the classes; cut them into legs; solve; bound the errors and decide;
        decide in ball arithmetic what was left.
    """

    p: int
    sequences: int
    classes: int
    enumeration: float
    cutting: float
    newton: float
    assessment: float
    balls: float


def stage_times(p: int, stadium: Stadium) -> StageTimes:
    """Measure every stage for one period, once."""
    clock = [perf_counter()]
    least, sizes = representatives(p)
    clock.append(perf_counter())
    groups = cut(least)
    clock.append(perf_counter())
    found = [newton(legs, stadium.a) for _, legs in groups]
    clock.append(perf_counter())
    orbits = Orbits.empty(least)
    for (rows, legs), way in zip(groups, found, strict=True):
        orbits.place(rows, assess(least[rows], legs, stadium, way))
    clock.append(perf_counter())
    open_words = least[orbits.status == Status.UNRESOLVED]
    if len(open_words):
        certificates(open_words, stadium)
    clock.append(perf_counter())
    return StageTimes(p, int(sizes.sum()), len(least), *np.diff(clock).tolist())
