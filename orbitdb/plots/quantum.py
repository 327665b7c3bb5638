"""Figures of levels: the length spectrum beside that of orbits, and the counting function."""

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE
from orbitdb.quantum.spectrum import Spectrum

Floats = NDArray[np.float64]


def draw_spectrum(ax: Axes, found: Spectrum, label: Callable[[str], str]) -> None:
    """Draw |F| of levels upwards, that of orbits downwards, and the labels that peaks' codes get."""
    side = -1 if found.quantum is None else 1
    if found.quantum is not None:
        ax.plot(found.length, np.abs(found.quantum), color=BLUE, label="levels")
    ax.plot(found.length, -np.abs(found.orbits), color=ORANGE, label="orbits, downwards")
    first, last = found.length[[0, -1]]
    if found.complete < last:
        beyond = max(found.complete, first)
        ax.axvspan(beyond, last, color=GREY, alpha=0.12, label="orbits may be missing")
    for peak in found.peaks(1):
        ax.annotate(label(peak.code), (peak.length, side * peak.height), xytext=(0, 4 * side),
                    textcoords="offset points", fontsize=7, rotation=90, ha="center",
                    va="bottom" if side > 0 else "top")  # fmt: skip
    ax.axhline(0, color=INK, linewidth=0.6)
    ax.margins(x=0, y=0.25)
    ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")


def draw_level_count(
    above: Axes, below: Axes, k: Floats, at: Floats, smooth: Floats, family: Floats, orbits: Floats, p: int
) -> None:
    """Draw the number of levels, and how far it is from its smooth part.

    Parameters
    ----------
    above, below : Axes
    k : ndarray, shape (N,)
        The levels.
    at, smooth, family, orbits : ndarray, shape (n,)
        Wavenumbers, the smooth part there, and what bouncing balls and orbits make of the rest.
    p : int
        The highest period of the orbits.
    """
    above.step(np.append(0.0, k), np.arange(len(k) + 1), where="post", color=BLUE, label="levels")
    above.plot(at, smooth, color=ORANGE, linestyle="--", linewidth=1, label="Weyl's law")
    above.set(ylabel="levels below $k$")
    rest = np.searchsorted(k, at) - smooth
    below.plot(at, rest, color=BLUE, linewidth=0.8, label="levels, less Weyl's law")
    below.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls")
    label = f"bouncing balls and orbits to $p = {p}$, a partial sum"
    below.plot(at, family + orbits, color=ORANGE, linewidth=0.8, label=label)
    below.set(xlabel="$kR$", ylabel="fluctuation")
