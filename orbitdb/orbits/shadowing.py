"""Find the periodic orbits that a trajectory shadows, that is, follows closely bounce by bounce.

A trajectory that follows an orbit of period p for a long time has the orbit's word as p successive symbols,
and after p bounces it returns close to where it was. The words to solve are therefore the pieces of its
symbol sequence between near returns, closed to cycles; every word has at most one orbit.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orbitdb.arrays import Floats, Indices, Marks, Words
from orbitdb.billiard.stadium import SIDE, STRAIGHT, Stadium, written
from orbitdb.orbits.admissible import solve_admissible
from orbitdb.orbits.status import EXISTING
from orbitdb.symbols.pruning import rules_broken
from orbitdb.symbols.words import are_primitive, from_strings, least_rotation, primitive_root, to_strings

LONGEST = 24
"""The longest period to look for in a sequence; a list of points as a whole may be a longer orbit."""

_LEAST = 2
"""Least number of successive bounces that make a shadow; a single bounce does not fix the direction."""

_NEAR = 0.5
"""Largest distance of a near return, in units of the radius; it is larger if the tolerance is large."""


@dataclass(frozen=True)
class Shadow:
    """A stretch of a trajectory that follows a periodic orbit."""

    word: str  # the word of the orbit, beginning with the first bounce of the stretch
    first: int  # index of that bounce in the trajectory
    bounces: int  # number of successive bounces within the tolerance
    distance: float  # the least distance of these bounces from those of the orbit, in units of the radius

    @property
    def turns(self) -> float:
        """Number of times that the stretch goes round the orbit."""
        return self.bounces / len(self.word)


def shadows(
    stadium: Stadium, symbols: Words, points: Floats, tolerance: float, whole: bool = False
) -> list[Shadow]:
    """Find the orbits that a trajectory shadows, sorted by how often it goes round them, most often first.

    Parameters
    ----------
    symbols : ndarray of uint8, shape (T,)
        The symbols of the bounces of the trajectory.
    points : ndarray, shape (T, 2)
        The Cartesian coordinates of these bounces.
    tolerance : float
        Largest distance of a bounce from the corresponding bounce of the orbit, in units of the radius.
    whole : bool, optional
        Whether to try the entire list of bounces as one cycle too.

    Returns
    -------
    list of Shadow
        One for each cyclic word, with its longest stretch.
    """
    best: dict[str, Shadow] = {}
    for words, starts in _candidates(stadium, symbols, points, max(_NEAR, 2 * tolerance), whole):
        for shadow in _stretches(stadium, words, starts, points, tolerance):
            name = least_rotation(shadow.word)
            if name not in best or _rank(shadow) < _rank(best[name]):
                best[name] = shadow
    return sorted(best.values(), key=_rank)


def _rank(shadow: Shadow) -> tuple[float, float, int, str]:
    return -shadow.turns, shadow.distance, shadow.first, shadow.word


def _candidates(
    stadium: Stadium, symbols: Words, points: Floats, near: float, whole: bool
) -> Iterator[tuple[Words, Indices]]:
    """Yield words of each period, shape (N, p), and the index of the first bounce of each, shape (N,)."""
    for p in range(2, min(LONGEST, len(symbols)) + 1):
        back = np.hypot(*(points[p:] - points[:-p]).T) <= near
        starts = np.flatnonzero(
            np.append(back, True) | np.insert(back, 0, True)
        )  # near returns forward and backward in time
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


def _closed(stadium: Stadium, symbols: Words, points: Floats, starts: Indices, p: int) -> Words:
    """Return pieces of a trajectory, closed to cyclic words, shape (N, p).

    Symbols can change if a piece is cut out of the middle of a run, because a single bounce has no sense.
    """
    around = starts[:, None] + np.arange(-1, p + 1) % p
    cut_out = symbols[around]
    x, y = np.moveaxis(points[around], -1, 0)
    return written(stadium, x, np.where(STRAIGHT[cut_out], cut_out - 1.0, y), SIDE[cut_out])[0]


def _stretches(
    stadium: Stadium, words: Words, starts: Indices, points: Floats, tolerance: float
) -> Iterator[Shadow]:
    """Yield, for each word that is an orbit, the longest stretch of the trajectory that stays near it."""
    p = words.shape[1]
    distinct, of = np.unique(words, axis=0, return_inverse=True)
    solved = solve_admissible(distinct, stadium)
    exists = np.isin(solved.status, EXISTING)
    corners = stadium.points(distinct, solved.coordinates)
    for word, start in zip(of.ravel(), starts, strict=True):
        if exists[word]:
            phase = (np.arange(len(points)) - start) % p
            distance = np.hypot(*(corners[word, phase] - points).T)
            first, count = _longest_run(distance <= tolerance)
            if count >= _LEAST:
                turned = np.roll(distinct[word], -phase[first])
                least = float(distance[first : first + count].min())
                yield Shadow(to_strings(turned[None])[0], first, count, least)


def _longest_run(marks: Marks) -> tuple[int, int]:
    """Return the start and the length of the longest run of true marks."""
    steps = np.arange(len(marks))
    lengths = steps - np.maximum.accumulate(np.where(marks, -1, steps))
    last = int(lengths.argmax())
    return last - int(lengths[last]) + 1, int(lengths[last])
