"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import sys
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.options import USUAL_A
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import averaged, meant, reading
from orbitdb.cli.render import code_text, note
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit

EXAMPLES = """
Examples:

  orbitdb plot orbit --code 1232131 --a 1.2 -o orbit.pdf

  orbitdb plot entropy --p 2-11 -o entropy.svg

  orbitdb plot life --code 010203113 -o life.svg

  orbitdb plot birkhoff --p 2-8 --reversal self -o phase-space.png

The figures: orbit, its path in the stadium (Fig. 1 of the paper); reverse, an orbit and its time
reverse (Fig. 4); entropy (Fig. 5) and lyapunov (Fig. 6) against the period, and with --over-a the proved
bounds on the entropy that 'orbitdb bounds' has found against a; sheet, all classes of a
period; birkhoff, the bounces in phase space; lengths, the length spectrum; births, how many words are
orbits at every a, from what 'orbitdb births' has found; life, an orbit at its birth, and its length and
lambda over a.
"""


class Kind(StrEnum):
    """The figures."""

    ORBIT = "orbit"
    REVERSE = "reverse"
    ENTROPY = "entropy"
    LYAPUNOV = "lyapunov"
    SHEET = "sheet"
    BIRKHOFF = "birkhoff"
    LENGTHS = "lengths"
    BIRTHS = "births"
    LIFE = "life"


_OF_CLASSES = (Kind.ENTROPY, Kind.LYAPUNOV, Kind.LENGTHS)
"""Figures of averages, and of the lengths that they are made of."""


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(plot)


@options.with_choice
def plot(
    *,
    context: typer.Context,
    kind: Annotated[Kind, typer.Argument(help="What to draw.")],
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Ends in .png, .svg or .pdf; -: stdout, with --format."
        ),
    ],
    code: Annotated[
        str | None, typer.Option("--code", help="The word, for orbit, reverse and life; stored or not.")
    ] = None,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    over_a: Annotated[bool, typer.Option("--over-a", help="The entropy against a, not the period.")] = False,
    limit: Annotated[int, options.count_option("--limit", least=1, help="Orbits on a sheet at most.")] = 120,
    form: Annotated[
        str | None, typer.Option("--format", help="png, svg or pdf, whatever the name ends in.")
    ] = None,
    force: options.Force = False,
    db: options.Database = None,
) -> None:
    """Draw an orbit, or a figure of the chosen subset, into a file."""
    from orbitdb.export import STDOUT, check_ending, check_target, complete

    to_stdout = output == STDOUT
    if to_stdout:
        options.refuse_idle(context, "on stdout", "force")
    else:
        check_target(output, force)
    ending = check_ending(output, form)
    from orbitdb.cli import figures  # not before: matplotlib takes its time
    from orbitdb.plots import style

    if kind in (Kind.ORBIT, Kind.REVERSE):
        options.takes_only(context, f"in plot {kind}", "kind", "output", "code", "a")
        if code is None:
            raise InputError(f"name the orbit to draw: plot {kind} --code 1232131")
        found = _orbit(code, a, db)
        made = figures.draw_orbit(found) if kind is Kind.ORBIT else figures.draw_reverse(found)
        said = f"orbit {code_text(found.code)} at a = {found.a:g}"
    elif kind is Kind.LIFE:
        from orbitdb.cli.birth_figures import draw_life

        options.takes_only(context, f"in plot {kind}", "kind", "output", "code")
        options.refuse_idle(context, f"in plot {kind}", "db")
        if code is None:
            raise InputError(f"name the orbit to draw: plot {kind} --code 1232131")
        with progress("following"):
            made = draw_life(found := _followed(code))
        said = f"life of {code_text(found.code)}"
    elif kind is Kind.BIRTHS:
        from orbitdb.cli.birth_figures import draw_births

        options.takes_only(context, f"in plot {kind}", "kind", "output", "p")
        with progress("drawing"), reading(db, USUAL_A, options.Choice(p=choice.p)) as (catalogue, chosen):
            made = draw_births(catalogue, chosen)
        said = "births and deaths of orbits"
    elif over_a:
        from orbitdb.cli.entropy_figures import draw_over_a

        if kind is not Kind.ENTROPY:
            raise InputError(f"--over-a does nothing in plot {kind}: leave it out")
        options.takes_only(context, "with --over-a", "kind", "output", "p", "over_a")
        with progress("drawing"), reading(db, USUAL_A, options.Choice(p=choice.p)) as (catalogue, chosen):
            made = draw_over_a(catalogue, chosen)
        said = "topological entropy over a"
    else:
        options.refuse_idle(context, f"in plot {kind}", "code", *[] if kind is Kind.SHEET else ["limit"])
        choice = averaged(choice) if kind in _OF_CLASSES else choice
        wanted = replace(choice, status="orbit" if choice.status is None else choice.status)
        with progress("drawing"), reading(db, a, wanted) as (catalogue, chosen):
            made = figures.OF_SUBSETS[kind.value](catalogue, chosen, limit)
        said = str(made.get_label()) or chosen.describe()  # it may show less
    if to_stdout:
        sys.stdout.buffer.write(style.as_bytes(made, ending, said))
        return
    with progress("drawing"), complete(output) as draft:
        style.save(made, draft, ending, said)
    note(f"{said}, in {output}")


def _followed(code: str) -> "Orbit":
    """Return a word with from where to where in a it is an orbit.

    Raises
    ------
    InputError
        If it never is one, or is too long to be followed.
    """
    from orbitdb.cli.codes import primitive
    from orbitdb.orbits.newton import solve_word
    from orbitdb.store.reading.one_word import with_existence

    found = with_existence(solve_word(primitive(code), USUAL_A))
    if found.exists is None:
        raise InputError(f"{code_text(found.code)} is too long to be followed in a")
    if not found.exists:
        raise InputError(f"{code_text(found.code)} has no life: {found.status.sentence}")
    return found


def _orbit(code: str, a: float | None, db: Path | None) -> "Orbit":
    """Return the orbit of a word, stored or solved on the spot.

    Raises
    ------
    InputError
        If it has none.
    """
    from orbitdb.cli.codes import primitive
    from orbitdb.store.file.database import check_file, default_path
    from orbitdb.store.reading.one_word import find_or_solve
    from orbitdb.symbols.words import parse, primitive_root

    path = db or default_path()
    at = meant(path, a)
    found = find_or_solve(None if check_file(path) is None else path, primitive_root(parse(code)), at)
    if found.coordinates is None:
        raise InputError(f"{code_text(found.code)} at a = {at:g} cannot be drawn: {found.status.sentence}")
    primitive(code)  # tells of a code that repeats a shorter one
    return found
