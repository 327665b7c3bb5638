"""The number of quantum levels below k: of the levels, from the orbits, and by Weyl's law."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.polynomial import Polynomial

from orbitdb.answers.stadium_levels import orbits_for, read_orbits
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.style import BLUE, GREEN, INK, ORANGE, Picture, figure
from orbitdb.quantum.bouncing_balls import family_count
from orbitdb.quantum.weyl import Parity, check_levels, weyl
from orbitdb.selection import Selection
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.quantum.exact_levels import Levels

_LONGEST = 12.0
"""Length up to which bouncing balls count."""


def staircase(
    catalogue: "Catalogue",
    chosen: Selection,
    levels: Floats | None = None,
    parity: Parity | None = None,
    window: bool = False,
) -> Picture:
    """Draw the number of levels below k and its fluctuations, each compared with that from the orbits.

    The staircase of a window begins with the number that the orbits give its first level.
    """
    stadium = Stadium(chosen.a)
    if levels is None:
        stored = catalogue.levels(parity=parity, a=chosen.a)
        k, end = stored.k, stored.high
    else:
        k = check_levels(levels, stadium, parity, window)
        end = float(k[-1])
    below, named = 0, f"k below {end:.4g}"
    notes: tuple[str, ...] = ()
    if window:
        found = catalogue.assess(k, parity=parity, window=True, a=chosen.a)
        below, notes = found.first - 1, found.notes
        known = f"from number {found.first} (P {found.first_probability:.2f})"
        named = f"k from {k[0]:.6g} to {end:.6g}, {known if found.sure_of_first else 'up to a constant'}"
    with catalogue._reading() as connection:
        classes, period = read_orbits(connection, chosen)
    orbits = orbits_for(stadium, classes, parity, k if window else np.array([end]), window, period=period)
    low = float(k[0]) if window else 0.0
    inside = (low <= orbits.k) & (orbits.k <= end)
    at, smooth, count = orbits.k[inside], orbits.smooth[inside], orbits.count[0][inside]
    title = f"{len(k)} levels at a = {format_float(chosen.a)}, {of_parity(parity)}, {named}"
    with figure(7.2, 4.2, title, notes) as made:
        ax = made.add_subplot()
        own = below + np.searchsorted(k, at, "right" if window else "left")
        ax.plot(at, own - smooth, color=BLUE, linewidth=0.8, label="levels")
        label = f"orbits, cut off at length $X = {orbits.cutoffs[0]:g}\\,R$"
        ax.plot(at, count - smooth, "-", color=ORANGE, linewidth=1, label=label)
        family = family_count(stadium, at, _LONGEST, parity)
        ax.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls alone")
        ax.set(xlabel="$kR$", ylabel="levels below $k$\nminus Weyl's law", xlim=(low, end))
    return made


def of_parity(parity: Parity | None) -> str:
    """Name one parity, or all of them, for a title."""
    return "all parities" if parity is None else f"parity {parity}"


def draw_staircase(ax: Axes, levels: "Levels") -> None:
    """Draw the number of levels from the lower end of their range up to k, and Weyl's law."""
    smooth = sum((weyl(Stadium(levels.a), parity) for parity in levels.parities), Polynomial([0.0]))
    k = np.linspace(levels.low, levels.high, 400)
    below = smooth(levels.low) if levels.low else 0.0
    ends = [levels.low, *np.sort(levels.k), levels.high]
    count = [*range(len(levels) + 1), len(levels)]
    ax.step(ends, count, where="post", color=BLUE, label="levels")
    ax.plot(k, smooth(k) - below, color=INK, linestyle="--", linewidth=1, label="Weyl's law")
    ax.set(xlabel="$kR$", ylabel=f"levels from {levels.low:g} to $k$" if levels.low else "levels below $k$")
