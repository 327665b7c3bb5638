"""``orbitdb plot``: figures as PNG, SVG or PDF."""

import sys
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.choice import Choice
from orbitdb.cli.options import USUAL_A
from orbitdb.cli.progress.line import progress
from orbitdb.cli.reading import averaged, known_catalogue, meant, reading
from orbitdb.cli.render import code_text, note
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit

EXAMPLES = """
Examples:

  orbitdb plot orbit 1232131 --a 1.2 -o orbit.pdf

  orbitdb plot entropy --p 2-11 -o entropy.svg

  orbitdb plot life 010203113 -o life.svg

  orbitdb plot birkhoff --p 2-8 --reversal self -o phase-space.png

\b
Figures:
  orbit     the path of WORD in the stadium (Fig. 1 of the paper)
  reverse   WORD above its time reverse (Fig. 4)
  life      WORD at its birth, its length and its lambda for every a
  entropy   by period (Fig. 5); with --over-a the proved bounds for every a
  lyapunov  by period (Fig. 6)
  sheet     all classes of a period
  birkhoff  the bounces in phase space
  lengths   how many orbits are no longer than L, and their density
  births    how many words are orbits at every a ('orbitdb births' first)
  spectrum  the length spectrum of levels beside that of the orbits
  staircase the number of levels, and its fluctuations ('orbitdb levels' first)
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
    SPECTRUM = "spectrum"
    STAIRCASE = "staircase"


_OF_CLASSES = (Kind.ENTROPY, Kind.LYAPUNOV, Kind.LENGTHS)
"""Figures of averages, and of the lengths that they are made of."""


def plot(
    *,
    context: typer.Context,
    kind: Annotated[Kind, typer.Argument(help="What to draw.")],
    words: options.Words = None,
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Ends in .png, .svg or .pdf; -: stdout, with --format."
        ),
    ],
    code: options.Codes = None,
    a: options.StoredHalfLength = None,
    choice: Choice,
    over_a: Annotated[bool, typer.Option("--over-a", help="The entropy against a, not the period.")] = False,
    limit: Annotated[int, options.count_option("--limit", least=1, help="Orbits on a sheet at most.")] = 120,
    form: Annotated[
        str | None, typer.Option("--format", help="png, svg or pdf, whatever the name ends in.")
    ] = None,
    force: options.Force = False,
    db: options.Database = None,
) -> None:
    """Draw an orbit, or a figure of the chosen subset, into a file.

    orbit, reverse and life draw the orbit of one WORD.
    """
    from orbitdb.export import FIGURES, STDOUT, check_target, complete, form_of

    to_stdout = output == STDOUT
    if to_stdout:
        options.refuse_idle(context, "on stdout", "force")
    else:
        check_target(output, force)
    ending = form_of(output, form, FIGURES)
    from orbitdb.cli.figures import orbits, subsets  # not before: matplotlib takes its time
    from orbitdb.plots import style

    if kind in (Kind.ORBIT, Kind.REVERSE):
        options.takes_only(context, f"in plot {kind}", "kind", "output", "words", "code", "a")
        found = _orbit(_one_code(kind, words, code), a, db)
        made = orbits.draw_orbit(found) if kind is Kind.ORBIT else orbits.draw_reverse(found)
        said = f"orbit {code_text(found.code)} at a = {found.a:g}"
    elif kind is Kind.LIFE:
        from orbitdb.cli.figures.over_a import draw_life

        options.takes_only(context, f"in plot {kind}", "kind", "output", "words", "code")
        options.refuse_idle(context, f"in plot {kind}", "db")
        asked = _one_code(kind, words, code)
        with progress("following"):
            made = draw_life(found := _followed(asked))
        said = f"life of {code_text(found.code)}"
    elif kind is Kind.BIRTHS:
        from orbitdb.cli.figures.over_a import draw_births

        options.takes_only(context, f"in plot {kind}", "kind", "output", "p")
        with progress("drawing"), reading(db, USUAL_A, Choice(p=choice.p)) as (catalogue, chosen):
            made = draw_births(catalogue, chosen)
        said = "births and deaths of orbits"
    elif kind in (Kind.SPECTRUM, Kind.STAIRCASE):
        from orbitdb.cli.figures.levels import draw_length_spectrum, draw_levels

        options.takes_only(context, f"in plot {kind}", "kind", "output", "a")
        with progress("drawing"), reading(db, a, Choice()) as (catalogue, chosen):
            draw = draw_length_spectrum if kind is Kind.SPECTRUM else draw_levels
            made = draw(catalogue, chosen)
        said = str(made.get_label())
    elif over_a:
        from orbitdb.cli.figures.over_a import draw_over_a

        if kind is not Kind.ENTROPY:
            raise InputError(f"--over-a does nothing in plot {kind}: leave it out")
        options.takes_only(context, "with --over-a", "kind", "output", "p", "over_a")
        with progress("drawing"), reading(db, USUAL_A, Choice(p=choice.p)) as (catalogue, chosen):
            made = draw_over_a(catalogue, chosen)
        said = "topological entropy over a"
    else:
        idle = ("words", "code") if kind is Kind.SHEET else ("words", "code", "limit")
        options.refuse_idle(context, f"in plot {kind}", *idle)
        choice = averaged(choice) if kind in _OF_CLASSES else choice
        wanted = replace(choice, status="orbit" if choice.status is None else choice.status)
        with progress("drawing"), reading(db, a, wanted) as (catalogue, chosen):
            made = subsets.OF_SUBSETS[kind.value](catalogue, chosen, limit)
        said = str(made.get_label()) or chosen.describe()  # it may show less
    if to_stdout:
        sys.stdout.buffer.write(style.as_bytes(made, ending, said))
        return
    with progress("drawing"), complete(output) as draft:
        style.save(made, draft, ending, said)
    note(f"{said}, in {output}")


def _one_code(kind: Kind, words: list[str] | None, code: list[str] | None) -> str:
    """Return the only code that is given.

    Raises
    ------
    InputError
        If there is none, or another.
    """
    from orbitdb.cli.arguments import given_codes

    codes = list(given_codes(words, code))
    if len(codes) != 1:
        raise InputError(f"name one orbit to draw: plot {kind} 1232131")
    return codes[0]


def _followed(code: str) -> "Orbit":
    """Return a word with from where to where in a it is an orbit.

    Raises
    ------
    InputError
        If it never is one, or is too long to be followed.
    """
    from orbitdb.cli.arguments import primitive
    from orbitdb.orbits.newton import solve_word
    from orbitdb.store.reading.lookup import with_existence

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
    from orbitdb.cli.arguments import primitive
    from orbitdb.store.file.database import default_path
    from orbitdb.store.reading.lookup import find_or_solve

    at = meant(db or default_path(), a)
    found = find_or_solve(known_catalogue(db), primitive(code), at)
    if found.coordinates is None:
        raise InputError(f"{code_text(found.code)} at a = {at:g} cannot be drawn: {found.status.sentence}")
    return found
