"""Ensembles of random trajectories: the reference for averages over orbits.

The starts are drawn with the invariant measure of the bounces, restricted to the semicircles, and go on
from semicircle to semicircle (`orbitdb.trajectories.rays`). So every step is a fair sample from the
first on, and only the tangent vectors need a while to settle.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.trajectories.rays import Arcs, advance, random_arcs

TRAJECTORIES = 4096
"""Run at the same time; few enough for their arrays to stay in the cache."""

LEAST = 256
"""At least so many: with fewer an error, which comes from their spread, would itself be uncertain."""

BLOCK = 256
_RENORMALISE = 8
_SETTLED = 8.0


class Beam(NamedTuple):
    """Tangent vectors along N trajectories and what has been summed up on the way; shape (N,) each."""

    y: Floats  # offset across the path, scaled to |y| + |slope| = 1
    slope: Floats  # its change of direction
    growth: Floats  # logarithm of the scales taken out
    path: Floats  # length of the path
    bounces: Floats  # on walls and semicircles

    @classmethod
    def begin(cls, y: Floats, slope: Floats) -> "Beam":
        """Return beams with the given tangent vectors and nothing summed up."""
        return cls(y, slope, *np.zeros((3, len(y))))


def follow(arcs: Arcs, beam: Beam, a: float, steps: int) -> tuple[Arcs, Beam]:
    """Follow trajectories and their tangent vectors over a number of steps.

    Notes
    -----
    A path of length l adds l * slope to y, a bounce on a semicircle takes 2 y / sin(theta) from the
    slope: the matrices of `orbitdb.billiard.stability` less the -1 that each bounce has.
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
    return arcs, Beam(y, slope, growth, path, bounces)


def _settled(n: int, a: float, rng: np.random.Generator) -> tuple[Arcs, Beam]:
    """Return random starts whose tangent vectors have forgotten how they began.

    With det M = 1, growth by e^g turns a vector to within about e^(-2g) of the one that grows. Near the
    circle a vector first grows by shear alone, as the logarithm of the steps; there, measured,
    lambda is 1.6 sqrt(a) a step.
    """
    arcs, beam = random_arcs(n, rng), Beam.begin(np.zeros(n), np.ones(n))
    arcs, beam = follow(arcs, beam, a, math.ceil(_SETTLED / math.sqrt(a)))
    while beam.growth.mean() < _SETTLED:
        arcs, beam = follow(arcs, beam, a, _RENORMALISE)
    return arcs, Beam.begin(beam.y, beam.slope)


@dataclass(frozen=True)
class Reference:
    """Averages over random trajectories, each with the standard error of its mean.

    Attributes
    ----------
    lambda_d, lambda_d_error : float
        Lyapunov exponent per bounce.
    lambda_c, lambda_c_error : float
        Lyapunov exponent per length.
    mean_free_path, mean_free_path_error : float
        Mean path between bounces; `Stadium.mean_free_path` is its exact value.
    bounces : int
        Bounces in all.
    groups : int
        Number of independent starts; the errors come from their spread.
    seed : int
    """

    lambda_d: float
    lambda_d_error: float
    lambda_c: float
    lambda_c_error: float
    mean_free_path: float
    mean_free_path_error: float
    bounces: int
    groups: int
    seed: int


def simulate(
    stadium: Stadium,
    bounces: int,
    seed: int = 0,
    trajectories: int | None = None,
    progress: Callable[[float, Reference], None] | None = None,
) -> Reference:
    """Average over random trajectories.

    Parameters
    ----------
    stadium : Stadium
    bounces : int
        Bounces to expect in all; every trajectory makes at least one on a semicircle.
    seed : int, optional
        The same seed and numbers give the same result.
    trajectories : int, optional
        How many run at the same time; by default `TRAJECTORIES`, or fewer if that comes nearer to the
        bounces, but at least `LEAST`.
    progress : callable, optional
        Called every few hundred steps with the fraction done and the averages so far.

    Raises
    ------
    ValueError
        If there are no bounces, or fewer than two trajectories.
    """
    for done, found in references(stadium, bounces, seed, trajectories):
        if progress is not None:
            progress(done, found)
    return found


def references(
    stadium: Stadium,
    bounces: int,
    seed: int = 0,
    trajectories: int | None = None,
) -> Iterator[tuple[float, Reference]]:
    """Yield the fraction done and the averages so far, every few hundred steps of `simulate`.

    Every value is a full result of fewer bounces, so a caller may stop at any.
    """
    wanted = math.ceil(bounces * 2 * math.pi / stadium.perimeter)
    if bounces < 1 or (trajectories is not None and trajectories < 2):
        raise ValueError("give at least one bounce, and two trajectories")
    if trajectories is None:
        trajectories = max(LEAST, math.ceil(wanted / math.ceil(wanted / TRAJECTORIES)))
    arcs, beam = _settled(trajectories, stadium.a, np.random.default_rng(seed))
    steps = math.ceil(wanted / trajectories)
    done = 0
    while done < steps:
        block = min(BLOCK, steps - done)
        arcs, beam = follow(arcs, beam, stadium.a, block)
        done += block
        yield done / steps, _reference(beam, done, stadium, seed)


def _reference(beam: Beam, steps: int, stadium: Stadium, seed: int) -> Reference:
    """Average over trajectories, and take the errors from their spread.

    Between two bounces on a semicircle lie perimeter / 2 pi bounces and a path of area / 2 on average,
    by the invariant measure. With these exact numbers the exponents need only the growth per step.

    The mean free path is a check of that measure. Plain numbers of bounces have no error that could be
    told: n walls between two semicircles have a probability of about a^2 / n^3, one such leg brings on
    others nearly as long, and most runs lack the few very long ones that the mean needs without their
    scatter showing it. But such a leg is steep: its path is 2 n and little more. So path less twice the
    walls has a scatter that is soon known, and what is taken off on average, twice 2a / pi, is exact.
    """
    count = len(beam.growth)
    walls = beam.bounces - steps

    def mean(values: Floats) -> tuple[float, float]:
        """Return the mean a step, and its standard error."""
        return float(values.mean()) / steps, float(values.std(ddof=1)) / steps / math.sqrt(count)

    rest, rest_error = mean(beam.path - 2 * walls)
    per_step, per_step_error = mean(beam.growth)
    per_bounce, per_length = 2 * math.pi / stadium.perimeter, 2 / stadium.area
    return Reference(
        lambda_d=per_step * per_bounce,
        lambda_d_error=per_step_error * per_bounce,
        lambda_c=per_step * per_length,
        lambda_c_error=per_step_error * per_length,
        mean_free_path=(rest + 4 * stadium.a / math.pi) * per_bounce,
        mean_free_path_error=rest_error * per_bounce,
        bounces=int(beam.bounces.sum()),
        groups=count,
        seed=seed,
    )
