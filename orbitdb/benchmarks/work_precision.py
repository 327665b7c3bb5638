"""Run time of each method against its error.

The reference is ball arithmetic, which encloses every orbit to more than 50 digits
(`orbitdb.orbits.admissible.certificates`). The error of a method is the distance of its result from the
reference.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.arrays import Floats, Indices, Integers, Words
from orbitdb.billiard.stability import forces
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.admissible import certificates, solve_in_doubles
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.relaxation import relax, starting_points
from orbitdb.orbits.status import Status
from orbitdb.symbols.enumeration import representatives

if TYPE_CHECKING:
    from orbitdb.orbits.balls import Enclosure


REFERENCE_BITS = 256
TOLERANCES = (1e-1, 1e-2, 1e-4, 1e-8, 1e-16)
EPSILONS = (1e-4, 1e-6, 1e-7, 1e-8, 1e-10, 1e-12)
ROOT_TOLERANCES = (1e-4, 1e-8, 1e-12)
BITS = (64, 128, 256)
REPEATS = 5
FAR = 1e-2
"""A coordinate whose error (in radians or units of the radius) is larger belongs to another orbit."""


@dataclass(frozen=True)
class WorkPrecision:
    """Cost and errors of one method at one setting."""

    method: str  # ``newton``, ``relaxation``, ``root`` or ``balls``
    setting: float  # tolerance, final force or number of bits
    words: int  # number of words solved, one per symmetry class
    seconds: float  # run time per word solved
    # Run time per cyclic word. ``newton`` and ``balls`` solve one word for all words of a class; the other
    # methods would have to solve each word.
    seconds_per_sequence: float
    failures: int  # number of words left undecided, or given a wrong status or another orbit
    # maximum and median over all words of the largest error of a coordinate
    coordinates_max: float
    coordinates_median: float
    # maximum and median of the relative errors; for ``balls``, all errors are the proved radii
    length_max: float
    length_median: float
    lyapunov_max: float
    lyapunov_median: float


@dataclass(frozen=True, eq=False)
class Sample:
    """Words of the same period, one per class, with their enclosures."""

    words: Words  # shape (N, p)
    sizes: Integers  # number of cyclic words in each class, shape (N,)
    stadium: Stadium
    truth: "list[Enclosure]"

    def part(self, count: int) -> "Sample":
        """Return about `count` of the words, evenly spread."""
        rows = _spread(len(self.words), count)
        return Sample(self.words[rows], self.sizes[rows], self.stadium, [self.truth[row] for row in rows])


def sample(p: int, stadium: Stadium, count: int | None = None) -> Sample:
    """Return all classes of period p, or about `count` of them, with enclosures at `REFERENCE_BITS`."""
    words, sizes = representatives(p)
    rows = _spread(len(words), count or len(words))
    truth = certificates(words[rows], stadium, REFERENCE_BITS)
    return Sample(words[rows], sizes[rows], stadium, truth)


def _spread(n: int, count: int) -> Indices:
    """Return about `count` evenly spread indices from 0 to n - 1."""
    return np.unique(np.linspace(0, n - 1, min(count, n)).astype(np.intp))


def work_precision(cases: Sample, slow: int = 100) -> Iterator[WorkPrecision]:
    """Measure all methods on the same words; yield a row for each method and setting as soon as it is done.

    `slow` is the approximate number of words for ``root`` and ``balls``, which solve one word at a time.
    """
    yield from newton_rows(cases)
    yield from ball_rows(cases.part(slow))
    yield from root_rows(cases.part(slow))
    yield from relaxation_rows(cases)


def newton_rows(cases: Sample, tolerances: Sequence[float] = TOLERANCES) -> Iterator[WorkPrecision]:
    """Measure Newton's method for the legs, including error bounds, statuses and lambda."""
    for tolerance in tolerances:
        times = []
        for _ in range(REPEATS):
            begin = perf_counter()
            orbits = solve_in_doubles(cases.words, cases.stadium, tolerance)
            times.append(perf_counter() - begin)
        yield _row("newton", tolerance, cases, orbits, float(np.median(times)), shared=True)


def relaxation_rows(cases: Sample, epsilons: Sequence[float] = EPSILONS) -> Iterator[WorkPrecision]:
    """Measure the paper's artificial dynamics, vectorised over all words of the sample.

    The relaxation to each force epsilon continues where the previous, larger epsilon stopped. Its time
    includes the times of all previous ones.
    """
    x = starting_points(cases.words, cases.stadium)
    seconds = 0.0
    for epsilon in sorted(epsilons, reverse=True):
        begin = perf_counter()
        orbits = relax(cases.words, cases.stadium, epsilon, start=x)
        seconds += perf_counter() - begin
        x = np.where(np.isnan(orbits.coordinates), x, orbits.coordinates)
        yield _row("relaxation", epsilon, cases, orbits, seconds)


def root_rows(cases: Sample, tolerances: Sequence[float] = ROOT_TOLERANCES) -> Iterator[WorkPrecision]:
    """Measure SciPy's hybrid Powell method on the p coordinates, with the relaxation's starting points."""
    from scipy.optimize import root

    start = starting_points(cases.words, cases.stadium)
    for tolerance in tolerances:
        x = np.full_like(start, np.nan)
        begin = perf_counter()
        for row, word in enumerate(cases.words):

            def field(x: Floats, word: Words = word[None]) -> Floats:
                return forces(cases.stadium, word, x[None])[0]

            solution = root(field, start[row], tol=tolerance)
            if solution.success:
                x[row] = solution.x
        seconds = perf_counter() - begin
        solved = np.flatnonzero(~np.isnan(x[:, 0]))
        orbits = Orbits.empty(cases.words)
        if len(solved):
            # with an infinite epsilon, `relax` takes no steps and only computes the properties of the orbits
            orbits.place(solved, relax(cases.words[solved], cases.stadium, np.inf, start=x[solved]))
        yield _row("root", tolerance, cases, orbits, seconds)


def ball_rows(cases: Sample, bits: Sequence[int] = BITS) -> Iterator[WorkPrecision]:
    """Measure ball arithmetic, whose errors are the proved radii."""
    for precision in bits:
        begin = perf_counter()
        enclosures = certificates(cases.words, cases.stadium, precision)
        seconds = perf_counter() - begin
        kept = [enclosure for enclosure in enclosures if enclosure.status is Status.ORBIT]
        errors = (
            np.array([max(float(x.rad()) for x in ball.coordinates) for ball in kept]),
            np.array([float(ball.length.rad() / ball.length.mid()) for ball in kept]),
            np.array([float(ball.lyapunov.rad() / ball.lyapunov.mid()) for ball in kept]),
        )
        failures = sum(a.status is not b.status for a, b in zip(enclosures, cases.truth, strict=True))
        yield _summary("balls", precision, cases, failures, errors, seconds, shared=True)


def _row(
    method: str, setting: float, cases: Sample, orbits: Orbits, seconds: float, shared: bool = False
) -> WorkPrecision:
    """Compare the orbits that a method found with their enclosures, and return the row."""
    from orbitdb.orbits.balls import true_errors

    status = np.array([enclosure.status.value for enclosure in cases.truth])
    kept = np.flatnonzero((status == Status.ORBIT) & np.isfinite(orbits.coordinates).all(axis=1))
    truth = [cases.truth[row] for row in kept]
    coordinates, length, lyapunov = true_errors(orbits.rows(kept), truth)[:3]
    right = coordinates < FAR
    settled = status != Status.BOUNDARY
    wrong = settled & (orbits.status != status)
    wrong[kept[~right]] = True
    relative = length / orbits.length[kept], lyapunov / orbits.lyapunov[kept]
    errors = (coordinates[right], relative[0][right], relative[1][right])
    return _summary(method, setting, cases, int(wrong.sum()), errors, seconds, shared)


def _summary(
    method: str,
    setting: float,
    cases: Sample,
    failures: int,
    errors: tuple[Floats, Floats, Floats],
    seconds: float,
    shared: bool,
) -> WorkPrecision:
    words = len(cases.words)
    served = int(cases.sizes.sum()) if shared else words
    numbers = [float(f(of)) if len(of) else float("nan") for of in errors for f in (np.max, np.median)]
    return WorkPrecision(method, setting, words, seconds / words, seconds / served, failures, *numbers)
