"""``orbitdb bench``: run time against error, run time by stage, and hard cases."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output
from orbitdb.cli.progress import progress
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.extras import load
from orbitdb.numerals import exact
from orbitdb.progress import aside

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orbitdb.benchmarks.agreement import Agreement
    from orbitdb.benchmarks.work_precision import WorkPrecision
    from orbitdb.billiard.stadium import Stadium

EXAMPLES = (
    "bench",
    "bench --p 9 --plot work-precision.svg",
    "bench --kind stages --p 2-12",
    "bench --kind stress --json",
    "bench --kind statuses --a 1 --p 2-6",
)
_MOST = 13
_DOUBLE = 2.0**-53


def bench(
    *,
    context: typer.Context,
    kind: Annotated[
        Literal["methods", "stages", "stress", "statuses"],
        typer.Option(
            help="Compare methods, time the stages of a fill, solve hard cases, or compare statuses."
        ),
    ] = "methods",
    a: options.HalfLength = 1.6,
    p: options.Periods = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--plot", metavar="FILE", help="Also draw the work-precision diagram (.png, .svg, .pdf)."
        ),
    ] = None,
    output: Output,
) -> None:
    """Measure run time against error, time the stages of a fill, solve hard cases, or compare statuses.

    methods runs Newton's method, the paper's relaxation, scipy.optimize.root and ball arithmetic on all
    classes of one period (default 9), and shows their true errors. stages shows the run time of every step
    from a period to its orbits (default 2-11). stress solves hard cases, and shows the errors and times.
    statuses compares the status of every class, by Newton's method in double precision and by the relaxation,
    with the status that ball arithmetic proves (default 2-8); stderr names every word that differs, with the
    reason. The relaxation takes seconds at a = 1.6, and half an hour at a = 10. bench does not use the
    catalogue.
    """
    from orbitdb.billiard.stadium import Stadium

    idle = {"methods": [], "stress": ["a", "p", "picture"]}.get(kind, ["picture"])
    options.refuse_idle(context, f"with --kind {kind}", *idle)
    stadium = Stadium(a)
    if kind == "stress":
        from orbitdb.benchmarks.stress import Outcome, stress

        outcomes = _write(output, Outcome, _watched(stress()))
        if not all(each.passed for each in outcomes):
            raise typer.Exit(1)
    elif kind == "stages":
        from orbitdb.benchmarks.work_precision import StageTimes, stage_times

        periods = _periods(p or "2-11")
        _write(output, StageTimes, _watched(stage_times(period, stadium) for period in periods))
    elif kind == "statuses":
        from orbitdb.benchmarks.agreement import Agreement

        found = _write(output, Agreement, _agreements(_periods(p or "2-8"), stadium))
        if any(each.unexplained for each in found):
            raise typer.Exit(1)
    else:
        _compare(_periods(p or "9"), stadium, output, picture)


def _compare(periods: list[int], stadium: "Stadium", output: Output, picture: Path | None) -> None:
    """Compare the methods for one period, and draw the diagram if requested."""
    from orbitdb.benchmarks.work_precision import WorkPrecision
    from orbitdb.export import FIGURES, complete, form_of

    if len(periods) > 1:
        raise InputError(
            f"periods {periods[0]} to {periods[-1]}: compare the methods for a single period, such as --p 9"
        )
    said = f"p = {periods[0]} at a = {exact(stadium.a)}"
    if picture is None:
        note(f"{said}: times are in seconds, errors of length and lambda are relative")
        _write(output, WorkPrecision, _compared(periods[0], stadium))
        return
    ending = form_of(picture, known=FIGURES)
    style = load("orbitdb.plots.style", "a figure", "plot")  # late, because matplotlib is slow to import
    with complete(picture) as draft:
        rows = _write(output, WorkPrecision, _compared(periods[0], stadium))
        style.save(draw_work_precision(rows, said), draft, ending, said)
    note(f"{said}, in {picture}")


def draw_work_precision(rows: "Sequence[WorkPrecision]", said: str) -> "Figure":
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
            ax.loglog(errors, times, line, color=colour, markersize=5, label=label)
        ax.axvline(_DOUBLE, color=INK, linewidth=0.8, linestyle="--")
        ax.annotate("double", (_DOUBLE, 0), xycoords=("data", "axes fraction"), xytext=(-3, 4), ha="right",
                    textcoords="offset points", color=INK, fontsize=8)  # fmt: skip
        ax.set(xlabel="largest error of a coordinate (units of $R$, rad)", ylabel="run time per word (s)")
        ax.set_title(f"run time against error, {said}")
    return made


def _compared(p: int, stadium: "Stadium") -> "Iterator[WorkPrecision]":
    from orbitdb.benchmarks.work_precision import sample, work_precision

    with progress("true orbits in ball arithmetic"):
        cases = sample(p, stadium)
    yield from _watched(work_precision(cases))


def _agreements(periods: list[int], stadium: "Stadium") -> "Iterator[Agreement]":
    """Compare the statuses that three methods give, by period; write a note for each word that differs."""
    from orbitdb.benchmarks.agreement import agreement

    with progress("the paper's relaxation") as shown:
        for p in periods:

            def show(step: int, moving: int, p: int = p) -> None:
                shown(0, 0, f"p = {p}: step {step:,}, {moving} classes still move")

            found, differing = agreement(p, stadium, show)
            with aside():
                for each in differing:
                    note(each)
                yield found


def _periods(text: str) -> list[int]:
    from orbitdb.store.asking.criteria import parse_periods

    periods = [period for low, high in parse_periods(text) for period in range(low, min(high, _MOST) + 1)]
    if not periods or min(periods) < 2:
        raise InputError(f"periods {text!r}: give periods from 2 to {_MOST}")
    return periods


def _write(output: Output, kind: Any, rows: Iterable[Any]) -> list[Any]:
    """Write each row as soon as it is there, with NaN as an empty field; return the rows."""
    written = []

    def values() -> Iterator[list[Any]]:
        for row in rows:
            written.append(row)
            yield [None if value != value else value for value in asdict(row).values()]

    output.write([field.name for field in fields(kind)], values())
    return written


def _watched(rows: Iterable[Any]) -> Iterator[Any]:
    """Yield the rows, and show the latest one as progress."""
    with progress("measuring") as shown:
        for row in rows:
            with aside():
                yield row
            first = " ".join(str(value) for value in list(asdict(row).values())[:2])
            shown(0, 0, f"measuring, done: {first}")
