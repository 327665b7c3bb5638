"""Trajectories in an open stadium, from one semicircle to the next, for many at once.

A step of `orbitdb.trajectories.ensemble` hits all straight walls between two semicircles at once. In the
unfolded stadium these hits are equally spaced, so the first one in an opening follows from a division, and
the first pattern that they complete from a table: a thousand walls cost as much as one.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Indices, Marks
from orbitdb.billiard.stadium import Stadium
from orbitdb.open_stadium.openings import Opening, spans_on
from orbitdb.open_stadium.patterns import DEAD, Patterns, patterns_of
from orbitdb.trajectories.ensemble import Arcs, ArcStep, advance, stays

_TINY = 1e-150


class Flights(NamedTuple):
    """N trajectories just after a bounce; all arrays have shape (N,)."""

    arcs: Arcs
    curved: Marks  # whether the bounce is on the semicircle `arcs.side`; if not, the path moves away from it
    running: Marks  # whether the bounce before was on the same semicircle
    falling: Marks  # if so, whether the run goes down
    state: Indices  # of the automaton of the patterns, before this bounce

    def taken(self, chosen: Marks | Indices) -> "Flights":
        """Return some of the trajectories, chosen by a mask or by indices."""
        arcs = Arcs(*(part[chosen] for part in self.arcs))
        marks = self.curved[chosen], self.running[chosen], self.falling[chosen]
        return Flights(arcs, *marks, self.state[chosen])


class Onward(NamedTuple):
    """The way of N trajectories to the next bounce on a semicircle; all arrays have shape (N,)."""

    flights: Flights  # the trajectories just after this bounce
    crossed: Marks  # whether it is on the other semicircle
    bounces: Floats  # number of bounces on the way, the last one included
    path: Floats  # length of the way
    fatal: Floats  # number of the first bounce with which it escapes, inf if none; 0 is the start
    fatal_path: Floats  # length of the way to that bounce


@dataclass(frozen=True)
class OpenStadium:
    """A stadium from which trajectories escape at a bounce in an opening, or when they complete a pattern.

    Attributes
    ----------
    stadium : Stadium
    walls : tuple of (float, float, float)
        Openings of the straight walls: y of the wall, and the least and greatest x.
    arcs : tuple of (float, float, float)
        Openings of the semicircles: the side, and the least and greatest y.
    patterns : Patterns or None
    """

    stadium: Stadium
    walls: tuple[tuple[float, float, float], ...]
    arcs: tuple[tuple[float, float, float], ...]
    patterns: Patterns | None

    @classmethod
    def of(cls, stadium: Stadium, openings: Iterable[Opening], patterns: Iterable[str]) -> "OpenStadium":
        """Open a stadium; the errors are those of `spans_on`."""
        spans = spans_on(stadium, openings)
        walls = ((y, *span) for y, wall in ((-1.0, "bottom"), (1.0, "top")) for span in spans[wall])
        arcs = (
            (side, math.sin(low), math.sin(high))
            for side, wall in ((-1.0, "left"), (1.0, "right"))
            for low, high in spans[wall]
        )
        return cls(stadium, tuple(walls), tuple(arcs), patterns_of(tuple(patterns)))

    def escaped_at(self, flights: Flights) -> Marks:
        """Tell which trajectories have their bounce in an opening."""
        side, x, y = flights.arcs.side, flights.arcs.x, flights.arcs.y
        out = np.zeros(len(y), dtype=np.bool_)
        for own, low, high in self.arcs:
            out |= flights.curved & (side == own) & (low <= y) & (y <= high)
        if self.walls:
            place = x + side * self.stadium.a
            for own, low, high in self.walls:
                out |= ~flights.curved & (y == own) & (low <= place) & (place <= high)
        return out

    def onward(self, flights: Flights) -> Onward:
        """Follow trajectories to their next bounce on a semicircle, also those that escape on the way."""
        arcs = flights.arcs
        same = flights.curved & stays(arcs)
        hit = advance(arcs, self.stadium.a, same)
        falling = np.where(same, hit.arcs.y < arcs.y, flights.falling)
        state, fatal = flights.state, np.full(len(arcs.y), np.inf)
        if self.patterns is not None:
            symbols = _symbols(flights, flights.running | same, falling)
            state, fatal = self._symbolic(self.patterns, state, symbols, arcs.vy > 0, hit.walls)
        for opening in self.walls:
            fatal = np.minimum(fatal, self._first_hit(opening, arcs, hit.walls))
        fatal_path = _path_to(fatal, arcs, hit)
        after = Flights(hit.arcs, np.ones_like(same), same, falling, state)
        if self.arcs:
            last = (fatal == np.inf) & self.escaped_at(after)
            fatal = np.where(last, hit.walls + 1, fatal)
            fatal_path = np.where(last, hit.path, fatal_path)
        return Onward(after, ~same, hit.walls + 1, hit.path, fatal, fatal_path)

    def _symbolic(
        self, patterns: Patterns, state: Indices, symbols: Indices, top: Marks, walls: Floats
    ) -> tuple[Indices, Floats]:
        """Follow the automaton past a bounce and the walls after it; return states and fatal bounces."""
        state = patterns.step[state, symbols]
        at_once = state == DEAD
        state, fatal = patterns.cross(np.where(at_once, 0, state), top.astype(np.intp), walls)
        return state, np.where(at_once, 0.0, fatal)

    def _first_hit(self, opening: tuple[float, float, float], arcs: Arcs, walls: Floats) -> Floats:
        """Return the number of the first of the walls on the way that is hit in an opening, inf if none."""
        wall, low, high = opening
        ahead = np.copysign(1.0, arcs.vx)
        slope = np.abs(arcs.vx) / np.maximum(np.abs(arcs.vy), _TINY)
        top = np.copysign(1.0, arcs.vy)
        # along the direction of motion, hit number j is at first + 2 (j - 1) slope
        first = ahead * (arcs.x + arcs.side * self.stadium.a) + slope * (1 - top * arcs.y)
        start, end = np.where(ahead > 0, low, -high), np.where(ahead > 0, high, -low)
        # every second hit is on this wall: the first or the second one, and then 4 slopes apart
        own = np.where(top == wall, first, first + 2 * slope)
        times = np.maximum(np.ceil((start - own) / np.maximum(4 * slope, _TINY)), 0.0)
        number = 2 * times + np.where(top == wall, 1.0, 2.0)
        return np.where((own + 4 * slope * times <= end) & (number <= walls), number, np.inf)


def _symbols(flights: Flights, running: Marks, falling: Marks) -> Indices:
    """Return the symbols of bounces; in a run of two or more, they say whether it goes up or down."""
    down = running & falling
    curved = np.where(flights.arcs.side < 0, 1 + 3 * down, 3 + 2 * down)
    return np.where(flights.curved, curved, 1 + flights.arcs.y).astype(np.intp)


def _path_to(fatal: Floats, arcs: Arcs, hit: ArcStep) -> Floats:
    """Return the length of the way to the given bounce: the start, or one of the straight walls."""
    speed = np.maximum(np.abs(arcs.vy), _TINY)
    first = 1 - np.copysign(1.0, arcs.vy) * arcs.y
    to_wall = (first + 2 * (np.where(fatal < np.inf, fatal, 1.0) - 1)) / speed
    return np.where(fatal == 0, 0.0, np.where(fatal < np.inf, to_wall, np.inf))
