"""The options for output on stdout, and the functions that write it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from orbitdb.cli.render import FOR_PEOPLE, Format, write
from orbitdb.errors import InputError


@dataclass(frozen=True)
class Output:
    """The options for the format of data; contradictory ones are refused."""

    format_: Annotated[
        Format,
        typer.Option("--format", metavar="FORMAT", help="table, csv, tsv, json, jsonl, markdown or latex."),
    ] = Format.TABLE
    json: Annotated[bool, typer.Option("--json", help="Same as --format json.")] = False

    def __post_init__(self) -> None:
        if self.json and self.format_ not in (Format.TABLE, Format.JSON):
            raise InputError(
                f"--json and --format {self.format_} contradict each other: leave one of them out"
            )

    @property
    def form(self) -> Format:
        """The requested format."""
        return Format.JSON if self.json else self.format_

    @property
    def table(self) -> bool:
        """Whether the format is a table for the terminal."""
        return self.form is Format.TABLE

    @property
    def for_people(self) -> bool:
        """Whether the format has few columns and rounded numbers."""
        return self.form in FOR_PEOPLE

    def write(self, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> int:
        """Write rows to stdout, and return their number."""
        return write(columns, rows, self.form)
