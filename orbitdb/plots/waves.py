"""Figures of the wave of a level: psi^2 in the stadium, and its Husimi function in phase space."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes

from orbitdb.plots.paths import draw_outline, mark_stadium
from orbitdb.plots.phase_space import draw_walls
from orbitdb.plots.style import ORANGE, Colours, Picture, closed, figure, short, width_or
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit
    from orbitdb.quantum.waves import Wave


_WIDTH, _LEAST_HEIGHT, _HIGHEST = 7.2, 1.7, 0.65
"""Usual width and least height of a figure, in inches, and its greatest height in units of the width."""
_BESIDE = 1.5, 0.95
"""Width of what is beside the stadium, and height of what is above and below it, in inches."""


def wave(wave: "Wave", orbit: "Orbit | None" = None) -> Picture:
    """Draw psi^2 of a level, with the orbit, if any, on top."""
    wide = width_or(_WIDTH)
    as_wide = _BESIDE[1] + (wide - _BESIDE[0]) / (1 + wave.stadium.a)
    return _of_wave(draw_wave, wide, min(max(as_wide, _LEAST_HEIGHT), _HIGHEST * wide), wave, orbit)


def husimi(wave: "Wave", orbit: "Orbit | None" = None) -> Picture:
    """Draw the Husimi function of a level, with the bounces of the orbit, if any."""
    return _of_wave(draw_husimi, _WIDTH, 4.2, wave, orbit)


def _of_wave(
    draw: Callable[..., Colours], width: float, height: float, wave: "Wave", orbit: "Orbit | None"
) -> Picture:
    title = f"level k = {wave.k:.7g} ({wave.parity}) at a = {format_float(wave.stadium.a)}"
    if orbit is not None:
        title += f", with the orbit {short(orbit.code)} (strength {wave.strength(orbit):.3f})"
    with figure(width, height, title) as made:
        ax = made.add_subplot()
        draw(ax, wave, orbit).add_bar(ax)
    return made


_PIXELS, _LEAST, _MOST = 5, 80, 200
"""Pixels in half the height of the stadium: their number in units of k, and its limits."""
_ROOM = 0.03
"""Room around the stadium, in units of the radius, for the thickness of its walls."""
_PLACES, _SINES = 300, 121


def draw_wave(ax: Axes, wave: "Wave", orbit: "Orbit | None" = None) -> Colours:
    """Draw psi^2 in the stadium, in units of its mean; if an orbit is given, draw it on top."""
    a, pixels = wave.stadium.a, min(max(round(_PIXELS * wave.k), _LEAST), _MOST)
    y = (np.arange(pixels) + 0.5) / pixels
    x = (np.arange(round(pixels * (1 + a))) + 0.5) / pixels
    quarter = wave.stadium.area * wave.psi(*np.meshgrid(x, y)) ** 2
    half = np.concatenate([quarter[:, ::-1], quarter], axis=1)
    whole = np.concatenate([half[::-1], half])
    image = ax.imshow(whole, cmap="Blues", extent=(-1 - a, 1 + a, -1, 1), origin="lower", vmin=0,
                      interpolation="bilinear")  # fmt: skip
    image.set_clip_path(draw_outline(ax, wave.stadium, 1.5)[0])
    if orbit is not None and orbit.points is not None:
        ax.plot(*closed(orbit.points).T, "--", color=ORANGE, linewidth=0.8)
        ax.plot(*orbit.points.T, "o", color=ORANGE, markersize=0.6 * rcParams["lines.markersize"])
    ax.grid(visible=False)
    ax.spines[:].set_visible(False)
    ax.set(xlim=(-1 - a - _ROOM, 1 + a + _ROOM), ylim=(-1 - _ROOM, 1 + _ROOM), aspect="equal")
    mark_stadium(ax, wave.stadium)
    return Colours(image, r"$\psi^2$ (mean 1)")


def draw_husimi(ax: Axes, wave: "Wave", orbit: "Orbit | None" = None) -> Colours:
    """Draw the Husimi function in phase space, in units of its mean, and perhaps the bounces of an orbit."""
    s = (np.arange(_PLACES) + 0.5) * wave.stadium.perimeter / _PLACES
    density = wave.husimi(s, (np.arange(_SINES) + 0.5) * 2 / _SINES - 1)
    image = ax.imshow(
        density.T / density.mean(),
        cmap="Blues",
        extent=(0, wave.stadium.perimeter, -1, 1),
        origin="lower",
        aspect="auto",
        interpolation="bilinear",
        vmin=0,
    )
    if orbit is not None and orbit.arclength is not None and orbit.sine is not None:
        ax.plot(orbit.arclength, orbit.sine, "o", color=ORANGE, markeredgecolor="white",
                clip_on=False, zorder=4)  # fmt: skip
    draw_walls(ax, wave.stadium)
    return Colours(image, "Husimi function (mean 1)")
