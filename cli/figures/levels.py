"""Figures of quantum levels, and of levels from orbits."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from orbitdb.answers.judging import assess_levels, orbits_for
from orbitdb.answers.spectrum import levels_from_zero, read_classes, read_levels, read_spectrum
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.numerals import exact
from orbitdb.orbits.orbit import Orbit
from orbitdb.plots import curves, waves
from orbitdb.plots.curves import short
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, figure
from orbitdb.quantum.amplitudes import Parity, weyl
from orbitdb.quantum.assessment import CUTOFF_OF_ALL
from orbitdb.quantum.lengths import family_count
from orbitdb.quantum.spectrum import check_levels
from orbitdb.quantum.statistics import FAMILY_TO, delta3, goe_delta3, unfolded
from orbitdb.quantum.waves import Wave
from orbitdb.quantum.waves import waves as all_waves
from orbitdb.store.asking.selection import Selection
from orbitdb.store.reading.moment import Moment

_LENGTHS = (1.0, 12.0)
_NONE = "no levels to draw: 'orbitdb levels --k 0:30 --a {a}' finds them"
_RIGID = np.linspace(0.5, 25.0, 50)
_BINS = [n / 5 for n in range(21)]


def draw_length_spectrum(
    moment: Moment, chosen: Selection, levels: Sequence[float] | None = None, parity: Parity | None = None
) -> Figure:
    """Draw the length spectrum of the orbits downwards, and of any levels upwards."""
    found = read_spectrum(moment, chosen.a, _LENGTHS, 1000, levels=levels, parity=parity)
    for said in found.notes():
        note(said)
    with figure(7.2, 4.8, f"length spectrum at a = {exact(chosen.a)}, k below {found.k_max:.4g}") as made:
        curves.draw_spectrum(made.add_subplot(), found)
    return made


def draw_levels(moment: Moment, chosen: Selection) -> Figure:
    """Draw the number of levels and its fluctuations, with those from the orbits."""
    known = read_levels(moment, chosen.a, None)
    if known is None:
        raise InputError(_NONE.format(a=exact(chosen.a)))
    k, end = known
    stadium, classes = Stadium(chosen.a), read_classes(moment, chosen)[0]
    orbits = orbits_for(stadium, classes, None, end)
    here = orbits.k <= end
    at, smooth, count = orbits.k[here], orbits.smooth[here], orbits.count[0][here]
    label = f"orbits, $X = {CUTOFF_OF_ALL:g}$"
    with figure(7.2, 6.0, f"{len(k)} levels at a = {exact(chosen.a)}, k below {end:.4g}") as made:
        above, below = made.subplots(2, 1, sharex=True)
        above.step(np.append(0.0, k), np.arange(len(k) + 1), where="post", color=BLUE, label="levels")
        above.plot(at, count, color=ORANGE, linewidth=0.8, label=label)
        above.plot(at, smooth, color=INK, linestyle="--", linewidth=1, label="Weyl's law")
        above.set(ylabel="levels below $k$")
        rest = np.searchsorted(k, at) - smooth
        below.plot(at, rest, color=BLUE, linewidth=0.8, label="levels, less Weyl's law")
        below.plot(at, count - smooth, color=ORANGE, linewidth=0.8, label=f"{label}, less Weyl's law")
        family = family_count(stadium, at, _LENGTHS[1])
        below.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls")
        below.set(xlabel="$kR$", ylabel="fluctuation")
    return made


def draw_assessment(
    moment: Moment, chosen: Selection, levels: Sequence[float] | None = None, parity: Parity | None = None
) -> Figure:
    """Draw N_X at each level minus its place in the list; it rises by one at a missing level."""
    found, told = assess_levels(moment, chosen.a, levels, parity)
    for said in [*told, found.verdict()]:
        note(said)
    with figure(7.2, 4.2, f"{found.verdict()}, a = {exact(chosen.a)}") as made:
        curves.draw_assessment(made.add_subplot(), found)
    return made


def draw_spacings(
    moment: Moment, chosen: Selection, levels: Sequence[float] | None = None, parity: Parity | None = None
) -> Figure:
    """Draw the spacings of levels in units of their mean, with the curves of Wigner and Poisson."""
    stadium, parts = Stadium(chosen.a), _by_parity(moment, chosen, levels, parity)
    gaps = np.concatenate([np.diff(np.sort(unfolded(k, stadium, each))) for each, k in parts.items()])
    s = np.linspace(0, _BINS[-1], 200)
    with figure(6.4, 4.2, f"{len(gaps)} spacings at a = {exact(chosen.a)}: {', '.join(parts)}") as made:
        ax = made.add_subplot()
        ax.hist(gaps, _BINS, density=True, color=BLUE, alpha=0.5, label="levels, by Weyl's law")
        wigner = np.pi / 2 * s * np.exp(-np.pi / 4 * s**2)
        ax.plot(s, wigner, color=INK, label="random matrices (Wigner)")
        ax.plot(s, np.exp(-s), color=GREY, linestyle="--", label="random numbers (Poisson)")
        ax.set(xlabel="spacing, in its mean", ylabel="density", xlim=(0, _BINS[-1]))
    return made


def draw_rigidity(
    moment: Moment, chosen: Selection, levels: Sequence[float] | None = None, parity: Parity | None = None
) -> Figure:
    """Draw Delta_3 of each parity, with bouncing balls in and out, and of random matrices and numbers."""
    stadium, parts = Stadium(chosen.a), _by_parity(moment, chosen, levels, parity)
    colours = dict(zip(Parity, (BLUE, ORANGE, GREEN, PURPLE), strict=True))
    with figure(6.4, 4.6, f"spectral rigidity at a = {exact(chosen.a)}") as made:
        ax = made.add_subplot()
        for each, k in parts.items():
            for balls, style in ((False, "-"), (True, ":")):
                x = np.sort(unfolded(k, stadium, each, balls))
                values = [delta3(x, length) for length in _RIGID]
                label = f"{each}, bouncing balls out" if balls else f"{each}"
                shown = [np.nan if value is None else value for value in values]
                ax.plot(_RIGID, shown, style, color=colours[each], label=label)
        ax.plot(_RIGID, [goe_delta3(length) for length in _RIGID], color=INK, label="random matrices (GOE)")
        ax.plot(_RIGID, _RIGID / 15, "--", color=GREY, label="random numbers (Poisson)")
        ax.set(xlabel="$L$, mean spacings", ylabel=r"$\Delta_3(L)$", ylim=(0, 0.8), xlim=(0, _RIGID[-1]))
    note(f"bouncing balls up to length {FAMILY_TO:g} are taken out of the staircase for the dotted lines")
    return made


def _by_parity(
    moment: Moment, chosen: Selection, levels: Sequence[float] | None, parity: Parity | None
) -> dict[Parity, Floats]:
    """Return the levels of each requested parity, from a list or the catalogue."""
    if levels is not None:
        if parity is None:
            raise InputError("statistics need one parity: name that of the levels with --parity")
        k = np.sort(np.asarray(levels, np.float64))
        check_levels(k, Stadium(chosen.a), parity)
        return {parity: k}
    parities = list(Parity) if parity is None else [parity]
    return {each: levels_from_zero(moment, chosen.a, each).k for each in parities}


def draw_wave(a: float, k: float, parity: Parity, orbit: Orbit | None) -> Figure:
    """Draw psi^2 of the level nearest to some k, with any orbit over it."""
    found = _nearest(a, k, parity)
    with figure(7.2, 2.2 + 2.4 / (1 + a), _title(found, orbit)) as made:
        waves.draw_wave(made.add_subplot(), found, orbit)
    return made


def draw_husimi(a: float, k: float, parity: Parity, orbit: Orbit | None) -> Figure:
    """Draw the Husimi function of the level nearest to some k, with the bounces of any orbit over it."""
    found = _nearest(a, k, parity)
    with figure(7.2, 4.2, _title(found, orbit)) as made:
        waves.draw_husimi(made.add_subplot(), found, orbit)
    return made


def _nearest(a: float, k: float, parity: Parity) -> Wave:
    """Return the wave of the level nearest to some k."""
    stadium, width = Stadium(a), 0.0
    spacing = 1 / max(float(weyl(stadium, parity).deriv()(k)), 0.2)
    found: list[Wave] = []
    while not found:
        width += 2 * spacing
        found = list(all_waves(stadium, max(k - width, 0.0), k + width, parity))
    return min(found, key=lambda wave: abs(wave.k - k))


def _title(found: Wave, orbit: Orbit | None) -> str:
    level = f"k = {found.k:.7g}, {found.parity}, a = {exact(found.stadium.a)}"
    if orbit is None:
        return level
    return f"{level}; {short(orbit.code)} with strength {found.strength(orbit):.3f}"
