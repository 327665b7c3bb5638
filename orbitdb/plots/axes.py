"""Orbits and subsets drawn into axes of matplotlib, which may be the caller's."""

from collections.abc import Sequence

import numpy as np
from matplotlib import pyplot
from matplotlib.axes import Axes
from numpy.typing import NDArray

from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.curves import draw_birkhoff, draw_staircase
from orbitdb.plots.paths import draw_orbit
from orbitdb.plots.style import look, wrapped

Floats = NDArray[np.float64]
Period = tuple[NDArray[np.uint8], Floats, Floats]
"""The orbits of one period: symbols and coordinates, shape (N, p), and lambda per bounce, shape (N,)."""

_LONGEST = 40


def orbit_axes(code: str, stadium: Stadium, points: Floats, ax: Axes | None) -> Axes:
    """Draw an orbit in its stadium, given its bounces, shape (p, 2), with its code above it."""
    with look():
        ax = _axes(ax)
        draw_orbit(ax, stadium, points)
        ax.set_title(code if len(code) <= _LONGEST else f"{code[: _LONGEST - 3]}...")
    return ax


def phase_space_axes(title: str, stadium: Stadium, periods: Sequence[Period], ax: Axes | None) -> Axes:
    """Draw the bounces of orbits in phase space; lambda per bounce gives their colours."""
    place, sine, colour = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for symbols, coordinates, lambda_d in periods:
        along, sines = birkhoff(stadium, symbols, coordinates)
        place.append(along.ravel())
        sine.append(sines.ravel())
        colour.append(np.repeat(lambda_d, symbols.shape[1]))
    with look():
        ax = _axes(ax)
        draw_birkhoff(ax, stadium, *map(np.concatenate, (place, sine, colour)))
        ax.set_title(_fitted(title, ax), pad=20)
    return ax


def lengths_axes(title: str, length: Floats, ax: Axes | None) -> Axes:
    """Draw how many orbits are no longer than L, given their lengths, shape (N,)."""
    with look():
        ax = _axes(ax)
        draw_staircase(ax, length, np.ones(len(length), np.int64))
        ax.set_title(_fitted(title, ax))
    return ax


def _axes(ax: Axes | None) -> Axes:
    return pyplot.subplots(layout="constrained")[1] if ax is None else ax


def _fitted(title: str, ax: Axes) -> str:
    """Return a title in lines that the axes have room for."""
    return wrapped(title, ax.get_window_extent().width / ax.figure.dpi)
