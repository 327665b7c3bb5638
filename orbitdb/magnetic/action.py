"""The action of closed paths of circular arcs, and its derivatives in the coordinates of the bounces.

In a field perpendicular to the stadium, a particle moves on arcs of curvature kappa = 1 / (cyclotron radius),
which turn left if kappa > 0. An orbit is a stationary point of the action S = L - kappa A, where A is the
enclosed area (anticlockwise is positive). An arc with the chord c turns by 2 chi, sin chi = kappa c / 2; its
length is 2 chi / kappa, and its part of the action is (chi + sin chi cos chi) / kappa. The polygon of the
bounces adds -kappa times its area. Every arc is the shorter one of its circle, so |chi| < pi / 2.

Bounces lie on the straight walls and circles, continued beyond their ends. All arrays have one row per bounce
and one column per word, shape (p, N).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitdb.arrays import Batch, Floats, Words
from orbitdb.billiard.legs import following, preceding
from orbitdb.billiard.stability import solve_cyclic
from orbitdb.billiard.stadium import SIDE, STRAIGHT, Stadium

_SMALL = 0.05
"""Below this sine of chi, the area between arc and chord is summed as a series."""

_SERIES = (1 / 3, 1 / 10, 3 / 56, 5 / 144, 35 / 1408, 63 / 3328)
"""Integral of t^2 / sqrt(1 - t^2) from 0 to u, divided by u^3, as a series in u^2."""


@dataclass(frozen=True, eq=False)
class ArcPaths(Batch):
    """Closed paths of N words in a magnetic field, with one arc from each bounce to the next.

    Attributes
    ----------
    kappa : ndarray, shape (N,)
        Curvatures of the arcs, in 1/radius.
    x, y, along_x, along_y : ndarray, shape (p, N)
        The bounces, and the unit tangents there in the direction of increasing coordinate.
    bend_x, bend_y : ndarray, shape (p, N)
        Derivatives of the tangents: the inward normal on a circle, 0 on a straight wall.
    chord, ahead_x, ahead_y : ndarray, shape (p, N)
        Length and direction of the chord from each bounce to the next.
    sine, cosine : ndarray, shape (p, N)
        Sine and cosine of chi; the cosine is NaN if the chord is longer than the circle's diameter.
    """

    kappa: Floats
    x: Floats
    y: Floats
    along_x: Floats
    along_y: Floats
    bend_x: Floats
    bend_y: Floats
    chord: Floats
    ahead_x: Floats
    ahead_y: Floats
    sine: Floats
    cosine: Floats

    @classmethod
    def of(cls, stadium: Stadium, symbols: Words, coordinates: Floats, kappa: Floats) -> "ArcPaths":
        """Join bounces with the given symbols and coordinates, each of shape (p, N), by arcs."""
        (x, y), along = stadium.frames(symbols, coordinates)
        bend = -SIDE[symbols] * np.cos(coordinates), np.where(STRAIGHT[symbols], 0.0, -y)
        step_x, step_y = following(x) - x, following(y) - y
        chord = np.sqrt(step_x**2 + step_y**2)
        sine = kappa * chord / 2
        with np.errstate(invalid="ignore", divide="ignore"):
            return cls(kappa, x, y, *along, *bend, chord, step_x / chord, step_y / chord, sine,
                       np.sqrt(1 - sine**2))  # fmt: skip

    @property
    def lengths(self) -> Floats:
        """Lengths of the paths, shape (N,)."""
        return (self.chord * stretch(self.sine)).sum(axis=0)

    @property
    def areas(self) -> Floats:
        """Areas that the paths enclose, anticlockwise positive, shape (N,)."""
        between = self.kappa * self.chord**3 * _bulge(self.sine, self.cosine) / 4
        return self._polygons + between.sum(axis=0)

    @property
    def actions(self) -> Floats:
        """Actions L - kappa A, shape (N,)."""
        of_arcs = self.chord * (stretch(self.sine) + self.cosine) / 2
        return of_arcs.sum(axis=0) - self.kappa * self._polygons

    @property
    def _polygons(self) -> Floats:
        return (self.x * following(self.y) - self.y * following(self.x)).sum(axis=0) / 2

    @property
    def directions(self) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """Directions (x, y) of each arc at its start and at its end, each of shape (p, N)."""
        ahead_x, ahead_y = self.ahead_x, self.ahead_y
        along_x, along_y = self.cosine * ahead_x, self.cosine * ahead_y
        left_x, left_y = -self.sine * ahead_y, self.sine * ahead_x
        return (along_x - left_x, along_y - left_y), (along_x + left_x, along_y + left_y)

    @property
    def outgoing(self) -> Floats:
        """Components along the tangents of the directions in which the paths leave the bounces, (p, N)."""
        along, across = _products(self.along_x, self.along_y, self.ahead_x, self.ahead_y)
        return self.cosine * along + self.sine * across

    @property
    def residuals(self) -> Floats:
        """Largest violation of the law of reflection, as a difference of cosines, shape (N,)."""
        return np.abs(derivatives_of_action(self).gradient).max(axis=0)


def stretch(sine: Floats) -> Floats:
    """Return the ratio of arc to chord."""
    tiny = np.abs(sine) < 1e-8
    return np.where(tiny, 1.0, np.arcsin(sine) / np.where(tiny, 1.0, sine))


def _bulge(sine: Floats, cosine: Floats) -> Floats:
    """Return (chi - sin chi cos chi) / (2 sin^3 chi)."""
    small = np.abs(sine) < _SMALL
    safe = np.where(small, 1.0, sine)
    series = np.polynomial.polynomial.polyval(np.where(small, sine, 0.0) ** 2, _SERIES)
    return np.where(small, series, (np.arcsin(sine) - sine * cosine) / (2 * safe**3))


def _products(a_x: Floats, a_y: Floats, b_x: Floats, b_y: Floats) -> tuple[Floats, Floats]:
    """Return the scalar and the cross products of vectors in the plane."""
    return a_x * b_x + a_y * b_y, a_x * b_y - a_y * b_x


class ActionDerivatives(NamedTuple):
    """Derivatives of the action in the coordinates of the bounces, each of shape (p, N)."""

    gradient: Floats  # t . (arriving direction - leaving direction): 0 where the law of reflection holds
    diagonal: Floats  # of the Hessian
    couplings: Floats  # mixed derivative in the coordinates of each bounce and the next
    in_kappa: Floats  # derivative of the gradient in kappa


def derivatives_of_action(paths: ArcPaths) -> ActionDerivatives:
    """Return the derivatives of the action, in closed form.

    For p = 2, both arcs couple the same two bounces; each contributes its own entry of ``couplings``.
    """
    kappa, chord, sine, cosine = paths.kappa, paths.chord, paths.sine, paths.cosine
    t_x, t_y, ahead_x, ahead_y = paths.along_x, paths.along_y, paths.ahead_x, paths.ahead_y
    next_x, next_y = following(t_x), following(t_y)
    first, first_across = _products(t_x, t_y, ahead_x, ahead_y)
    last, last_across = _products(next_x, next_y, ahead_x, ahead_y)
    both, both_across = _products(t_x, t_y, next_x, next_y)
    leaving = cosine * first + sine * first_across
    arriving = cosine * last - sine * last_across
    turning = -kappa * sine / (2 * cosine)  # second derivative of an arc's action in its chord
    lean = -chord * sine / (2 * cosine)  # and its mixed derivative in chord and kappa
    bend_first = paths.bend_x * ahead_x + paths.bend_y * ahead_y
    bend_last = following(paths.bend_x) * ahead_x + following(paths.bend_y) * ahead_y
    own_first = turning * first**2 + cosine * ((1 - first**2) / chord - bend_first)
    own_last = turning * last**2 + cosine * ((1 - last**2) / chord + bend_last)
    across_x = following(paths.x) - preceding(paths.x)
    across_y = following(paths.y) - preceding(paths.y)
    swept = paths.bend_x * across_y - paths.bend_y * across_x
    return ActionDerivatives(
        gradient=preceding(arriving) - leaving,
        diagonal=own_first + preceding(own_last) - kappa / 2 * swept,
        couplings=-turning * first * last - cosine * (both - first * last) / chord - kappa / 2 * both_across,
        in_kappa=preceding(lean * last - chord / 2 * last_across) - lean * first - chord / 2 * first_across,
    )


def solve_hessian(slopes: ActionDerivatives, *forces: Floats) -> Floats:
    """Solve H x = force for r forces of shape (p, N); return the solutions, shape (r, p, N).

    At an orbit without a field, H is positive definite in the straight bounces and negative definite in the
    others, so that elimination in any order is stable; a field changes this only near bifurcations. A path
    that has no isolated stationary action gets numbers that are not finite.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return solve_cyclic(slopes.diagonal, preceding(slopes.couplings), np.stack(forces), definite=False)


def area_slopes(stadium: Stadium, words: Words, coordinates: Floats) -> Floats:
    """Return the derivatives of the enclosed areas in kappa at kappa = 0, in radius^3, shape (N,).

    To second order, the action is S = L - kappa A - kappa^2 area_slope / 2.

    Parameters
    ----------
    words : ndarray of uint8, shape (N, p)
    coordinates : ndarray, shape (N, p)
        The bounces of orbits without a field, in the order of the words' symbols.
    """
    none = np.zeros(len(words))
    paths = ArcPaths.of(stadium, words.T, coordinates.T, none)
    slopes = derivatives_of_action(paths)
    (shift,) = solve_hessian(slopes, slopes.in_kappa)
    return (paths.chord**3).sum(axis=0) / 12 + (slopes.in_kappa * shift).sum(axis=0)
