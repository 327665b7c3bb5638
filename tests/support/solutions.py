"""Solved periods, kept for all tests of a process, and random words."""

from functools import cache

import numpy as np

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.newton import solve
from orbitdb.orbits.orbit import Orbits, Status
from orbitdb.symbols.enumeration import admissible_words
from orbitdb.symbols.symmetry import classify
from orbitdb.symbols.words import pack


@cache
def words_of(p: int) -> np.ndarray:
    return np.concatenate(list(admissible_words(p)))


@cache
def representatives(p: int) -> np.ndarray:
    words = words_of(p)
    return words[classify(words).representative == pack(words)]


@cache
def solved(p: int, a: float) -> Orbits:
    return solve(words_of(p), Stadium(a))


def real(orbits: Orbits) -> np.ndarray:
    return orbits.status == Status.ORBIT


def random_word(seed: int, order: int) -> str:
    """A random admissible word: runs of 1 to 4 bounces, left and right in turn, over 0 to 4 walls."""
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
