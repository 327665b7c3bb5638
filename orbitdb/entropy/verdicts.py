"""What becomes of windows: allowed, forbidden or undecided, whatever stands beyond their ends."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.arithmetic import check_functions
from orbitdb.billiard.legs import Floats
from orbitdb.entropy.clamped import Condition, corner, solve_corner
from orbitdb.entropy.windows import OpenChains, Windows, open_chains
from orbitdb.equality import ByValue

BATCH = 1 << 15
"""Windows that are solved at a time: it bounds the memory."""

Tell = Callable[[str, int, int], None]
"""Is told what is at work, how much of it is done, and how much there is (0: not known)."""

_ROUGH = 0.02
"""Error of f, as a share of its range, at which it is clear enough which end to extend."""


class Verdict(IntEnum):
    """Whether the junction at the mark keeps to its walls."""

    UNDECIDED = 0
    ALLOWED = 1
    FORBIDDEN = 2


@dataclass(frozen=True, eq=False)
class Decision(ByValue):
    """What N windows are.

    Attributes
    ----------
    verdict : ndarray of uint8, shape (N,)
        `Verdict`: f > 0 for every continuation, f < 0 for every one, or not known.
    extend_left : ndarray of bool, shape (N,)
        Whether, of an undecided window, the left end changes f more than the right one does.
    """

    verdict: NDArray[np.uint8]
    extend_left: NDArray[np.bool_]


def decide(windows: Windows, a: float, tell: Tell | None = None) -> Decision:
    """Decide windows at one a, telling how far the work is.

    f rises with the push d at the left end and with the push c at the right one (`OpenChains.lean`), or
    at least crosses zero in this sense only. So the corner with both pushes reversed shows that it is
    positive, the other one that it is negative.
    """
    check_functions()
    verdict = np.zeros(len(windows), dtype=np.uint8)
    extend_left = np.zeros(len(windows), dtype=np.bool_)
    for start in range(0, len(windows), BATCH):
        if tell:
            tell(f"{windows.edges} letters", start, len(windows))
        batch = np.arange(start, min(start + BATCH, len(windows)))
        for rows, chains in open_chains(windows.rows(batch)):
            found = _decide(chains, a)
            verdict[batch[rows]], extend_left[batch[rows]] = found.verdict, found.extend_left
    return Decision(verdict, extend_left)


def _decide(chains: OpenChains, a: float) -> Decision:
    nothing = np.zeros(len(chains))
    least, most = _f(chains, a, -1, -1, nothing), _f(chains, a, 1, 1, nothing)
    verdict = np.full(len(chains), Verdict.UNDECIDED, dtype=np.uint8)
    verdict[least.lower > 0] = Verdict.ALLOWED
    verdict[most.upper < 0] = Verdict.FORBIDDEN
    extend_left = np.zeros(len(chains), dtype=np.bool_)
    rows = np.flatnonzero(verdict == Verdict.UNDECIDED)
    low, high = least.value[rows], most.value[rows]
    between = _f(chains.rows(rows), a, 1, -1, _ROUGH * (high - low)).value
    extend_left[rows] = between - low > high - between
    return Decision(verdict, extend_left)


def _f(chains: OpenChains, a: float, left: int, right: int, enough: Floats) -> Condition:
    """Return f with the ends pushed to raise it (+1) or to lower it (-1)."""
    pushed = corner(chains, a, left * chains.sense, right * chains.lean)
    return solve_corner(pushed, a, enough)
