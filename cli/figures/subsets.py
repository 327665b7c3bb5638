"""Figures of the orbits of chosen subsets, and of levels of the quantum stadium beside them."""

import math
from collections.abc import Sequence

import numpy as np
import typer
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from orbitdb.answers import whole_periods
from orbitdb.answers.gaps import complete_length
from orbitdb.answers.spectrum import read_classes, read_levels, read_spectrum
from orbitdb.answers.subset import read_subset
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.figures.averages import NOTHING
from orbitdb.cli.figures.orbits import short
from orbitdb.cli.reading import note_gaps, note_nothing
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots import paths, sheet
from orbitdb.plots.sheet import size_of
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, figure
from orbitdb.quantum.amplitudes import orbit_terms, weyl
from orbitdb.quantum.lengths import counted, family_count
from orbitdb.quantum.spectrum import Peak
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

_BINS = 120
_LENGTHS = (1.0, 12.0)
_PLACES = 2000


def draw_sheet(moment: Moment, chosen: Selection, limit: int, order: str = "p") -> Figure:
    """Draw one orbit of each class of a subset, or the first ones in its order, as many as the limit."""
    note_gaps(moment, chosen, order=order)
    first: dict[str, None] = {}
    for (word,) in moment.rows(chosen, ("representative",), order):
        first[word] = None
        if len(first) > limit:
            break
    orbits = [found for word in [*first][:limit] if (found := moment.find(word, chosen.a)) is not None]
    drawn = [found for found in orbits if found.points is not None]
    if not drawn:
        raise _nothing(moment, chosen)
    if len(first) > limit:
        total = len(moment.choose(chosen).ids)
        note(f"{limit} of {total} classes are drawn; --limit {total} draws all")
    return sheet_of(drawn, f"Classes of {chosen.describe()}")


def sheet_of(orbits: Sequence[Orbit], title: str) -> Figure:
    """Draw some orbits with coordinates at one a."""
    with figure(*size_of(len(orbits), orbits[0].a), title) as made:
        sheet.draw_sheet(made.add_subplot(), orbits)
    return made


def draw_phase_space(moment: Moment, chosen: Selection) -> Figure:
    """Draw the bounces in phase space, coloured by lambda."""
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
    """Draw how many orbits are no longer than L, and how many there are per unit of length."""
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
    """Say that there is nothing to draw; return how the command ends then."""
    note_nothing(moment, chosen, more=NOTHING)
    return typer.Exit(1)


def draw_length_spectrum(moment: Moment, chosen: Selection) -> Figure:
    """Draw the length spectrum of the orbits downwards, and that of the levels upwards if there are any."""
    found = read_spectrum(moment, chosen.a, _LENGTHS, 1000)
    for said in found.notes():
        note(said)
    with figure(7.2, 4.8, f"length spectrum at a = {exact(chosen.a)}, k below {found.k_max:.4g}") as made:
        ax = made.add_subplot()
        side = -1 if found.quantum is None else 1
        if found.quantum is not None:
            ax.plot(found.length, np.abs(found.quantum), color=BLUE, label="levels")
        ax.plot(found.length, -np.abs(found.orbits), color=ORANGE, label="orbits, downwards")
        first, last = found.length[[0, -1]]
        if found.complete < last:
            beyond = max(found.complete, first)
            ax.axvspan(beyond, last, color=GREY, alpha=0.12, label="orbits may be missing")
        for peak in found.peaks(1):
            ax.annotate(_times(peak), (peak.length, side * peak.height), xytext=(0, 4 * side),
                        textcoords="offset points", fontsize=7, rotation=90, ha="center",
                        va="bottom" if side > 0 else "top")  # fmt: skip
        ax.axhline(0, color=INK, linewidth=0.6)
        ax.margins(x=0, y=0.25)
        ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")
    return made


def _times(peak: Peak) -> str:
    """Say how often which orbit is gone round; of one parity it may be half of it."""
    whole, half = divmod(peak.repetitions, 1)
    times = f"{int(whole) or ''}{'½' if half else ''}"
    return short(peak.code) if times == "1" else f"{times} × {short(peak.code)}"


def draw_levels(moment: Moment, chosen: Selection) -> Figure:
    """Draw the number of levels, and its fluctuations beside those that the orbits give."""
    known = read_levels(moment, chosen.a, None)
    if known is None:
        raise InputError(f"no levels to draw: 'orbitdb levels --k 0:30 --a {exact(chosen.a)}' finds them")
    k, end = known
    at, stadium = np.linspace(0.5, end, _PLACES), Stadium(chosen.a)
    classes, _, highest = read_classes(moment, chosen)
    smooth, family = weyl(stadium, None)(at), family_count(stadium, at, _LENGTHS[1])
    orbits = counted(orbit_terms(classes, _LENGTHS[1]), at)
    note(f"orbits and bouncing balls of lengths up to {_LENGTHS[1]:g}: a partial sum")
    with figure(7.2, 6.0, f"{len(k)} levels at a = {exact(chosen.a)}, k below {end:.4g}") as made:
        above, below = made.subplots(2, 1, sharex=True)
        above.step(np.append(0.0, k), np.arange(len(k) + 1), where="post", color=BLUE, label="levels")
        above.plot(at, smooth, color=ORANGE, linestyle="--", linewidth=1, label="Weyl's law")
        above.set(ylabel="levels below $k$")
        rest = np.searchsorted(k, at) - smooth
        below.plot(at, rest, color=BLUE, linewidth=0.8, label="levels, less Weyl's law")
        below.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls")
        label = f"bouncing balls and orbits to $p = {highest}$, a partial sum"
        below.plot(at, family + orbits, color=ORANGE, linewidth=0.8, label=label)
        below.set(xlabel="$kR$", ylabel="fluctuation")
    return made
