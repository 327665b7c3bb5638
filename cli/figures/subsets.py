"""Figures of the orbits in a chosen subset."""

import math
from collections.abc import Sequence

import numpy as np
import typer
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from orbitdb.answers import whole_periods
from orbitdb.answers.completeness import complete_length
from orbitdb.answers.select import read_subset
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.figures.averages import NOTHING
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.cli.render import note
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots import paths, sheet
from orbitdb.plots.sheet import size_of
from orbitdb.plots.style import ORANGE, figure
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

_BINS = 120


def draw_sheet(moment: Moment, chosen: Selection, limit: int, order: str = "p") -> Figure:
    """Draw one orbit of each class of a subset, or only of the first `limit` classes in the given order."""
    note_gaps(moment, chosen, order=order)
    first: dict[str, None] = {}
    for (word,) in moment.rows(moment.choose(chosen, order), ("representative",)):
        first[word] = None
        if len(first) > limit:
            break
    orbits = [found for word in [*first][:limit] if (found := moment.find(word, chosen.a)) is not None]
    drawn = [found for found in orbits if found.points is not None]
    if not drawn:
        raise _nothing(moment, chosen)
    if len(first) > limit:
        total = len(moment.choose(chosen).ids)
        note(f"{limit} of {total} classes are drawn; --limit {total} draws them all")
    return sheet_of(drawn, f"Classes of {chosen.describe()}")


def sheet_of(orbits: Sequence[Orbit], title: str) -> Figure:
    """Draw each orbit in a stadium of its own; all have coordinates at the same a."""
    with figure(*size_of(len(orbits), orbits[0].a), title) as made:
        sheet.draw_sheet(made.add_subplot(), orbits)
    return made


def draw_phase_space(moment: Moment, chosen: Selection) -> Figure:
    """Draw the bounces of a subset in phase space, coloured by lambda per bounce."""
    stadium = Stadium(chosen.a)
    note_gaps(moment, chosen)
    subset = read_subset(moment, chosen, "p", coordinates=True)
    if not len(subset):
        raise _nothing(moment, chosen)
    periods = ((*subset.of_period(p), subset.lambda_d[subset.p == p]) for p in np.unique(subset.p).tolist())
    with figure(7.2, 4.4, chosen.describe()) as made:
        ax = made.add_subplot()
        dots = paths.draw_phase_space(ax, stadium, periods)
        made.colorbar(dots, ax=ax, label=r"$\lambda_d$ (per bounce)", pad=0.01, extend="both")
    return made


def draw_lengths(moment: Moment, chosen: Selection) -> Figure:
    """Draw the number of orbits up to length L, and their number per unit length for each period."""
    note_gaps(moment, chosen)
    found = whole_periods.read_classes(moment, chosen)
    if not len(found):
        raise _nothing(moment, chosen)
    complete = complete_length(moment.fills(chosen.a), chosen)
    with figure(6.4, 6.0, chosen.describe()) as made:
        above, below = made.subplots(2, 1, sharex=True)
        paths.draw_staircase(above, found.length, found.chosen)
        if complete is not None:
            end = math.floor(complete * 100) / 100
            label = f"complete, by proof, up to $L = {end:.2f}\\,R$"
            above.axvline(end, color=ORANGE, linewidth=1, linestyle="--", label=label)
        edges = np.linspace(found.length.min() - 0.5, found.length.max() + 0.5, _BINS + 1)
        periods = np.arange(found.p.min(), found.p.max() + 2) - 0.5
        orbits, _, _ = np.histogram2d(found.p, found.length, [periods, edges], weights=found.chosen)
        density = np.ma.masked_equal(orbits / (edges[1] - edges[0]), 0)
        drawn = below.pcolormesh(edges, periods, density, norm=LogNorm(), cmap="viridis")
        below.set(xlabel="length $L/R$", ylabel="period $p$ (bounces)")
        below.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        made.colorbar(drawn, ax=below, label="orbits per unit of $L/R$", pad=0.01)
        above.set(xlabel="")
    return made


def _nothing(moment: Moment, chosen: Selection) -> typer.Exit:
    """Report that there is nothing to draw; return the exception that ends the command."""
    note_nothing(moment, chosen, more=NOTHING)
    return typer.Exit(1)
