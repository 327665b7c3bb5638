"""Orbits and subsets drawn into axes of matplotlib, which may be the caller's."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

import numpy as np
from matplotlib import pyplot
from matplotlib.axes import Axes
from numpy.typing import NDArray

from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.curves import Period, bounces, draw_phase_space, draw_staircase
from orbitdb.plots.paths import draw_orbit
from orbitdb.plots.style import look, wrapped

Floats = NDArray[np.float64]
_LONGEST = 40


def orbit_axes(code: str, stadium: Stadium, points: Floats, ax: Axes | None) -> Axes:
    """Draw an orbit in its stadium, given its bounces, shape (p, 2), with its code above it."""
    with _axes(ax) as axes:
        draw_orbit(axes, stadium, points)
        axes.set_title(code if len(code) <= _LONGEST else f"{code[: _LONGEST - 3]}...")
    return axes


def phase_space_axes(title: str, stadium: Stadium, periods: Iterable[Period], ax: Axes | None) -> Axes:
    """Draw the bounces of orbits in phase space; lambda per bounce gives their colours."""
    with _axes(ax) as axes:
        draw_phase_space(axes, stadium, *bounces(stadium, periods))
        axes.set_title(_fitted(title, axes), pad=20)
    return axes


def lengths_axes(title: str, length: Floats, ax: Axes | None) -> Axes:
    """Draw how many orbits are no longer than L, given their lengths, shape (N,)."""
    with _axes(ax) as axes:
        draw_staircase(axes, length, np.ones(len(length), np.int64))
        axes.set_title(_fitted(title, axes))
    return axes


@contextmanager
def _axes(ax: Axes | None) -> Iterator[Axes]:
    """Give axes, by default of a new figure, to draw in the house's look."""
    # The figure comes before the look, whose end undoes all settings: the first one loads the backend, and
    # that of a notebook then sets that figures are shown.
    figure = ax.figure if ax else pyplot.figure(layout="constrained")
    with look():
        yield ax or figure.subplots()


def _fitted(title: str, ax: Axes) -> str:
    """Return a title in lines that the axes have room for."""
    return wrapped(title, ax.get_window_extent().width / ax.figure.dpi)
