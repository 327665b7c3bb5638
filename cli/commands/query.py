"""``orbitdb query``: one word, or rows of the catalogue."""

from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.codes import given_codes, primitive
from orbitdb.cli.options import Format
from orbitdb.cli.reading import meant, note_gaps, note_nothing, reading
from orbitdb.cli.render import code_text, note, write, write_facts
from orbitdb.cli.rows import COLUMNS_HELP, KEYS, lines_or_rows, with_marks
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit

EXAMPLES = (
    """
Examples:

  orbitdb query 1232131

  orbitdb query --p 2-8 --where "lambda_c < 0.5 and time_reversal = 'self'" --order length -c word,length

  orbitdb query --p 11 --status orbit --format csv > orbits.csv

"""
    + COLUMNS_HELP
)

WORD_KEYS = (*KEYS, "coordinates", "stored", "exists")
"""Those of a word that is asked for by its code."""

TABLE_COLUMNS = (
    "code",
    "p",
    "status",
    "length",
    "lyapunov",
    "lambda_d",
    "lambda_c",
    "time_reversal",
    "class_size",
)
_ON_SCREEN = 40


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(query)


@options.with_choice
def query(
    *,
    context: typer.Context,
    words: Annotated[
        list[str] | None, typer.Argument(metavar="[WORD]...", help="The same as --code WORD.")
    ] = None,
    code: Annotated[
        list[str] | None,
        typer.Option(
            "--code", help="A word in any rotation, stored or not; repeatable; - reads lines of stdin."
        ),
    ] = None,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    order: Annotated[
        str, options.column_option("--order", help="Columns to sort by; a falling one ends in desc.")
    ] = "p,code",
    limit: Annotated[
        int | None,
        options.count_option(
            "--limit", least=0, help=f"Rows at most [default: {_ON_SCREEN} in a table, else all]."
        ),
    ] = None,
    offset: Annotated[int, options.count_option("--offset", least=0, help="Rows to pass over first.")] = 0,
    columns: Annotated[
        str | None, options.column_option("-c", "--columns", help="Columns to show, with commas between.")
    ] = None,
    bounces: Annotated[
        bool, typer.Option("--bounces", help="With --code, one row a bounce: x, y, arc length, sine.")
    ] = False,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    mark_words: options.MarkWords = False,
    db: options.Database = None,
) -> None:
    """Ask for an orbit by its code, or for rows of the catalogue.

    A word that is not stored is solved on the spot. The rows are symbol sequences of every status,
    as least rotations; --status orbit leaves the orbits.
    """
    form = options.chosen(format_, json)
    options.check_marks(mark_words, form)
    if asked := [*(words or ()), *(code or ())]:
        options.takes_only(context, "with --code", "words", "code", "a", "columns", "bounces", "mark_words")
        show = _show_bounces if bounces else _show_words
        show(list(given_codes(asked)), a, db, columns, form, mark_words)
        return
    if bounces:
        raise InputError("--bounces goes with --code; 'orbitdb export --bounces' writes those of many orbits")
    names = _columns(columns, form)
    on_screen = form is Format.TABLE and limit is None
    shown = _ON_SCREEN if on_screen else limit
    with reading(db, a, choice) as (catalogue, chosen):
        note_gaps(catalogue, chosen, names=names, order=order)
        rows = lines_or_rows(catalogue, chosen, names, order, form, mark_words, shown, offset)
        count = write(names, rows, form)
        cut = offset or count == shown
        total = catalogue.count(chosen) if cut and (form is Format.TABLE or not count) else count
        if not total:
            note_nothing(catalogue, chosen)
    if total and form is Format.TABLE:
        rest = "" if offset else f", --limit {total} shows all"
        more = f"; {count} shown{rest}" if total > count else ""
        note(f"{total} {chosen.describe()}{more}")
    if not count:
        raise typer.Exit(1)


def _columns(text: str | None, form: Format) -> tuple[str, ...]:
    from orbitdb.store.asking.conditions import parse_columns

    if text is not None:
        return parse_columns(text)
    return TABLE_COLUMNS if form in options.FOR_PEOPLE else KEYS


def _show_words(
    codes: list[str], a: float | None, db: Path | None, columns: str | None, form: Format, mark: bool
) -> None:
    from orbitdb.cli.word import facts, write_bounces
    from orbitdb.filling.single_word import born_with, with_existence

    keys = _keys(columns, TABLE_COLUMNS if form in (Format.MARKDOWN, Format.LATEX) else WORD_KEYS)
    found, catalogue = _find(codes, a, db)
    if "exists" in keys:
        found = [with_existence(orbit) for orbit in found]
    if found and form is Format.TABLE and columns is None:
        for orbit in found:
            write_facts(facts(orbit, born_with(catalogue, orbit)))
            write_bounces(orbit)
        return
    separated = _in_a_cell if form in (Format.CSV, Format.TSV) else _value
    value = _told if form in options.FOR_PEOPLE else separated
    rows = (tuple(value(orbit, key) for key in keys) for orbit in found)
    write(keys, with_marks(keys, rows) if mark else rows, form)
    if not found:
        raise typer.Exit(1)


def _show_bounces(
    codes: list[str], a: float | None, db: Path | None, columns: str | None, form: Format, mark: bool
) -> None:
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.orbits.bounce_rows import BOUNCE_COLUMNS, bounce_rows

    keys = _keys(columns, ("code",))
    found, _ = _find(codes, a, db)
    rows = (
        (*(_value(orbit, key) for key in keys), *bounce)
        for orbit in found
        for bounce in bounce_rows(Stadium(orbit.a), [orbit.code], [orbit.coordinates])[0]
    )
    names = (*keys, *BOUNCE_COLUMNS)
    count = write(names, with_marks(names, rows) if mark else rows, form)
    for orbit in found:
        if orbit.coordinates is None:
            note(f"{code_text(orbit.code)} has no bounces: {orbit.status.sentence}")
    if not count:
        raise typer.Exit(1)


def _find(codes: list[str], a: float | None, db: Path | None) -> tuple[list["Orbit"], Path | None]:
    """Return what becomes of words, and the catalogue that was asked, if there is one."""
    from orbitdb.filling.single_word import find_or_solve
    from orbitdb.store.file.database import check_file, default_path
    from orbitdb.symbols.words import parse

    path = db or default_path()
    at = meant(path, a)
    known = None if check_file(path) is None else path
    if known is None and db is not None:
        note(f"no catalogue at {path}: solved on the spot")
    for code in codes:
        parse(code)  # so that a wrong one is all that is told
    found = [find_or_solve(known, primitive(code), at) for code in codes]
    if not found:
        note("no code on stdin")
    return found, known


def _keys(text: str | None, otherwise: tuple[str, ...]) -> tuple[str, ...]:
    """Read the names of what is known of a word, stored or not."""
    from orbitdb.store.asking.conditions import parse_names

    return otherwise if text is None else parse_names(text, WORD_KEYS)


def _value(orbit: "Orbit", key: str) -> Any:
    value = getattr(orbit, key)
    return value.tolist() if key == "coordinates" and value is not None else value


def _in_a_cell(orbit: "Orbit", key: str) -> Any:
    """Return a value for a cell, which tells an orbit that never exists from one of which that is unknown."""
    if key == "exists" and orbit.exists is not None:
        return dumps(orbit.exists)
    return _value(orbit, key)


def _told(orbit: "Orbit", key: str) -> Any:
    """Return a value for people, who are told in words where an orbit exists."""
    from orbitdb.cli.word import lives_text

    if key == "exists" and orbit.exists is not None:
        return lives_text(orbit.exists) or "for no a"
    return _value(orbit, key)
