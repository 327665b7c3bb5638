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
from orbitdb.cli.rows import COLUMNS_HELP, KEYS, lines_or_rows, with_marks, with_rules
from orbitdb.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from orbitdb.store.asking.selection import Selection
    from orbitdb.store.reading.catalogue import Catalogue

EXAMPLES = (
    """
Examples:

  orbitdb export orbits.parquet --status orbit

  orbitdb export short.csv --p 2-8 --range length=:20 --coordinates

  orbitdb export bounces.parquet --p 5 --status orbit --bounces

  orbitdb export --format jsonl --p 11 --status orbit | jq .length

"""
    + COLUMNS_HELP
)
_BLOCK = 4_000
_BETWEEN_TELLING = 1000
_HOW = ("code", "cycle", "element")

Row = tuple[Any, ...]


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
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="The same as FILE.")
    ] = None,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    order: Annotated[
        str, options.column_option("--order", help="Columns to sort by; a falling one ends in desc.")
    ] = "p,code",
    limit: Annotated[
        int | None, options.count_option("--limit", least=0, help="Symbol sequences at most.")
    ] = None,
    columns: Annotated[
        str | None, options.column_option("-c", "--columns", help="Columns to write, with commas between.")
    ] = None,
    coordinates: Annotated[
        bool, typer.Option("--coordinates", help="Write the coordinates of every bounce, too.")
    ] = False,
    bounces: Annotated[
        bool, typer.Option("--bounces", help="Write one row a bounce: x, y, arc length, sine of the angle.")
    ] = False,
    form: Annotated[
        str | None, typer.Option("--format", help="csv, jsonl, parquet or npz, whatever the name ends in.")
    ] = None,
    mark_words: options.MarkWords = False,
    force: options.Force = False,
    db: options.Database = None,
) -> None:
    """Write symbol sequences and what is known of them to a file, every number in full.

    Where they come from is noted in the file (parquet, npz) or in FILE-metadata.json beside it, with
    the periods among them that a fill had stored in part only.
    """
    from orbitdb import export as files
    from orbitdb.store.asking.conditions import parse_columns

    if file is not None and output is not None:
        raise InputError(f"{file} and -o {output}: name one file")
    file = output if file is None else file
    if file is None or file == files.STDOUT:
        options.refuse_idle(context, "on stdout", "force")
        file, kind = None, _form_of_stdout(form)
    else:
        kind = files.form_of(file, form)
        files.check_target(file, force)
    options.check_marks(mark_words, kind)
    if bounces:
        options.refuse_idle(context, "with --bounces", "coordinates")
    otherwise: tuple[str, ...] = ("code",) if bounces else KEYS
    names = otherwise if columns is None else parse_columns(columns)
    with reading(db, a, choice) as (catalogue, chosen):
        partial = catalogue.partial(chosen)
        note_gaps(catalogue, chosen, names=names, order=order)
        if bounces:
            names, rows = _with_bounces(catalogue, chosen, names, order, limit)
        elif coordinates:
            names, rows = _with_coordinates(catalogue, chosen, names, order, limit)
            rows = _with_lists(rows) if kind in files.TEXT_WRITERS else rows
        else:
            rows = lines_or_rows(catalogue, chosen, names, order, kind, mark_words, limit)
        if mark_words and (bounces or coordinates):
            rows = with_marks(names, rows)
        with progress("sorting"):
            first = next(rows, None)
        if first is None:
            note_nothing(catalogue, chosen, ": nothing is written")
            raise typer.Exit(1)
        everything: Iterator[Row] = chain([first], rows)
        with progress("writing", to_stdout=file is None) as shown:
            written = _watched(everything, shown)
            if file is None:
                files.TEXT_WRITERS[kind](sys.stdout, names, written)
                return
            provenance = _provenance(catalogue, chosen) | {"partial": [fill.p for fill in partial]}
            files.write_file(file, kind, names, written, provenance)
    note(f"{chosen.describe()}, in {file}")


def _watched(rows: Iterator[Row], shown: Progress) -> Iterator[Row]:
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


def _with_coordinates(
    catalogue: "Catalogue", chosen: "Selection", names: Sequence[str], order: str, limit: int | None
) -> tuple[tuple[str, ...], Iterator[Row]]:
    """Return columns and rows with the coordinates of all bounces behind them, None where there are none."""
    found = _placed(catalogue, chosen, names, order, limit)
    return (*names, "coordinates"), ((*row, place) for _, row, place in chain.from_iterable(found))


def _with_lists(rows: Iterator[Row]) -> Iterator[Row]:
    """Give arrays, which are last in rows, as lists."""
    return ((*row, None if place is None else place.tolist()) for *row, place in rows)


def _with_bounces(
    catalogue: "Catalogue", chosen: "Selection", names: Sequence[str], order: str, limit: int | None
) -> tuple[tuple[str, ...], Iterator[Row]]:
    """Return columns and rows of bounces, behind what is known of their orbit; others have no row."""
    from orbitdb.billiard.stadium import Stadium
    from orbitdb.orbits.bounce_rows import BOUNCE_COLUMNS, bounce_rows

    def rows() -> Iterator[Row]:
        for block in _placed(catalogue, chosen, names, order, limit):
            words, known, places = zip(*block, strict=True)
            for row, bounces in zip(known, bounce_rows(Stadium(chosen.a), words, places), strict=True):
                yield from ((*row, *bounce) for bounce in bounces)

    return (*names, *BOUNCE_COLUMNS), rows()


def _placed(
    catalogue: "Catalogue", chosen: "Selection", names: Sequence[str], order: str, limit: int | None
) -> Iterator[list[tuple[str, Row, "NDArray[np.float64] | None"]]]:
    """Yield blocks of words, their rows, and the coordinates of their bounces if they have any."""
    columns = (*names, *_HOW)
    rows = with_rules(columns, catalogue.rows(chosen, columns, order, limit))
    while block := list(islice(rows, _BLOCK)):
        places = _coordinates(catalogue, chosen.a, block)
        yield [(row[len(names)], row[: len(names)], place) for row, place in zip(block, places, strict=True)]


def _coordinates(
    catalogue: "Catalogue", a: float, block: Sequence[Row]
) -> list["NDArray[np.float64] | None"]:
    """Return the coordinates of rows that end in `_HOW`."""
    import numpy as np

    from orbitdb.store.reading.subset import read_coordinates

    words, cycles, elements = zip(*(row[-len(_HOW) :] for row in block), strict=True)
    flat = read_coordinates(catalogue, a, words, cycles, elements)
    ends = np.cumsum([len(word) for word in words])
    return [None if np.isnan(part[0]) else part for part in np.split(flat, ends[:-1])]
