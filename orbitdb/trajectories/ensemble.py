"""Ensembles of random trajectories: the reference for averages over orbits.

The trajectories start from the invariant measure of the bounces on the semicircles and are followed from one
such bounce to the next. So all steps, including the first, sample the invariant measure; only the tangent
vectors need time to settle.

If the stadium is unfolded at its straight walls, a path from one semicircle to the other is a straight line.
The number of walls that it hits follows from the copy of the stadium in which it ends. So thousands of
bounces between the walls cost no more than one bounce, and their rounding errors do not accumulate.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.stadium import HALF_PI, Stadium
from orbitdb.display import Record
from orbitdb.errors import InputError, check_int
from orbitdb.text import format_float
from orbitdb.trajectories.rays import reflect_off_circle

TRAJECTORIES = 4096
"""Maximum number of trajectories by default, small enough for their arrays to stay in the cache."""

LEAST = 256
"""Minimum number of trajectories by default; with fewer, errors estimated from their spread are uncertain."""

LEAST_ON_WALLS = 10
"""Minimum expected number of bounces on straight walls.

In a nearly circular stadium, trajectories differ by these alone, so that their spread says nothing about the
error before there are some.
"""

BLOCK = 256
_TINY = 1e-150
_RENORMALISE = 8
_SETTLED = 8.0

_NEAR = 0.05
"""Share by which the number of bounces may differ from the wanted one without a note."""


class Arcs(NamedTuple):
    """N trajectories just after a bounce on a semicircle; all arrays have shape (N,)."""

    side: Floats  # -1 for the left semicircle, +1 for the right semicircle
    x: Floats  # point of the bounce, from the centre of its circle
    y: Floats
    vx: Floats  # direction of the outgoing path, a unit vector
    vy: Floats


def random_arcs(n: int, rng: np.random.Generator) -> Arcs:
    """Draw n bounces on the semicircles from the invariant measure."""
    side = np.where(rng.random(n) < 0.5, -1.0, 1.0)
    return arcs_at(side, rng.uniform(-HALF_PI, HALF_PI, n), rng.uniform(-1, 1, n))


def arcs_at(side: Floats, angle: Floats, sine: Floats) -> Arcs:
    """Return bounces at given angles on the semicircles, and sines of reflection."""
    cosine = np.sqrt(1 - sine**2)
    x, y = side * np.cos(angle), np.sin(angle)
    return Arcs(side, x, y, -cosine * x - sine * y, -cosine * y + sine * x)


class ArcStep(NamedTuple):
    """The step of N trajectories to their next bounce on a semicircle; all arrays have shape (N,)."""

    arcs: Arcs  # the trajectories just after this bounce
    path: Floats  # length of the path to this bounce
    walls: Floats  # number of straight bounces on the way
    kick: Floats  # 2 / sin(theta), the convergence that the bounce adds to a beam


def stays(arcs: Arcs) -> Marks:
    """Tell which trajectories hit the same semicircle next: those whose chord of the circle ends on it."""
    along = arcs.x * arcs.vx + arcs.y * arcs.vy
    return arcs.side * (arcs.x - 2 * along * arcs.vx) > 0


def advance(arcs: Arcs, a: float, same: Marks | None = None) -> ArcStep:
    """Move trajectories to their next bounce on a semicircle and reflect them.

    A path to the other semicircle is unfolded, and the height at which it reaches the x of the other centre
    determines the copy it hits. `same` tells which paths end on the same semicircle, by default those that
    `stays` tells. A path that begins on a straight wall does not; its `side` is the one it moves away from.
    """
    side, x, y, vx, vy = arcs.side, arcs.x, arcs.y, arcs.vx, arcs.vy
    same = stays(arcs) if same is None else same
    dx = np.where(same, x, x + 2 * a * side)
    level = y - vy * dx / np.copysign(np.maximum(np.abs(vx), _TINY), -side)
    copy = np.where(same, 0.0, np.rint(level / 2))
    dy = y - 2 * copy
    path, sine, nx, ny, vx, vy = reflect_off_circle(dx, dy, vx, vy, same)
    walls = np.abs(copy)
    fold = 1 - 2 * (walls % 2)
    after = Arcs(np.where(same, side, -side), nx, ny * fold, vx, vy * fold)
    return ArcStep(after, path, walls, 2 / np.maximum(sine, _TINY))


class TangentVectors(NamedTuple):
    """Tangent vectors of N trajectories and sums along their paths; all arrays have shape (N,)."""

    y: Floats  # offset across the path, scaled to |y| + |slope| = 1
    slope: Floats  # change of direction, scaled by the same factor
    growth: Floats  # sum of the logarithms of all scale factors so far
    path: Floats  # length of the path so far
    bounces: Floats  # number of bounces so far, on straight walls and semicircles

    @classmethod
    def begin(cls, y: Floats, slope: Floats) -> "TangentVectors":
        """Return the given tangent vectors, with all sums at zero."""
        return cls(y, slope, *np.zeros((3, len(y))))


def follow_arcs(arcs: Arcs, beam: TangentVectors, a: float, steps: int) -> tuple[Arcs, TangentVectors]:
    """Follow trajectories and their tangent vectors for a number of steps.

    A path of length l adds l * slope to y, and a bounce on a semicircle subtracts 2 y / sin(theta) from the
    slope. These are the matrices of `orbitdb.billiard.stability`, without the factor -1 for each bounce.
    """
    y, slope = beam.y, beam.slope
    growth, path, bounces = beam.growth.copy(), beam.path.copy(), beam.bounces + steps
    for step in range(1, steps + 1):
        hit = advance(arcs, a)
        arcs = hit.arcs
        path += hit.path
        bounces += hit.walls
        y = y + hit.path * slope
        slope = slope - hit.kick * y
        if step % _RENORMALISE == 0 or step == steps:
            size = np.abs(y) + np.abs(slope)
            growth += np.log(size)
            y, slope = y / size, slope / size
    return arcs, TangentVectors(y, slope, growth, path, bounces)


def _settled(n: int, a: float, rng: np.random.Generator) -> tuple[Arcs, TangentVectors]:
    """Return random trajectories whose tangent vectors have settled into the unstable direction.

    Because det M = 1, a vector that has grown by e^g is within about e^(-2g) of the unstable direction. In a
    nearly circular stadium, a vector first grows only by shear, and lambda is about 1.6 sqrt(a) per step.
    """
    arcs, beam = random_arcs(n, rng), TangentVectors.begin(np.zeros(n), np.ones(n))
    arcs, beam = follow_arcs(arcs, beam, a, math.ceil(_SETTLED / math.sqrt(a)))
    while beam.growth.mean() < _SETTLED:
        arcs, beam = follow_arcs(arcs, beam, a, _RENORMALISE)
    return arcs, TangentVectors.begin(beam.y, beam.slope)


Measured = tuple[float, float]
"""A mean and its standard error."""


@dataclass(frozen=True)
class Reference(Record):
    """Averages over random trajectories, with their standard errors.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    lambda_d, lambda_d_error : float
        Lyapunov exponent per bounce.
    lambda_c, lambda_c_error : float
        Lyapunov exponent per unit length.
    mean_free_path, mean_free_path_error : float
        Mean path length between bounces, whose exact value is `Stadium.mean_free_path`.
    bounces : int
        Total number of bounces.
    groups : int
        Number of independent starts; the errors are estimated from their spread.
    seed : int
        Seed of the random numbers.
    on_a : tuple of str
        If no a was named, a note on which one was taken.
    """

    a: float
    lambda_d: float
    lambda_d_error: float
    lambda_c: float
    lambda_c_error: float
    mean_free_path: float
    mean_free_path_error: float
    bounces: int
    groups: int
    seed: int
    on_a: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)

    @classmethod
    def of(
        cls, a: float, growth: Measured, path: Measured, per_bounce: float, per_length: float, *counts: int
    ) -> "Reference":
        """Return the averages that follow from the mean growth and mean path of a step, and from exact rates.

        Parameters
        ----------
        a : float
            Half length of the stadium.
        growth, path : (float, float)
            Mean logarithmic growth and mean path length per step, each with its standard error.
        per_bounce, per_length : float
            Exact mean numbers of steps per bounce and per unit length.
        *counts : int
            `bounces`, `groups` and `seed`.
        """
        return cls(
            a,
            float(growth[0] * per_bounce), float(growth[1] * per_bounce),
            float(growth[0] * per_length), float(growth[1] * per_length),
            float(path[0] * per_bounce), float(path[1] * per_bounce),
            *counts,
        )  # fmt: skip

    def row(self) -> dict[str, Any]:
        """Return the averages, errors and counts by name."""
        values = super().row()
        del values["on_a"]
        return values

    def notes(self, wanted: int | None = None) -> Iterator[str]:
        """Yield which a was taken if none was named, and how far the mean free path is from its exact value.

        If far more or fewer than the `wanted` bounces were followed, another line says why.
        """
        yield from self.on_a
        exact = Stadium(self.a).mean_free_path
        off = (self.mean_free_path - exact) / self.mean_free_path_error
        yield (
            f"the mean free path is {abs(off):.1f} standard errors {'above' if off > 0 else 'below'} "
            f"pi Area / Perimeter = {exact:.6f}"
        )
        if wanted is not None and abs(self.bounces - wanted) > _NEAR * wanted:
            why = (
                f"the errors need {LEAST} trajectories"
                if self.groups == LEAST
                else "trajectories differ much"
            )
            yield f"{self.bounces} bounces were followed, not {wanted}: {why}"


def references(
    stadium: Stadium, bounces: int, seed: int = 0, trajectories: int | None = None
) -> Iterator[tuple[float, Reference]]:
    """Run a simulation; every few hundred steps, yield the fraction done and the averages so far.

    The parameters are those of `orbitdb.simulate`. Each result is complete, but from fewer bounces than the
    next, so the caller may stop at any time.
    """
    wanted = math.ceil(bounces * 2 * math.pi / stadium.perimeter)
    seed = check_int("seed", seed, 0)
    if bounces < 1 or (trajectories is not None and trajectories < 2):
        given = f"{bounces} bounces, {LEAST if trajectories is None else trajectories} trajectories"
        raise InputError(f"{given}: give at least one bounce and two trajectories")
    if trajectories is None:
        trajectories = max(LEAST, math.ceil(wanted / math.ceil(wanted / TRAJECTORIES)))
    steps = math.ceil(wanted / trajectories)
    if trajectories * steps * 2 * stadium.a / math.pi < LEAST_ON_WALLS:
        needed = math.ceil(LEAST_ON_WALLS * stadium.perimeter / (4 * stadium.a))
        raise InputError(
            f"{bounces} bounces at a = {format_float(stadium.a)} are too few for an error, because hardly "
            f"any is on a straight wall: give {needed} or more"
        )
    arcs, beam = _settled(trajectories, stadium.a, np.random.default_rng(seed))
    done = 0
    while done < steps:
        block = min(BLOCK, steps - done)
        arcs, beam = follow_arcs(arcs, beam, stadium.a, block)
        done += block
        yield done / steps, _reference(beam, done, stadium, seed)


def _reference(beam: TangentVectors, steps: int, stadium: Stadium, seed: int) -> Reference:
    """Average over trajectories, with errors estimated from their spread.

    By the invariant measure, a step has perimeter / 2 pi bounces and a path length of area / 2 on average.
    Given these exact numbers, the exponents need only the growth per step.

    The mean free path checks the invariant measure. The error of a plain mean would be unreliable: the
    probability of n walls between two semicircles is about a^2 / n^3, one such leg is followed by others
    nearly as long, and most simulations lack the few very long legs that determine the mean. But such a leg
    is steep, and its path is hardly longer than 2 n. So the path minus twice the number of walls scatters
    little, and the mean of the part subtracted, twice 2a / pi, is known exactly.
    """
    count = len(beam.growth)
    walls = beam.bounces - steps

    def mean(values: Floats) -> Measured:
        """Return the mean of the values per step, and its standard error."""
        return float(values.mean()) / steps, float(values.std(ddof=1)) / steps / math.sqrt(count)

    rest, error = mean(beam.path - 2 * walls)
    path = rest + 4 * stadium.a / math.pi, error
    rates = 2 * math.pi / stadium.perimeter, 2 / stadium.area
    return Reference.of(stadium.a, mean(beam.growth), path, *rates, int(beam.bounces.sum()), count, seed)
