"""Figures of levels of the quantum stadium beside orbits, from what the catalogue holds."""

import numpy as np
from matplotlib.figure import Figure

from orbitdb.billiard.stadium import Stadium
from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.catalogue.spectrum import read_classes, read_levels
from orbitdb.cli.figures.orbits import short
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, figure
from orbitdb.quantum.amplitudes import orbit_terms, weyl
from orbitdb.quantum.lengths import counted, family_count
from orbitdb.store.asking.selection import Selection

_LENGTHS = (1.0, 12.0)
_PLACES = 2000


def draw_length_spectrum(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the length spectrum of the orbits downwards, and that of the levels upwards if there are any."""
    found = catalogue.spectrum(_LENGTHS, points=1000, a=chosen.a)
    for said in found.notes():
        note(said)
    with figure(7.2, 4.8, f"length spectrum at a = {chosen.a:g}, k below {found.k_max:.4g}") as made:
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
            ax.annotate(short(peak.code), (peak.length, side * peak.height), xytext=(0, 4 * side),
                        textcoords="offset points", fontsize=7, rotation=90, ha="center",
                        va="bottom" if side > 0 else "top")  # fmt: skip
        ax.axhline(0, color=INK, linewidth=0.6)
        ax.margins(x=0, y=0.25)
        ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")
    return made


def draw_levels(catalogue: Catalogue, chosen: Selection) -> Figure:
    """Draw the number of levels, and its fluctuations beside those that the orbits give."""
    known = read_levels(catalogue, chosen.a, None)
    if known is None:
        raise InputError(f"no levels to draw: 'orbitdb levels --k 0:30 --a {chosen.a:g}' finds them")
    k, end = known
    at, stadium = np.linspace(0.5, end, _PLACES), Stadium(chosen.a)
    classes, _, highest = read_classes(catalogue, chosen)
    smooth, family = weyl(stadium, None)(at), family_count(stadium, at, _LENGTHS[1])
    orbits = counted(orbit_terms(classes, _LENGTHS[1]), at)
    note(f"orbits and bouncing balls of lengths up to {_LENGTHS[1]:g}: a partial sum")
    with figure(7.2, 6.0, f"{len(k)} levels at a = {chosen.a:g}, k below {end:.4g}") as made:
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
