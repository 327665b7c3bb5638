"""Figures of quantum levels against orbits: length spectra, staircases, and what a list of levels lacks."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.polynomial import Polynomial

from orbitdb.answers.levels import orbits_for, read_orbits
from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium
from orbitdb.plots.assess import draw_assess
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, SMALL, Picture, figure, short
from orbitdb.quantum.trace_formula import family_count
from orbitdb.quantum.weyl import Parity, begins_at_zero, check_levels, weyl
from orbitdb.store.selection import Selection
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.quantum.length_spectrum import Peak, Spectrum
    from orbitdb.quantum.levels import Levels

_ROOM, _ROOM_OF_LABELS = 0.04, 0.16
"""Margin of a length spectrum at its end without and with labels, in units of the range of its values."""
_LENGTHS = (1.0, 12.0)
"""Range of lengths in a spectrum; bouncing balls count up to its end."""


def spectrum(
    catalogue: "Catalogue", chosen: Selection, levels: Floats | None = None, parity: Parity | None = None
) -> Picture:
    """Draw the length spectrum of the orbits downwards and that of the levels, if there are any, upwards."""
    found = catalogue.spectrum(_LENGTHS, points=1000, levels=levels, parity=parity, a=chosen.a)
    notes = [*found.notes(), *found.judged]
    title = f"length spectrum at a = {format_float(chosen.a)}, {_of(parity)}, k below {found.k_max:.4g}"
    with figure(7.2, 4.8, title, notes) as made:
        draw_spectrum(made.add_subplot(), found)
    return made


def staircase(
    catalogue: "Catalogue", chosen: Selection, levels: Floats | None = None, parity: Parity | None = None
) -> Picture:
    """Draw the number of levels below k and its fluctuations, each compared with that from the orbits."""
    stadium = Stadium(chosen.a)
    if levels is None:
        stored = catalogue.levels(parity=parity, a=chosen.a)
        k, end = stored.k, stored.high
    else:
        k = check_levels(levels, stadium, parity)
        end = float(k[-1])
    with catalogue.snapshot() as connection:
        classes, _ = read_orbits(connection, chosen)
    orbits = orbits_for(stadium, classes, parity, np.array([end]))
    below = orbits.k <= end
    at, smooth, count = orbits.k[below], orbits.smooth[below], orbits.count[0][below]
    title = f"{len(k)} levels at a = {format_float(chosen.a)}, {_of(parity)}, k below {end:.4g}"
    with figure(7.2, 4.2, title) as made:
        ax = made.add_subplot()
        ax.plot(at, np.searchsorted(k, at) - smooth, color=BLUE, linewidth=0.8, label="levels")
        label = f"orbits, cut off at length $X = {orbits.cutoffs[0]:g}\\,R$"
        ax.plot(at, count - smooth, "-", color=ORANGE, linewidth=1, label=label)
        family = family_count(stadium, at, _LENGTHS[1], parity)
        ax.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls alone")
        ax.set(xlabel="$kR$", ylabel="levels below $k$\nminus Weyl's law", xlim=(0, end))
    return made


def assess(
    catalogue: "Catalogue", chosen: Selection, levels: Floats | None = None, parity: Parity | None = None
) -> Picture:
    """Draw the excess of each level, which increases by 1 at a missing level.

    A list that cannot begin with the lowest level is taken as a window.
    """
    window = levels is not None and not begins_at_zero(levels, Stadium(chosen.a), parity)
    assessment = catalogue.assess(levels, parity=parity, window=window, a=chosen.a)
    with figure(7.2, 4.2, assessment.verdict().replace("+-", "±"), assessment.notes) as made:
        draw_assess(made.add_subplot(), assessment)
    return made


def _of(parity: Parity | None) -> str:
    return "all parities" if parity is None else f"parity {parity}"


def draw_spectrum(ax: Axes, spectrum: "Spectrum") -> None:
    """Draw the length spectrum of the orbits downwards, and that of the levels, if there are any, upwards."""
    side = -1 if spectrum.quantum is None else 1
    if spectrum.quantum is not None:
        ax.plot(spectrum.length, np.abs(spectrum.quantum), color=BLUE, label="levels")
    ax.plot(spectrum.length, -np.abs(spectrum.orbits), color=ORANGE, label="orbits, downwards")
    first, last = spectrum.length[[0, -1]]
    if spectrum.complete < last:
        beyond = max(spectrum.complete, first)
        ax.axvspan(beyond, last, color=GREY, alpha=0.12, label="orbits may be missing")
    for peak in spectrum.peaks(1):
        ax.annotate(times(peak), (peak.length, side * peak.height), xytext=(0, 4 * side),
                    textcoords="offset points", fontsize=SMALL, rotation=90, ha="center",
                    va="bottom" if side > 0 else "top")  # fmt: skip
    ax.axhline(0, color=INK, linewidth=0.6)
    low, high = ax.dataLim.intervaly
    below, above = (_ROOM, _ROOM_OF_LABELS)[::side]
    ax.set(xlim=(first, last), ylim=(low - below * (high - low), high + above * (high - low)))
    ax.yaxis.set_major_formatter(lambda tick, _: f"{abs(tick):g}")  # downwards, too, |F| is positive
    ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")


def times(peak: "Peak") -> str:
    """Return a label for a peak, with the code of its orbit and the number of traversals, such as 1½."""
    whole, half = divmod(peak.repetitions, 1)
    count = f"{int(whole) or ''}{'½' if half else ''}"
    return short(peak.code) if count == "1" else f"{count} × {short(peak.code)}"


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
