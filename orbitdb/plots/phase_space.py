"""Bounces in phase space: tangential momentum against position along the boundary."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from numpy.typing import NDArray

from orbitdb.arrays import Floats
from orbitdb.billiard.stability import birkhoff
from orbitdb.billiard.stadium import Stadium
from orbitdb.open_stadium.openings import SYMBOL_OF, Opening, spans_on
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots.orbits import with_paths
from orbitdb.plots.registry import gaps, nothing
from orbitdb.plots.style import BLUE, GREY, Colours, Picture, figure, inches_wide, short
from orbitdb.selection import Selection
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue

Period = tuple[NDArray[np.uint8], Floats, Floats]
"""The orbits of one period: symbols and coordinates, shape (N, p), and lambda per bounce, shape (N,)."""


_PARTS = ("0: bottom", "3, 5: right", "2: top", "1, 4: left")
"""The symbols and the names of walls and semicircles, along the boundary."""
_WIDE = 3.2
"""Width, in inches, from which on axes have room for the names beside the symbols."""


def phase_space(catalogue: "Catalogue", chosen: Selection) -> Picture:
    """Draw the bounces of a subset in phase space, coloured by lambda per bounce."""
    chosen = with_paths(catalogue, chosen)
    subset = catalogue.select(chosen, coordinates=True)
    if not len(subset):
        raise nothing(catalogue, chosen)
    periods = ((*subset.of_period(p), subset.lambda_d[subset.p == p]) for p in np.unique(subset.p).tolist())
    with figure(7.2, 4.4, chosen.describe(), gaps(catalogue, chosen)) as made:
        ax = made.add_subplot()
        draw_phase_space(ax, Stadium(chosen.a), periods).add_bar(ax, extend="both")
        _shade(ax, Stadium(chosen.a), chosen.opening)
    return made


def phase_space_of(orbit: Orbit) -> Picture:
    """Draw the bounces of an orbit, which must have coordinates, in phase space."""
    with figure(6.4, 4.0, f"phase space at a = {format_float(orbit.a)}") as made:
        ax = made.add_subplot()
        assert orbit.arclength is not None and orbit.sine is not None  # noqa: PT018
        ax.plot(orbit.arclength, orbit.sine, "o", color=BLUE, label=short(orbit.code))
        draw_walls(ax, Stadium(orbit.a))
    return made


def draw_phase_space(ax: Axes, stadium: Stadium, periods: Iterable[Period]) -> Colours:
    """Draw bounces in phase space: tangential momentum against position along the boundary.

    The position is the arc length (`Stadium.arclength`). The momentum is the sine of the angle from the
    inward normal to the outgoing path, positive anticlockwise. The colour of a bounce shows the lambda per
    bounce of its orbit.
    """
    drawn = [
        (*birkhoff(stadium, symbols, coordinates), np.repeat(lambda_d, symbols.shape[1]))
        for symbols, coordinates, lambda_d in periods
    ]
    place, sine, colour = (
        np.concatenate([part.ravel() for part in parts]) for parts in zip(*drawn, strict=True)
    )
    size = float(np.clip(6e4 / len(place), 0.3, 12)) * (rcParams["lines.markersize"] / 5) ** 2
    low, high = np.percentile(colour, [2, 98])
    dots = ax.scatter(
        place, sine, c=colour, s=size, cmap="viridis", vmin=low, vmax=high, linewidths=0, rasterized=True
    )
    draw_walls(ax, stadium)
    return Colours(dots, r"$\lambda_d$ (per bounce)")


def _shade(ax: Axes, stadium: Stadium, openings: Iterable[Opening]) -> None:
    """Shade the openings of the boundary."""
    for wall, spans in spans_on(stadium, openings).items():
        symbol = np.full(2, SYMBOL_OF[wall], np.uint8)
        for span in spans:
            ax.axvspan(*stadium.arclength(symbol, np.array(span)), color=GREY, alpha=0.3, linewidth=0)


def draw_walls(ax: Axes, stadium: Stadium) -> None:
    """Make the axes those of phase space, with the joints of walls and semicircles, and their symbols."""
    joints = np.cumsum([0, 2 * stadium.a, np.pi, 2 * stadium.a, np.pi])
    for joint in joints[1:-1]:
        ax.axvline(joint, color=GREY, linewidth=0.8)
    inches = inches_wide(ax)
    for middle, name in zip((joints[1:] + joints[:-1]) / 2, _PARTS, strict=True):
        name = name if inches > _WIDE else name.partition(":")[0]
        ax.annotate(name, (middle, 1.02), xycoords=("data", "axes fraction"), ha="center", color=GREY)
    ax.set(xlim=(0, stadium.perimeter), ylim=(-1, 1), xlabel="arc length $s/R$", ylabel=r"$\sin\alpha$")
    ax.set_yticks([-1, -0.5, 0, 0.5, 1])
    ax.grid(False)
