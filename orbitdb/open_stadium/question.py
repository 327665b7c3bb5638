"""The question of what escapes from an open stadium: its arguments, its tasks and its answer."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.errors import InputError, check_int
from orbitdb.open_stadium.escape import Escape
from orbitdb.open_stadium.flight import OpenStadium
from orbitdb.open_stadium.openings import Opening, measure, parse_openings
from orbitdb.open_stadium.patterns import patterns_of
from orbitdb.open_stadium.rates import EscapeRates, escape_rates
from orbitdb.open_stadium.survival import BATCH, Counts, Sampled, Stops, Survival, sample, survival_of
from orbitdb.open_stadium.tails import Tails, tails
from orbitdb.progress import Tell, nobody
from orbitdb.symbols.words import parse

TRAJECTORIES, BOUNCES = 1_000_000, 2000
"""Numbers of trajectories and of bounces by default."""

MOST_TRAJECTORIES, MOST_BOUNCES = 10**9, 10**7
_MOST_SYMBOLS = 200


@dataclass(frozen=True)
class Question:
    """What to open, and how to sample it; the arguments of `escape`, checked."""

    stadium: Stadium
    opening: tuple[Opening, ...]
    without: tuple[str, ...]
    trajectories: int
    bounces: int
    seed: int

    @classmethod
    def of(
        cls,
        stadium: Stadium | float,
        opening: Any = (),
        without: Any = (),
        trajectories: int = TRAJECTORIES,
        bounces: int = BOUNCES,
        seed: int = 0,
    ) -> "Question":
        """Check the arguments of `escape`."""
        billiard = as_stadium(stadium)
        alone = isinstance(without, str) or not isinstance(without, Iterable)
        patterns = tuple(sorted({parse(text) for text in ((without,) if alone else without)}))
        if sum(map(len, patterns)) > _MOST_SYMBOLS:
            raise InputError(f"patterns with more than {_MOST_SYMBOLS} symbols in all: give shorter ones")
        openings = parse_openings(opening)
        if not openings and not patterns:
            raise InputError("nothing is opened: name an opening, such as top:-0.3:0.3, or a pattern")
        measure(billiard, openings)  # raises if one does not fit
        return cls(
            billiard,
            openings,
            patterns,
            _number("trajectories", trajectories, 0, MOST_TRAJECTORIES),
            _number("bounces", bounces, 1, MOST_BOUNCES),
            check_int("seed", seed, 0),
        )

    @property
    def opened(self) -> OpenStadium:
        """The open stadium."""
        return OpenStadium.of(self.stadium, self.opening, self.without)

    @property
    def left(self) -> Tails:
        """What never escapes."""
        return tails(self.stadium, self.opening, patterns_of(self.without))

    @property
    def rows(self) -> Stops:
        """The rows at which survival is counted."""
        return Stops.up_to(self.stadium, self.bounces)

    @property
    def expected(self) -> float:
        """Rough mean number of bounces before a trajectory escapes, at most `bounces`."""
        return min(self.bounces, 1 / max(measure(self.stadium, self.opening), 0.005 * len(self.without)))

    def tasks(self) -> "list[partial[Counts]]":
        """Return functions that each sample some of the trajectories; their counts add up."""
        parts = max(1, math.ceil(self.trajectories / BATCH)) if self.trajectories else 0
        opened, rows = self.opened, self.rows
        seeds = np.random.SeedSequence(self.seed).spawn(parts)
        sizes = (self.trajectories * (n + 1) // parts - self.trajectories * n // parts for n in range(parts))
        return [partial(sample, opened, rows, size, seed) for size, seed in zip(sizes, seeds, strict=True)]

    def answer(self, sampled: Sampled, rates: EscapeRates) -> Escape:
        """Return the result with sampled survival, if there is any, and with the rates."""
        left = self.left
        return Escape(
            self.stadium.a, self.opening, self.without, measure(self.stadium, self.opening),
            left.gaps, left.c1, left.c2, left.d1, left.uncut, *rates,
            self.trajectories, self.bounces, self.seed, *sampled,
        )  # fmt: skip

    def sampled(self, parts: Iterable[Counts], tell: Tell = nobody) -> Sampled:
        """Return survival from the counts of the tasks, which are added up as they come."""
        total = None
        for part in parts:
            total = part if total is None else total + part
            tell(total.bounces[0], self.trajectories, "trajectories")
        return survival_of(self.rows, total)

    def unpacked(self, packed: bytes) -> Sampled:
        """Return survival from its arrays and those of its errors, as a catalogue stores them."""
        if not self.trajectories:
            return survival_of(self.rows, None)
        sizes = [len(at) for at in self.rows for _ in range(2)]
        arrays = np.split(np.frombuffer(packed, dtype="<f8").astype(np.float64), np.cumsum(sizes)[:-1])
        pairs = zip(self.rows, arrays[::2], arrays[1::2], strict=True)
        first, second, third = (Survival(*parts) for parts in pairs)
        return first, second, third


def _number(name: str, value: int, least: int, most: int) -> int:
    number = check_int(name, value, least)
    if number > most:
        raise InputError(f"{name} = {number}: give at most {most}")
    return number


def escape(
    stadium: Stadium | float,
    opening: Any = (),
    without: Any = (),
    trajectories: int = TRAJECTORIES,
    bounces: int = BOUNCES,
    seed: int = 0,
    *,
    progress: Tell | None = None,
) -> Escape:
    """Open a stadium, and find how many trajectories survive in it, and how fast the others escape.

    A trajectory escapes at a bounce in an opening, or at the bounce that completes a pattern of symbols.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium, or its half length.
    opening : str or iterable of str, optional
        Openings ``WALL:LOW:HIGH``: ``top`` or ``bottom`` with x, ``left`` or ``right`` with the angle from
        the outward horizontal (radians). An empty LOW or HIGH, as in ``top::0.3``, is the end of the wall.
    without : str or iterable of str, optional
        Patterns of symbols, such as ``0202``.
    trajectories : int, optional
        Number of random trajectories; with 0, survival is not sampled.
    bounces : int, optional
        Number of bounces, and time, up to which they are followed.
    seed : int, optional
        Seed of the random numbers; the same arguments give the same result.
    progress : callable, optional
        Called with the number of trajectories done, their total and a text.

    Raises
    ------
    InputError
        If nothing is opened, an opening does not fit on the boundary, or nothing is left of it.

    Examples
    --------
    >>> from orbitdb import escape
    >>> found = escape(1.6, "top:-0.3:0.3", trajectories=0)
    >>> found.gaps, round(found.measure, 6), round(found.c1, 5)
    (((-1.6, -0.3), (0.3, 1.6)), 0.047307, 0.24304)
    """
    tell = progress or nobody
    asked = Question.of(stadium, opening, without, trajectories, bounces, seed)
    sampled = asked.sampled((task() for task in asked.tasks()), tell)
    return asked.answer(sampled, escape_rates(asked.opened, asked.left, tell))
