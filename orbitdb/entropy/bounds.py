"""Proved bounds on the topological entropy, level by level.

Windows of L edges are decided for all continuations at once. Edge words that avoid the forbidden windows grow
at least as fast as the codes of trajectories. Words that also avoid the undecided windows grow at most as
fast. Both rates belong to paths in a graph. Undecided windows are extended by one letter, at the end that
matters more, and decided again (the proof is in docs/entropy-proof.md).
"""

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from orbitdb.arithmetic import arithmetic
from orbitdb.arrays import Marks
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.avoidance import Automaton, automaton
from orbitdb.entropy.growth import growth
from orbitdb.entropy.verdicts import Decision, Verdict, decide
from orbitdb.entropy.windows import Letters, Windows, extended, first_windows
from orbitdb.extras import Record
from orbitdb.numerals import between
from orbitdb.progress import Tell

if TYPE_CHECKING:
    from orbitdb.entropy.proof import Proof

DOUBLES, BALLS = "doubles", "balls"
"""How windows are decided: in doubles with error bounds, or confirmed in ball arithmetic too."""

FORBIDDEN, UNDECIDED = 1, 2
"""Kinds of patterns."""

MAX_WINDOW = 40
"""Longest window, in edges."""

MOST_UNDECIDED = 1_000_000
"""Undecided windows are not extended if there are more; this limits the memory."""

_USUAL_GROWTH, _LEAST_GROWTH = 1.8, 1.3
"""Ratio of the times of successive levels."""

_BRIEF = 0.05
"""A level that takes fewer seconds does not predict the time of the next."""


@dataclass(frozen=True)
class EntropyBounds(Record):
    """Bounds on the topological entropy per bounce at one a, proved by windows up to one length.

    Attributes
    ----------
    a : float
        Half length of a straight wall.
    window : int
        Edges of the longest windows.
    lower, upper : float
        Bounds on h_top, rounded outward.
    windows : int
        Windows examined so far, up to mirror and reversal.
    undecided : int
        Undecided windows of this length.
    proof : str
        How the windows were decided, for stored bounds: `DOUBLES` or `BALLS`.
    """

    a: float
    window: int
    lower: float
    upper: float
    windows: int
    undecided: int
    proof: str = DOUBLES

    @property
    def width(self) -> float:
        """Upper minus lower bound."""
        return self.upper - self.lower

    @property
    def between(self) -> str:
        """The bounds in words, rounded outward."""
        return between(self.lower, "h", self.upper)

    @property
    def basis(self) -> str:
        """The windows and arithmetic behind the bounds, in words."""
        how = "in balls" if self.proof == BALLS else "in doubles with error bounds"
        return f"windows of {self.window} edges {how}"


Judge = Callable[[Windows, float, Tell | None], Decision]
"""Decides windows at one a and reports progress."""


def levels(stadium: Stadium, tell: Tell | None = None, judge: Judge = decide) -> Iterator[EntropyBounds]:
    """Enclose the topological entropy with longer and longer windows.

    Parameters
    ----------
    tell : callable, optional
        Receives progress.
    judge : callable, optional
        `orbitdb.entropy.verdicts.decide` or `orbitdb.entropy.proof.Proof.decide`.

    Yields
    ------
    EntropyBounds
        For windows of 2, 3, ... edges, to `MAX_WINDOW`, to `MOST_UNDECIDED`, or until all are decided.
    """
    forbidden: list[tuple[Letters, int]] = []
    windows, count = first_windows(), 0
    while len(windows):
        decision = judge(windows, stadium.a, tell)
        count += len(windows)
        forbidden.append((windows.letters[decision.verdict == Verdict.FORBIDDEN], FORBIDDEN))
        open_ = decision.verdict == Verdict.UNDECIDED
        windows, at_left = windows.rows(open_), decision.extend_left[open_]
        if tell:
            tell(0, 0, f"{windows.edges} letters: growth rates")
        avoiding = automaton(forbidden)
        upper = growth(*avoiding.edges(FORBIDDEN), len(avoiding)).upper
        at_end = windows.edges == MAX_WINDOW or len(windows) > MOST_UNDECIDED
        following = None if at_end else _following(windows, at_left, avoiding)
        del avoiding  # the next automaton needs the memory
        lower = _lower(forbidden, windows)
        yield EntropyBounds(stadium.a, windows.edges, lower, upper, count, len(windows))
        if following is None:
            break
        windows = following


def _following(windows: Windows, at_left: Marks, avoiding: Automaton) -> Windows:
    """Return the windows with one more letter that contain no forbidden window."""
    longer = extended(windows, at_left)
    return longer.rows(avoiding.follow(longer.letters) == 0)


def _lower(forbidden: list[tuple[Letters, int]], undecided: Windows) -> float:
    """Return the growth rate of the words that avoid undecided windows too, rounded down."""
    avoiding = automaton([*forbidden, (undecided.letters, UNDECIDED)])
    return max(0.0, growth(*avoiding.edges(FORBIDDEN | UNDECIDED), len(avoiding)).lower)


def search(
    stadium: Stadium,
    window: int | None = None,
    width: float = 0.0,
    seconds: float = math.inf,
    tell: Tell | None = None,
    judge: Judge = decide,
) -> Iterator[EntropyBounds]:
    """Enclose the topological entropy until the bounds are close enough or the time is spent.

    Parameters
    ----------
    window : int, optional
        Edges of the longest windows to try; `MAX_WINDOW` by default.
    width : float, optional
        Stop when the upper minus the lower bound is at most this.
    seconds : float, optional
        Time to spend. A level is not begun if it would exceed the time, judging by the last two.
    tell, judge : callable, optional
        As for `levels`.

    Yields
    ------
    EntropyBounds
        As `levels` does.
    """
    began = ended = time.monotonic()
    last = 0.0
    for found in levels(stadium, tell, judge):
        yield found
        took, ended = time.monotonic() - ended, time.monotonic()
        growing = max(took / last, _LEAST_GROWTH) if last > _BRIEF else _USUAL_GROWTH
        last = took
        enough = found.window == window or found.width <= width
        if enough or ended - began + took * growing > seconds:
            break


class Enclosed(NamedTuple):
    """Bounds on the entropy at one a."""

    levels: tuple[EntropyBounds, ...]  # the bounds, one per window length
    proof: "Proof | None"  # counts of the decisions that balls confirmed, if they were used
    arithmetic: str  # the software that computed the bounds (`orbitdb.arithmetic.arithmetic`)


def enclose(
    a: float,
    window: int | None = None,
    width: float = 0.0,
    seconds: float = math.inf,
    proof: "Proof | None" = None,
) -> Enclosed:
    """Enclose the entropy at one a with `search`, as a task that can run in another process.

    Parameters
    ----------
    a : float
        Half length of a straight wall.
    window, width, seconds : optional
        As for `search`.
    proof : Proof, optional
        Confirms every decision in balls.
    """
    judge = decide if proof is None else proof.decide
    return Enclosed(tuple(search(Stadium(a), window, width, seconds, judge=judge)), proof, arithmetic())
