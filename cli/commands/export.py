"""``orbitdb export``: write rows of the catalogue to files for other tools."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.grids import GivenValues, many_a, named
from orbitdb.cli.notes import note, notes, progress
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.snapshots import OF_CATALOGUE, asked_columns, chosen_codes, snapshot
from orbitdb.columns import WRITTEN, Row
from orbitdb.errors import InputError
from orbitdb.progress import Tell
from orbitdb.text import gigabytes, several

if TYPE_CHECKING:
    from orbitdb.answers.listing import Listing

EXAMPLES = (
    "export orbits.parquet --status orbit",
    "export short.csv --p 2-8 --range length=:20 -c +coordinates",
    "export bounces.parquet --p 5 --status orbit --by-bounce",
    "export --format jsonl --p 11 --status orbit | jq .length",
    "export stadium-data --dataset --p 2-11",
    "export atlas.html --p 2-9",
    "export copy.db",
    "export part.db --a 0.5 --p 2-9",
)
AFTERWORD = "'orbitdb columns' explains the columns."
_BETWEEN_TELLING = 1000
_PLACED = ("a", "code", "coordinates")
COPY = ".db"
"""How the name of a copy of the whole catalogue ends."""
PAGE = ".html"
"""How the name of an atlas ends."""


def export(
    *,
    context: typer.Context,
    file: Annotated[
        Path | None,
        typer.Argument(
            metavar="[FILE]",
            parser=options.read_path,
            help="Name ending in .csv, .tsv, .json, .jsonl, .parquet, .html or .db; none or -: stdout.",
        ),
    ] = None,
    a: options.HalfLengths = None,
    code: options.OnlyCodes = None,
    choice: SelectionOptions,
    classes: options.Classes = False,
    order: options.Order = "p",
    limit: Annotated[
        int | None, options.count_option("--limit", "-n", least=1, help="Maximum number of rows to write.")
    ] = None,
    columns: options.Columns = None,
    by_bounce: options.ByBounce = False,
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
    limited to these words. A name ending in .db makes a copy of the whole catalogue, as it is at one moment,
    even while other commands write to it; with --a or --p, a part of it, with the levels, bounds and averages
    over trajectories at these a, for 'orbitdb merge'. A name ending in .html makes an atlas: a page with the
    chosen orbits, one row for each class, that opens in any browser.
    """
    from orbitdb import output_files as files

    if dataset:
        choosing = (field.name for field in fields(SelectionOptions))
        options.takes_only(context, "with --dataset", "file", "dataset", "a", "code", *choosing)
        _write_dataset(file, a, code, choice, force, db)
        return
    if file is not None and file.suffix.lower() == COPY:
        options.takes_only(context, f"with {file.name}, which is a catalogue", "file", "form", "a", "p")
        _copy(file, a, choice, force, db)
        return
    if file is not None and file.suffix.lower() == PAGE:
        choosing = (field.name for field in fields(SelectionOptions))
        options.takes_only(
            context, f"with {file.name}, which is an atlas", "file", "a", "order", "limit", "form", *choosing
        )
        _write_atlas(file, a, choice, order, limit, force, db)
        return
    if file is None or file == files.STDOUT:
        options.refuse_idle(context, "on stdout", "force")
        if form not in files.TEXT_WRITERS:
            raise InputError("name a file, such as orbits.parquet, or give --format csv, tsv, json or jsonl")
        file, kind = None, form
    else:
        kind = files.check_rows(file, form, force, also=(PAGE[1:], COPY[1:]))
    usual = ("code",) if by_bounce else (*WRITTEN, *["words"] * classes)
    names = asked_columns(columns, usual, a, OF_CATALOGUE if by_bounce else ())
    names += _PLACED if by_bounce else ()
    with snapshot(db, a, choice, code=chosen_codes(code)) as (catalogue, selections):
        listing = catalogue.rows(selections, columns=names, order=order, limit=limit, classes=classes)
        count = _write(listing, by_bounce, file, kind, many_a(a))
        complete, subject = listing.complete, listing.describe()
    for text in complete:
        note(text)
    if file is not None:
        note(f"{several(count, 'row')} written: {subject}, in {file}")


def _write(listing: "Listing", by_bounce: bool, file: Path | None, kind: str, many: bool) -> int:
    """Write the rows to a file or to stdout, and return how many; without rows, exit."""
    from orbitdb import output_files as files

    with progress("sorting"):
        said, absent = listing.notes, listing.absent
    notes(f"{text}: nothing is written" if text in absent else text for text in said)
    names, rows = listing.columns, iter(listing)
    if by_bounce:
        from orbitdb.orbits.bounces import BOUNCE_COLUMNS, bounce_by_bounce

        names, rows = names[: -len(_PLACED)] + BOUNCE_COLUMNS, bounce_by_bounce(rows)
    first = next(rows, None)
    if first is None:
        if not listing.empty:
            note("these words have no bounces; only orbits do (--status orbit): nothing is written")
        raise typer.Exit(1)
    with progress("writing", to_stdout=file is None) as shown:
        written = _watched(chain([first], rows), shown)
        if file is None:
            return files.TEXT_WRITERS[kind](sys.stdout, names, written)
        return files.write_file(file, kind, names, written, listing.provenance(many))


def _copy(
    file: Path, a: Sequence[GivenValues] | None, choice: SelectionOptions, force: bool, db: Path
) -> None:
    """Copy the catalogue, or the part of it at the given a and of the given periods."""
    from orbitdb import output_files as files
    from orbitdb.catalogue import Catalogue

    files.check_target(file, force)  # before anything is read
    with progress("copying"), Catalogue(db) as catalogue:
        catalogue.copy(file, a=named(a), p=choice.p, force=force)
    note(f"{gigabytes(file.stat().st_size)} copied from {db}, in {file}")


def _write_atlas(
    file: Path,
    a: Sequence[GivenValues] | None,
    choice: SelectionOptions,
    order: str,
    limit: int | None,
    force: bool,
    db: Path,
) -> None:
    """Write the chosen orbits as a page for browsers, and say what is missing; without any, exit."""
    from orbitdb.orbits.status import Status

    with snapshot(db, a, choice) as (catalogue, selections), progress("atlas"):
        orbits = [replace(chosen, statuses=(Status.ORBIT,)) for chosen in selections]
        listing = catalogue.rows(orbits, order=order, limit=limit, classes=True)
        said, absent, subject = listing.notes, listing.absent, listing.describe()
        count = catalogue.atlas(file, selections, order=order, limit=limit, force=force)
    notes(f"{text}: nothing is written" if text in absent else text for text in said)
    if not count:
        raise typer.Exit(1)
    note(f"{several(count, 'class', 'classes')} written: {subject}, in {file}")


def _write_dataset(
    folder: Path | None,
    a: Sequence[GivenValues] | None,
    code: Sequence[str] | None,
    choice: SelectionOptions,
    force: bool,
    db: Path,
) -> None:
    """Write a folder with the chosen words of whole periods, at the given a or at every stored a."""
    if folder is None or str(folder) == "-":
        raise InputError("name the folder of the dataset, such as 'orbitdb export stadium-data --dataset'")
    with (
        snapshot(db, a or [GivenValues()], choice, (), chosen_codes(code)) as (catalogue, selections),
        progress("dataset") as shown,
    ):
        dataset = catalogue.write_dataset(folder, selections, force=force, progress=shown)
    notes(f"{text}: nothing is written" if text in dataset.absent else text for text in dataset.notes)
    if not dataset.words:
        raise typer.Exit(1)
    note(f"{dataset.description}, in {folder}")


def _watched(rows: Iterator[Row], shown: Tell) -> Iterator[Row]:
    """Yield the rows, and show their number as progress."""
    for count, row in enumerate(rows):
        if count % _BETWEEN_TELLING == 0:
            shown(0, 0, f"{count:,} rows written")
        yield row
