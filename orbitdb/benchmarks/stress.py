"""Stress tests: extreme cases, each checked against ball arithmetic.

A case is a function without required arguments that yields an `Outcome` for each question. An outcome
contains the largest true errors and the largest ratio of a true error to its stored bound, which must not
exceed 1.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from time import perf_counter

import numpy as np

from orbitdb.arrays import Floats, Words
from orbitdb.averages.by_period import HIGHEST, PeriodSums
from orbitdb.billiard.arithmetic import EPSILON
from orbitdb.billiard.stadium import SIDE, Stadium, written
from orbitdb.orbits.admissible import certificates
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.solve import solve
from orbitdb.orbits.status import Status
from orbitdb.symbols.enumeration import representatives
from orbitdb.symbols.pruning import rules_broken
from orbitdb.symbols.words import from_strings, parse
from orbitdb.text import format_float
from orbitdb.trajectories.ensemble import random_arcs
from orbitdb.trajectories.rays import Rays, bounce

_WINDOW = 200

BITS = 256
"""Precision of the reference in ball arithmetic, in bits."""

SUM_BOUND = 64 * EPSILON
"""Relative error allowed for a sum of positive terms by NumPy's pairwise summation."""


@dataclass(frozen=True)
class Outcome:
    """Result of one question of a stress case."""

    case: str  # name of the case
    asked: str  # the question
    words: int  # number of words solved, or of terms summed
    orbits: int  # number of words that are orbits
    open: int  # number of words left undecided
    wrong: int  # number of words whose status differs from that in ball arithmetic
    coordinates: float  # largest true error of a coordinate of an orbit
    length: float  # largest relative error of a length
    lyapunov: float  # largest relative error of a lambda
    share: float  # largest ratio of a true error to its stored bound
    seconds: float  # run time of the solution, without that of the reference

    @property
    def passed(self) -> bool:
        """Whether all words have the right status and no error exceeds its stored bound."""
        return self.open == 0 and self.wrong == 0 and not self.share > 1


def judge(case: str, asked: str, words: Words, stadium: Stadium) -> Outcome:
    """Solve words of the same period and compare every orbit with its enclosure."""
    begin = perf_counter()
    orbits = solve(words, stadium)
    return compare(case, asked, orbits, stadium, perf_counter() - begin)


def compare(case: str, asked: str, orbits: Orbits, stadium: Stadium, seconds: float) -> Outcome:
    """Compare solved orbits with their enclosures in ball arithmetic."""
    from orbitdb.orbits.balls import true_errors

    truth = certificates(orbits.words, stadium, BITS)
    status = np.array([enclosure.status.value for enclosure in truth])
    kept = np.flatnonzero((status == Status.ORBIT) & (orbits.status == Status.ORBIT))
    part = orbits.rows(kept)
    errors = true_errors(part, [truth[row] for row in kept])[:3]
    coordinates, length, lyapunov = errors
    bounds = (part.error, part.length_error, part.lyapunov_error)
    return Outcome(
        case=case,
        asked=asked,
        words=len(orbits),
        orbits=int((status == Status.ORBIT).sum()),
        open=int((orbits.status == Status.UNRESOLVED).sum()),
        wrong=int((orbits.status != status).sum()),
        coordinates=_largest(coordinates),
        length=_largest(length / part.length),
        lyapunov=_largest(lyapunov / part.lyapunov),
        share=max(_largest(error / bound) for error, bound in zip(errors, bounds, strict=True)),
        seconds=seconds,
    )


def _largest(values: Floats) -> float:
    return float(values.max()) if len(values) else math.nan


def extreme_stadia(p: int = 8) -> Iterator[Outcome]:
    """Solve all classes of period p in stadia of all shapes, from nearly a circle to a long channel."""
    words, _ = representatives(p)
    for exponent in range(-6, 7):
        yield judge("stadium", f"a = 1e{exponent}, all classes of p = {p}", words, Stadium(10.0**exponent))


def long_runs(powers: int = 5) -> Iterator[Outcome]:
    """Solve words with runs of 10, 100, ... bounces on each semicircle, which stay close to the wall."""
    for k in (10**e for e in range(1, powers + 1)):
        text = f"1^{k} 5^{k}"
        yield judge("run", text, from_strings([parse(text)]), Stadium())


def long_legs(powers: int = 5) -> Iterator[Outcome]:
    """Solve words with legs of 10, 100, ... straight bounces, nearly perpendicular to the walls."""
    for n in (10**e for e in range(1, powers + 1)):
        text = f"1 2 (02)^{n // 2} 3 2 (02)^{n // 2}"
        yield judge("leg", text, from_strings([parse(text)]), Stadium())


def long_orbits(orders: tuple[int, ...] = (200, 2000), count: int = 10) -> Iterator[Outcome]:
    """Solve closed segments of random trajectories, orbits so long that e^lambda may overflow."""
    for p in orders:
        words = closed_words(Stadium(), p, count)
        yield judge("trajectory", f"closed segments of p = {p}", words, Stadium())


def closed_words(stadium: Stadium, p: int, count: int, seed: int = 1) -> Words:
    """Return up to `count` orbits of period p that are closed segments of random trajectories, shape (n, p).

    A segment consists of p bounces, from the beginning of one run on the left semicircle up to the beginning
    of another, and is read as a cyclic word. Words that break a pruning rule or are not orbits are left out.
    """
    arcs = random_arcs(8 * count, np.random.default_rng(seed))
    rays = [Rays(arcs.x + arcs.side * stadium.a, arcs.y, arcs.vx, arcs.vy, arcs.side)]
    for _ in range(p + _WINDOW + 1):
        rays.append(bounce(rays[-1], stadium.a).rays)
    x, y, side = (np.stack([getattr(ray, name) for ray in rays], axis=1) for name in ("x", "y", "side"))
    symbols, _ = written(stadium, x, y, side)
    left = SIDE[symbols] < 0
    begins = left[:, 1:] & ~left[:, :-1]
    both = begins[:, :-p] & begins[:, p:]
    starts = np.where(both.any(axis=1), both.argmax(axis=1) + 1, -1)
    closing = np.flatnonzero(starts > 0)
    words = np.stack([symbols[row, starts[row] : starts[row] + p] for row in closing])
    words = words[rules_broken(words) == 0]
    orbits = solve(words, stadium)
    return words[orbits.status == Status.ORBIT][:count]


def small_margins(orders: tuple[int, ...] = (11, 13), below: float = 1e-4) -> Iterator[Outcome]:
    """Solve the words of each period whose bounces come closest to a joint, on either side of it."""
    for p in orders:
        words, _ = representatives(p)
        begin = perf_counter()
        orbits = solve(words, Stadium())
        seconds = perf_counter() - begin
        near = np.abs(orbits.margin) < below
        least = np.abs(orbits.margin).min()
        asked = f"|margin| < {below:g} of p = {p}, least {least:.1e}"
        yield compare("margin", asked, orbits.rows(near), Stadium(), seconds * near.mean())


def joint_words(orders: tuple[int, ...] = (6, 8)) -> Iterator[Outcome]:
    """Solve all classes of each period in stadia where some words run exactly through a joint."""
    for p in orders:
        words, _ = representatives(p)
        for a in (0.5, 1.0, 2.5):
            yield judge("joint", f"a = {format_float(a)}, all classes of p = {p}", words, Stadium(a))


def weighted_sums(terms: int = 30_000_000) -> Iterator[Outcome]:
    """Compare sums over orbits, with weights from e^-40 to e^0 as in an average, with exact summation."""
    rng = np.random.default_rng(1)
    lyapunov = 40 * rng.random(terms) + 0.5
    ones = np.ones(terms, dtype=np.int64)
    rows = OrbitClasses(HIGHEST * ones, ones, lyapunov / 0.4, lyapunov, 0 * ones)
    begin = perf_counter()
    sums = PeriodSums.of(rows, HIGHEST).sums[0, 0]
    seconds = perf_counter() - begin
    weight = np.exp(-lyapunov)
    pairs = zip(sums.tolist(), (weight, weight * lyapunov, weight * rows.length), strict=False)
    errors = [_relative_error(total, parts) for total, parts in pairs]
    yield Outcome(
        case="sum",
        asked="e^-40 .. e^0, against exact summation",
        words=terms,
        orbits=0,
        open=0,
        wrong=0,
        coordinates=math.nan,
        length=errors[2],
        lyapunov=errors[1],
        share=max(errors) / SUM_BOUND,
        seconds=seconds,
    )


def _relative_error(value: float, terms: Floats) -> float:
    pieces = (terms[start : start + 65536].tolist() for start in range(0, len(terms), 65536))
    exact = math.fsum(chain.from_iterable(pieces))
    return abs(value - exact) / exact


CASES: dict[str, Callable[[], Iterator[Outcome]]] = {
    "stadium": extreme_stadia,
    "joint": joint_words,
    "run": long_runs,
    "leg": long_legs,
    "trajectory": long_orbits,
    "margin": small_margins,
    "sum": weighted_sums,
}
"""The cases by name, in the order in which `stress` runs them."""


def stress() -> Iterator[Outcome]:
    """Run all cases and yield their outcomes."""
    for case in CASES.values():
        yield from case()
