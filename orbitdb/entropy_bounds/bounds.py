"""Proved bounds on the topological entropy, one level for each length of windows.

Windows of L edges are decided for all continuations at once. The number of edge words that avoid the
forbidden windows grows at least as fast as the number of codes of trajectories; the number of words that
avoid the undecided windows too grows at most as fast. Both growth rates are those of paths in a graph.
Undecided windows are extended by one letter, at the end that matters more, and decided again
(docs/entropy-proof.md has the proof).
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from orbitdb.billiard.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import Record
from orbitdb.entropy_bounds.growth import automaton, growth
from orbitdb.entropy_bounds.verdicts import Decision, Verdict, decide_windows
from orbitdb.entropy_bounds.windows import Letters, Windows, extended, first_windows
from orbitdb.progress import Tell
from orbitdb.text import between

DOUBLES, BALLS = "doubles", "balls"
"""How windows are decided: in double precision with error bounds, or also confirmed in ball arithmetic."""

FORBIDDEN, UNDECIDED = 1, 2
"""Kinds of patterns that words can avoid, as bits."""

MAX_WINDOW = 40
"""Greatest length of windows, in edges."""

MOST_UNDECIDED = 1_000_000
"""If there are more undecided windows, they are not extended; this limits the memory."""

_USUAL_GROWTH, _LEAST_GROWTH = 1.8, 1.3
"""Usual and least ratio of the times that successive levels take."""

_BRIEF = 0.05
"""Seconds that a level must take before its time is used to predict that of the next."""


@dataclass(frozen=True)
class EntropyBounds(Record):
    """Bounds on the topological entropy per bounce at a given a, proved with windows of up to a given length.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    edges : int
        Number of edges of the longest windows.
    lower, upper : float
        Bounds on h_top, rounded outward.
    windows : int
        Number of windows examined so far, up to mirror images and reversal.
    undecided : int
        Number of undecided windows among the longest.
    arithmetic : str
        Arithmetic in which the windows were decided: `DOUBLES` or `BALLS`.
    proved, left_open : int
        Decisions of this search that ball arithmetic confirmed so far, and those that it did not confirm; 0
        if it was not used, or if the bounds are stored ones.
    """

    a: float
    edges: int
    lower: float
    upper: float
    windows: int
    undecided: int
    arithmetic: str = DOUBLES
    proved: int = field(default=0, compare=False)
    left_open: int = field(default=0, compare=False)

    @property
    def width(self) -> float:
        """Difference between the upper and the lower bound."""
        return self.upper - self.lower

    @property
    def estimate(self) -> float:
        """The middle of the bounds: the best digits of the entropy, but not proved."""
        return (self.lower + self.upper) / 2

    def row(self) -> dict[str, Any]:
        """Return the values under the names that they have in JSON, with the estimate after the bounds."""
        values = super().row()
        names = [name for name in values if name not in ("proved", "left_open")]
        names.insert(names.index("upper") + 1, "estimate")
        return {name: values.get(name, self.estimate) for name in names}

    @property
    def between(self) -> str:
        """The bounds as an inequality, rounded outward."""
        return between(self.lower, "h", self.upper)

    @property
    def basis(self) -> str:
        """What the bounds are based on, in words: the paths examined and the arithmetic."""
        how = "in ball arithmetic" if self.arithmetic == BALLS else "in double precision with error bounds"
        return f"all paths of {self.edges + 1} bounces, {how}"


Decider = Callable[[Windows, float, Tell | None], Decision]
"""A function that decides windows at a given a and reports progress."""


def _levels(stadium: Stadium, tell: Tell | None, decider: Decider) -> Iterator[EntropyBounds]:
    """Yield bounds for windows of 2, 3, ... edges, while there are undecided windows, but not too many."""
    forbidden: list[tuple[Letters, int]] = []
    windows, count = first_windows(), 0
    while len(windows):
        decision = decider(windows, stadium.a, tell)
        count += len(windows)
        forbidden.append((windows.letters[decision.verdict == Verdict.FORBIDDEN], FORBIDDEN))
        open_ = decision.verdict == Verdict.UNDECIDED
        windows, at_left = windows.rows(open_), decision.extend_left[open_]
        if tell:
            tell(0, 0, f"{windows.edges} letters: growth rates")
        avoiding = automaton(forbidden)
        upper = growth(*avoiding.edges(FORBIDDEN), len(avoiding)).upper
        if going_on := windows.edges < MAX_WINDOW and len(windows) <= MOST_UNDECIDED:
            longer = extended(windows, at_left)
            longer = longer.rows(avoiding.patterns_in(longer.letters) == 0)
        del avoiding  # the next automaton needs the memory
        avoiding = automaton([*forbidden, (windows.letters, UNDECIDED)])
        lower = max(0.0, growth(*avoiding.edges(FORBIDDEN | UNDECIDED), len(avoiding)).lower)
        yield EntropyBounds(stadium.a, windows.edges, lower, upper, count, len(windows))
        if not going_on:
            break
        windows = longer


def search(
    stadium: Stadium,
    edges: int | None = None,
    width: float = 0.0,
    seconds: float = math.inf,
    tell: Tell | None = None,
    decider: Decider = decide_windows,
) -> Iterator[EntropyBounds]:
    """Enclose the topological entropy with longer and longer windows, up to some limit.

    Parameters
    ----------
    edges : int, optional
        Number of edges of the longest windows to try; `MAX_WINDOW` by default.
    width : float, optional
        Stop when the upper minus the lower bound is at most this.
    seconds : float, optional
        Time limit. A level is not begun if, judging by the last two, it would exceed the limit.
    tell : callable, optional
        Receives progress reports.
    decider : callable, optional
        `orbitdb.entropy_bounds.verdicts.decide_windows`, or the method with the same name of
        `orbitdb.entropy_bounds.proof.Proof`.

    Yields
    ------
    EntropyBounds
        For windows of 2, 3, ... edges, up to `MAX_WINDOW`, or until no window or more than `MOST_UNDECIDED`
        are undecided.
    """
    began = ended = time.monotonic()
    last = 0.0
    for bounds in _levels(stadium, tell, decider):
        yield bounds
        took, ended = time.monotonic() - ended, time.monotonic()
        growing = max(took / last, _LEAST_GROWTH) if last > _BRIEF else _USUAL_GROWTH
        last = took
        enough = bounds.edges == edges or bounds.width <= width
        if enough or ended - began + took * growing > seconds:
            break


def search_in_balls(
    stadium: Stadium,
    edges: int | None = None,
    width: float = 0.0,
    seconds: float = math.inf,
    tell: Tell | None = None,
) -> Iterator[EntropyBounds]:
    """Enclose the topological entropy as `search` does, with every decision confirmed in ball arithmetic."""
    from orbitdb.entropy_bounds.proof import Proof  # loads flint, which double precision does not need

    proof = Proof()
    for bounds in search(stadium, edges, width, seconds, tell, proof.decide_windows):
        yield replace(bounds, arithmetic=BALLS, proved=proof.proved, left_open=proof.left_open)


class Enclosed(NamedTuple):
    """Bounds on the entropy at a given half length."""

    levels: tuple[EntropyBounds, ...]  # the bounds for each window length
    arithmetic: str  # the software that computed the bounds (`orbitdb.billiard.arithmetic.arithmetic`)


def enclose(
    a: float,
    edges: int | None = None,
    width: float = 0.0,
    seconds: float = math.inf,
    prove: bool = False,
) -> Enclosed:
    """Enclose the entropy at a given half length, as a task that can run in another process.

    Parameters
    ----------
    a : float
        Half length of the stadium.
    edges, width, seconds : optional
        As for `search`.
    prove : bool, optional
        Whether to confirm every decision in ball arithmetic.
    """
    find = search_in_balls if prove else search
    return Enclosed(tuple(find(Stadium(a), edges, width, seconds)), arithmetic())
