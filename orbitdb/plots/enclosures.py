"""Figures of proved bounds on the topological entropy: over a, with what orbits give."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from orbitdb.plots.style import BLUE, GREY, ORANGE, PURPLE

Floats = NDArray[np.float64]

_STYLES = ((BLUE, "-"), (ORANGE, "--"))


def draw_entropy_over_a(
    ax: Axes,
    a: Floats,
    lower: Floats,
    upper: Floats,
    curves: Mapping[int, tuple[Floats, Floats]],
    limit: float,
) -> None:
    """Draw the bounds on the entropy over a as a band, with a bar where it is proved.

    Parameters
    ----------
    ax : Axes
    a, lower, upper : ndarray, shape (n,)
        Where the entropy is enclosed, rising, and between what; per bounce.
    curves : mapping of int to (ndarray, ndarray)
        By the highest period of a zeta function: values of a, and the entropy there, NaN where it has no
        zero that can be used.
    limit : float
        The bound that holds at every a.
    """
    ax.fill_between(a, lower, upper, color=PURPLE, alpha=0.35, linewidth=0)
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    ax.errorbar(a, middle, half, fmt="none", color=PURPLE, capsize=2, linewidth=1.2, label="proved bounds")
    for (p, (places, values)), (colour, style) in zip(curves.items(), _STYLES, strict=False):
        ax.plot(places, values, style, color=colour, linewidth=1, label=f"$h({p}; a)$, from births")
    ax.axhline(limit, color=GREY, linewidth=0.8, label="bound at every $a$")
    ax.set(xscale="log", xlabel="$a$", ylabel="topological entropy (per bounce)")
    ax.set_ylim(min(float(lower.min()), limit - 0.1) - 0.02, limit + 0.02)
