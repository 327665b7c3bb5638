"""Orbits by length: how many there are up to each length, and up to which length they are complete."""

import math
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator

from orbitdb.answers.completeness import complete_length
from orbitdb.arrays import Floats, Integers
from orbitdb.orbits.exponents import OrbitClasses
from orbitdb.orbits.least_values import least_limit_of_lengths
from orbitdb.orbits.status import Status
from orbitdb.plots.registry import gaps, nothing
from orbitdb.plots.style import BLUE, GREY, INKS, ORANGE, Colours, Picture, figure
from orbitdb.selection import Selection
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

_BINS = 120


def lengths(catalogue: "Catalogue", *chosen: Selection) -> Picture:
    """Draw the number of orbits up to length L, and their number per unit length for each period.

    If there are subsets at several a, only their numbers up to L are drawn. A dashed line shows the length
    up to which it is proved that no orbit is missing.
    """
    read = [catalogue.classes(subset) for subset in chosen]
    for subset, classes in zip(chosen, read, strict=True):
        if not len(classes):
            raise nothing(catalogue, subset)
    title = chosen[0].describe([subset.a for subset in chosen])
    several, notes = len(chosen) > 1, [line for subset in chosen for line in gaps(catalogue, subset)]
    with figure(6.4, 4.2 if several else 6.0, title, notes) as made:
        above, *below = made.subplots(1 if several else 2, 1, sharex=True, squeeze=False)[:, 0]
        for subset, classes, colour in zip(chosen, read, cycle(INKS.values()), strict=False):
            label = f"$a = {format_float(subset.a)}$" if several else None
            draw_lengths(above, classes.length, classes.words, colour, label)
        for subset, colour in zip(chosen, cycle(INKS.values()), strict=False):
            complete = complete_length(catalogue.fills(a=subset.a), subset)
            _draw_end(above, complete, colour if several else ORANGE, several)
        if not several:
            _draw_limit(above, chosen[0], read[0].length.max())
            _draw_density(below[0], read[0])
            above.set(xlabel="")
    return made


def draw_lengths(
    ax: Axes, length: Floats, count: Integers, colour: str = BLUE, label: str | None = None
) -> None:
    """Draw the number of orbits up to each length, given how many orbits have each one, shape (n,).

    The lengths are in units of the radius and in any order; `label` is the name of the line in the legend.
    """
    order = np.argsort(length, kind="stable")
    ax.step(length[order], np.cumsum(count[order]), where="post", color=colour, label=label)
    ax.set(yscale="log", xlabel="length $L/R$", ylabel="orbits no longer than $L$")


def _draw_end(ax: Axes, complete: float | None, colour: str, several: bool) -> None:
    """Draw the length up to which the orbits are complete, if there is one."""
    if complete is not None:
        end = math.floor(complete * 100) / 100
        label = (
            f"complete up to ${end:.2f}\\,R$" if several else f"complete, by proof, up to $L = {end:.2f}\\,R$"
        )
        ax.axvline(end, color=colour, linewidth=1, linestyle="--", label=label)


def _draw_limit(ax: Axes, chosen: Selection, longest: float) -> None:
    """Draw the length below which there are infinitely many orbits, so that no list is complete."""
    limit = least_limit_of_lengths(chosen.a)
    if chosen.statuses == (Status.ORBIT,) and longest > limit:
        above = math.ceil(limit * 100) / 100  # only finitely many are shorter than a number below the limit
        label = rf"infinitely many orbits below $4a + 2\pi < {above:.2f}\,R$"
        ax.axvline(limit, color=GREY, linewidth=1, linestyle=":", label=label)


def _draw_density(ax: Axes, classes: OrbitClasses) -> None:
    """Draw the number of orbits per unit length, by period, with a bar for its colours."""
    edges = np.linspace(classes.length.min() - 0.5, classes.length.max() + 0.5, _BINS + 1)
    periods = np.arange(classes.p.min(), classes.p.max() + 2) - 0.5
    orbits, _, _ = np.histogram2d(classes.p, classes.length, [periods, edges], weights=classes.words)
    density = np.ma.masked_equal(orbits / (edges[1] - edges[0]), 0)
    drawn = ax.pcolormesh(edges, periods, density, norm=LogNorm(), cmap="viridis")
    ax.set(xlabel="length $L/R$", ylabel="period $p$ (bounces)")
    ax.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    Colours(drawn, "orbits per unit of $L/R$").add_bar(ax)
