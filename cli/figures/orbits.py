"""Figures of orbits: one orbit, the orbits of a subset, and what the screen shows of them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import cycle

import numpy as np
import typer
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter
from numpy.typing import NDArray

from orbitdb.answers import whole_periods
from orbitdb.answers.completeness import complete_length, gaps, nothing
from orbitdb.answers.subset import read_subset
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.figures.averages import NOTHING
from orbitdb.cli.output import code_text, note
from orbitdb.orbits.least_values import least_limit_of_lengths
from orbitdb.orbits.orbit import Orbit
from orbitdb.orbits.solve import solve_word
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.plots import paths
from orbitdb.plots.paths import size_of
from orbitdb.plots.style import BLUE, GREY, INKS, ORANGE, figure, short
from orbitdb.store.connection import Moment
from orbitdb.store.fills import read_fills
from orbitdb.store.lookup import find_word
from orbitdb.store.query import choose
from orbitdb.store.rows import rows_of
from orbitdb.store.selection import Selection
from orbitdb.symbols.symmetry import REVERSE, images_of
from orbitdb.text import exact

PLACES = 400
_WIDTH = 6.4
_LOW, _HIGH, _BESIDE = 0.1, 5.0, 1e-9


def draw_orbit(orbit: Orbit) -> Figure:
    """Draw the path of an orbit, which must have coordinates, in its stadium."""
    with figure(_WIDTH, _height(orbit.a)) as made:
        ax = made.add_subplot()
        _draw_path(made, ax, orbit, "")
    return made


def draw_reverse(orbit: Orbit) -> Figure:
    """Draw an orbit above its time reverse, which has the same bounces in reverse order."""
    reverse, same = images_of(orbit.code)[REVERSE], orbit.time_reversal == "self"
    kind = "the same orbit: it retraces its path" if same else "another orbit, counted separately"
    with figure(_WIDTH, 2 * _height(orbit.a)) as made:
        above, below = made.subplots(2, 1)
        points = _draw_path(made, above, orbit, "(a) ")
        paths.draw_orbit(below, Stadium(orbit.a), points[::-1], BLUE if same else ORANGE)
        below.set_title(f"(b) its time reverse {short(reverse)}: {kind}")
    return made


def _draw_path(made: Figure, ax: Axes, orbit: Orbit, which: str) -> NDArray[np.float64]:
    """Draw an orbit with its a, length and lambda above it, and label the figure; return the bounces."""
    assert orbit.points is not None
    paths.draw_orbit(ax, Stadium(orbit.a), orbit.points)
    numbers = f"$a = {exact(orbit.a)}$,  $L = {orbit.length:.4f}\\,R$,  $\\lambda = {orbit.lyapunov:.4f}$"
    ax.set_title(f"{which}{short(orbit.code)},  {numbers}")
    made.set_label(f"orbit {code_text(orbit.code)} at a = {exact(orbit.a)}")
    return orbit.points


def _height(a: float) -> float:
    """Return the height, in inches, of a stadium as wide as the figure, with its title, axis and legend."""
    return max(2.2, (_WIDTH - 0.8) * 2.7 / (2 * a + 2.7) + 1.1)


def draw_life(orbit: Orbit) -> Figure:
    """Draw the orbit of a word at its birth, and its length and lambda against a."""
    lives = orbit.exists or ()
    ends = [end for life in lives for end in life if end]
    start = lives[0][0] * (1 + _BESIDE) or orbit.a
    first = solve_word(orbit.code, start)
    a = np.geomspace(
        min([_LOW, *(end / 2 for end in ends)]), max([_HIGH, *(4 * end for end in ends)]), PLACES
    )
    beside = [end * (1 + sign * _BESIDE) for end in ends for sign in (-1, 1)]
    a = np.sort(np.concatenate([a, beside]))
    orbits = [solve_word(orbit.code, at) for at in a.tolist()]
    numbers = np.array([
        (np.nan, np.nan) if solved.status != "orbit" else (solved.length or np.nan, solved.lyapunov or np.nan)
        for solved in orbits
    ])  # fmt: skip
    with figure(_WIDTH, 7.6) as made:
        above, middle, below = made.subplots(3, 1)
        assert first.points is not None
        paths.draw_orbit(above, Stadium(first.a), first.points)
        above.set_title(
            f"{short(orbit.code)} {'is born' if lives[0][0] else 'exists'} at $a = {first.a:.6g}$"
        )
        for ax, values, label, colour in zip(
            (middle, below), numbers.T, ("length $L$", r"$\lambda$"), (BLUE, ORANGE), strict=True
        ):
            ax.plot(a, values, color=colour)
            for end in ends:
                ax.axvline(end, color=GREY, linewidth=0.8, linestyle=":", label="birth or death")
            ax.set(xscale="log", ylabel=label, xlim=(a[0], a[-1]))
            ax.xaxis.set_minor_formatter(NullFormatter())
        below.set_xlabel("$a$")
        made.set_label(f"life of {code_text(orbit.code)}")
    return made


Size = tuple[float, float]

_BINS = 120
_MOST = 500
"""Largest number of orbits on a sheet that can still be told apart."""


def draw_sheet(
    moment: Moment, chosen: Selection, limit: int, order: str = "p", size: Size | None = None
) -> Figure:
    """Draw one orbit of each class of a subset, or only of the first `limit` classes in the given order."""
    chosen = _with_paths(moment, chosen)
    for text in gaps(moment, chosen, order=order):
        note(text)
    classes = choose(moment, chosen, order, by_class=True)
    words = rows_of(moment, classes, ("representative",), 0, limit)
    orbits = [orbit for (word,) in words if (orbit := find_word(moment, word, chosen.a)) is not None]
    drawn = [orbit for orbit in orbits if orbit.points is not None]
    if not drawn:
        raise _nothing(moment, chosen)
    if (total := len(classes)) > limit:
        rest = f"--limit {total} draws them all" if total <= _MOST else "choose fewer to see them all"
        note(f"{limit} of {total} classes are drawn; {rest}")
    return sheet_of(drawn, f"Classes of {chosen.describe()}", size)


def sheet_of(orbits: Sequence[Orbit], title: str, size: Size | None = None) -> Figure:
    """Draw each orbit in a stadium of its own; all have coordinates at the same a. The size is in inches."""
    with figure(*(size or size_of(len(orbits), orbits[0].a)), title) as made:
        paths.draw_sheet(made.add_subplot(), orbits)
    return made


def draw_phase_space(moment: Moment, chosen: Selection) -> Figure:
    """Draw the bounces of a subset in phase space, coloured by lambda per bounce."""
    stadium, chosen = Stadium(chosen.a), _with_paths(moment, chosen)
    for text in gaps(moment, chosen):
        note(text)
    subset = read_subset(moment, chosen, "p", coordinates=True)
    if not len(subset):
        raise _nothing(moment, chosen)
    periods = ((*subset.of_period(p), subset.lambda_d[subset.p == p]) for p in np.unique(subset.p).tolist())
    with figure(7.2, 4.4, chosen.describe()) as made:
        ax = made.add_subplot()
        dots = paths.draw_phase_space(ax, stadium, periods)
        made.colorbar(dots, ax=ax, label=r"$\lambda_d$ (per bounce)", pad=0.01, extend="both")
    return made


def draw_lengths(moment: Moment, *subsets: Selection) -> Figure:
    """Draw the number of orbits up to length L, and their number per unit length for each period.

    If there are subsets at several a, only their numbers up to L are drawn.
    """
    read = [whole_periods.read_classes(moment, chosen) for chosen in subsets]
    for chosen, classes in zip(subsets, read, strict=True):
        for text in gaps(moment, chosen):
            note(text)
        if not len(classes):
            raise _nothing(moment, chosen)
    (chosen, *others), (classes, *_) = subsets, read
    if others:
        with figure(6.4, 4.2, chosen.describe([subset.a for subset in subsets])) as made:
            ax = made.add_subplot()
            for subset, classes, colour in zip(subsets, read, cycle(INKS.values()), strict=False):
                paths.draw_staircase(ax, classes.length, classes.words, colour, f"$a = {exact(subset.a)}$")
        return made
    with figure(6.4, 6.0, chosen.describe()) as made:
        above, below = made.subplots(2, 1, sharex=True)
        paths.draw_staircase(above, classes.length, classes.words)
        _draw_ends(above, complete_length(read_fills(moment, chosen.a), chosen), chosen, classes.length.max())
        edges = np.linspace(classes.length.min() - 0.5, classes.length.max() + 0.5, _BINS + 1)
        periods = np.arange(classes.p.min(), classes.p.max() + 2) - 0.5
        orbits, _, _ = np.histogram2d(classes.p, classes.length, [periods, edges], weights=classes.words)
        density = np.ma.masked_equal(orbits / (edges[1] - edges[0]), 0)
        drawn = below.pcolormesh(edges, periods, density, norm=LogNorm(), cmap="viridis")
        below.set(xlabel="length $L/R$", ylabel="period $p$ (bounces)")
        below.yaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        made.colorbar(drawn, ax=below, label="orbits per unit of $L/R$", pad=0.01)
        above.set(xlabel="")
    return made


def _draw_ends(ax: Axes, complete: float | None, chosen: Selection, longest: float) -> None:
    """Draw the length up to which the orbits are complete, and the limit above which none can be."""
    if complete is not None:
        end = math.floor(complete * 100) / 100
        label = f"complete, by proof, up to $L = {end:.2f}\\,R$"
        ax.axvline(end, color=ORANGE, linewidth=1, linestyle="--", label=label)
    limit = least_limit_of_lengths(chosen.a)
    if chosen.statuses == (Status.ORBIT,) and longest > limit:
        label = rf"infinitely many orbits below $4a + 2\pi = {limit:.2f}\,R$"
        ax.axvline(limit, color=GREY, linewidth=1, linestyle=":", label=label)


def _with_paths(moment: Moment, chosen: Selection) -> Selection:
    """Return the part of a subset that has paths; end the command if the subset has none."""
    statuses = tuple(status for status in chosen.statuses if status in EXISTING)
    if statuses or not chosen.statuses:
        return replace(chosen, statuses=statuses)
    for text in gaps(moment, chosen):
        note(text)
    if total := len(choose(moment, chosen)):
        note(f"{chosen.describe(count=total)}: no path to draw; --status orbit draws orbits instead")
        raise typer.Exit(1)
    raise _nothing(moment, chosen)


def _nothing(moment: Moment, chosen: Selection) -> typer.Exit:
    """Report that there is nothing to draw; return the exception that ends the command."""
    if text := nothing(moment, chosen):
        note(f"{text}{NOTHING}")
    return typer.Exit(1)


__all__ = ["draw_counts", "draw_curves", "draw_orbit", "draw_phase"]

Curve = tuple[str, str, Floats, Floats, str]
"""A curve: its style on the screen, name, periods, values, and marker, which is empty for a line."""

_MARKERS = {"×": "x", "•": "o"}
_LINE = 0.2
"""Height of a bar with its label, in inches."""


def draw_phase(orbit: Orbit) -> Figure:
    """Draw the bounces of an orbit, which must have coordinates, in phase space."""
    with figure(6.4, 4.0, f"phase space at a = {exact(orbit.a)}") as made:
        ax = made.add_subplot()
        assert orbit.arclength is not None and orbit.sine is not None  # noqa: PT018
        ax.plot(orbit.arclength, orbit.sine, "o", color=BLUE, markersize=5, label=short(orbit.code))
        ends = (0, Stadium(orbit.a).perimeter)
        ax.set(xlim=ends, ylim=(-1, 1), xlabel="arc length $s/R$", ylabel=r"$\sin\alpha$")
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
