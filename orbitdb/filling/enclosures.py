"""Enclosing the entropy at many a at once: one a is a task for any process."""

import math
from typing import NamedTuple

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import search
from orbitdb.entropy.entropy_bounds import EntropyBounds
from orbitdb.entropy.verdicts import decide


class Enclosed(NamedTuple):
    """Bounds on the entropy at one a.

    Attributes
    ----------
    levels : tuple of EntropyBounds
        For longer and longer windows.
    proved, left_open : int
        Windows decided in doubles that balls confirm, and that they do not; 0 if they were not asked.
    seconds : float
        Time that the balls have taken.
    arithmetic : str
        What computed them (`orbitdb.arithmetic.arithmetic`).
    """

    levels: tuple[EntropyBounds, ...]
    proved: int
    left_open: int
    seconds: float
    arithmetic: str


def enclose(
    a: float, window: int | None = None, width: float = 0.0, seconds: float = math.inf, prove: bool = False
) -> Enclosed:
    """Enclose the entropy at one a with longer and longer windows; what is reached first ends it.

    Parameters
    ----------
    a : float
        Half length of a straight wall.
    window : int or None, optional
        Edges of the longest windows.
    width : float, optional
        Difference of the bounds that is enough.
    seconds : float, optional
        Time to spend.
    prove : bool, optional
        Whether every window is decided in balls, too.
    """
    if not prove:
        levels = search(Stadium(a), window, width, seconds, judge=decide)
        return Enclosed(tuple(levels), 0, 0, 0.0, arithmetic())
    from orbitdb.entropy.proof import Proof  # it loads flint, which doubles alone do not need

    proof = Proof()
    levels = search(Stadium(a), window, width, seconds, judge=proof.decide)
    return Enclosed(tuple(levels), proof.proved, proof.left_open, proof.seconds, arithmetic())
