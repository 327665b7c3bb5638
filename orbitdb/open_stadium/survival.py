"""Survival in an open stadium, sampled with random trajectories."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Indices, Marks
from orbitdb.billiard.stadium import HALF_PI, Stadium
from orbitdb.open_stadium.flight import Flights, OpenStadium
from orbitdb.trajectories.ensemble import Arcs, advance, stays

BATCH = 1 << 15
"""Trajectories that are followed at once, few enough for their arrays to stay in the cache."""


def rows_to(last: int) -> list[int]:
    """Return 1, 2, 5, 10, 20, 50, ... below a number, and the number itself."""
    steps = (step * 10**power for power in range(len(str(last))) for step in (1, 2, 5))
    return [*(step for step in steps if step < last), last]


class Starts(NamedTuple):
    """N first bounces, drawn from the invariant measure; all arrays have shape (N,)."""

    flights: Flights
    before: Floats  # length of the path to the bounce from the one before
    first: Marks  # whether the bounce is the first one of a run, where a leg begins


def random_starts(stadium: Stadium, n: int, rng: np.random.Generator) -> Starts:
    """Draw bounces from the measure ds d(sin theta), with what came before them."""
    a = stadium.a
    curved = rng.random(n) * stadium.perimeter < 2 * math.pi
    side = np.where(rng.random(n) < 0.5, -1.0, 1.0)
    angle, place = rng.uniform(-HALF_PI, HALF_PI, n), rng.uniform(-a, a, n)
    sine = rng.uniform(-1, 1, n)
    cosine = np.sqrt(1 - sine**2)
    nx, ny = np.where(curved, side * np.cos(angle), 0.0), np.where(curved, np.sin(angle), side)

    def leaving(along: Floats) -> Arcs:
        vx, vy = -cosine * nx - along * ny, -cosine * ny + along * nx
        away = np.where(curved, side, -np.copysign(1.0, vx))
        return Arcs(away, np.where(curved, nx, place - away * a), ny, vx, vy)

    back, ahead = leaving(-sine), leaving(sine)
    same = curved & stays(back)
    hit = advance(back, a, same)
    to_wall = (1 - np.copysign(1.0, back.vy) * back.y) / np.maximum(np.abs(back.vy), 1e-150)
    before = np.where(hit.walls > 0, to_wall, hit.path)
    falling = same & (hit.arcs.y > ny)
    flights = Flights(ahead, curved, same, falling, np.zeros(n, dtype=np.intp))
    return Starts(flights, before, curved & ~same)


class Stops(NamedTuple):
    """The numbers of bounces, the times and the numbers of legs at which survival is counted."""

    bounces: Floats
    time: Floats
    legs: Floats

    @classmethod
    def up_to(cls, stadium: Stadium, last: int) -> "Stops":
        """Return rows up to a number of bounces, up to this time, and the legs of as many bounces."""
        legs = max(1, int(last * stadium.legs_per_bounce))
        return cls(*(np.array(rows_to(end), dtype=np.float64) for end in (last, last, legs)))


@dataclass(frozen=True)
class Counts:
    """How many trajectories survive; the sum of the counts of batches is that of all their trajectories.

    Attributes
    ----------
    bounces, legs : ndarray
        Number of trajectories that survive each row; the first entry counts all.
    time, squares : ndarray
        The same sums of the weights of the trajectories, and of their squares.
    """

    bounces: Floats
    time: Floats
    squares: Floats
    legs: Floats

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(*(own + others for own, others in zip(_fields(self), _fields(other), strict=True)))


def _fields(counts: Counts) -> tuple[Floats, ...]:
    return counts.bounces, counts.time, counts.squares, counts.legs


def sample(open_stadium: OpenStadium, rows: Stops, n: int, seed: np.random.SeedSequence) -> Counts:
    """Follow n random trajectories until they escape or have survived every row."""
    rng = np.random.default_rng(seed)
    starts = random_starts(open_stadium.stadium, n, rng)
    bounce, time = np.ones(n), starts.before * rng.random(n)
    legs = np.zeros(n)
    last = [row[-1] for row in rows]
    ends = np.full((3, n), np.inf)  # the bounce, the time and the leg in which each trajectory escapes
    at_once = open_stadium.escaped_at(starts.flights)
    ends[:, at_once] = bounce[at_once], time[at_once], legs[at_once]
    left = np.flatnonzero(~at_once)
    flights, bounce, time, legs = starts.flights.taken(left), bounce[left], time[left], legs[left]
    while len(left):
        way = open_stadium.onward(flights)
        out = way.fatal < np.inf
        ends[:, left[out]] = (bounce + way.fatal)[out], (time + way.fatal_path)[out], legs[out]
        bounce, time, legs = bounce + way.bounces, time + way.path, legs + way.crossed
        kept = ~out & ((bounce <= last[0]) | (time <= last[1]) | (legs < last[2]))
        flights, left = way.flights.taken(kept), left[kept]
        bounce, time, legs = bounce[kept], time[kept], legs[kept]
    weight = starts.before
    survived = [
        np.searchsorted(rows.bounces, ends[0]),
        np.searchsorted(rows.time, ends[1]),
        np.searchsorted(rows.legs, ends[2], "right"),
    ]
    return Counts(
        _surviving(survived[0], len(rows.bounces)),
        _surviving(survived[1], len(rows.time), weight),
        _surviving(survived[1], len(rows.time), weight**2),
        _surviving(survived[2][starts.first], len(rows.legs)),
    )


def _surviving(survived: Indices, rows: int, weight: Floats | None = None) -> Floats:
    """Return the weight of all trajectories and of those that survive each row, given how many each does."""
    ended = np.bincount(survived, weight, minlength=rows + 1).astype(np.float64)
    return ended[::-1].cumsum()[::-1]


class Survival(NamedTuple):
    """Survival at each row, with standard errors; all arrays have shape (R,)."""

    at: Floats
    survival: Floats
    error: Floats


Sampled = tuple[Survival, Survival, Survival]
"""Survival by bounce, by time and by leg."""


def survival_of(rows: Stops, counts: Counts | None) -> Sampled:
    """Return survival by bounce, by time and by leg; without counts, they are empty."""
    if counts is None:
        empty = Survival(*np.zeros((3, 0)))
        return empty, empty, empty

    def share(at: Floats, sums: Floats, squares: Floats) -> Survival:
        total = sums[0] or math.nan  # at large a, no leg may have begun
        p = sums[1:] / total
        spread = (1 - 2 * p) * squares[1:] + p**2 * squares[0]
        least = squares[0] / total  # where none has escaped or none is left, one more or less
        return Survival(at, p, np.sqrt(np.maximum(spread, 0) + least**2 * (spread <= 0)) / total)

    return (
        share(rows.bounces, counts.bounces, counts.bounces),
        share(rows.time, counts.time, counts.squares),
        share(rows.legs, counts.legs, counts.legs),
    )
