"""Pictures of wave functions in the stadium, and of their Husimi functions on the boundary."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from orbitdb.plots.style import INK, ORANGE

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit
    from orbitdb.quantum.waves import Wave

_PIXELS = 130
"""Number of pixels in half the height of the stadium."""
_PLACES, _SINES = 300, 121


def draw_wave(ax: Axes, wave: "Wave", orbit: "Orbit | None" = None) -> None:
    """Draw psi^2 in the stadium; if an orbit is given, draw it on top."""
    a = wave.stadium.a
    y = (np.arange(_PIXELS) + 0.5) / _PIXELS
    x = (np.arange(round(_PIXELS * (1 + a))) + 0.5) / _PIXELS
    quarter = wave.psi(*np.meshgrid(x, y)) ** 2
    half = np.concatenate([quarter[:, ::-1], quarter], axis=1)
    whole = np.concatenate([half[::-1], half])
    ax.imshow(whole, cmap="Blues", extent=(-1 - a, 1 + a, -1, 1), origin="lower", interpolation="nearest")
    angle = np.linspace(-np.pi / 2, np.pi / 2, 100)
    edge_x = np.concatenate([a + np.cos(angle), -a - np.cos(angle), [a]])
    edge_y = np.concatenate([np.sin(angle), -np.sin(angle), [-1.0]])
    ax.plot(edge_x, edge_y, color=INK, linewidth=1)
    if orbit is not None and orbit.points is not None:
        ax.plot(*np.concatenate([orbit.points, orbit.points[:1]]).T, color=ORANGE, linewidth=1)
    ax.set_axis_off()
    ax.set_aspect("equal")


def draw_husimi(ax: Axes, wave: "Wave", orbit: "Orbit | None" = None) -> None:
    """Draw the Husimi function in phase space; if an orbit is given, draw its bounces on top."""
    s = (np.arange(_PLACES) + 0.5) * wave.stadium.perimeter / _PLACES
    sine = np.linspace(-1, 1, _SINES)
    found = wave.husimi(s, sine)
    ax.imshow(found.T, cmap="Blues", extent=(0, wave.stadium.perimeter, -1, 1), origin="lower", aspect="auto")
    if orbit is not None and orbit.arclength is not None and orbit.sine is not None:
        ax.plot(orbit.arclength, orbit.sine, "o", color=ORANGE, markersize=4, markeredgecolor=INK)
    ax.grid(visible=False)
    ax.set(xlabel="arc length $s/R$", ylabel=r"$\sin\alpha$")
