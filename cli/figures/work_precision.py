"""The figure of the command `bench`."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from orbitdb.benchmarks.work_precision import WorkPrecision
from orbitdb.plots.style import BLUE, GREEN, INK, ORANGE, PURPLE, figure

_OF_METHODS = {
    "newton": ("o-", BLUE, "Newton on leg directions"),
    "balls": ("D-", GREEN, "ball arithmetic (proved radius)"),
    "root": ("^--", PURPLE, "scipy.optimize.root"),
    "relaxation": ("s:", ORANGE, "relaxation (Biham and Kvale)"),
}
_DOUBLE = 2.0**-53


def draw_work_precision(rows: Sequence[WorkPrecision], said: str) -> Figure:
    """Draw the run time per word against the largest error of a coordinate, of all methods of one run."""
    with figure(6, 5) as made:
        ax = made.subplots()
        for method, (line, colour, label) in _OF_METHODS.items():
            mine = [row for row in rows if row.method == method]
            errors = [row.coordinates_max for row in mine]
            times = [row.seconds_per_sequence for row in mine]
            ax.loglog(errors, times, line, color=colour, markersize=5, label=label)
        ax.axvline(_DOUBLE, color=INK, linewidth=0.8, linestyle="--")
        ax.annotate("double", (_DOUBLE, 0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
                    textcoords="offset points", color=INK, fontsize=8)  # fmt: skip
        ax.set(xlabel="largest error of a coordinate (units of $R$, rad)", ylabel="run time per word (s)")
        ax.set_title(f"run time against error, {said}")
    return made
