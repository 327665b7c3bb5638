"""The length spectrum of quantum levels against that of the orbits."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from orbitdb.answers.level_lists import assessed, lacking
from orbitdb.arrays import Floats
from orbitdb.plots.staircase import of_parity
from orbitdb.plots.style import BLUE, GREY, INK, ORANGE, SMALL, Picture, figure, short
from orbitdb.quantum.weyl import Parity
from orbitdb.selection import Selection
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.quantum.length_spectrum import Peak, Spectrum

_RESOLUTION = 1000
_ROOM, _ROOM_OF_LABELS = 0.04, 0.16
"""Margin at the end of the axis without and with labels, in units of the range of its values."""


def spectrum(
    catalogue: "Catalogue",
    chosen: Selection,
    levels: Floats | None = None,
    parity: Parity | None = None,
    window: bool = False,
    lengths: tuple[float, float] | None = None,
    k: tuple[float, float] | None = None,
) -> Picture:
    """Draw the length spectrum of the orbits downwards and that of the levels, if there are any, upwards."""
    found = catalogue.spectrum(
        lengths, resolution=_RESOLUTION, k=k, levels=levels, window=window, parity=parity, a=chosen.a
    )
    notes = found.notes()
    if levels is not None:
        with catalogue._reading() as connection:
            notes += lacking(assessed(connection, chosen.a, levels, parity, window))
    title = f"length spectrum at a = {format_float(chosen.a)}, {of_parity(parity)}, {found.range_of_k}"
    with figure(7.2, 4.8, title, notes) as made:
        draw_spectrum(made.add_subplot(), found)
    return made


def draw_spectrum(ax: Axes, spectrum: "Spectrum") -> None:
    """Draw the length spectrum of the orbits downwards, and that of the levels, if there are any, upwards."""
    side = -1 if spectrum.quantum is None else 1
    if spectrum.quantum is not None:
        ax.plot(spectrum.length, np.abs(spectrum.quantum), color=BLUE, label="levels")
    ax.plot(spectrum.length, -np.abs(spectrum.orbits), color=ORANGE, label="orbits, downwards")
    first, last = spectrum.length[[0, -1]]
    if spectrum.complete_length < last:
        beyond = max(spectrum.complete_length, first)
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
