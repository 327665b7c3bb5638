"""``orbitdb bench``: run time against error, and hard cases."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output, note, progress
from orbitdb.extras import load
from orbitdb.text import exact

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orbitdb.benchmarks.work_precision import WorkPrecision
    from orbitdb.billiard.stadium import Stadium

EXAMPLES = ("bench", "bench --p 9 --plot work-precision.svg", "bench --kind stress --json")
_LEAST_SHOWN = 1e-20
"""Smaller errors, which only ball arithmetic has, are beyond the left edge of the diagram."""

_DOUBLE = 2.0**-53


def bench(
    *,
    context: typer.Context,
    kind: Annotated[
        Literal["methods", "stress"], typer.Option(help="Compare methods, or solve hard cases.")
    ] = "methods",
    a: options.HalfLength = 1.6,
    p: Annotated[int, options.count_option("--p", least=2, most=13, help="Period of the words.")] = 9,
    picture: Annotated[
        Path | None,
        options.path_option("--plot", help="Also draw the work-precision diagram (.png, .svg, .pdf)."),
    ] = None,
    output: Output,
) -> None:
    """Measure run time against error, or solve hard cases.

    methods runs Newton's method, the paper's relaxation, scipy.optimize.root and ball arithmetic on all
    classes of one period, and shows their true errors. stress solves hard cases, and shows the
    errors and times. bench does not use the catalogue.
    """
    from orbitdb.billiard.stadium import Stadium

    if kind == "stress":
        from orbitdb.benchmarks.stress import Outcome, stress

        options.refuse_idle(context, "with --kind stress", "a", "p", "picture")
        outcomes = _write(output, Outcome, stress())
        if not all(outcome.passed for outcome in outcomes):
            raise typer.Exit(1)
    else:
        _compare(p, Stadium(a), output, picture)


def _compare(p: int, stadium: "Stadium", output: Output, picture: Path | None) -> None:
    """Compare the methods for one period, and draw the diagram if requested."""
    from orbitdb.answers.export import FIGURES, check_target, complete, form_of
    from orbitdb.benchmarks.work_precision import WorkPrecision, sample, work_precision

    title = f"p = {p} at a = {exact(stadium.a)}"
    if picture is not None:
        ending = form_of(picture, None, FIGURES)
        check_target(picture)
        style = load("orbitdb.plots.style", "a figure", "plot")  # late, because matplotlib is slow to import
    with progress("true orbits in ball arithmetic"):
        cases = sample(p, stadium)
    rows = _write(output, WorkPrecision, work_precision(cases))
    if picture is None:
        note(f"{title}: times are in seconds, errors of length and lambda are relative")
        return
    with complete(picture) as draft:
        style.save(draw_work_precision(rows, title), draft, ending, title)
    note(f"{title}, in {picture}")


def draw_work_precision(rows: "Sequence[WorkPrecision]", title: str) -> "Figure":
    """Draw, for each method, the run time per word against the largest error of a coordinate."""
    from orbitdb.plots.style import BLUE, GREEN, INK, ORANGE, PURPLE, figure

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
            ax.loglog(errors, times, line, color=colour, markersize=5, label=label)
        ax.set_xlim(left=max(ax.get_xlim()[0], _LEAST_SHOWN))
        ax.axvline(_DOUBLE, color=INK, linewidth=0.8, linestyle="--")
        ax.annotate("double", (_DOUBLE, 0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
                    textcoords="offset points", color=INK, fontsize=8)  # fmt: skip
        ax.set(xlabel="largest error of a coordinate (units of $R$, rad)", ylabel="run time per word (s)")
        ax.set_title(f"run time against error, {title}")
    return made


def _write(output: Output, kind: Any, rows: Iterable[Any]) -> list[Any]:
    """Write rows, with NaN as an empty field, while progress names the latest one; return them."""
    written = []
    with progress("measuring") as shown:
        for row in rows:
            written.append(row)
            shown(0, 0, f"measuring, done: {' '.join(map(str, [*asdict(row).values()][:2]))}")
    values = ([None if value != value else value for value in asdict(row).values()] for row in written)
    output.write([field.name for field in fields(kind)], values)
    return written
