"""Enclosing the entropy at many a at once: one a is a task for any process."""

import math
from typing import NamedTuple

from orbitdb.arithmetic import arithmetic
from orbitdb.billiard.stadium import Stadium
from orbitdb.entropy.bounds import search
from orbitdb.entropy.entropy_bounds import EntropyBounds
from orbitdb.entropy.verdicts import decide


class Enclosed(NamedTuple):
    """Bounds on the entropy at one a."""

    levels: tuple[EntropyBounds, ...]  # for longer and longer windows
    proved: int  # windows decided in doubles that balls confirm, 0 if they were not asked
    left_open: int  # those that they do not
    seconds: float  # that the balls have taken
    arithmetic: str  # what computed it (`orbitdb.arithmetic.arithmetic`)


def enclose(
    a: float, window: int | None = None, width: float = 0.0, seconds: float = math.inf, prove: bool = False
) -> Enclosed:
    """Enclose the entropy at one a; what is reached first ends it.

    That is windows of so many edges, so small a difference of the bounds, or the time. To prove is to decide
    every window in balls, too.
    """
    if not prove:
        levels = search(Stadium(a), window, width, seconds, judge=decide)
        return Enclosed(tuple(levels), 0, 0, 0.0, arithmetic())
    from orbitdb.entropy.proof import Proof  # it loads flint, which doubles alone do not need

    proof = Proof()
    levels = search(Stadium(a), window, width, seconds, judge=proof.decide)
    return Enclosed(tuple(levels), proof.proved, proof.left_open, proof.seconds, arithmetic())
