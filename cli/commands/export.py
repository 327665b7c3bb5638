"""``orbitdb export``: rows of the catalogue as files for other tools."""

import sys
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb import __version__
from orbitdb.cli import options
from orbitdb.cli.progress import Progress, progress
from orbitdb.cli.reading import note_gaps, note_nothing, reading
from orbitdb.cli.render import note
from orbitdb.cli.rows import KEYS
from orbitdb.errors import InputError

if TYPE_CHECKING:
    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue

EXAMPLES = """
Examples:

  orbitdb export orbits.parquet --status orbit

  orbitdb export short.csv --p 2-8 --range length=:20 --coordinates

  orbitdb export --format jsonl --p 11 --status orbit | jq .length
"""
_BLOCK = 20_000
_BETWEEN_TELLING = 1000
_STDOUT = Path("-")
_HOW = ("code", "cycle", "element")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(epilog=EXAMPLES)(export)


@options.with_choice
def export(
    *,
    context: typer.Context,
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]", help="Ends in .csv, .jsonl, .parquet or .npz; none or -: stdout, with --format."
        ),
    ] = None,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    order: Annotated[
        str, typer.Option("--order", help="Columns to sort by; a falling one ends in desc.")
    ] = "p,code",
    limit: Annotated[int | None, options.count_option("--limit", least=0, help="Rows at most.")] = None,
    columns: Annotated[
        str | None, typer.Option("-c", "--columns", help="Columns to write, with commas between.")
    ] = None,
    coordinates: Annotated[
        bool, typer.Option("--coordinates", help="Write the coordinates of every bounce, too.")
    ] = False,
    form: Annotated[
        str | None, typer.Option("--format", help="csv, jsonl, parquet or npz, whatever the name ends in.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the file if there is one.")] = False,
    db: options.Database = None,
) -> None:
    """Write symbol sequences and what is known of them to a file, every number in full.

    Where they come from is noted in the file (parquet, npz) or in FILE-metadata.json beside it, with
    the periods among them that a fill had stored in part only.
    """
    from orbitdb import export as files
    from orbitdb.store.asking.conditions import parse_columns

    if file is None or file == _STDOUT:
        options.refuse_idle(context, "on stdout", "force")
        file, kind = None, _form_of_stdout(form)
    else:
        kind = files.form_of(file, form)
        files.check_target(file, force)
    names = KEYS if columns is None else parse_columns(columns)
    with reading(db, a, choice) as (catalogue, chosen):
        partial = catalogue.partial(chosen)
        note_gaps(catalogue, chosen, names=names, order=order)
        rows = _rows(catalogue, chosen, names, order, limit, coordinates)
        with progress("sorting"):
            first = next(rows, None)
        if first is None:
            note_nothing(catalogue, chosen, ": nothing is written")
            raise typer.Exit(1)
        everything = chain([first], rows)
        names = (*names, "coordinates") if coordinates else names
        with progress("writing", to_stdout=file is None) as shown:
            written = _watched(everything, shown)
            if file is None:
                files.TEXT_WRITERS[kind](sys.stdout, names, written)
                return
            provenance = _provenance(catalogue, chosen) | {"partial": [fill.p for fill in partial]}
            files.write_file(file, kind, names, written, provenance)
    note(f"{chosen.describe()}, in {file}")


def _watched(rows: Iterator[list[Any]], shown: Progress) -> Iterator[list[Any]]:
    """Pass rows on, and show how many they are."""
    for count, row in enumerate(rows):
        if count % _BETWEEN_TELLING == 0:
            shown.tell(f"{count:,} rows written")
        yield row


def _form_of_stdout(form: str | None) -> str:
    """Return the format of what is written to stdout.

    Raises
    ------
    InputError
        If it is not named, or cannot be written row by row.
    """
    from orbitdb.export import FORMATS, TEXT_WRITERS

    if form in TEXT_WRITERS:
        return str(form)
    said = "" if form is None else f"{form} is for files: " if form in FORMATS else f"no format {form!r}: "
    raise InputError(
        f"{said}name a file, such as orbits.parquet, or write to stdout with --format csv or jsonl"
    )


def _provenance(catalogue: "Catalogue", chosen: "Selection") -> dict[str, Any]:
    return {
        "orbitdb": __version__,
        "selection": chosen.describe(),
        "a": chosen.a,
        "database": str(catalogue.path.resolve()),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _rows(
    catalogue: "Catalogue",
    chosen: "Selection",
    names: Sequence[str],
    order: str,
    limit: int | None,
    coordinates: bool,
) -> Iterator[list[Any]]:
    """Yield rows with the rules broken as lists, and the coordinates behind them if they are wanted."""
    from orbitdb.store.asking.conditions import rules_of

    wanted = (*names, *_HOW) if coordinates else names
    rows = catalogue.rows(chosen, wanted, order, limit)
    rules = [place for place, name in enumerate(names) if name == "rules"]
    while block := list(islice(rows, _BLOCK)):
        places = _coordinates(catalogue, chosen.a, block) if coordinates else [None] * len(block)
        for row, place in zip(block, places, strict=True):
            values = [*row[: len(names)], place] if coordinates else list(row)
            for k in rules:
                values[k] = rules_of(values[k])
            yield values


def _coordinates(
    catalogue: "Catalogue", a: float, block: Sequence[Sequence[Any]]
) -> list[list[float] | None]:
    """Return the coordinates of rows that end in `_HOW`."""
    import numpy as np

    from orbitdb.store.reading.subset import read_coordinates

    words, cycles, elements = zip(*(row[-len(_HOW) :] for row in block), strict=True)
    flat = read_coordinates(catalogue, a, words, cycles, elements)
    ends = np.cumsum([len(word) for word in words])
    parts = np.split(flat, ends[:-1])
    return [None if np.isnan(part[0]) else part.tolist() for part in parts]
