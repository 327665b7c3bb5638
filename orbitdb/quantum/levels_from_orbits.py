"""The number of levels below k from orbits alone, and the levels that follow from it.

With the terms Re(A exp(i k l)) of all orbits (`orbitdb.quantum.trace_formula`) and of the bouncing balls,

    N_X(k) = smooth number + sum of Im(A exp(i k l)) / l * exp(-(l / X)^2 / 2).

A longer cutoff X makes the steps of this staircase steeper, but needs longer orbits. For each X, the n-th
level is where N_X first reaches n - 1/2. The result is the median over several X; its error is estimated from
their spread.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.quantum.bouncing_balls import family
from orbitdb.quantum.staircase_errors import error_of_levels, sufficient_length
from orbitdb.quantum.trace_formula import orbit_terms
from orbitdb.quantum.weyl import Parity, weyl

CUTOFFS = (6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0)
"""Cutoffs X from which the levels are computed, in units of the radius."""

BEYOND = 2.5
"""Maximum length of a term, in units of X; longer terms have weights below 0.05."""

_BIN = 0.02
"""Width of the bins in which terms of similar length are collected, in units of the radius."""
_STRETCH, _ORDERS = 100.0, 8
"""Length of the stretches of k, and number of powers of (k - middle of the stretch) (l - centre of the bin)
that are kept. This changes a term by less than 1e-7 of its size."""
_MORE = 3
"""Number of levels to look for beyond the number that Weyl's law predicts."""
_NEIGHBOURS = 9
_RESOLVED, _SIGMAS = 8.0, 1.8
"""Cutoff beyond which the median knows nothing, and how many standard deviations are stated."""
_DENSITIES = 40
"""Number of densities of levels for which the part that is not known is computed."""
_AT_LEAST = 0.05
"""Minimum error of a level, in mean spacings."""
_LEAST_DENSITY = 0.1
_RMS, _GOOD = 0.027, 0.2
_STEPS = 16
"""Number of grid points in k per period of the longest term."""


@dataclass(frozen=True, eq=False)
class Staircase:
    """The number of levels below k from orbits, for several cutoffs X.

    Attributes
    ----------
    k : ndarray, shape (n,)
        A grid of k that starts near 0, in 1/radius.
    count : ndarray, shape (X, n)
        N_X at each k, with one row per cutoff.
    cutoffs : tuple of float
        The cutoffs X, in units of the radius.
    smooth : ndarray, shape (n,)
        The smooth number of levels below each k, by Weyl's law.
    sufficient : float
        Length up to which the orbits of the stored periods suffice
        (`orbitdb.quantum.staircase_errors.sufficient_length`).
    """

    k: Floats
    count: Floats
    cutoffs: tuple[float, ...]
    smooth: Floats
    sufficient: float

    @property
    def density(self) -> Floats:
        """Smooth density of levels, shape (n,)."""
        return np.gradient(self.smooth, self.k)

    def at(self, k: Floats) -> Floats:
        """Return each N_X at the given k by linear interpolation, shape (X, m)."""
        return np.stack([np.interp(k, self.k, row) for row in self.count])


def staircase(
    stadium: Stadium,
    classes: OrbitClasses,
    k_max: float,
    parity: Parity | None = None,
    cutoffs: Sequence[float] = CUTOFFS,
    k_min: float = 0.0,
    period: int | None = None,
) -> Staircase:
    """Return the number of levels of one parity or of all below k, on a grid from `k_min` to `k_max`.

    It needs all orbits shorter than `BEYOND` times the largest cutoff; for one parity, those up to twice this
    length, because half orbits contribute. All periods up to `period`, by default the highest one, are
    complete.
    """
    longest = BEYOND * max(cutoffs)
    points = math.ceil((k_max - k_min) * longest * _STEPS / (2 * math.pi)) + 2
    k = np.linspace(k_min, k_max, points)[1:]
    terms = orbit_terms(classes, longest, parity)
    smooth = weyl(stadium, parity)(k)
    count = smooth + _collected(terms.length, terms.amplitude / terms.length, k, cutoffs)
    for length, wave in family(stadium, k, longest, parity):
        count += _weights(np.array([float(length)]), cutoffs) * (wave.imag / length)
    sufficient = sufficient_length(int(classes.p.max()) if period is None else period, parity is None)
    return Staircase(k, count, tuple(cutoffs), smooth, sufficient)


def _weights(length: Floats, cutoffs: Sequence[float]) -> Floats:
    """Return the weight of each term for each cutoff, shape (X, N), given the lengths of the terms."""
    return np.exp(-((length / np.array(cutoffs)[:, None]) ** 2) / 2)


def _collected(
    length: Floats, amplitude: NDArray[np.complex128], k: Floats, cutoffs: Sequence[float]
) -> Floats:
    """Return the weighted sum of Im(amplitude exp(i k l)) at each k for each cutoff, shape (X, n).

    Terms of nearly equal length share a bin. Their sum is a power series in (k - k0) (l - centre of the bin),
    where k0 is the middle of a stretch of k.
    """
    if not len(length):
        return np.zeros((len(cutoffs), len(k)))
    bins, place = np.unique(np.floor(length / _BIN).astype(np.int64), return_inverse=True)
    centre = (bins + 0.5) * _BIN
    off = length - centre[place]
    weighted = _weights(length, cutoffs) * amplitude
    parts = []
    for part in np.array_split(k, max(1, math.ceil((k[-1] - k[0]) / _STRETCH))):
        middle = (part[0] + part[-1]) / 2
        factor, moments = np.exp(1j * middle * length), []
        for order in range(_ORDERS):
            moments += [_binned(place, row * factor, len(bins)) for row in weighted]
            factor = factor * off / (order + 1)
        waves = np.exp(1j * (part - middle)[:, None] * centre) @ np.array(moments).T
        powers = (1j * (part - middle)[:, None]) ** np.arange(_ORDERS)
        parts.append(np.einsum("no,nox->xn", powers, waves.reshape(len(part), _ORDERS, len(cutoffs))))
    return np.concatenate(parts, axis=1).imag


def _binned(place: NDArray[np.int64], values: NDArray[np.complex128], count: int) -> NDArray[np.complex128]:
    real, imag = (np.bincount(place, part, count) for part in (values.real, values.imag))
    return real + 1j * imag


def _first(k: Floats, count: Floats, numbers: Floats) -> Floats:
    """Return the k at which a function on a grid first reaches each number, or NaN; interpolates linearly."""
    highest = np.maximum.accumulate(count)
    place = np.searchsorted(highest, numbers)
    inside = np.clip(place, 1, len(k) - 1)
    rise = highest[inside] - count[inside - 1]
    share = (numbers - count[inside - 1]) / np.where(rise > 0, rise, 1.0)
    reached = k[inside - 1] + np.clip(share, 0.0, 1.0) * (k[inside] - k[inside - 1])
    reached[place == 0] = k[0]
    reached[place >= len(k)] = np.nan
    return reached


def levels_of(orbits: Staircase, k_max: float) -> tuple[Floats, Floats]:
    """Return the levels below `k_max` from orbits, shape (N,), and their errors, shape (N,).

    The error combines the spread of a level over the cutoffs with the mean spread of neighbouring levels, and
    is at least what follows from the part of the staircase that no orbit up to the cutoff tells.
    """
    most = math.floor(float(orbits.smooth[-1])) + _MORE
    reached = np.stack([_first(orbits.k, row, np.arange(0.5, most)) for row in orbits.count])
    reached = reached[:, ~np.isnan(reached).any(axis=0)]
    k = np.sort(np.median(reached, axis=0))
    spacing = 1 / np.maximum(np.interp(k, orbits.k, orbits.density), _LEAST_DENSITY)
    spread = np.ptp(reached, axis=0) / spacing
    if not len(k):
        return k, k
    window, middle = np.ones(_NEIGHBOURS), slice(_NEIGHBOURS // 2, _NEIGHBOURS // 2 + len(k))
    near = np.convolve(spread, window)[middle] / np.convolve(np.ones(len(k)), window)[middle]
    error = (np.hypot(2 * spread, 2.5 * near) + _AT_LEAST) * spacing
    crowded = np.linspace(0.0, 1 / spacing.min() / _RESOLVED, _DENSITIES)[1:]
    unknown = [error_of_levels(each) for each in crowded.tolist()]
    error = np.maximum(error, _SIGMAS * spacing * np.interp(1 / spacing / _RESOLVED, crowded, unknown))
    below = k < k_max
    return k[below], error[below]


def reliable_end(stadium: Stadium, parity: Parity) -> float:
    """Return the k up to which the rms error of levels from orbits is below 0.2 mean spacings.

    In tests with all orbits of periods up to 12, the rms error near k, in units of the mean spacing, was
    about `_RMS` times the mean density of levels of the parity, at every half length.
    """
    smooth = weyl(stadium, parity)
    slope, curve = smooth.coef[1], 2 * smooth.coef[2]
    return float((_GOOD / _RMS - slope) / curve)
