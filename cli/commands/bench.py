"""``orbitdb bench``: run time against error, and hard cases."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.cli import options
from orbitdb.cli.output import Output, note, progress
from orbitdb.errors import InputError
from orbitdb.extras import load
from orbitdb.progress import aside
from orbitdb.text import exact

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orbitdb.benchmarks.work_precision import WorkPrecision
    from orbitdb.billiard.stadium import Stadium

EXAMPLES = (
    "bench",
    "bench --p 9 --plot work-precision.svg",
    "bench --kind stress --json",
)
_MOST = 13
_LEAST_SHOWN = 1e-20
"""Smaller errors, which only ball arithmetic has, are beyond the left edge of the diagram."""

_DOUBLE = 2.0**-53


def bench(
    *,
    context: typer.Context,
    kind: Annotated[
        Literal["methods", "stress"],
        typer.Option(help="Compare methods, or solve hard cases."),
    ] = "methods",
    a: options.HalfLength = 1.6,
    p: options.Periods = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--plot",
            metavar="FILE",
            parser=options.read_path,
            help="Also draw the work-precision diagram (.png, .svg, .pdf).",
        ),
    ] = None,
    output: Output,
) -> None:
    """Measure run time against error, or solve hard cases.

    methods runs Newton's method, the paper's relaxation, scipy.optimize.root and ball arithmetic on all
    classes of one period (default 9), and shows their true errors. stress solves hard cases, and shows the
    errors and times. bench does not use the catalogue.
    """
    from orbitdb.billiard.stadium import Stadium

    if kind == "stress":
        from orbitdb.benchmarks.stress import Outcome, stress

        options.refuse_idle(context, "with --kind stress", "a", "p", "picture")
        outcomes = _write(output, Outcome, _watched(stress()))
        if not all(each.passed for each in outcomes):
            raise typer.Exit(1)
    else:
        _compare(_period(p or "9"), Stadium(a), output, picture)


def _period(text: str) -> int:
    from orbitdb.store.selection import parse_periods

    ((p, last), *others) = parse_periods(text)
    if others or p != last or not 2 <= p <= _MOST:
        raise InputError(f"periods {text!r}: give a single period from 2 to {_MOST}, such as --p 9")
    return p


def _compare(p: int, stadium: "Stadium", output: Output, picture: Path | None) -> None:
    """Compare the methods for one period, and draw the diagram if requested."""
    from orbitdb.answers.export import FIGURES, complete, form_of
    from orbitdb.benchmarks.work_precision import WorkPrecision

    said = f"p = {p} at a = {exact(stadium.a)}"
    if picture is None:
        note(f"{said}: times are in seconds, errors of length and lambda are relative")
        _write(output, WorkPrecision, _compared(p, stadium))
        return
    ending = form_of(picture, known=FIGURES)
    style = load("orbitdb.plots.style", "a figure", "plot")  # late, because matplotlib is slow to import
    with complete(picture) as draft:
        rows = _write(output, WorkPrecision, _compared(p, stadium))
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
            if method == "balls" and min(errors, default=1.0) < _LEAST_SHOWN:
                label += f", down to $10^{{{math.floor(math.log10(min(errors)))}}}$"
            ax.loglog(errors, times, line, color=colour, markersize=5, label=label)
        ax.set_xlim(left=max(ax.get_xlim()[0], _LEAST_SHOWN))
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
