"""Survival in an open stadium, with its exponential and its tail."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from orbitdb.plots.registry import EmptyFigureError
from orbitdb.plots.style import BLUE, GREY, ORANGE, Picture, figure
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.open_stadium.escape import Escape

_AXES = {"bounce": "bounces $n$", "time": "time $t$ (radius / speed)"}
_POINTS = 300
_FITTED = 0.1
"""The exponential goes through the row whose survival is nearest to this, in logarithm."""


def escape(found: "Escape") -> Picture:
    """Draw survival against the number of bounces, and against time."""
    from orbitdb.open_stadium.escape import ways

    title = f"escape {ways(found.opening, found.without)} at a = {format_float(found.a)}"
    with figure(7.2, 3.6, title, found.notes) as made:
        first, second = made.subplots(1, 2, sharey=True)
        draw_escape(first, found)
        draw_escape_time(second, found)
        second.set_ylabel("")
    return made


def draw_escape(ax: Axes, found: "Escape") -> None:
    """Draw survival against the number of bounces."""
    _draw(ax, found, "bounce")


def draw_escape_time(ax: Axes, found: "Escape") -> None:
    """Draw survival against time."""
    _draw(ax, found, "time")


def _draw(ax: Axes, found: "Escape", by: str) -> None:
    """Draw sampled survival with its errors, the exponential solid, and the tail dashed."""
    if not len(found):
        raise EmptyFigureError(["survival was not sampled: trajectories=0"])
    columns = {name: np.array(values, float) for name, values in found.columns(by).items()}
    at, survival, error, tail = columns.values()
    left = survival > 0
    ax.errorbar(at[left], survival[left], error[left], fmt=".", color=BLUE, label="sampled")
    rate = found.rate_time if by == "time" else found.rate_bounce
    lowest = survival[left].min() / 3
    if rate is not None:
        place = np.abs(np.log(np.maximum(survival, lowest) / _FITTED)).argmin()
        along = np.geomspace(at[0], at[-1], _POINTS)
        decay = survival[place] * np.exp(rate * (at[place] - along))
        ax.plot(along[decay > lowest], decay[decay > lowest], color=ORANGE, label="exponential")
    if tail.any():
        shown = tail < 1
        ax.plot(at[shown], tail[shown], "--", color=GREY, label="tail")
    ax.set(xscale="log", yscale="log", xlabel=_AXES[by], ylabel="survival", ylim=(lowest, 1.5))
