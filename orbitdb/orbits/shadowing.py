"""Periodic orbits that a trajectory shadows: follows so closely, bounce by bounce, that they look the same.

A trajectory that stays with an orbit of period p for long has its word as p symbols in a row, and comes back
near to where it was p bounces before. So the pieces of its symbol sequence between near returns, closed to
cycles, are the words to solve; every word has one orbit at most.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import SIDE, STRAIGHT, Stadium, written
from orbitdb.orbits.newton import solve_admissible
from orbitdb.orbits.orbit import EXISTING
from orbitdb.symbols.pruning import rules_broken
from orbitdb.symbols.words import are_primitive, from_strings, least_rotation, primitive_root, to_strings

Symbols = NDArray[np.uint8]
Rows = NDArray[np.intp]

LONGEST = 24
"""The longest period that is sought in a sequence; a list of points may be one longer orbit as a whole."""

_LEAST = 2
"""Bounces in a row that make a shadow: one alone says nothing of the direction."""

_NEAR = 0.5
"""How far from its place p bounces before a trajectory may return, in units of the radius; farther where
the tolerance is large."""


@dataclass(frozen=True)
class Shadow:
    """A stretch of a trajectory that stays with a periodic orbit.

    Attributes
    ----------
    word : str
        The orbit's, in the rotation that begins with the first bounce of the stretch.
    first : int
        Index of that bounce in the trajectory.
    bounces : int
        Number of bounces in a row that are within the tolerance.
    distance : float
        The least distance of one of them from the orbit's, in units of the radius.
    """

    word: str
    first: int
    bounces: int
    distance: float

    @property
    def turns(self) -> float:
        """How often the stretch goes round the orbit."""
        return self.bounces / len(self.word)


def shadows(
    stadium: Stadium, symbols: Symbols, points: Floats, tolerance: float, whole: bool = False
) -> list[Shadow]:
    """Find the orbits that a trajectory shadows, those it goes round most often first.

    Parameters
    ----------
    stadium : Stadium
    symbols : ndarray of uint8, shape (T,)
        Its bounces.
    points : ndarray, shape (T, 2)
        Cartesian.
    tolerance : float
        How far a bounce may be from that of the orbit, in units of the radius.
    whole : bool, optional
        Whether to try all bounces as one cycle, too, as of a polygon.

    Returns
    -------
    list of Shadow
        Each cyclic word once, with its longest stretch.
    """
    best: dict[str, Shadow] = {}
    for words, starts in _candidates(stadium, symbols, points, max(_NEAR, 2 * tolerance), whole):
        for found in _stretches(stadium, words, starts, points, tolerance):
            name = least_rotation(found.word)
            if name not in best or _rank(found) < _rank(best[name]):
                best[name] = found
    return sorted(best.values(), key=_rank)


def _rank(shadow: Shadow) -> tuple[float, float, int, str]:
    return -shadow.turns, shadow.distance, shadow.first, shadow.word


def _candidates(
    stadium: Stadium, symbols: Symbols, points: Floats, near: float, whole: bool
) -> Iterator[tuple[Symbols, Rows]]:
    """Yield words of one order each, shape (N, p), and the indices at which they begin, shape (N,)."""
    for p in range(2, min(LONGEST, len(symbols)) + 1):
        back = np.hypot(*(points[p:] - points[:-p]).T) <= near
        starts = np.flatnonzero(
            np.append(back, True) | np.insert(back, 0, True)
        )  # the same backwards in time
        words = _closed(stadium, symbols, points, starts, p)
        kept = (rules_broken(words) == 0) & are_primitive(words)
        if kept.any():
            yield words[kept], starts[kept]
    if whole and len(symbols) >= 2:
        start = np.zeros(1, np.intp)
        words = _closed(stadium, symbols, points, start, len(symbols))
        root = from_strings([primitive_root(to_strings(words)[0])])
        if not rules_broken(root).any():
            yield root, start


def _closed(stadium: Stadium, symbols: Symbols, points: Floats, starts: Rows, p: int) -> Symbols:
    """Return pieces of a trajectory as words, the first bounce of each behind the last, shape (N, p).

    What is single, or in a run that goes up or down, may differ where a piece is cut out of a run.
    """
    around = starts[:, None] + np.arange(-1, p + 1) % p
    here = symbols[around]
    x, y = np.moveaxis(points[around], -1, 0)
    return written(stadium, x, np.where(STRAIGHT[here], here - 1.0, y), SIDE[here])[0]


def _stretches(
    stadium: Stadium, words: Symbols, starts: Rows, points: Floats, tolerance: float
) -> Iterator[Shadow]:
    """Yield the longest stretch of a trajectory at each word that is an orbit, laid where the word begins."""
    p = words.shape[1]
    known, of = np.unique(words, axis=0, return_inverse=True)
    solved = solve_admissible(known, stadium)
    exists = np.isin(solved.status, EXISTING)
    corners = stadium.points(known, solved.coordinates)
    for word, start in zip(of.ravel(), starts, strict=True):
        if exists[word]:
            phase = (np.arange(len(points)) - start) % p
            distance = np.hypot(*(corners[word, phase] - points).T)
            first, count = _longest_run(distance <= tolerance)
            if count >= _LEAST:
                turned = np.roll(known[word], -phase[first])
                least = float(distance[first : first + count].min())
                yield Shadow(to_strings(turned[None])[0], first, count, least)


def _longest_run(marks: NDArray[np.bool_]) -> tuple[int, int]:
    """Return where the longest row of marks begins, and how many they are."""
    steps = np.arange(len(marks))
    lengths = steps - np.maximum.accumulate(np.where(marks, -1, steps))
    last = int(lengths.argmax())
    return last - int(lengths[last]) + 1, int(lengths[last])
