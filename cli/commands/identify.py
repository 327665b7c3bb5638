"""``orbitdb identify``: find orbits that match a trajectory or a length."""

from pathlib import Path
from typing import Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import not_shown, note, notes
from orbitdb.cli.options import count_option, number_option
from orbitdb.cli.output import ON_SCREEN, Output, code_text, write_facts
from orbitdb.cli.snapshots import snapshot_at, solving
from orbitdb.errors import InputError
from orbitdb.text import real

EXAMPLES = (
    "identify --start 0,0.5,1.2",
    "query 1232131 --by-bounce --format csv | orbitdb identify --points -",
    "identify --length 21.7 --tolerance 2e-3",
)
SHADOW_COLUMNS = ("code", "p", "first", "last", "turns", "distance", "length", "lambda_d")
"""Columns of the table; they fit into 80 characters for every orbit."""

LENGTH_COLUMNS = ("code", "p", "class_size", "repetitions", "length", "total", "difference")
LENGTH_KEYS = (*LENGTH_COLUMNS, "lyapunov", "length_error", "a")
_LONG_SEQUENCE = 40
"""Longer sequences are shown in run notation."""


def identify(
    *,
    context: typer.Context,
    start: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,ANGLE", help="Start of a trajectory: a point, and its direction in radians."
        ),
    ] = None,
    points: Annotated[
        Path | None,
        options.path_option(help="File of bounces, csv or json, one x,y per line; - reads stdin."),
    ] = None,
    length: Annotated[float | None, number_option(help="Length of an orbit, in units of the radius.")] = None,
    tolerance: Annotated[
        float | None,
        number_option(
            help="Tolerance, in units of the radius [default: 0.01 for bounces, 0.001 for a length]."
        ),
    ] = None,
    each_way: Annotated[
        int | None,
        count_option(
            "--bounces", help="Number of bounces to follow from --start in each direction [default: 60]."
        ),
    ] = None,
    limit: Annotated[
        int | None,
        count_option(
            "--limit",
            "-n",
            least=0,
            help="Maximum number of rows to show [default: 10; "
            f"with --length, {ON_SCREEN} in a table, otherwise all].",
        ),
    ] = None,
    a: options.HalfLength = None,
    output: Output,
    db: options.Database,
) -> None:
    """Find the orbits near a trajectory, or the orbits of a given length.

    The output for a trajectory is its sequence of symbols, then the periodic orbits that it shadows, stored
    or not: from bounce first to bounce last, the trajectory stays within the tolerance of the orbit. The
    orbits with the most turns come first. From --start, the trajectory is followed forward (bounces 1, 2,
    ...) and backward (bounces 0, -1, ...). A length is compared with the stored orbits and their repetitions:
    total = repetitions x length.
    """
    ways = {"start": start, "points": points, "length": length}
    given = [name for name in ways if ways[name] is not None]
    if len(given) != 1:
        raise InputError("identify takes exactly one of --start, --points and --length")
    if start is None:
        options.refuse_idle(context, f"with --{given[0]}", "each_way")
    if length is not None:
        count = _show_length(length, tolerance, limit, a, db, output)
    else:
        from orbitdb.trajectories.point_files import read_points  # late: it loads NumPy

        asked: dict[str, Any] = {"tolerance": tolerance, "bounces": each_way, "limit": limit}
        if points is not None:
            asked["points"] = read_points(points)
        else:
            asked["start"] = parse_start(start or "")
        count = _show_trajectory(asked, a, db, output)
    if not count:
        raise typer.Exit(1)


def parse_start(text: str) -> list[float]:
    """Parse a starting point and direction such as ``0,0.5,1.2``."""
    try:
        return [real(part) for part in text.split(",")]
    except ValueError as error:
        raise InputError(f"--start: {error}; write x,y,angle, such as 0,0.5,1.2") from None


def _show_trajectory(asked: dict[str, Any], a: float | None, db: Path, output: Output) -> int:
    """Write the orbits that a trajectory shadows; return the number of rows."""
    with solving(db, a) as (catalogue, (at,)):
        path = catalogue.identify(**asked, a=at)
    if output.table:
        back = max(0, 1 - path.first)
        parts = (("before", path.sequence[:back]), ("sequence", path.sequence[back:]))
        write_facts([(name, code_text(symbols, _LONG_SEQUENCE)) for name, symbols in parts if symbols])
        if path.shadowed:
            print()
    names = SHADOW_COLUMNS if output.for_people else path.columns
    count = output.write(names, path.rows(names))
    notes(path.notes)
    if path.total:
        orbits = "orbit is" if path.total == 1 else "orbits are"
        note(f"{path.total} {orbits} shadowed{not_shown(count, path.total)}")
    return count


def _show_length(
    length: float, tolerance: float | None, limit: int | None, a: float | None, db: Path, output: Output
) -> int:
    """Write the stored orbits of a given length; return the number of rows."""
    names = LENGTH_COLUMNS if output.for_people else LENGTH_KEYS
    with snapshot_at(db, a) as (catalogue, at):
        orbits = catalogue.identify(length=length, tolerance=tolerance, a=at)
    notes(orbits.notes)
    rows = (
        [at if name == "a" else getattr(orbit, name) for name in names]
        for orbit in orbits[: output.most(limit)]
    )
    count = output.write(names, rows)
    if said := orbits.describe(not_shown(count, len(orbits))):
        note(said)
    return count
