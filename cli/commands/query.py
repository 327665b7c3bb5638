"""``orbitdb query``, ``columns`` and ``sql``: words, rows, and what the columns mean."""

import shutil
import sys
from collections.abc import Sequence
from dataclasses import replace
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.grids import GivenValues, many_a
from orbitdb.cli.notes import not_shown, note, notes
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.output import ON_SCREEN, Format, Output, code_text, wrap_after, write_facts
from orbitdb.cli.snapshots import OF_CATALOGUE, asked_columns, given_codes, primitive_words, snapshot, solving
from orbitdb.columns import EVERY, GROUPS, IN_CATALOGUE, WRITTEN
from orbitdb.errors import InputError
from orbitdb.text import format_float, guess

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.orbits.orbit import Orbit
    from orbitdb.orbits.status import Status
    from orbitdb.selection import Selection


EXAMPLES = {
    "query": (
        "query 1232131",
        "query --p 2-8 --where \"lambda_c < 0.5 and time_reversal = 'self'\" --order length -c code,length",
        "query 1232131 --a all",
        "query --p 11 --status orbit --format csv > orbits.csv",
    ),
    "sql": (
        "sql \"SELECT p, count(*) AS orbits FROM catalogue WHERE status = 'orbit' GROUP BY a, p\"",
        'sql "SELECT a, length FROM catalogue WHERE code = :word ORDER BY a" --parameter word=0103155 --json',
    ),
    "columns": ("columns", "columns margin quarter_length", "columns --json"),
}

WORD_KEYS = (*WRITTEN, "coordinates", "stored", "exists")
"""Keys shown for a word that is asked for by its code."""

OF_A_WORD = (*WORD_KEYS, "walls", "born", "dies", "reverse", "quarter_signs", "quarter_orientations")
"""Columns that -c accepts for a word, stored or not."""

OF_LIVES = {"exists", "born", "dies"}

TABLE_COLUMNS = ("code", "p", "status", "length", "lambda_d", "lambda_c", "time_reversal")
"""Columns of a table; they fit into 80 characters for periods up to 18."""


def query(
    *,
    context: typer.Context,
    words: options.Words = None,
    code: options.Codes = None,
    a: options.HalfLengths = None,
    choice: SelectionOptions,
    classes: options.Classes = False,
    order: options.Order = "p",
    limit: options.Limit = None,
    offset: Annotated[int, options.count_option(least=0, help="Number of rows to skip.")] = 0,
    columns: options.Columns = None,
    by_bounce: options.ByBounce = False,
    output: Output,
    db: options.Database,
) -> None:
    """Show an orbit by its code, or rows of the catalogue.

    A word that is not stored is solved on the spot. Each row is a word, written as its least rotation. You
    see orbits, unless you choose words of other statuses with --status. 'orbitdb columns' explains the
    columns.
    """
    if words or code:
        options.takes_only(context, "with --code", "words", "code", "a", "columns", "by_bounce")
        if not _show_words(list(given_codes(words, code)), a, db, columns, by_bounce, output):
            raise typer.Exit(1)
        return
    if by_bounce:
        raise InputError(
            "--by-bounce needs WORD; 'orbitdb export --by-bounce' writes the bounces of many orbits"
        )
    with snapshot(db, a, choice) as (catalogue, selections):
        in_table = (*_in_table(_statuses(catalogue, selections, output)), *_sorted_by(order))
        usual = (*(in_table if output.for_people else WRITTEN), *["words"] * classes)
        names = asked_columns(columns, usual, a)
        names = (*names, *_bounds_of(names, output))
        listing = catalogue.rows(
            selections, columns=names, order=order, limit=limit, offset=offset, classes=classes
        )
        notes(listing.notes)
        total = listing.total
        on_screen = output.table and limit is None
        count = output.write(names, listing.head(ON_SCREEN) if on_screen else listing)
        for text in listing.complete:
            note(text)
        if total and output.table:
            note(f"{listing.describe(total)}{not_shown(count, total, remedy=not offset)}")
    if not count and not (total and limit == 0):
        raise typer.Exit(1)


def _bounds_of(names: Sequence[str], output: Output) -> list[str]:
    """Return the columns with the bounds of the named ones if --uncertainty needs them."""
    bounds = [f"{name}_error" for name in names] if output.uncertainty else []
    return [name for name in bounds if name in OF_CATALOGUE and name not in names]


def _statuses(
    catalogue: "Catalogue", selections: "Sequence[Selection]", output: Output
) -> "Sequence[Status]":
    """Return the chosen statuses or, for a table of words of every status, those that the words have."""
    from orbitdb.orbits.status import STORED, Status

    if output.for_people and selections[0].statuses in ((), STORED):
        return [*map(Status, catalogue.count(selections, by="status").columns.get("status", ()))]
    return selections[0].statuses


def _in_table(statuses: "Sequence[Status]") -> tuple[str, ...]:
    """Return the columns of a table of words with these statuses, without those that none of them has."""
    from orbitdb.orbits.status import Status

    if set(statuses) == {Status.GEOMETRIC}:
        return ("code", "p", "status", "rules")
    if statuses and not {*statuses} & {Status.ORBIT, Status.BOUNDARY}:
        return ("code", "p", "status", "margin", "born", "time_reversal")
    return TABLE_COLUMNS


def _sorted_by(order: str) -> list[str]:
    """Return the columns of an order that a table does not show by default, without unknown ones."""
    named = (part.strip().removeprefix("-").partition(" ")[0] for part in order.split(","))
    usual = {*TABLE_COLUMNS, "a"}
    return [name for name in dict.fromkeys(named) if name in OF_CATALOGUE and name not in usual]


def _show_words(
    codes: list[str],
    a: list[GivenValues] | None,
    db: Path,
    columns: str | None,
    by_bounce: bool,
    output: Output,
) -> int:
    """Write what is known about the given words, or their bounces; return the number of rows or words."""
    from orbitdb.cli.orbit_facts import facts, write_bounces

    in_rows = columns is not None or not output.table or many_a(a)
    usual = ("code",) if by_bounce else TABLE_COLUMNS if in_rows and output.for_people else WORD_KEYS
    keys = asked_columns(columns, usual, a, OF_A_WORD)
    keys = (*keys, *(() if by_bounce else _bounds_of(keys, output)))
    words = primitive_words(codes)
    with solving(db, a) as (catalogue, values):
        asked = [catalogue.orbit(words, a=at) for at in values]
        orbits = [orbit for at_every_a in zip(*asked, strict=True) for orbit in at_every_a]
        if OF_LIVES & set(keys):
            alive = catalogue.orbit(words, a=values[0], exists=True)
            lives = {orbit.code: orbit.exists for orbit in alive}
            orbits = [replace(orbit, exists=lives[orbit.code]) for orbit in orbits]
        partners = [] if in_rows or by_bounce else [catalogue.born_with(orbit) for orbit in orbits]
    if not orbits:
        note("stdin contains no code")
    if by_bounce:
        return _show_bounces(keys, orbits, many_a(a), output)
    if in_rows:
        return output.write(keys, ([_value(orbit, key, output) for key in keys] for orbit in orbits))
    for orbit, born_with in zip(orbits, partners, strict=True):
        if orbit is not orbits[0]:
            print()
        write_facts(facts(orbit, born_with, output=output))
        write_bounces(orbit)
    return len(orbits)


def _show_bounces(keys: Sequence[str], orbits: "Sequence[Orbit]", many: bool, output: Output) -> int:
    from orbitdb.orbits.bounces import BOUNCE_COLUMNS, bounce_by_bounce

    shown = (*keys, "a", "code", "coordinates")
    rows = ([_value(orbit, key) for key in shown] for orbit in orbits)
    count = output.write((*keys, *BOUNCE_COLUMNS), bounce_by_bounce(rows))
    for orbit in orbits:
        if orbit.coordinates is None:
            at = f" at a = {format_float(orbit.a)}" if many else ""
            note(f"{code_text(orbit.code)} has no bounces{at}: {orbit.status.sentence}")
    return count


def _value(orbit: "Orbit", key: str, output: Output | None = None) -> Any:
    """Return the value of a key for a word; with `output`, in the form that its format needs."""
    from orbitdb.symbols.words import least_rotation

    match key:
        case "exists" if orbit.exists is not None and output is not None:
            from orbitdb.cli.orbit_facts import lives_text

            if output.for_people:
                return lives_text(orbit.exists) or "for no a"
            return dumps(orbit.exists) if output.form in (Format.CSV, Format.TSV) else orbit.exists
        case "coordinates":
            return None if orbit.coordinates is None else orbit.coordinates.tolist()
        case "reverse":
            return least_rotation(orbit.reverse().code)
        case "walls":
            return orbit.walls if orbit.class_size else None
        case "born":
            return (orbit.exists[0][0] or None) if orbit.exists else None
        case "dies":
            return orbit.exists[0][1] if orbit.exists else None
    return getattr(orbit, key)


def _known(incomplete: str) -> list[tuple[str, str]]:
    """Offer the columns that begin with what is typed."""
    return [(name, column.brief) for name, column in EVERY.items() if name.startswith(incomplete)]


COLUMN_KEYS = ("column", "of", "type", "unit", "bound", "empty", "means")


def columns(
    *,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[COLUMN]...", help="Columns to explain [default: all].", autocompletion=_known
        ),
    ] = None,
    output: Output,
) -> None:
    """Explain the columns: their units, the bounds on their errors, and their meanings.

    -c, --order and --where accept the columns of words and orbits, and --by-bounce writes the columns of
    bounces. query --code adds columns of its own. identify has different columns for a trajectory and for a
    length. The error of a number never exceeds its bound.
    """
    for name in names or ():
        if name not in EVERY:
            raise InputError(f"column {name!r}: {guess(name, EVERY)}'orbitdb columns' lists all")
    every = [(column, of) for of, group in GROUPS for column in group]
    described = [(column, of) for column, of in every if not names or column.name in names]
    if output.table:
        lines = [(column.name, column.unit, column.bound, column.means) for column, _ in described]
        _write_table(lines, sum(column in IN_CATALOGUE for column, _ in described))
        return
    rows = (
        (column.name, of, column.kind, column.unit, column.bound, column.empty, column.means)
        for column, of in described
    )
    output.write(COLUMN_KEYS, rows)


def _write_table(rows: Sequence[tuple[str, ...]], first: int) -> None:
    """Write one line per column, with its meaning wrapped, and an empty line after the `first` ones."""
    lines = [("column", "unit", "bounded by", "means"), *rows]
    widths = [max(len(line[k]) for line in lines) for k in range(3)]
    columns = shutil.get_terminal_size().columns
    for place, (*cells, means) in enumerate(lines):
        if place == 1 + first and first:
            sys.stdout.write("\n")
        start = "".join(f"{text.ljust(width)}  " for text, width in zip(cells, widths, strict=True))
        sys.stdout.writelines(wrap_after(start, means, columns))


def sql(
    *,
    statement: Annotated[str, typer.Argument(metavar="SELECT", help="One SELECT statement, in quotes.")],
    parameters: options.Parameters = None,
    output: Output,
    db: options.Database,
) -> None:
    """Run one SELECT statement on the catalogue, over all values of a.

    The statement can read the views catalogue (one row per word; see 'orbitdb columns'), class (one row per
    class) and life (births and deaths). It cannot write, and is stopped after a minute. code =
    code('310') finds a word in any rotation, and contains(code, '0202') the words that contain 0202 in any
    rotation.
    """
    from orbitdb.catalogue import Catalogue
    from orbitdb.sql_text import parse_parameters

    with Catalogue(db).snapshot() as then:
        answer = then.sql(statement, parse_parameters(parameters or (), statement))
        names = answer.columns
        if not output.write(names, answer):
            note(answer.absent)
            raise typer.Exit(1)
