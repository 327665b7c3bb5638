"""``orbitdb bench``: run time against error, and hard cases."""

from collections.abc import Iterable
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.notes import note, progress
from orbitdb.cli.output import Output
from orbitdb.display import load
from orbitdb.plots.registry import load_function
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.billiard.stadium import Stadium

EXAMPLES = ("bench", "bench --p 9 -o work-precision.svg", "bench --kind stress --json")


def bench(
    *,
    context: typer.Context,
    kind: Annotated[
        Literal["methods", "stress"], typer.Option(help="Compare methods, or solve hard cases.")
    ] = "methods",
    a: options.GivenHalfLength = USUAL_A,
    p: Annotated[int, options.count_option("--p", "-p", least=2, most=13, help="Period of the words.")] = 9,
    picture: Annotated[
        Path | None,
        options.path_option(
            "--output", "-o", help="Also draw the work-precision diagram (.png, .svg, .pdf)."
        ),
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
    from orbitdb.benchmarks.work_precision import WorkPrecision, sample, work_precision
    from orbitdb.output_files import FIGURES, atomic_file, check_target, form_of

    title = f"p = {p} at a = {format_float(stadium.a)}"
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
    with atomic_file(picture) as draft:
        style.save(load_function("work_precision.work_precision")(rows, title), draft, ending, title)
    note(f"{title}, in {picture}")


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
