"""Figures of what the screen shows: curves by period, and counts as bars."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.ticker import MaxNLocator

from orbitdb.arrays import Floats
from orbitdb.plots.style import BLUE, INKS, Picture, figure

Curve = tuple[str, str, Floats, Floats, str]
"""A curve: its style on the screen, name, periods, values, and marker, which is empty for a line."""

_MARKERS = {"×": "x", "•": "o"}
_LINE = 0.2
"""Height of a bar with its label, in inches."""


def curves(curves: Mapping[str, Sequence[Curve]], titles: Mapping[str, str], title: str) -> Picture:
    """Draw curves against the period, with one panel for each name."""
    with figure(6.4, 2.6 * len(curves) + 0.8, title) as made:
        for ax, (name, group) in zip(
            made.subplots(len(curves), 1, sharex=True, squeeze=False)[:, 0], curves.items(), strict=True
        ):
            for style, label, p, values, marker in group:
                look = _MARKERS.get(marker, "-")
                ax.plot(p, values, look, color=INKS[style], label=label or "_unnamed")
            ax.legend(fontsize="small")
            ax.set(ylabel=titles[name])
            ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        ax.set(xlabel="period $p$ (bounces)")
    return made


def counts(counts: Sequence[tuple[str, int]], of: str, title: str) -> Picture:
    """Draw counts of words as labelled bars, from the top down."""
    with figure(6.4, _LINE * len(counts) + 1.2, title) as made:
        ax = made.add_subplot()
        places = np.arange(len(counts))
        ax.barh(places, [count for _, count in counts], color=BLUE)
        ax.set_yticks(places, [label for label, _ in counts])
        ax.invert_yaxis()
        ax.set(xlabel="words", ylabel=of)
    return made
