"""Solutions of whole periods, cached for all tests of a process, and random words."""

from functools import cache

import numpy as np

from orbitdb.averages.by_period import (
    Entropy,
    Lyapunov,
    PeriodSums,
    Weight,
    entropy_of_counts,
    lyapunov_of_periods,
)
from orbitdb.averages.sum_rules import SumRules, orbits_of_words, sum_rules
from orbitdb.averages.tilting import TiltedOrbits
from orbitdb.billiard.stadium import STRAIGHT, Stadium
from orbitdb.orbits.exponents import OrbitClasses, exponents
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols import enumeration as classes
from orbitdb.symbols.enumeration import Span, all_least_words
from orbitdb.symbols.symmetry import SIZES, all_images
from orbitdb.symbols.words import unpack


@cache
def words_of(p: int) -> np.ndarray:
    """Return all admissible primitive words of period p as sorted least rotations."""
    return unpack(np.unique(all_images(all_least_words(Span.of_period(p)).codes, p)), p)


@cache
def representatives(p: int) -> np.ndarray:
    return classes.representatives(p)[0]


def tilted(a: float, highest: int) -> list[tuple[int, TiltedOrbits]]:
    """Return the orbits of each period from 2 on, as sum rules take them."""
    found = []
    for p in range(2, highest + 1):
        classes = all_least_words(Span.of_period(p))
        for part in exponents(classes.codes, p, Stadium(a)):
            words, sizes = unpack(classes.codes[part.orbits], p), SIZES[classes.stabiliser[part.orbits]]
            found.append((p, orbits_of_words(words, sizes, part.lyapunov, a)))
    return found


def sum_rules_to(a: float, highest: int) -> SumRules:
    """Return the averages by sum rules over all orbits up to each period."""
    return sum_rules(a, tilted(a, highest), highest, highest)


@cache
def solved(p: int, a: float) -> Orbits:
    return solve(words_of(p), Stadium(a))


def real(orbits: Orbits) -> np.ndarray:
    return orbits.status == Status.ORBIT


def random_word(seed: int, order: int) -> str:
    """Return a random admissible word: runs of 1 to 4 bounces on alternating sides, 0 to 4 walls between."""
    rng = np.random.default_rng(seed)
    parts: list[str] = []
    size = 0
    while size < order:
        for one, down in ("14", "35"):
            k, n = int(rng.integers(1, 5)), int(rng.integers(0, 5))
            run = (one if k == 1 else str(rng.choice([one, down]))) * k
            walls = ("02" * n)[int(rng.integers(2)) :][:n]
            parts += [run, walls]
            size += k + n
    return "".join(parts)


@cache
def class_rows(a: float, highest: int) -> OrbitClasses:
    """Solve one word of every class up to a period."""
    columns = []
    for p in range(2, highest + 1):
        words, size = classes.representatives(p)
        orbits = solve(words, Stadium(a))
        walls = STRAIGHT[words].sum(axis=1)
        table = np.stack([np.full(len(size), p), size, orbits.length, orbits.lyapunov, walls])
        columns.append(table[:, orbits.status == "orbit"])
    p, words, length, exponent, walls = np.concatenate(columns, axis=1)
    return OrbitClasses(p.astype(int), words.astype(int), length, exponent, walls.astype(int))


def entropy(rows: OrbitClasses, highest: int) -> Entropy:
    cycles = np.bincount(rows.p, rows.words, minlength=highest + 1)[: highest + 1]
    return entropy_of_counts(cycles.astype(np.int64))


def lyapunov(rows: OrbitClasses, highest: int, weight: Weight = Weight.EXPONENTIAL) -> Lyapunov:
    sums = {p: PeriodSums.of(part, p) for p, part in rows.by_period().items()}
    return lyapunov_of_periods(sums, highest, weight)
