"""The figure of `assess`: how many levels are missing below each k."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from orbitdb.arrays import Floats
from orbitdb.plots.style import BLUE, ORANGE, SMALL, Picture, figure
from orbitdb.quantum.weyl import Parity
from orbitdb.selection import Selection

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.quantum.conclusions import Gap
    from orbitdb.quantum.missing_levels import Assessment

_SURE, _LIGHT = 0.9, 0.35
"""Least probability of what is drawn in full, and the opacity of the rest."""
_SHADE = 0.15
_ROOM = (0.1, 0.35)
"""Margin below and above the points, in units of their range; the name of a gap needs the larger."""
_MOST_NAMES = 12
"""Gaps are named if there are not more of them."""


def assess(
    catalogue: "Catalogue",
    chosen: Selection,
    levels: Floats | None = None,
    parity: Parity | None = None,
    window: bool = False,
) -> Picture:
    """Draw the excess of each level, which increases by 1 at a missing level."""
    assessment = catalogue.assess(levels, parity=parity, window=window, a=chosen.a)
    with figure(7.2, 4.2, assessment.verdict().replace("+-", "±"), assessment.notes) as made:
        draw_assess(made.add_subplot(), assessment)
    return made


def draw_assess(ax: Axes, assessment: "Assessment") -> None:
    """Draw how many levels are missing below k, by the orbits and as the most probable integer.

    Gaps with missing or spurious levels are shaded. What has a probability below 0.9 is lighter. In a window,
    the levels below its first do not count.
    """
    _draw_steps(ax, assessment)
    excess = assessment.excess - (assessment.first - 1)
    sure = assessment.probability >= _SURE
    label = r"$N_\mathrm{orbits}(k) - N_\mathrm{list}(k)$"
    dots: dict[str, Any] = {
        "marker": ".",
        "linestyle": "",
        "color": BLUE,
        "markersize": 0.8 * rcParams["lines.markersize"],
    }
    ax.plot(assessment.k[sure], excess[sure], label=label, **dots)
    ax.plot(assessment.k[~sure], excess[~sure], alpha=_LIGHT, **dots)
    for gap in assessment.gaps:
        low = assessment.k[0] if gap.after is None else gap.after
        high = assessment.k[-1] if gap.before is None else gap.before
        alpha = _SHADE if gap.probability >= _SURE else _SHADE * _LIGHT
        ax.axvspan(low, high, color=ORANGE, alpha=alpha, linewidth=0)
    low, high = ax.dataLim.intervaly
    below, above = _ROOM if len(assessment.gaps) <= _MOST_NAMES else (_ROOM[0], _ROOM[0])
    ax.set_ylim(low - below * (high - low), high + above * (high - low))
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    ends = (assessment.k[0] if assessment.window else 0, assessment.k[-1])
    ax.set(xlabel="$kR$", ylabel="levels missing below $k$", xlim=ends)


def _draw_steps(ax: Axes, assessment: "Assessment") -> None:
    """Draw the most probable number of missing levels, minus that of spurious ones, below each k."""
    spurious = assessment.k[assessment.number == 0]
    k = np.concatenate([assessment.k, assessment.places, spurious])
    rise = np.repeat([0, 1, -1], [len(assessment), len(assessment.places), len(spurious)])
    order = np.argsort(k, kind="stable")
    k, height = k[order], np.cumsum(rise[order])
    sure = np.interp(k, assessment.k, assessment.probability) >= _SURE
    ax.step(k, height, where="post", color=ORANGE, alpha=_LIGHT)
    full = np.where(sure, height, np.nan)
    ax.step(k, full, where="post", color=ORANGE, label="levels missing below $k$")
    if len(assessment.gaps) <= _MOST_NAMES:
        for gap in assessment.gaps:
            _name(ax, gap, assessment, k, height)


def _name(ax: Axes, gap: "Gap", assessment: "Assessment", k: Floats, height: Floats) -> None:
    """Write how many levels are missing or spurious in a gap, and where, beside its step, above the points.

    The text is upright: it stays inside the figure, and away from that of the next gap.
    """
    low = -np.inf if gap.after is None else gap.after
    high = np.inf if gap.before is None else gap.before
    every = np.concatenate([assessment.places, assessment.k[assessment.number == 0]])
    inside = every[(every > low) & (every < high)]
    at = float(inside.mean()) if len(inside) else low
    start, end = (
        float(height[max(np.searchsorted(k, edge, "right") - 1, 0)]) for edge in (low, min(high, k[-1]))
    )
    rising = end >= start
    ax.annotate(
        f"{gap.counts()} at {at:.2f}",
        (inside.min(initial=at) if rising else inside.max(initial=at), min(start, end) + 0.5),
        xytext=(-2 if rising else 2, 0),
        textcoords="offset points",
        rotation=90,
        ha="right" if rising else "left",
        va="bottom",
        color=ORANGE,
        fontsize=SMALL,
    )
