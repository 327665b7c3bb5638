"""Figure of how far averages are from a known value, against the period."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from orbitdb.plots.style import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_LOOKS = (("x:", BLUE), ("^-", GREEN), ("s--", ORANGE), ("D-", PURPLE), ("o-", INK))


def draw_deviations(ax: Axes, p: Integers, deviations: dict[str, Floats], estimate: Floats) -> None:
    """Draw relative deviations on a logarithmic scale, and the estimate of the last one.

    Parameters
    ----------
    ax : Axes
    p : ndarray of int, shape (n,)
    deviations : dict of str to ndarray, shape (n,)
        By the name of the average, at most five; NaN where there is none.
    estimate : ndarray, shape (n,)
        Of the error of the last average: the band below it is drawn.
    """
    for (name, values), (look, colour) in zip(deviations.items(), _LOOKS, strict=False):
        ax.plot(p, np.abs(values), look, color=colour, markersize=5, label=name)
    ax.set(yscale="log", xlabel="period $p$ (bounces)", ylabel="relative deviation")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    low, high = ax.get_ylim()
    ax.fill_between(p, low, estimate, color=FAINT, alpha=0.3, linewidth=0, label="estimate of its error")
    ax.set_ylim(low, high)
    ax.legend(loc="center left", bbox_to_anchor=(1, 0.5))
