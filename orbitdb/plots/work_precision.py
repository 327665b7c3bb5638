"""The work-precision diagram of `orbitdb bench`: run time against error."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from orbitdb.plots.style import BLUE, GREEN, INK, ORANGE, PURPLE, SMALL, Picture, figure, titled

if TYPE_CHECKING:
    from orbitdb.benchmarks.work_precision import WorkPrecision

_LEAST_SHOWN = 1e-20
"""Smaller errors, which only ball arithmetic has, are beyond the left edge of the diagram."""

_DOUBLE = 2.0**-53


def work_precision(rows: Sequence["WorkPrecision"], title: str) -> Picture:
    """Draw, for each method, the run time per word against the largest error of a coordinate."""
    of_methods = {
        "newton": ("o-", BLUE, "Newton on leg directions"),
        "balls": ("D-", GREEN, "ball arithmetic (proved radius)"),
        "root": ("^--", PURPLE, "scipy.optimize.root"),
        "relaxation": ("s:", ORANGE, "relaxation (Biham and Kvale)"),
    }
    with figure(6, 5) as made:
        ax = made.subplots()
        for method, (line, colour, label) in of_methods.items():
            mine = [row for row in rows if row.method == method]
            errors = [row.coordinates_max for row in mine]
            times = [row.seconds_per_sequence for row in mine]
            if method == "balls" and min(errors, default=1.0) < _LEAST_SHOWN:
                label += f", down to $10^{{{math.floor(math.log10(min(errors)))}}}$"
            ax.loglog(errors, times, line, color=colour, label=label)
        ax.set_xlim(left=max(ax.get_xlim()[0], _LEAST_SHOWN))
        ax.axvline(_DOUBLE, color=INK, linewidth=0.8, linestyle="--")
        ax.annotate("double", (_DOUBLE, 0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
                    textcoords="offset points", color=INK, fontsize=SMALL)  # fmt: skip
        ax.set(xlabel="largest error of a coordinate (units of $R$, rad)", ylabel="run time per word (s)")
        ax.set_title(titled(f"run time against error, {title}"))
    return made
