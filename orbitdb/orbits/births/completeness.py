"""Proof that no birth or death of a word is missing between two values of a.

It is a second way, which shares with `orbitdb.orbits.births.changes` only the equations: it looks for no
zeros, but cuts ln a into cells in which a word can be born at most once, or die at most once, or neither
(`orbitdb.orbits.births.cells`), and counts.
"""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from orbitdb.billiard.legs import cut
from orbitdb.orbits.births.brackets import signs
from orbitdb.orbits.births.cells import Kind
from orbitdb.orbits.births.stretches import stretches
from orbitdb.orbits.newton import newton

LOW, HIGH = 0.02, 1000.0
"""Between these it is tried: some slacks go like a^5 as a goes to 0, and there no cell is small enough."""

Segment = tuple[int, float, float]
"""What is proved, of values of `Kind`, and from where to where in ln a."""

KnownChange = tuple[float, float, bool]
"""The ends of a bracket in ln a, and whether the word is born there."""

_CONSTANT = (Kind.ALIVE, Kind.DEAD)


class Verdict(IntEnum):
    """What is proved of the known births and deaths of a word."""

    WRONG = -1
    UNDECIDED = 0
    PROVED = 1


def prove_all(
    words: NDArray[np.uint8], changes: Sequence[Sequence[KnownChange]]
) -> tuple[NDArray[np.int8], int]:
    """Tell whether the known changes of words are all there are between `LOW` and `HIGH`.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
        Admissible primitive words of one order.
    changes : sequence of sequence of KnownChange
        Those of each word, by rising a.

    Returns
    -------
    verdict : ndarray of int8, shape (N,)
        Values of `Verdict`.
    cells : int
        How many cells were looked at.
    """
    verdict, cells = np.zeros(len(words), np.int8), 0
    for rows, legs in cut(words):
        first = signs(words[rows], legs, np.full(len(rows), LOW), newton(legs, LOW).alpha)
        found = stretches(legs, float(np.log(LOW)), float(np.log(HIGH)))
        cells += found.cells
        ends = np.searchsorted(found.word, np.arange(len(rows) + 1)).tolist()
        segments = list(zip(found.kind.tolist(), found.low.tolist(), found.high.tolist(), strict=True))
        for row, sign, start, end in zip(rows.tolist(), first.tolist(), ends, ends[1:], strict=False):
            state = None if sign == 0 else sign > 0
            verdict[row] = walk(segments[start:end], changes[row], state)
    return verdict, cells


def walk(segments: Sequence[Segment], changes: Sequence[KnownChange], alive: bool | None) -> Verdict:
    """Tell whether known changes are all that segments allow.

    Parameters
    ----------
    segments : sequence of Segment
        One behind the other, by rising a.
    changes : sequence of KnownChange
        By rising a; those outside the segments do not matter.
    alive : bool or None
        Whether the word is an orbit where the segments begin; None if that is not known.
    """
    left = [each for each in changes if segments[0][1] < (each[0] + each[1]) / 2 < segments[-1][2]]
    sure = True
    for place, (kind, _, high) in enumerate(segments):
        if kind in _CONSTANT:
            if alive is (kind != Kind.ALIVE) or (left and left[0][1] < high):
                return Verdict.WRONG
            alive = kind == Kind.ALIVE
            continue
        here = [each for each in left if each[0] <= high]
        left = left[len(here) :]
        if kind == Kind.OPEN:
            alive, sure = None, False
            continue
        way = kind == Kind.RISING
        if len(here) > 1 or any(born != way for *_, born in here) or (here and alive is way):
            return Verdict.WRONG
        if here:
            alive = way
        elif alive is not way:
            behind = segments[place + 1][0] if place + 1 < len(segments) else Kind.OPEN
            if behind not in _CONSTANT:
                alive, sure = None, False
            elif (behind == Kind.ALIVE) is way and alive is not None:
                return Verdict.WRONG
            else:
                sure = sure and (behind == Kind.ALIVE) is not way
                alive = behind == Kind.ALIVE
    return Verdict.PROVED if sure and not left else Verdict.UNDECIDED
