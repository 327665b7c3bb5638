"""What escapes from an open stadium, and how fast: survival, its tails and its rates in one result."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from orbitdb.display import Drawn, Table, data_frame
from orbitdb.errors import InputError
from orbitdb.open_stadium.openings import Opening, Span
from orbitdb.open_stadium.rates import FAST
from orbitdb.open_stadium.survival import Survival
from orbitdb.text import concise, format_float, several

if TYPE_CHECKING:
    import pandas

AT = {"bounce": "n", "time": "t", "leg": "legs"}
"""What survival is counted by, with the name of its column."""

RATES = (
    "measure", "c1", "c2", "d1", "rate_leg", "rate_leg_error", "rate_time", "rate_time_error", "rate_bounce",
    "rate_bounce_error", "n_tail", "t_tail",
)  # fmt: skip
"""The numbers of `Escape.rates`."""


@dataclass(frozen=True, repr=False, eq=False)
class Escape(Table, Drawn):
    """Survival in an open stadium, its tails and its rates.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    opening : tuple of Opening
        The openings of the boundary.
    without : tuple of str
        Patterns of symbols; a trajectory escapes at the bounce that completes one.
    measure : float
        Share of the perimeter that is open, mu.
    gaps : tuple of (float, float)
        The x between which bouncing balls are left, in ascending order.
    c1, c2, d1 : float
        Survival of n bounces tends to c1/n + c2/n^2, and of a time t to d1/t; derived, not proved.
    uncut : bool
        Whether bouncing balls drift all the way from one semicircle to the other.
    rate_leg, rate_time, rate_bounce : float or None
        Escape rates, estimated, each with its ``_error``; None where a rate is not defined.
    trajectories, bounces, seed : int
        Number of random trajectories, number of bounces up to which they were followed, and their seed.
    bounce, time, leg : Survival
        Sampled survival of n bounces, of a time t (radius / speed), and of legs; empty without trajectories.
    on_a : tuple of str
        The first of the notes if no a was named: which one was taken.
    """

    a: float
    opening: tuple[Opening, ...]
    without: tuple[str, ...]
    measure: float
    gaps: tuple[Span, ...]
    c1: float
    c2: float
    d1: float
    uncut: bool
    rate_leg: float | None
    rate_leg_error: float | None
    rate_time: float | None
    rate_time_error: float | None
    rate_bounce: float | None
    rate_bounce_error: float | None
    trajectories: int
    bounces: int
    seed: int
    bounce: Survival
    time: Survival
    leg: Survival
    on_a: tuple[str, ...] = ()

    @property
    def n_tail(self) -> float | None:
        """Number of bounces n from which the tail is larger than e^(-n rate_bounce), or None."""
        return _overtaken(self.rate_bounce, self.c1, self.c2)

    @property
    def t_tail(self) -> float | None:
        """Time t from which the tail is larger than e^(-t rate_time), or None."""
        return _overtaken(self.rate_time, self.d1, 0.0)

    def rates(self) -> dict[str, float | None]:
        """Return the measure, the constants of the tails, the rates, and where the tails overtake them."""
        return {name: getattr(self, name) for name in RATES}

    def columns(self, by: str = "bounce") -> dict[str, list[Any]]:
        """Return survival by ``bounce``, ``time`` or ``leg`` as columns; the tail by legs is None."""
        if by not in AT:
            raise InputError(f"by {by!r}: use bounce, time or leg")
        found: Survival = getattr(self, by)
        at, (first, second) = found.at, self._tail(by)
        tail = [None] * len(at) if by == "leg" else (first / at + second / at**2).tolist()
        rows = {AT[by]: at.astype(np.int64), "survival": found.survival, "error": found.error}
        columns = {name: column.tolist() for name, column in rows.items()}
        known = {name: [None if value != value else value for value in own] for name, own in columns.items()}
        return {**known, "tail": tail}

    def _tail(self, by: str) -> tuple[float, float]:
        """Return the factors of 1/n and 1/n^2, or of 1/t and 1/t^2, in the tail."""
        return (self.c1, self.c2) if by == "bounce" else (self.d1, 0.0)

    @property
    def notes(self) -> tuple[str, ...]:
        """What never escapes, which rates are not defined and why, and how sure each number is."""
        return (*self.on_a, *_notes(self))

    def to_pandas(self, by: str = "bounce") -> "pandas.DataFrame":
        """Return a data frame with the rows of `columns` (extra ``pandas``)."""
        return data_frame(self.columns(by))

    def __len__(self) -> int:
        return len(self.bounce.at)

    def __str__(self) -> str:
        rate = concise(self.rate_leg, self.rate_leg_error) or "not defined"
        place = f"{ways(self.opening, self.without)} at a = {format_float(self.a)}"
        return f"<escape {place}: {self.measure:.2%} open, rate per leg {rate}>"

    def _columns_shown(self) -> dict[str, list[Any]]:
        return self.columns()

    _FIGURES = ("escape", "escape-time")

    def _drawing(self, name: str) -> tuple[Sequence[Any], str]:
        return (self,), f"Escape {ways(self.opening, self.without)} at a = {format_float(self.a)}"


def ways(opening: Sequence[Opening], without: Sequence[str]) -> str:
    """Return the ways out, such as ``through top:-0.3:0.3 and by 0202``."""
    texts = [f"through {', '.join(map(str, opening))}"] if opening else []
    return " and ".join([*texts, *([f"by {', '.join(without)}"] if without else [])])


def _overtaken(rate: float | None, first: float, second: float) -> float | None:
    """Return where first / n + second / n^2 becomes larger than e^(-n rate) for good, or None."""
    if not rate or not (first or second):
        return None

    def ahead(n: float) -> float:
        return math.log(first / n + second / n**2) + rate * n

    low = (1 if first else 2) / rate  # the exponential is never farther ahead than near here
    if ahead(low) >= 0:
        return None
    high = low
    while ahead(high) < 0:
        high *= 2
    while high - low > 1e-6 * high:
        middle = (low + high) / 2
        low, high = (middle, high) if ahead(middle) < 0 else (low, middle)
    return high


def _notes(found: Escape) -> Iterator[str]:
    """Yield the notes of a result."""
    if found.gaps:
        where = " and ".join(f"{low:.6g} to {high:.6g}" for low, high in found.gaps)
        yield (
            f"the bouncing-ball family is left on x = {where}: survival falls like {found.c1:.4f}/n and "
            f"{found.d1:.4f}/t"
        )
    if found.c2:
        yield f"runs along a semicircle are left: {found.c2:.4f}/n^2; none in time"
    if not (found.gaps or found.c2):
        yield "neither bouncing balls nor runs are left: survival has no algebraic tail"
    yield from _undefined(found)
    many = several(found.trajectories, "trajectory", "trajectories")
    sampled = f"; survival is sampled with {many} (seed {found.seed})" if found.trajectories else ""
    yield f"measure is exact; tails are derived and checked, but not proved; rates are estimated{sampled}"


def _undefined(found: Escape) -> Iterator[str]:
    """Yield why rates are not defined."""
    if found.rate_leg is None:
        if found.uncut and found.measure:
            yield "no rates: the bouncing-ball family is not cut and outlives everything else"
        else:
            yield "no rates: too few of the points of the transfer matrix escape, or all of them"
    elif found.uncut:
        yield "no rate per time or bounce: the bouncing-ball family is not cut"
    elif found.rate_bounce is None and found.c2:
        yield f"no rate per bounce: it would be above {FAST:g}, and runs along a semicircle are left"
