"""``orbitdb query``: one word, or rows of the catalogue."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import given_codes, primitive, several
from orbitdb.cli.choice import Choice, with_choice
from orbitdb.cli.options import Format
from orbitdb.cli.reading import all_meant, note_gaps, note_nothing, reading_all
from orbitdb.cli.render import code_text, note, write, write_facts
from orbitdb.cli.rows import KEYS, Row, in_order, with_a, with_marks
from orbitdb.columns import IN_CATALOGUE
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.orbits.orbit import Orbit
    from orbitdb.store.asking.selection import Selection

EXAMPLES = """
Examples:

  orbitdb query 1232131

  orbitdb query --p 2-8 --where "lambda_c < 0.5 and time_reversal = 'self'" --order length -c word,length

  orbitdb query 1232131 --a all

  orbitdb query --p 11 --status orbit --format csv > orbits.csv

The columns: 'orbitdb columns'.
"""

WORD_KEYS = (*KEYS, "coordinates", "stored", "exists")
"""Those of a word that is asked for by its code."""

OF_A_WORD = (*WORD_KEYS, "word", "walls", "born", "dies")
"""All that may be asked of a word, stored or not."""

_OF_CATALOGUE = tuple(each.name for each in IN_CATALOGUE)

OF_ROWS = tuple(name for name in _OF_CATALOGUE if name not in OF_A_WORD)
"""The columns that rows of the catalogue have besides."""

OF_LIVES = {"exists", "born", "dies"}

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


@with_choice
def query(
    *,
    context: typer.Context,
    words: options.Words = None,
    code: options.Codes = None,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    order: Annotated[
        str, options.column_option("--order", help="Columns to sort by; a falling one ends in desc.")
    ] = "p",
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

    A word that is not stored is solved on the spot. The rows are symbol sequences as least
    rotations, of every status but geometric; --status geometric shows those, --status orbit the orbits.
    """
    form = options.chosen(format_, json)
    options.check_marks(mark_words, form)
    if words or code:
        options.takes_only(context, "with --code", "words", "code", "a", "columns", "bounces", "mark_words")
        show = _show_bounces if bounces else _show_words
        show(list(given_codes(words, code)), a, db, columns, form, mark_words)
        return
    if bounces:
        raise InputError("--bounces goes with --code; 'orbitdb export --bounces' writes those of many orbits")
    names = _columns(columns, form, several(a))
    on_screen = form is Format.TABLE and limit is None
    shown = _ON_SCREEN if on_screen else limit
    with reading_all(db, a, choice) as (catalogue, stadiums):
        for chosen in stadiums:
            note_gaps(catalogue, chosen, names=names, order=order)

        def read(
            chosen: "Selection", names: tuple[str, ...], limit: int | None, offset: int
        ) -> Iterator[Row]:
            return catalogue.rows(chosen, names, order, limit, offset)

        rows: Iterator[Any] = in_order(read, stadiums, names, order, shown, offset)
        rows = with_marks(names, rows) if mark_words else rows
        count = write(names, rows, form)
        cut = offset or count == shown
        counted = cut and (form is Format.TABLE or not count)
        total = sum(map(catalogue.count, stadiums)) if counted else count
        if not total:
            for chosen in stadiums:
                note_nothing(catalogue, chosen)
    if total and form is Format.TABLE:
        rest = "" if offset else f", --limit {total} shows all"
        more = f"; {count} shown{rest}" if total > count else ""
        note(f"{stadiums[0].describe([each.a for each in stadiums], total)}{more}")
    if not count:
        raise typer.Exit(1)


def _columns(text: str | None, form: Format, many: bool) -> tuple[str, ...]:
    """Return the columns that are asked for, a among them where there are rows of several."""
    from orbitdb.store.asking.conditions import parse_columns

    usual = TABLE_COLUMNS if form in options.FOR_PEOPLE else KEYS
    names = usual if text is None else parse_columns(text)
    return with_a(names) if many else names


def _show_words(
    codes: list[str], a: list[str] | None, db: Path | None, columns: str | None, form: Format, mark: bool
) -> None:
    from orbitdb.cli.orbit_facts import facts, write_bounces
    from orbitdb.store.reading.lookup import born_with

    in_rows = form in (Format.MARKDOWN, Format.LATEX) or (form is Format.TABLE and several(a))
    keys = _keys(columns, TABLE_COLUMNS if in_rows else WORD_KEYS, codes, a)
    found, catalogue = _find(codes, a, db)
    if OF_LIVES & set(keys):
        found = _with_lives(found)
    if found and form is Format.TABLE and columns is None and not in_rows:
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
    codes: list[str], a: list[str] | None, db: Path | None, columns: str | None, form: Format, mark: bool
) -> None:
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.orbits.bounce_rows import BOUNCE_COLUMNS, bounce_rows

    keys = _keys(columns, ("code",), codes, a)
    found, _ = _find(codes, a, db)
    if OF_LIVES & set(keys):
        found = _with_lives(found)
    rows = (
        (*(_value(orbit, key) for key in keys), *bounce)
        for orbit in found
        for bounce in bounce_rows(Stadium(orbit.a), [orbit.code], [orbit.coordinates])[0]
    )
    names = (*keys, *BOUNCE_COLUMNS)
    count = write(names, with_marks(names, rows) if mark else rows, form)
    for orbit in found:
        if orbit.coordinates is None:
            at = f" at a = {orbit.a:g}" if several(a) else ""
            note(f"{code_text(orbit.code)} has no bounces{at}: {orbit.status.sentence}")
    if not count:
        raise typer.Exit(1)


def _find(codes: list[str], a: list[str] | None, db: Path | None) -> tuple[list["Orbit"], Path | None]:
    """Return what becomes of words at every a, and the catalogue that was asked, if there is one."""
    from orbitdb.store.file.database import check_file, default_path
    from orbitdb.store.reading.lookup import find_or_solve
    from orbitdb.symbols.words import parse

    path = db or default_path()
    values = all_meant(path, a)
    known = None if check_file(path) is None else path
    if known is None and db is not None:
        note(f"no catalogue at {path}: solved on the spot")
    for code in codes:
        parse(code)  # a wrong one ends the command before it prints anything
    words = [primitive(code) for code in codes]
    found = [find_or_solve(known, word, at) for word in words for at in values]
    if not found:
        note("no code on stdin")
    return found, known


def _keys(
    text: str | None, otherwise: tuple[str, ...], codes: list[str], a: list[str] | None
) -> tuple[str, ...]:
    """Read the names of what is known of a word, stored or not."""
    from orbitdb.store.asking.parsing import parse_names

    if text is not None and codes:
        _refuse_of_rows([name.strip() for name in text.split(",")], codes[0], a)
    names = otherwise if text is None else parse_names(text, OF_A_WORD)
    return with_a(names) if several(a) else names


def _refuse_of_rows(names: Sequence[str], code: str, a: list[str] | None) -> None:
    """Refuse columns that only rows have, with the command that shows them of a word."""
    from orbitdb.symbols.words import parse, primitive_root

    asked = [name for name in names if name in OF_ROWS]
    if asked:
        word, at = primitive_root(parse(code)), "".join(f" --a {value}" for value in a or ())
        columns = ",".join(name for name in names if name in _OF_CATALOGUE)
        raise InputError(
            f"column {asked[0]!r} comes with stored rows only: "
            f"orbitdb query --where \"code('{word}')\" -c {columns}{at}"
        )


def _with_lives(found: list["Orbit"]) -> list["Orbit"]:
    """Return words with from where to where in a they are orbits, each followed once at most."""
    from orbitdb.store.reading.lookup import with_existence

    known: dict[str, Any] = {}
    for place, orbit in enumerate(found):
        if orbit.code not in known:
            known[orbit.code] = with_existence(orbit).exists
        found[place] = replace(orbit, exists=known[orbit.code])
    return found


def _value(orbit: "Orbit", key: str) -> Any:
    match key:
        case "coordinates":
            return None if orbit.coordinates is None else orbit.coordinates.tolist()
        case "word":
            return orbit.code
        case "walls":
            return sum(map(orbit.code.count, "02")) if orbit.class_size else None
        case "born":
            return (orbit.exists[0][0] or None) if orbit.exists else None
        case "dies":
            return orbit.exists[0][1] if orbit.exists else None
    return getattr(orbit, key)


def _in_a_cell(orbit: "Orbit", key: str) -> Any:
    """Return a value for a cell, which tells an orbit that never exists from one of which that is unknown."""
    if key == "exists" and orbit.exists is not None:
        return dumps(orbit.exists)
    return _value(orbit, key)


def _told(orbit: "Orbit", key: str) -> Any:
    """Return a value for people: where an orbit exists stands in words."""
    from orbitdb.cli.orbit_facts import lives_text

    if key == "exists" and orbit.exists is not None:
        return lives_text(orbit.exists) or "for no a"
    return _value(orbit, key)
