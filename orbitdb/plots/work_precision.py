"""The work-precision diagram: run time against error, method against method."""

from collections.abc import Sequence

from matplotlib.axes import Axes

from orbitdb.benchmarks.work_precision import WorkPrecision
from orbitdb.plots.style import BLUE, GREEN, INK, ORANGE, PURPLE

_STYLES = {
    "newton": ("o-", BLUE, "Newton on leg directions"),
    "balls": ("D-", GREEN, "ball arithmetic (proved radius)"),
    "root": ("^--", PURPLE, "scipy.optimize.root"),
    "relaxation": ("s:", ORANGE, "relaxation (Biham and Kvale)"),
}
_DOUBLE = 2.0**-53


def draw_work_precision(ax: Axes, rows: Sequence[WorkPrecision]) -> None:
    """Draw the run time per word against the largest error of a coordinate.

    Parameters
    ----------
    ax : Axes
    rows : sequence of WorkPrecision
        All methods and settings of one run.
    """
    for method, (line, colour, label) in _STYLES.items():
        mine = [row for row in rows if row.method == method]
        errors = [row.coordinates_max for row in mine]
        times = [row.seconds_per_sequence for row in mine]
        ax.loglog(errors, times, line, color=colour, markersize=5, label=label)
    ax.axvline(_DOUBLE, color=INK, linewidth=0.8, linestyle="--")
    ax.annotate("double", (_DOUBLE, 0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
                textcoords="offset points", color=INK, fontsize=8)  # fmt: skip
    ax.set_xlabel("largest error of a coordinate (units of $R$, rad)")
    ax.set_ylabel("run time per word (s)")
