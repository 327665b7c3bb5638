"""``orbitdb query``: one word, or rows of the catalogue."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.codes import given_codes, primitive
from orbitdb.cli.options import Format
from orbitdb.cli.reading import meant, note_gaps, note_nothing, reading
from orbitdb.cli.render import note, write, write_facts
from orbitdb.cli.rows import KEYS, with_rules

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit

EXAMPLES = """
Examples:

  orbitdb query --code 1232131

  orbitdb query --p 2-8 --where "lambda_c < 0.5 and time_reversal = 'self'" --order length -c word,length

  orbitdb query --p 11 --status orbit --format csv > orbits.csv
"""

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
    code: Annotated[
        list[str] | None,
        typer.Option(
            "--code", help="A word in any rotation, stored or not; repeatable; - reads lines of stdin."
        ),
    ] = None,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    order: Annotated[
        str, typer.Option("--order", help="Columns to sort by; a falling one ends in desc.")
    ] = "p,code",
    limit: Annotated[
        int | None,
        options.count_option(
            "--limit", least=0, help=f"Rows at most [default: {_ON_SCREEN} in a table, else all]."
        ),
    ] = None,
    offset: Annotated[int, options.count_option("--offset", least=0, help="Rows to pass over first.")] = 0,
    columns: Annotated[
        str | None, typer.Option("-c", "--columns", help="Columns to show, with commas between.")
    ] = None,
    format_: options.OutputFormat = Format.TABLE,
    json: options.Json = False,
    db: options.Database = None,
) -> None:
    """Ask for an orbit by its code, or for rows of the catalogue.

    A word that is not stored is solved on the spot. The rows are symbol sequences of every status,
    as least rotations; --status orbit leaves the orbits.
    """
    form = options.chosen(format_, json)
    if code:
        options.takes_only(context, "with --code", "code", "a", "columns")
        _show_words(list(given_codes(code)), a, db, columns, form)
        return
    names = _columns(columns, form)
    on_screen = form is Format.TABLE and limit is None
    shown = _ON_SCREEN if on_screen else limit
    with reading(db, a, choice) as (catalogue, chosen):
        note_gaps(catalogue, chosen, names=names, order=order)
        rows = catalogue.rows(chosen, names, order, shown, offset)
        count = write(names, with_rules(names, rows), form)
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
    return TABLE_COLUMNS if form is Format.TABLE else KEYS


def _show_words(
    codes: list[str], a: float | None, db: Path | None, columns: str | None, form: Format
) -> None:
    from orbitdb.cli.word import facts, write_bounces
    from orbitdb.filling.single_word import born_with, find_or_solve, with_existence
    from orbitdb.store.file.database import check_file, default_path
    from orbitdb.symbols.words import parse

    keys = WORD_KEYS if columns is None else _keys(columns)
    path = db or default_path()
    at = meant(path, a)
    if check_file(path) is None:
        if db is not None:
            note(f"no catalogue at {path}: solved on the spot")
        known = None
    else:
        known = path
    for code in codes:
        parse(code)  # so that a wrong one is all that is told
    found = [find_or_solve(known, primitive(code), at) for code in codes]
    if "exists" in keys:
        found = [with_existence(orbit) for orbit in found]
    if found and form is Format.TABLE and columns is None:
        for orbit in found:
            write_facts(facts(orbit, born_with(known, orbit)))
            write_bounces(orbit)
        return
    write(keys, ([_value(orbit, key) for key in keys] for orbit in found), form)
    if not found:
        note("no code on stdin")
        raise typer.Exit(1)


def _keys(text: str) -> tuple[str, ...]:
    """Read the names of what is known of a word, stored or not."""
    from orbitdb.store.asking.conditions import parse_names

    return parse_names(text, (*WORD_KEYS, "symmetry", "length_error", "lyapunov_error"))


def _value(orbit: "Orbit", key: str) -> Any:
    value = getattr(orbit, key)
    return value.tolist() if key == "coordinates" and value is not None else value
