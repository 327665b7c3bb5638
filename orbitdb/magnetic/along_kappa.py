"""Follow stationary points of the action from one curvature to another.

Every step predicts the bounces along the tangent of the branch, and corrects them with Newton's method. A
step that has to be corrected by too much is halved, because it might lead to another branch. Each word has
its own step. A word is lost if its step becomes too small, as where two branches meet and end.
"""

from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Floats, Marks, Words
from orbitdb.billiard.stadium import STRAIGHT, Stadium
from orbitdb.magnetic.action import ArcPaths, derivatives_of_action, solve_hessian

STEP = 1 / 8
"""Largest step in kappa, in units of the largest curvature, 1 / (a + 1)."""

_LEAST_STEP = 2.0**-12 * STEP
_FAR = 0.05
"""Largest first correction of a step, in radians or, on a wall, in units of a + 1; the next one is about its
square."""

_CORRECTIONS = 3
_NEAR = 1e-4
"""Size of the last correction at which a step ends; the error is then about its square."""

_POLISHING = 6
_DONE = 1e-13
"""Size of the correction at which the bounces are as accurate as doubles allow."""

ACCURATE = 1e-9
"""Largest violation of the law of reflection at a bounce of a followed orbit, as a difference of cosines."""

_BATCH = 1 << 12
"""Number of words followed at once; they fit into the processor's cache."""


class FollowedWords(NamedTuple):
    """Stationary points of the action, followed for N words."""

    coordinates: Floats  # shape (N, p); NaN for lost words
    residual: Floats  # largest violation of the law of reflection, as a difference of cosines, shape (N,)

    @property
    def lost(self) -> Marks:
        """Words that could not be followed, shape (N,)."""
        return np.isnan(self.residual)


def follow_in_field(
    stadium: Stadium, words: Words, coordinates: Floats, start: Floats, end: Floats
) -> FollowedWords:
    """Follow stationary points of the action from one curvature to another.

    Parameters
    ----------
    stadium : Stadium
    words : ndarray of uint8, shape (N, p)
    coordinates : ndarray, shape (N, p)
        Stationary points at `start`, in the order of the words' symbols; NaN for words already lost.
    start, end : ndarray, shape (N,)
        Curvatures, in 1/radius.
    """
    parts = [
        _follow(stadium, words[rows].T, coordinates[rows].T, start[rows], end[rows])
        for rows in (slice(begin, begin + _BATCH) for begin in range(0, max(len(words), 1), _BATCH))
    ]
    return FollowedWords(*map(np.concatenate, zip(*parts, strict=True)))


def _follow(
    stadium: Stadium, symbols: Words, coordinates: Floats, start: Floats, end: Floats
) -> FollowedWords:
    coordinates, kappa = coordinates.copy(), start.copy()
    velocity = _newton_step(stadium, symbols, coordinates, kappa)[1]
    largest, least = STEP / (stadium.a + 1), _LEAST_STEP / (stadium.a + 1)
    step = np.full(len(kappa), largest)
    moving = np.flatnonzero((kappa != end) & ~np.isnan(coordinates[0]))
    while len(moving):
        own = symbols.take(moving, axis=1)
        target = end[moving]
        shift = np.clip(target - kappa[moving], -step[moving], step[moving])
        goal = np.where(np.abs(target - kappa[moving]) <= step[moving], target, kappa[moving] + shift)
        now = coordinates.take(moving, axis=1) + shift * velocity.take(moving, axis=1)
        now, fresh_speed, reached = _corrected(stadium, own, now, goal)
        there = moving[reached]
        coordinates[:, there], kappa[there] = now[:, reached], goal[reached]
        velocity[:, there] = fresh_speed[:, reached]
        step[there] = np.minimum(2 * step[there], largest)
        step[moving[~reached]] /= 2
        moving = moving[(kappa[moving] != target) & (step[moving] >= least)]
    coordinates[:, kappa != end] = np.nan
    return _polished(stadium, symbols, coordinates, end)


def _corrected(
    stadium: Stadium, symbols: Words, coordinates: Floats, kappa: Floats
) -> tuple[Floats, Floats, Marks]:
    """Return corrected bounces, their derivatives in kappa, and which of them are on their own branch."""
    near = np.ones(len(kappa), np.bool_)
    unit = np.where(STRAIGHT[symbols], stadium.a + 1, 1.0)
    for count in range(_CORRECTIONS):
        move, velocity = _newton_step(stadium, symbols, coordinates, kappa)
        size = np.abs(move / unit).max(axis=0)
        coordinates = coordinates + move
        if not count:
            near = size <= _FAR  # false for NaN, too
        if not (near & (size > _NEAR)).any():
            break
    return coordinates, velocity, near & (size <= _NEAR)


def _newton_step(
    stadium: Stadium, symbols: Words, coordinates: Floats, kappa: Floats
) -> tuple[Floats, Floats]:
    """Return the Newton step, and the derivatives of the bounces in kappa, each of shape (p, N)."""
    slopes = derivatives_of_action(ArcPaths.of(stadium, symbols, coordinates, kappa))
    step, velocity = -solve_hessian(slopes, slopes.gradient, slopes.in_kappa)
    return step, velocity


def _polished(stadium: Stadium, symbols: Words, coordinates: Floats, kappa: Floats) -> FollowedWords:
    """Repeat Newton steps until rounding stops them; mark words that do not converge as lost."""
    for _ in range(_POLISHING):
        move, _ = _newton_step(stadium, symbols, coordinates, kappa)
        coordinates = coordinates + move
        if not (np.abs(move) > _DONE).any():
            break
    residual = ArcPaths.of(stadium, symbols, coordinates, kappa).residuals
    residual = np.where(residual <= ACCURATE, residual, np.nan)
    return FollowedWords(np.where(np.isnan(residual), np.nan, coordinates).T, residual)
