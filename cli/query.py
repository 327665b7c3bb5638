"""``orbitdb query``: one word, or rows of the catalogue."""

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options
from orbitdb.cli.options import Format
from orbitdb.cli.reading import meant, note_gaps, note_nothing, reading
from orbitdb.cli.render import LONG_CODE, code_text, note, number, repeats, write, write_facts
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.orbits import Orbit

EXAMPLES = """
Examples:

  orbitdb query --code 1232131

  orbitdb query --p 2-8 --where "lambda_c < 0.5 and time_reversal = 'self'" --order length -c word,length

  orbitdb query --p 11 --status orbit --format csv > orbits.csv
"""

KEYS = (
    "code", "representative", "a", "p", "status", "rules", "length", "lyapunov", "lambda_d", "lambda_c",
    "time_reversal", "class_size", "margin", "residual", "error",
)  # fmt: skip
"""The keys of JSON output that other programs may rely on."""

WORD_KEYS = (*KEYS, "coordinates", "stored")
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
        note_gaps(catalogue, chosen)
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
    from orbitdb.store.selecting import parse_columns

    if text is not None:
        return parse_columns(text)
    return TABLE_COLUMNS if form is Format.TABLE else KEYS


def with_rules(names: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> Iterator[tuple[Any, ...]]:
    """Give the rules broken as a list of numbers."""
    from orbitdb.store.selecting import rules_of

    if "rules" not in names:
        yield from rows
        return
    place = names.index("rules")
    for row in rows:
        yield (*row[:place], rules_of(row[place]), *row[place + 1 :])


def given_codes(codes: Iterable[str]) -> Iterator[str]:
    """Return the codes given, the lines of stdin in the place of ``-``, without checking them."""
    try:
        for code in codes:
            if code == "-":
                yield from (line.strip() for line in sys.stdin or () if line.strip())
            else:
                yield code
    except UnicodeDecodeError:
        raise InputError("stdin is not text: write one code a line") from None


def primitive(code: str) -> str:
    """Read a code; where it repeats a shorter word, say so and return that."""
    from orbitdb.words import parse, primitive_root

    word = parse(code)
    root = primitive_root(word)
    if root != word:
        note(repeats(word, root))
    return root


def _show_words(
    codes: list[str], a: float | None, db: Path | None, columns: str | None, form: Format
) -> None:
    from orbitdb import single
    from orbitdb.store.database import check_file, default_path
    from orbitdb.words import parse

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
    found = [single.find(known, primitive(code), at) for code in codes]
    if found and form is Format.TABLE and columns is None:
        for orbit in found:
            write_facts(_facts(orbit))
            _write_bounces(orbit)
        return
    write(keys, ([_value(orbit, key) for key in keys] for orbit in found), form)
    if not found:
        note("no code on stdin")
        raise typer.Exit(1)


def _keys(text: str) -> tuple[str, ...]:
    """Read the names of what is known of a word, stored or not."""
    from orbitdb.store.selecting import parse_names

    return parse_names(text, (*WORD_KEYS, "symmetry", "length_error", "lyapunov_error"))


def _value(orbit: "Orbit", key: str) -> Any:
    value = getattr(orbit, key)
    return value.tolist() if key == "coordinates" and value is not None else value


def _facts(orbit: "Orbit") -> list[tuple[str, str]]:
    """Return what is known of a word, name by name, in words."""
    from orbitdb.pruning import RULES
    from orbitdb.words import run_notation

    code = orbit.code if orbit.p <= _ON_SCREEN else run_notation(orbit.code)
    facts = [
        ("code", code),
        ("a", f"{orbit.a:g}"),
        ("period", str(orbit.p)),
        ("status", orbit.status.sentence),
    ]
    facts += [(f"  rule {rule.number}", rule.sentence) for rule in RULES if rule.number in orbit.rules]
    if orbit.rules or orbit.length is None:
        return facts + ([("margin", number("margin", orbit.margin))] if orbit.margin is not None else [])
    errors = {"length": orbit.length_error, "lyapunov": orbit.lyapunov_error}
    for name in ("length", "lyapunov", "lambda_d", "lambda_c", "margin", "residual", "error"):
        bound = f" +- {errors[name]:.0e}" if errors.get(name) is not None else ""
        facts.append(
            (name, (_exact(getattr(orbit, name)) if bound else number(name, getattr(orbit, name))) + bound)
        )
    least = code_text(orbit.representative)
    reversal = "retraces its path" if orbit.time_reversal == "self" else "its reverse is another orbit"
    facts += [
        ("time reversal", reversal),
        (
            "class",
            f"{orbit.class_size} sequences, least {least}, symmetry {orbit.symmetry}",
        ),
        ("stored", "yes" if orbit.stored else "no: solved on the spot"),
    ]
    return facts


def _exact(value: float) -> str:
    return f"{value:.14g}"


def _write_bounces(orbit: "Orbit") -> None:
    """Write the bounces one by one, if a screen can hold them."""
    if orbit.coordinates is None or orbit.p > LONG_CODE:
        return
    import numpy as np

    from orbitdb.stadium import Stadium

    symbols = np.array([int(symbol) for symbol in orbit.code], dtype=np.uint8)
    points = Stadium(orbit.a).points(symbols, orbit.coordinates)
    walls = ("bottom", "left, up", "top", "right, up", "left, down", "right, down")
    rows = (
        (n + 1, int(symbol), _wall(orbit.code, n, walls), float(x), float(point[0]), float(point[1]))
        for n, (symbol, x, point) in enumerate(zip(symbols, orbit.coordinates, points, strict=True))
    )
    print()
    write(("n", "symbol", "wall", "coordinate", "x", "y"), rows, Format.TABLE)


def _wall(code: str, n: int, names: tuple[str, ...]) -> str:
    """Name the wall of a bounce; a single bounce on a semicircle has no sense of rotation."""
    name = names[int(code[n])]
    alone = code[n - 1] != code[n] and code[(n + 1) % len(code)] != code[n]
    return name.partition(",")[0] if alone else name
