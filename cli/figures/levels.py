"""Figures of quantum levels and of what the orbits say about them."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure

from orbitdb.answers.levels import (
    assess_levels,
    levels_from_zero,
    notes_on_missing_levels,
    orbits_for,
    read_orbits,
    read_spectrum,
)
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.given_levels import GivenLevels
from orbitdb.cli.output import note
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots import curves
from orbitdb.plots.assess import draw_assess
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, figure, short
from orbitdb.quantum.level_statistics import (
    FAMILY_TO,
    delta3,
    goe_delta3,
    goe_variance,
    number_variance,
    unfolded,
)
from orbitdb.quantum.trace_formula import family_count
from orbitdb.quantum.waves import Wave
from orbitdb.quantum.waves import waves as all_waves
from orbitdb.quantum.weyl import Parity, begins_at_zero, check_levels, weyl
from orbitdb.store.connection import Moment
from orbitdb.store.selection import Selection
from orbitdb.text import exact

_LENGTHS = (1.0, 12.0)
_RIGID = np.linspace(0.5, 25.0, 50)
_BINS = [n / 5 for n in range(21)]


def draw_length_spectrum(moment: Moment, chosen: Selection, given: GivenLevels) -> Figure:
    """Draw the length spectrum of the orbits downwards and that of the levels, if there are any, upwards."""
    parity = given.of_one()
    levels = given.read(parity)
    spectrum = read_spectrum(moment, chosen.a, _LENGTHS, 1000, levels=levels, parity=parity)
    judged = [] if levels is None else notes_on_missing_levels(moment, chosen.a, levels, parity)
    for line in [*spectrum.notes(), *judged]:
        note(line)
    title = f"length spectrum at a = {exact(chosen.a)}, {_of(parity)}, k below {spectrum.k_max:.4g}"
    with figure(7.2, 4.8, title) as made:
        curves.draw_spectrum(made.add_subplot(), spectrum)
    return made


def draw_levels(moment: Moment, chosen: Selection, given: GivenLevels) -> Figure:
    """Draw the number of levels below k and its fluctuations, each compared with that from the orbits."""
    stadium, parity = Stadium(chosen.a), given.of_one()
    levels = given.read(parity)
    if levels is None:
        stored = levels_from_zero(moment, chosen.a, parity)
        k, end = stored.k, stored.high
    else:
        k = check_levels(levels, stadium, parity)
        end = float(k[-1])
    orbits = orbits_for(stadium, read_orbits(moment, chosen)[0], parity, np.array([end]))
    below_end = orbits.k <= end
    at, smooth, count = orbits.k[below_end], orbits.smooth[below_end], orbits.count[0][below_end]
    label = f"orbits, $X = {orbits.cutoffs[0]:g}$"
    title = f"{len(k)} levels at a = {exact(chosen.a)}, {_of(parity)}, k below {end:.4g}"
    with figure(7.2, 6.0, title) as made:
        above, below = made.subplots(2, 1, sharex=True)
        above.step(np.append(0.0, k), np.arange(len(k) + 1), where="post", color=BLUE, label="levels")
        above.plot(at, count, color=ORANGE, linewidth=0.8, label=label)
        above.plot(at, smooth, color=INK, linestyle="--", linewidth=1, label="Weyl's law")
        above.set(ylabel="levels below $k$")
        rest = np.searchsorted(k, at) - smooth
        below.plot(at, rest, color=BLUE, linewidth=0.8, label="levels minus Weyl's law")
        below.plot(at, count - smooth, color=ORANGE, linewidth=0.8, label=f"{label}, minus Weyl's law")
        family = family_count(stadium, at, _LENGTHS[1], parity)
        below.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls")
        below.set(xlabel="$kR$", ylabel="fluctuation")
    return made


def draw_assessment(moment: Moment, chosen: Selection, given: GivenLevels) -> Figure:
    """Draw the excess of each level, which increases by 1 at a missing level.

    A list that cannot begin with the lowest level is taken as a window.
    """
    parity = given.of_one()
    levels = given.read(parity)
    window = levels is not None and not begins_at_zero(levels, Stadium(chosen.a), parity)
    assessment, hints = assess_levels(moment, chosen.a, levels, parity, window=window)
    for line in hints:
        note(line)
    with figure(7.2, 4.2, assessment.verdict()) as made:
        draw_assess(made.add_subplot(), assessment)
    return made


def draw_spacings(moment: Moment, chosen: Selection, given: GivenLevels) -> Figure:
    """Draw the distribution of level spacings, in units of their mean, with those of Wigner and Poisson."""
    a, parts = chosen.a, given.by_parity(moment, chosen.a)
    gaps = np.concatenate([np.diff(unfolded(k, Stadium(a), parity)) for parity, k in parts.items()])
    s = np.linspace(0, _BINS[-1], 200)
    with figure(6.4, 4.2, f"{len(gaps)} spacings at a = {exact(a)}: {', '.join(parts)}") as made:
        ax = made.add_subplot()
        ax.hist(gaps, _BINS, density=True, color=BLUE, alpha=0.5, label="levels, unfolded by Weyl's law")
        wigner = np.pi / 2 * s * np.exp(-np.pi / 4 * s**2)
        ax.plot(s, wigner, color=INK, label="random matrices (Wigner)")
        ax.plot(s, np.exp(-s), color=GREY, linestyle="--", label="uncorrelated levels (Poisson)")
        ax.set(xlabel="spacing (in units of the mean)", ylabel="density", xlim=(0, _BINS[-1]))
    return made


def draw_rigidity(moment: Moment, chosen: Selection, given: GivenLevels) -> Figure:
    """Draw Delta_3 and the number variance for each parity, with and without bouncing balls.

    The curves of the GOE and of uncorrelated (Poisson) levels are drawn for comparison.
    """
    a, parts = chosen.a, given.by_parity(moment, chosen.a)
    colours = dict(zip(Parity, (BLUE, ORANGE, GREEN, PURPLE), strict=True))
    shown: list[tuple[str, Callable[[Floats, float], float | None], Floats, Floats]] = [
        (r"$\Delta_3(L)$", delta3, np.array([goe_delta3(length) for length in _RIGID]), _RIGID / 15),
        (r"number variance $\Sigma^2(L)$", number_variance, goe_variance(_RIGID), _RIGID),
    ]
    with figure(6.4, 7.2, f"spectral rigidity at a = {exact(a)}: {', '.join(parts)}") as made:
        for ax, (name, statistic, goe, poisson) in zip(made.subplots(2, 1, sharex=True), shown, strict=True):
            for parity, k in parts.items():
                for balls, style in ((False, "-"), (True, ":")):
                    x = np.sort(unfolded(k, Stadium(a), parity, balls))
                    label = f"{parity}, without bouncing balls" if balls else f"{parity}"
                    values = np.array([statistic(x, length) for length in _RIGID], float)
                    ax.plot(_RIGID, values, style, color=colours[parity], label=label)
            ax.plot(_RIGID, goe, color=INK, label="random matrices (GOE)")
            ax.plot(_RIGID, poisson, "--", color=GREY, label="uncorrelated levels (Poisson)")
            ax.set(ylabel=name, ylim=(0, 2.5 * goe[-1]), xlim=(0, _RIGID[-1]))
        ax.set(xlabel="$L$ (mean spacings)")
    note(f"for the dotted lines, bouncing balls up to length {FAMILY_TO:g} are subtracted from the staircase")
    return made


def draw_wave(a: float, k: float, parity: Parity, orbit: Orbit | None) -> Figure:
    """Draw psi^2 of the level nearest to the given k, with the orbit, if any, on top."""
    return _of_wave(curves.draw_wave, 2.2 + 2.4 / (1 + a), _nearest(a, k, parity), orbit)


def draw_husimi(a: float, k: float, parity: Parity, orbit: Orbit | None) -> Figure:
    """Draw the Husimi function of the level nearest to the given k, with the bounces of the orbit, if any."""
    return _of_wave(curves.draw_husimi, 4.2, _nearest(a, k, parity), orbit)


def _of(parity: Parity | None) -> str:
    return "all parities" if parity is None else f"parity {parity}"


def _nearest(a: float, k: float, parity: Parity) -> Wave:
    """Return the wave of the level nearest to the given k."""
    stadium, width = Stadium(a), 0.0
    spacing = 1 / max(float(weyl(stadium, parity).deriv()(k)), 0.2)
    near: list[Wave] = []
    while not near:
        width += 2 * spacing
        near = list(all_waves(stadium, max(k - width, 0.0), k + width, parity))
    return min(near, key=lambda wave: abs(wave.k - k))


def _of_wave(draw: Callable[..., None], height: float, wave: Wave, orbit: Orbit | None) -> Figure:
    title = f"k = {wave.k:.7g}, {wave.parity}, a = {exact(wave.stadium.a)}"
    if orbit is not None:
        title += f"; {short(orbit.code)} with strength {wave.strength(orbit):.3f}"
    with figure(7.2, height, title) as made:
        draw(made.add_subplot(), wave, orbit)
    return made
