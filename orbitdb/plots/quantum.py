"""Figures of levels: the length spectrum beside that of orbits, and the counting function."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE

Floats = NDArray[np.float64]


def draw_spectrum(
    ax: Axes,
    length: Floats,
    orbits: Floats,
    quantum: Floats | None,
    complete: float,
    peaks: Sequence[tuple[float, float, str]],
) -> None:
    """Draw |F| of levels upwards and that of orbits downwards.

    Parameters
    ----------
    ax : Axes
    length, orbits : ndarray, shape (n,)
    quantum : ndarray, shape (n,), or None
    complete : float
        Up to which length no orbit is missing.
    peaks : sequence of (float, float, str)
        Length, height and label of each peak.
    """
    if quantum is not None:
        ax.plot(length, quantum, color=BLUE, label="levels")
    ax.plot(length, -orbits, color=ORANGE, label="orbits, downwards")
    if complete < length[-1]:
        ax.axvspan(
            max(complete, length[0]), length[-1], color=GREY, alpha=0.12, label="orbits may be missing"
        )
    side = 1 if quantum is not None else -1
    for x, height, label in peaks:
        ax.annotate(label, (x, side * height), xytext=(0, 4 * side), textcoords="offset points", fontsize=7,
                    rotation=90, ha="center", va="bottom" if side > 0 else "top")  # fmt: skip
    ax.axhline(0, color=INK, linewidth=0.6)
    ax.margins(x=0, y=0.25)
    ax.set(xlabel="length $x/R$", ylabel=r"$|F(x)|$")


def draw_count(ax: Axes, k: Floats, smooth: Floats, at: Floats) -> None:
    """Draw the number of levels below k, the levels given, and its smooth part at some places."""
    ax.step(np.append(0.0, k), np.arange(len(k) + 1), where="post", color=BLUE, label="levels")
    ax.plot(at, smooth, color=ORANGE, linestyle="--", linewidth=1, label="Weyl's law")
    ax.set(ylabel="levels below $k$")


def draw_fluctuation(ax: Axes, at: Floats, levels: Floats, family: Floats, all_terms: Floats, p: int) -> None:
    """Draw how far the levels are from Weyl's law, and what bouncing balls and orbits make of that."""
    ax.plot(at, levels, color=BLUE, linewidth=0.8, label="levels, less Weyl's law")
    ax.plot(at, family, color=GREEN, linestyle=":", label="bouncing balls")
    label = f"bouncing balls and orbits to $p = {p}$, a partial sum"
    ax.plot(at, all_terms, color=ORANGE, linewidth=0.8, label=label)
    ax.set(xlabel="$kR$", ylabel="fluctuation")
