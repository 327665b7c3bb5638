"""Figures of orbits in a magnetic field: their arcs, and their actions against the curvature."""

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes

from orbitdb.answers.field import FieldOrbits, follow_word, follow_words
from orbitdb.answers.field_words import named_words
from orbitdb.arrays import Floats
from orbitdb.billiard.legs import following
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError
from orbitdb.magnetic.action import ArcPaths
from orbitdb.magnetic.field_status import IN_FIELD, FieldStatus
from orbitdb.orbits.solve import solve_word
from orbitdb.plots.paths import draw_stadium
from orbitdb.plots.style import BLUE, GREY, INK, INKS, PURPLE, Picture, closed, figure, short, width_or
from orbitdb.symbols.words import least_rotation
from orbitdb.text import format_float, shortened

_PLACES = 40
"""Number of points on an arc."""

_LARGEST, _STEPS = 0.8, 81
"""End of the default range of curvatures, in units of the largest one, and number of curvatures."""


def points_on_arcs(paths: ArcPaths) -> Floats:
    """Return points along the arcs of a single path, shape (p, n, 2), beginning and ending with bounces."""
    share = np.linspace(-1, 1, _PLACES)[None, :]
    chord, ahead_x, ahead_y = paths.chord, paths.ahead_x, paths.ahead_y
    chi = np.arcsin(paths.sine)
    # half the chord times sin(share chi) / sin(chi), and the height of the arc to the right of the chord
    along = chord / 2 * share * np.sinc(share * chi / np.pi) / np.sinc(chi / np.pi)
    right = chord / 2 * (chi / 2) * (1 - share**2) / np.sinc(chi / np.pi)
    right = right * np.sinc((1 + share) * chi / 2 / np.pi) * np.sinc((1 - share) * chi / 2 / np.pi)
    middle_x, middle_y = (paths.x + following(paths.x)) / 2, (paths.y + following(paths.y)) / 2
    x = middle_x + along * ahead_x + right * ahead_y
    y = middle_y + along * ahead_y - right * ahead_x
    return np.stack([x, y], axis=-1)


def draw_arcs(ax: Axes, stadium: Stadium, paths: ArcPaths, straight: Floats | None = None) -> None:
    """Draw the path of one orbit in a field, and dashed its path without a field, through points (p, 2)."""
    draw_stadium(ax, stadium, small=False)
    arcs = points_on_arcs(paths)
    if straight is not None:
        ax.plot(*closed(straight).T, "--", color=GREY, linewidth=1, zorder=3, label="without the field")
    ax.plot(*arcs.reshape(-1, 2).T, color=BLUE, zorder=4, label="in the field")
    size = rcParams["lines.markersize"]
    ax.plot(paths.x[:, 0], paths.y[:, 0], "o", color=BLUE, markersize=0.8 * size, zorder=5)
    for arc in arcs:
        tail, tip = arc[_PLACES * 2 // 3], arc[_PLACES * 2 // 3 + 1]
        look = {"arrowstyle": "-|>", "color": BLUE, "mutation_scale": 2.6 * size}
        ax.annotate("", tip, tail, arrowprops=look, zorder=5)


def draw_actions(ax: Axes, orbits: FieldOrbits) -> None:
    """Draw the actions of words against the curvature, and dashed to second order; mark stable orbits."""
    codes = dict.fromkeys(orbits.code.tolist())
    for code, colour in zip(codes, cycle(INKS.values()), strict=False):
        own = orbits.code == code
        kappa, action = orbits.kappa[own], orbits.action[own]
        ax.plot(kappa, action, color=colour, label=short(code))
        orbit = solve_word(code, orbits.selection.a)
        if orbit.length is not None and orbit.area is not None and orbit.area_slope is not None:
            second = orbit.length - kappa * orbit.area - kappa**2 * orbit.area_slope / 2
            second[np.isnan(action)] = np.nan
            ax.plot(kappa, second, "--", color=INK, linewidth=1, label="to second order", zorder=3)
        stable = orbits.status[own] == FieldStatus.ELLIPTIC.value
        if stable.any():
            stretch = np.where(stable, action, np.nan)
            ax.plot(kappa, stretch, color=PURPLE, linewidth=5, alpha=0.5, label="stable", zorder=1)
    ax.set(xlabel=r"curvature $\kappa R$", ylabel=r"action $S/R = (L - \kappa A)/R$")


def orbit_in_field(word: str, a: float, kappa: Sequence[float]) -> Picture:
    """Draw the orbit of a word at one curvature, and dashed its orbit without a field."""
    if len(kappa) != 1:
        raise InputError(f"{len(kappa)} values of kappa: plot orbit draws one")
    status, paths = follow_word(word, a, kappa[0])
    title = f"{shortened(word)} at a = {format_float(a)}, kappa = {format_float(kappa[0])}"
    if status not in IN_FIELD:
        raise InputError(f"{title} cannot be drawn: {status.sentence}")
    wide = width_or(6.4)
    with figure(wide, max(2.2, (wide - 0.8) * 2.7 / (2 * a + 2.7) + 1.1), title) as made:
        draw_arcs(made.add_subplot(), Stadium(a), paths, solve_word(word, a).points)
    return made


def actions_in_field(word: str, a: float, kappa: Sequence[float] = ()) -> Picture:
    """Draw the actions of a word and its reverse against the curvature."""
    values = kappa or np.linspace(0, _LARGEST / (a + 1), _STEPS)
    reverse = solve_word(word, a).reverse().code
    words = [word] if least_rotation(reverse) == least_rotation(word) else [word, reverse]
    orbits = follow_words(named_words(words, a), values)
    if len(orbits.kappas) < 2 or not orbits.exists.any():
        raise InputError(
            f"{shortened(word)}: give a range of kappa in which it is an orbit, such as 0:0.3:31"
        )
    with figure(6.4, 4.2, f"{shortened(word)} in a magnetic field at a = {format_float(a)}") as made:
        draw_actions(made.add_subplot(), orbits)
    return made
