"""``orbitdb identify``: find orbits that match a trajectory or a length."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import parse_start, read_points
from orbitdb.cli.options import Choice, count_option, number_option
from orbitdb.cli.output import Output, code_text, note, write_facts
from orbitdb.cli.reading import known_catalogue, meant, note_gaps, reading
from orbitdb.errors import InputError
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.answers.identification import Trajectory

EXAMPLES = (
    "identify --start 0,0.5,1.2",
    "query 1232131 --bounces --format csv | orbitdb identify --points -",
    "identify --length 21.7 --tolerance 2e-3",
)
SHADOW_COLUMNS = ("code", "p", "first", "last", "turns", "distance", "length", "lambda_d")
"""Columns of the table; they fit into 80 characters for every orbit."""

LENGTH_COLUMNS = ("code", "p", "class_size", "repetitions", "length", "total", "difference")
LENGTH_KEYS = (*LENGTH_COLUMNS, "lyapunov", "length_error", "a")
_ON_SCREEN = 40


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
        str | None,
        typer.Option(metavar="PATH", help="File of bounces, csv or json, one x,y per line; - reads stdin."),
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
            least=0,
            help="Maximum number of rows to show [default: 10; "
            f"with --length, {_ON_SCREEN} in a table, otherwise all].",
        ),
    ] = None,
    a: options.StoredHalfLength = None,
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
        asked = {"points": read_points(points)} if points is not None else {"start": parse_start(start or "")}
        asked |= {"tolerance": tolerance, "bounces": each_way, "limit": limit}
        count = _show_trajectory(asked, a, db, output)
    if not count:
        raise typer.Exit(1)


def _show_trajectory(asked: dict[str, Any], a: float | None, db: Path, output: Output) -> int:
    """Write the orbits that a trajectory shadows; return the number of rows."""
    from orbitdb.answers.identification import SHADOWED, identify_trajectory
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.store.lookup import find_or_solve

    stadium = Stadium(*meant(db, a))
    known = known_catalogue(db)
    found = identify_trajectory(stadium, lambda word: find_or_solve(known, word, stadium.a), **asked)
    if output.table:
        back = max(0, 1 - found.first)
        parts = (("before", found.sequence[:back]), ("sequence", found.sequence[back:]))
        write_facts([(name, code_text(symbols)) for name, symbols in parts if symbols])
        if found.shadowed:
            print()
    names = SHADOW_COLUMNS if output.for_people else SHADOWED
    places = [SHADOWED.index(name) for name in names]
    count = output.write(names, ([row[place] for place in places] for row in found.rows()))
    _note_ends(found, asked)
    _note_count(found, count)
    return count


def _note_ends(found: "Trajectory", asked: dict[str, Any]) -> None:
    """Write a note if the trajectory from --start could not be followed as far as requested."""
    if "start" not in asked:
        return
    from orbitdb.trajectories.trajectory import BOUNCES

    last = found.first + len(found.sequence) - 1
    wanted = asked["bounces"] or BOUNCES
    if last < wanted or found.first > 1 - wanted:
        note(f"followed from bounce {found.first} to {last}; double precision does not determine the rest")


def _note_count(found: "Trajectory", count: int) -> None:
    """Write a note with the number of orbits, or why there are none."""
    if found.total:
        more = f"; {count} shown, --limit {found.total} shows all" if count < found.total else ""
        orbits = "orbit is" if found.total == 1 else "orbits are"
        note(f"{found.total} {orbits} shadowed{more}")
    elif found.sequence and set(found.sequence) <= {"0", "2"}:
        note("no orbit: the trajectory bounces between the straight walls, like the bouncing-ball family 02")
    else:
        note("no orbit is shadowed for two bounces or more; a larger --tolerance finds orbits farther away")


def _show_length(
    length: float,
    tolerance: float | None,
    limit: int | None,
    a: float | None,
    db: Path,
    output: Output,
) -> int:
    """Write the stored orbits of a given length; return the number of rows."""
    from orbitdb.answers.completeness import describe_fills
    from orbitdb.answers.identification import identify_length
    from orbitdb.orbits.status import Status
    from orbitdb.store.fills import read_fills
    from orbitdb.text import exact

    names = LENGTH_COLUMNS if output.for_people else LENGTH_KEYS
    most = _ON_SCREEN if limit is None and output.table else limit
    with reading(db, a, Choice()) as (moment, (chosen,)):
        note_gaps(moment, replace(chosen, statuses=(Status.ORBIT,)))
        found = identify_length(moment, chosen.a, length, tolerance)
        rows = ([chosen.a if name == "a" else getattr(each, name) for name in names] for each in found[:most])
        count = output.write(names, rows)
        fills = read_fills(moment, chosen.a)
        among = describe_fills(fills, chosen.a) if fills else f"single words at a = {exact(chosen.a)}"
        nearest = identify_length(moment, chosen.a, length, 1.0, 1) if not found else ()
    more = f"; {count} shown, --limit {len(found)} shows all" if count < len(found) else ""
    candidates = several(len(found), "candidate") if found else "no candidates"
    for each in nearest:
        times = f"{each.repetitions} x {each.code}" if each.repetitions > 1 else each.code
        enough = float(f"{1.05 * abs(each.difference):.2g}")
        note(f"the nearest orbit is {times} of length {each.total:.7f}: --tolerance {enough:g} finds it")
    if fills or found:  # otherwise another note says that nothing was searched
        note(f"{candidates} among {among}, one per symmetry class{more}; "
             "orbits of longer periods may have this length, too")  # fmt: skip
    return count
