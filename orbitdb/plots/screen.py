"""Figures of what the screen shows: averages by period, and counts as bars."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from orbitdb.answers.lyapunov import EXPONENTS
from orbitdb.answers.results import TRAJECTORIES, Result
from orbitdb.plots.averages import draw_entropy, draw_exponent
from orbitdb.plots.style import BLUE, Picture, figure

if TYPE_CHECKING:
    from orbitdb.trajectories.ensemble import Reference

_LINE, _FEWEST = 0.2, 6
"""Height of a bar, in inches, and the number below which bars are higher, so that the axis has room."""


def statistics(result: Result, reference: "Reference | None", title: str) -> Picture:
    """Draw entropies and Lyapunov averages by period, one panel below another, as `plot` draws them."""
    if reference is not None:
        known = {f"{name}_trajectory": [getattr(reference, name)] * len(result) for name in TRAJECTORIES}
        result = replace(result, columns={**result.columns, **known})
    with figure(6.4, 8.6, title) as made:
        above, *below = made.subplots(3, 1, sharex=True)
        draw_entropy(above, result)
        for ax, name in zip(below, EXPONENTS, strict=True):
            draw_exponent(ax, result, name)
        for ax in (above, below[0]):
            ax.set(xlabel="")
    return made


def counts(counts: Sequence[tuple[str, int]], of: str, title: str) -> Picture:
    """Draw how many there are of what the title names as labelled bars, from the top down."""
    with figure(6.4, _LINE * max(len(counts), _FEWEST) + 1.2, title) as made:
        ax = made.add_subplot()
        places = np.arange(len(counts))
        ax.barh(places, [count for _, count in counts], color=BLUE)
        ax.set_yticks(places, [label for label, _ in counts])
        ax.invert_yaxis()
        ax.set(xlabel="number", ylabel=of)
    return made
