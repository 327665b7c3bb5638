"""Verdicts on windows decided once more in ball arithmetic, one by one: a bound that rests on no rounding.

What balls do not confirm is undecided in the bounds that follow, and its window is extended like any other.
"""

import time
from dataclasses import dataclass

import numpy as np
from flint import ctx
from numpy.typing import NDArray

from orbitdb.entropy.ballwindow import BallWindow
from orbitdb.entropy.clamped import corner, directions
from orbitdb.entropy.letters import text_of
from orbitdb.entropy.verdicts import BATCH, Decision, Tell, Verdict, decide
from orbitdb.entropy.windows import Windows, open_chains

PRECISION = 64
"""Bits of the arithmetic."""

_OFTEN = 256
"""Windows between two reports of how far the work is."""


def proved(
    windows: Windows, verdict: NDArray[np.uint8], a: float, tell: Tell | None = None
) -> NDArray[np.bool_]:
    """Tell of each window whether its verdict is proved in balls.

    Parameters
    ----------
    windows : Windows
        N of them.
    verdict : ndarray of uint8, shape (N,)
        `Verdict` of each; one that is undecided is not proved.
    a : float
        Half length of a straight wall, taken as exact.
    tell : callable, optional
        Is told how far the work is.

    Returns
    -------
    ndarray of bool, shape (N,)
    """
    found = np.zeros(len(windows), dtype=np.bool_)
    decided = np.flatnonzero(verdict != Verdict.UNDECIDED)
    done = 0
    with ctx.workprec(PRECISION):
        for first in range(0, len(decided), BATCH):
            batch = decided[first : first + BATCH]
            for rows, chains in open_chains(windows.rows(batch)):
                way = np.where(verdict[batch[rows]] == Verdict.FORBIDDEN, 1.0, -1.0)
                # where balls shall look, in doubles
                start = directions(corner(chains, a, way * chains.sense, way * chains.lean), a)[1:-1]
                for row, near in zip(batch[rows].tolist(), start.T.tolist(), strict=True):
                    if tell and done % _OFTEN == 0:
                        tell(f"{windows.edges} letters in balls", done, len(decided))
                    done += 1
                    window = BallWindow(text_of(windows.letters[row]), int(windows.mark[row]), a)
                    found[row] = window.proves(Verdict(verdict[row]), near)
    return found


@dataclass
class Proof:
    """Decides windows in doubles, and keeps of that what balls prove; counts what comes of it.

    Attributes
    ----------
    proved, left_open : int
        Windows decided in doubles that balls confirm, and that they do not; mirror images and reversals
        are not counted.
    seconds : float
        Time that the balls have taken.
    """

    proved: int = 0
    left_open: int = 0
    seconds: float = 0.0

    def decide(self, windows: Windows, a: float, tell: Tell | None = None) -> Decision:
        """Decide windows, as `orbitdb.entropy.verdicts.decide` does, with proof."""
        decision = decide(windows, a, tell)
        began = time.monotonic()
        sure = proved(windows, decision.verdict, a, tell)
        self.seconds += time.monotonic() - began
        count = int(sure.sum())
        self.proved += count
        self.left_open += int((decision.verdict != Verdict.UNDECIDED).sum()) - count
        verdict = np.where(sure, decision.verdict, Verdict.UNDECIDED).astype(np.uint8)
        return Decision(verdict, decision.extend_left)
