"""``orbitdb export``: write rows of the catalogue to files for other tools."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import fields
from itertools import chain, groupby, islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.arguments import ALL, many_a
from orbitdb.cli.options import Choice
from orbitdb.cli.orbit_facts import BOUNCE_COLUMNS, bounce_rows
from orbitdb.cli.output import note
from orbitdb.cli.progress import progress
from orbitdb.cli.reading import (
    asked_columns,
    described,
    in_order,
    note_gaps,
    note_nothing,
    provenance,
    reading,
)
from orbitdb.columns import WRITTEN, Row
from orbitdb.errors import InputError
from orbitdb.progress import Tell
from orbitdb.text import several

if TYPE_CHECKING:
    from orbitdb.store.connection import Moment
    from orbitdb.store.selection import Selection

EXAMPLES = (
    "export orbits.parquet --status orbit",
    "export short.csv --p 2-8 --range length=:20 --coordinates",
    "export bounces.parquet --p 5 --status orbit --bounces",
    "export --format jsonl --p 11 --status orbit | jq .length",
    "export stadium-data --dataset --p 2-11",
)
AFTERWORD = "'orbitdb columns' explains the columns."
_BLOCK = 4_000
_BETWEEN_TELLING = 1000
_PLACED = ("a", "code", "coordinates")
COORDINATES = "coordinates"


def export(
    *,
    context: typer.Context,
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]",
            help="Name ending in .csv, .tsv, .json, .jsonl or .parquet; none or - writes to stdout.",
        ),
    ] = None,
    a: options.StoredHalfLengths = None,
    choice: Choice,
    classes: options.Classes = False,
    order: options.Order = "p",
    limit: Annotated[
        int | None, options.count_option(least=0, help="Maximum number of rows to write.")
    ] = None,
    columns: options.Columns = None,
    coordinates: Annotated[
        bool, typer.Option("--coordinates", help="Also write the coordinates of every bounce.")
    ] = False,
    bounces: Annotated[
        bool,
        typer.Option("--bounces", help="Write one row per bounce: x, y, arc length and sine of the angle."),
    ] = False,
    form: Annotated[
        str | None,
        typer.Option("--format", help="csv, tsv, json, jsonl or parquet, if the name does not say which."),
    ] = None,
    dataset: Annotated[
        bool, typer.Option("--dataset", help="Write FILE as a folder that others can load and cite.")
    ] = False,
    force: options.Force = False,
    db: options.Database,
) -> None:
    """Write rows of the catalogue, with all digits, to a file or to stdout.

    The file itself (parquet) or FILE-metadata.json beside it says where the rows come from, and which of
    their periods were only partly filled. With --dataset, FILE is a folder that others can load: a Data
    Package, version 2. It contains the chosen words of every completely filled period, with coordinates,
    at every stored a unless you name some; its classes, births, counts, averages, bounds and levels are not
    limited to these words.
    """
    from orbitdb.answers import export as files

    if dataset:
        choosing = (each.name for each in fields(Choice))
        options.takes_only(context, "with --dataset", "file", "dataset", "a", *choosing)
        _write_dataset(file, a, choice, force, db)
        return
    if file is None or file == files.STDOUT:
        options.refuse_idle(context, "on stdout", "force")
        file, kind = None, _form_of_stdout(form)
    else:
        kind = files.form_of(file, form)
        files.check_target(file, force)
    if bounces:
        options.refuse_idle(context, "with --bounces", "coordinates")
    from orbitdb.store.query import choose

    names = asked_columns(columns, ("code",) if bounces else WRITTEN, a)
    with reading(db, a, choice) as (moment, stadiums):
        note_gaps(moment, *stadiums, names=names, order=order)
        shown_last = _PLACED if bounces else (COORDINATES,) if coordinates else ()
        with progress("sorting"):
            subsets = [choose(moment, chosen, order, by_class=classes) for chosen in stadiums]
        rows = in_order(moment, subsets, (*names, *shown_last), order, limit)
        rows = _bounce_by_bounce(rows) if bounces else rows
        names += BOUNCE_COLUMNS if bounces else shown_last
        first = next(rows, None)
        if first is None:
            _note_nothing(moment, stadiums, sum(map(len, subsets)), limit)
            raise typer.Exit(1)
        with progress("writing", to_stdout=file is None) as shown:
            written = _watched(chain([first], rows), shown)
            if file is None:
                files.TEXT_WRITERS[kind](sys.stdout, names, written)
                return
            count = files.write_file(
                file, kind, names, written, provenance(moment, stadiums, many_a(a), classes)
            )
    note(f"{several(count, 'row')} written: {described(stadiums, classes=classes)}, in {file}")


def _write_dataset(
    folder: Path | None, a: "Sequence[str] | None", choice: Choice, force: bool, db: Path
) -> None:
    """Write a folder with the chosen words of whole periods, at the given a or at every stored a."""
    from orbitdb.answers.completeness import gaps
    from orbitdb.answers.dataset import write_dataset

    if folder is None:
        raise InputError("name the folder of the dataset, such as 'orbitdb export stadium-data --dataset'")
    with reading(db, a or [ALL], choice) as (moment, stadiums), progress("dataset") as shown:
        for told in (told for each in stadiums for told in gaps(moment, each, left_out=True)):
            note(told)
        held = write_dataset(moment, folder, stadiums, force, shown)
        if not held:
            note_nothing(moment, *stadiums, more=": nothing is written")
            raise typer.Exit(1)
    note(f"{held}, in {folder}")


def _note_nothing(moment: "Moment", stadiums: "Sequence[Selection]", total: int, limit: int | None) -> None:
    """Explain why nothing is written: no rows, a limit of 0, or no bounces."""
    if not total:
        note_nothing(moment, *stadiums, more=": nothing is written")
        return
    told = described(stadiums, total)
    if limit == 0:
        note(f"{told}, and --limit 0 leaves none of them: nothing is written")
        return
    first = "" if limit is None or limit >= total else f"the first {limit} of "
    have = "has" if total == 1 or (first and limit == 1) else "have"
    note(f"{first}{told} {have} no bounces; only orbits do (--status orbit): nothing is written")


def _watched(rows: Iterator[Row], shown: Tell) -> Iterator[Row]:
    """Yield the rows, and show their number as progress."""
    for count, row in enumerate(rows):
        if count % _BETWEEN_TELLING == 0:
            shown(0, 0, f"{count:,} rows written")
        yield row


def _form_of_stdout(form: str | None) -> str:
    """Check and return the format for stdout: the user must choose one that is written row by row."""
    from orbitdb.answers.export import FORMATS, TEXT_WRITERS

    if form in TEXT_WRITERS:
        return str(form)
    said = "" if form is None else f"{form} is for files: " if form in FORMATS else f"no format {form!r}: "
    raise InputError(
        f"{said}name a file, such as orbits.parquet, or write to stdout with --format csv, tsv, json or jsonl"
    )


def _bounce_by_bounce(rows: Iterator[Row]) -> Iterator[Row]:
    """Yield one row per bounce, with the columns of its orbit first; skip words that are not orbits."""
    while block := list(islice(rows, _BLOCK)):
        groups = groupby(block, key=lambda row: row[-3])
        for a, found in groups:
            known = list(found)
            words = [row[-2] for row in known]
            places = [row[-1] for row in known]
            for row, bounces in zip(known, bounce_rows(a, words, places), strict=True):
                yield from ((*row[: -len(_PLACED)], *bounce) for bounce in bounces)
