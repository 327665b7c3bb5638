"""Figures of what the screen shows: bounces in phase space, curves against the period, and counts."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.figures.orbits import draw_orbit
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots.curves import short
from orbitdb.plots.style import BLUE, INKS, figure

__all__ = ["draw_counts", "draw_curves", "draw_orbit", "draw_phase"]

Curve = tuple[str, str, Floats, Floats, str]
"""A curve: its style on the screen, name, periods, values, and marker, which is empty for a line."""

_MARKERS = {"×": "x", "•": "o"}
_LINE = 0.2
"""Height of a bar with its label, in inches."""


def draw_phase(orbits: Sequence[Orbit]) -> Figure:
    """Draw the bounces of orbits in phase space; the orbits have coordinates and share the same a."""
    a = orbits[0].a
    with figure(6.4, 4.0, f"phase space at a = {exact(a)}") as made:
        ax = made.add_subplot()
        for orbit, colour, marker in zip(orbits, INKS.values(), "osD^vx", strict=False):
            assert orbit.arclength is not None and orbit.sine is not None  # noqa: PT018
            ax.plot(orbit.arclength, orbit.sine, marker, color=colour, markersize=5, label=short(orbit.code))
        ax.set(xlim=(0, Stadium(a).perimeter), ylim=(-1, 1), xlabel="arclength $s/R$", ylabel="sine")
    return made


def draw_curves(curves: Mapping[str, Sequence[Curve]], titles: Mapping[str, str], title: str) -> Figure:
    """Draw curves against the period, with one panel for each name."""
    with figure(6.4, 2.6 * len(curves) + 0.8, title) as made:
        for ax, (name, group) in zip(made.subplots(len(curves), 1, sharex=True), curves.items(), strict=True):
            for style, label, p, values, marker in group:
                look = _MARKERS.get(marker, "-")
                ax.plot(p, values, look, color=INKS[style], label=label or "_unnamed")
            ax.legend(fontsize="small")
            ax.set(ylabel=titles[name])
            ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        ax.set(xlabel="period $p$ (bounces)")
    return made


def draw_counts(counts: Sequence[tuple[str, int]], of: str, title: str) -> Figure:
    """Draw counts of words as labelled bars, from the top down."""
    with figure(6.4, _LINE * len(counts) + 1.2, title) as made:
        ax = made.add_subplot()
        places = np.arange(len(counts))
        ax.barh(places, [count for _, count in counts], color=BLUE)
        ax.set_yticks(places, [label for label, _ in counts])
        ax.invert_yaxis()
        ax.set(xlabel="words", ylabel=of)
    return made
