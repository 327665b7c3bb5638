"""Run time of every stage on the way from a period to its orbits."""

from dataclasses import dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import cut
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import certificates, newton
from orbitdb.orbits.orbit import Orbits, Status
from orbitdb.orbits.status import assess
from orbitdb.symbols.enumeration import admissible_words
from orbitdb.symbols.symmetry import classify
from orbitdb.symbols.words import pack

Words = NDArray[np.uint8]


@dataclass(frozen=True)
class StageTimes:
    """Run time of every stage of the way from a period to its orbits, in seconds.

    Attributes
    ----------
    p : int
    sequences, classes : int
        Admissible cyclic words, and symmetry classes of them.
    enumeration, classification, cutting, newton, assessment, balls : float
        Generate the words; find their classes; cut the representatives into legs; solve; bound the
        errors and decide; decide in ball arithmetic what was left.
    """

    p: int
    sequences: int
    classes: int
    enumeration: float
    classification: float
    cutting: float
    newton: float
    assessment: float
    balls: float


def stage_times(p: int, stadium: Stadium) -> StageTimes:
    """Measure every stage for one period, once."""
    clock = [perf_counter()]
    words = np.concatenate(list(admissible_words(p)))
    clock.append(perf_counter())
    least = words[classify(words).representative == pack(words)]
    clock.append(perf_counter())
    groups = cut(least)
    clock.append(perf_counter())
    found = [newton(legs, stadium.a) for _, legs in groups]
    clock.append(perf_counter())
    orbits = Orbits.empty(least)
    for (rows, legs), way in zip(groups, found, strict=True):
        orbits.place(rows, assess(least[rows], legs, stadium, way.alpha, way.iterations))
    clock.append(perf_counter())
    open_words = least[orbits.status == Status.UNRESOLVED]
    if len(open_words):
        certificates(open_words, stadium)
    clock.append(perf_counter())
    return StageTimes(p, len(words), len(least), *np.diff(clock).tolist())
