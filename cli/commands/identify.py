"""``orbitdb identify``: orbits by a trajectory or a length."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import parse_start, read_points
from orbitdb.cli.choice import Choice
from orbitdb.cli.options import Format, count_option, number_option
from orbitdb.cli.reading import meant, note_gaps, reading
from orbitdb.cli.render import code_text, note, write, write_facts
from orbitdb.cli.rows import with_marks
from orbitdb.errors import InputError
from orbitdb.plaintext import several

if TYPE_CHECKING:
    from orbitdb.catalogue.identification import Candidate, Followed, Trajectory

EXAMPLES = """
Examples:

  orbitdb identify --start 0,0.5,1.2

  orbitdb query 1232131 --bounces --format csv | orbitdb identify --points -

  orbitdb identify --length 21.7 --tolerance 2e-3
"""
SHADOW_COLUMNS = (
    "code",
    "p",
    "status",
    "first",
    "last",
    "bounces",
    "turns",
    "distance",
    "length",
    "lambda_d",
)
SHADOW_KEYS = (*SHADOW_COLUMNS, "lyapunov", "representative", "class_size", "a", "stored",
               "sequence", "sequence_first")  # fmt: skip
LENGTH_COLUMNS = ("code", "p", "class_size", "repetitions", "length", "total", "difference", "lyapunov")
LENGTH_KEYS = (*LENGTH_COLUMNS, "length_error", "a")
_ON_SCREEN = 40


def identify(
    context: typer.Context,
    start: Annotated[
        str | None,
        typer.Option(
            "--start", metavar="X,Y,ANGLE", help="A point in the stadium, and the path's angle (radians)."
        ),
    ] = None,
    points: Annotated[
        str | None,
        typer.Option("--points", metavar="PATH", help="Bounces x,y, one a line, csv or json; - reads stdin."),
    ] = None,
    length: Annotated[float | None, number_option("--length", help="A length, in radii.")] = None,
    tolerance: Annotated[
        float | None,
        number_option("--tolerance", help="How far off [default: bounces 0.01, a length 0.001]."),
    ] = None,
    bounces: Annotated[
        int | None, count_option("--bounces", help="Bounces from --start, each way [default: 60].")
    ] = None,
    limit: Annotated[
        int | None,
        count_option(
            "--limit",
            least=0,
            help=f"Rows at most [default: 10; of a length {_ON_SCREEN} in a table, else all].",
        ),
    ] = None,
    a: options.StoredHalfLength = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    mark_words: options.MarkWords = False,
    db: options.Database = None,
) -> None:
    """Find the orbits near a start, near the bounces of a trajectory, or of a length.

    A trajectory becomes symbols, with the periodic orbits that it shadows, stored or solved on the
    spot, those it goes round most often first: for bounces first to last it stays within the tolerance
    of the orbit. From a start it is followed ahead (bounce 1, 2, ...) and back (0, -1, ...). A length is
    that of stored orbits, repeated or not: total = repetitions x length.
    """
    form = options.chosen(format_, json)
    options.check_marks(mark_words, form)
    given = [
        name
        for name, value in (("start", start), ("points", points), ("length", length))
        if value is not None
    ]
    if len(given) != 1:
        raise InputError("identify takes exactly one of --start, --points and --length")
    if start is None:
        options.refuse_idle(context, f"with --{given[0]}", "bounces")
    if length is not None:
        count = _show_length(length, tolerance, limit, a, db, form, mark_words)
    else:
        asked = {"points": read_points(points)} if points is not None else {"start": parse_start(start or "")}
        asked |= {"tolerance": tolerance, "bounces": bounces, "limit": limit}
        count = _show_trajectory(asked, a, db, form, mark_words)
    if not count:
        raise typer.Exit(1)


def _show_trajectory(
    asked: dict[str, Any], a: float | None, db: Path | None, form: Format, mark: bool
) -> int:
    """Write the orbits that a trajectory shadows; return how many there are."""
    found, at = _identify(asked, a, db)
    if form is Format.TABLE:
        write_facts(_facts(found))
        if found.shadowed:
            print()
    names = SHADOW_COLUMNS if form in options.FOR_PEOPLE else SHADOW_KEYS
    shared = {"a": at, "sequence": found.sequence, "sequence_first": found.first}
    rows = (
        tuple(shared[name] if name in shared else _of_shadow(each, name) for name in names)
        for each in found.shadowed
    )
    count = write(names, with_marks(names, rows) if mark else rows, form)
    _note_ends(found, asked)
    _note_count(found, count)
    return count


def _identify(asked: dict[str, Any], a: float | None, db: Path | None) -> tuple["Trajectory", float]:
    """Return what is found of a trajectory, with a catalogue or without one, and the a that is meant."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.catalogue.catalogue import Catalogue
    from orbitdb.catalogue.identification import identify_trajectory
    from orbitdb.orbits.newton import solve_word
    from orbitdb.store.file.database import check_file, default_path

    path = db or default_path()
    stadium = Stadium(meant(path, a))
    if check_file(path) is None:
        if db is not None:
            note(f"no catalogue at {path}: solved on the spot")
        return identify_trajectory(stadium, lambda word: solve_word(word, stadium), **asked), stadium.a
    with closing(Catalogue(path, stadium.a)) as opened, opened.at_one_moment() as catalogue:
        return catalogue.identify(**asked), stadium.a


def _facts(found: "Trajectory") -> list[tuple[str, str]]:
    """Return the sequence, what is before a start apart."""
    back = max(0, 1 - found.first)
    facts = [("before", found.sequence[:back]), ("sequence", found.sequence[back:])]
    return [(name, code_text(symbols)) for name, symbols in facts if symbols]


def _of_shadow(each: "Followed", name: str) -> Any:
    return getattr(each, name) if hasattr(each, name) else getattr(each.orbit, name)


def _note_ends(found: "Trajectory", asked: dict[str, Any]) -> None:
    """Say how far a start was followed, if not as far as it should."""
    if "start" not in asked:
        return
    from orbitdb.trajectories.traces import BOUNCES

    last = found.first + len(found.sequence) - 1
    wanted = asked["bounces"] or BOUNCES
    if last < wanted or found.first > 1 - wanted:
        note(f"followed from bounce {found.first} to {last}: farther, doubles do not tell where it goes")


def _note_count(found: "Trajectory", count: int) -> None:
    """Say how many orbits there are, or why there is none."""
    if found.total:
        more = f"; {count} shown, --limit {found.total} shows all" if count < found.total else ""
        orbits = "orbit is" if found.total == 1 else "orbits are"
        note(f"{found.total} {orbits} shadowed{more}")
    elif found.sequence and set(found.sequence) <= {"0", "2"}:
        note("no orbit: it runs up and down between the walls, with the bouncing-ball family 02")
    else:
        note("no orbit is shadowed for two bounces; a larger --tolerance finds those farther away")


def _show_length(
    length: float,
    tolerance: float | None,
    limit: int | None,
    a: float | None,
    db: Path | None,
    form: Format,
    mark: bool,
) -> int:
    """Write the stored orbits that have a length; return how many there are."""
    from orbitdb.catalogue.gaps import describe_fills
    from orbitdb.numerals import exact
    from orbitdb.orbits.orbit import Status

    names = LENGTH_COLUMNS if form in options.FOR_PEOPLE else LENGTH_KEYS
    most = _ON_SCREEN if limit is None and form is Format.TABLE else limit
    with reading(db, a, Choice()) as (catalogue, chosen):
        note_gaps(catalogue, replace(chosen, statuses=(Status.ORBIT,)))
        found = catalogue.identify(length=length, tolerance=tolerance)
        rows = (tuple(_of_candidate(each, name, chosen.a) for name in names) for each in found[:most])
        count = write(names, with_marks(names, rows) if mark else rows, form)
        fills = catalogue.fills(chosen.a)
        among = describe_fills(fills, chosen.a) if fills else f"single words at a = {exact(chosen.a)}"
    more = f"; {count} shown, --limit {len(found)} shows all" if count < len(found) else ""
    candidates = several(len(found), "candidate") if found else "no candidates"
    if fills or found:  # else another note says that nothing was searched
        note(f"{candidates} among {among}, one a symmetry class{more}; "
             "longer periods may have it, too")  # fmt: skip
    return count


def _of_candidate(each: "Candidate", name: str, a: float) -> Any:
    return a if name == "a" else getattr(each, name)
