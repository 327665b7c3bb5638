"""Verdicts on windows, confirmed one by one in ball arithmetic, so that no bound depends on rounding.

Every verdict follows from one clamped problem (`orbitdb.entropy_bounds.verdicts.corner`), which is given by
integers, a, and the limits of the directions (`limits_hold`). The directions found in double precision serve
only as centres and are taken as exact. The gradient g and the curvatures D there, computed in balls, show
that the clamped directions lie within the radius max |g_i| / (D_i / 2), where i runs over the directions that
are not pressed against a limit. The verdict is proved if f of the marked junction has the right sign there.
A verdict that balls do not confirm counts as undecided.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb
from numpy.typing import NDArray

from orbitdb.arrays import Marks
from orbitdb.billiard.arithmetic import ball_precision
from orbitdb.billiard.legs import Chain, direction_limits
from orbitdb.billiard.stadium import HALF_PI
from orbitdb.entropy_bounds.verdicts import (
    BATCH,
    Corner,
    Decision,
    Verdict,
    corner,
    decide_windows,
    solve_corner,
)
from orbitdb.entropy_bounds.windows import Windows, open_chains
from orbitdb.orbits.ball_path import BallPath
from orbitdb.progress import Tell

PRECISION = 64
"""Number of bits of the arithmetic."""

_OFTEN = 256
"""Number of windows between two progress reports."""


def proved(windows: Windows, verdict: NDArray[np.uint8], a: float, tell: Tell | None = None) -> Marks:
    """Tell which verdicts on N windows are proved in ball arithmetic, shape (N,).

    The result is false for undecided windows. The half length a is taken as exact; `tell` receives progress
    reports.
    """
    sure = np.zeros(len(windows), dtype=np.bool_)
    decided = np.flatnonzero(verdict != Verdict.UNDECIDED)
    done = 0
    with ball_precision(PRECISION):
        if not limits_hold(windows.edges, a):
            return sure
    for first in range(0, len(decided), BATCH):
        batch = decided[first : first + BATCH]
        for rows, chains in open_chains(windows.rows(batch)):
            way = np.where(verdict[batch[rows]] == Verdict.FORBIDDEN, 1.0, -1.0)
            pushed = corner(chains, a, way * chains.sense, way * chains.lean)
            start = solve_corner(pushed, a, np.zeros(len(rows))).alpha.T.tolist()
            for column, row in enumerate(batch[rows].tolist()):
                if tell and done % _OFTEN == 0:
                    tell(done, len(decided), f"{windows.edges} letters: ball arithmetic")
                done += 1
                with ball_precision(PRECISION):
                    f = condition_in_balls(pushed, column, a, start[column])
                    sure[row] = f is not None and (f < 0 if way[column] > 0 else f > 0)
    return sure


def limits_hold(most: int, a: float) -> bool:
    """Tell whether balls prove that `direction_limits` holds for all legs with up to `most` walls.

    The directions of a leg with n walls satisfy (n - 1) / (a + 1) <= s tan alpha <= (n + 1) / a, those of a
    leg without walls |tan alpha| <= 1 / a. The ends of these ranges must lie between the doubles, and the
    doubles within pi/2.
    """
    n = np.arange(most + 1.0)[None]
    low, high = direction_limits(Chain(n, n, n, np.ones_like(n)), a)
    return all(
        (least <= 0 if walls < 2 else least < (arb(walls - 1) / (arb(a) + 1)).atan())
        and (arb(walls + 1) / arb(a)).atan() < largest < arb.pi() / 2
        for walls, (least, largest) in enumerate(zip(low[0].tolist(), high[0].tolist(), strict=True))
    )


def condition_in_balls(problem: Corner, column: int, a: float, start: Sequence[float]) -> arb | None:
    """Return a ball that contains f of the marked junction of one window.

    `start` contains the directions of legs 0 to m + 1 in radians; they are clipped to their limits. The
    result is None if the error bound does not apply.
    """
    low, high = problem.low[:, column], problem.high[:, column]
    path = BallPath(problem.legs, column, a, list(zip(low.tolist(), high.tolist(), strict=True)))
    directions = np.clip(start, low, high).tolist()
    path.go_to([np.sign(x) * arb.pi() / 2 if abs(x) == HALF_PI else arb(x) for x in directions])
    radius = arb(0)
    for g, beyond, pressed in list(zip(path.gradient, path.between_centres, path.pressed(), strict=True))[
        1:-1
    ]:
        if not beyond > 0:
            return None
        if not pressed:
            radius = radius.max(2 * abs(g) / beyond)
    if not radius.is_finite():
        return None
    widened = arb(0, radius.abs_upper())
    path.alpha[1:-1] = [x + widened for x in path.alpha[1:-1]]
    marked = int(problem.marked[column])
    return path.half_turn(marked) + float(problem.lean[column]) * path.alpha[marked]


@dataclass
class Proof:
    """Decides windows in double precision, keeps the decisions that balls prove, and counts them."""

    proved: int = 0  # number of decisions that balls confirmed, up to mirror and reversal
    left_open: int = 0  # number of decisions that balls did not confirm

    def decide_windows(self, windows: Windows, a: float, tell: Tell | None = None) -> Decision:
        """Decide windows in doubles, as the function of this name does, but keep only proved decisions."""
        decision = decide_windows(windows, a, tell)
        sure = proved(windows, decision.verdict, a, tell)
        count = int(sure.sum())
        self.proved += count
        self.left_open += int((decision.verdict != Verdict.UNDECIDED).sum()) - count
        verdict = np.where(sure, decision.verdict, Verdict.UNDECIDED).astype(np.uint8)
        return Decision(verdict, decision.extend_left)
