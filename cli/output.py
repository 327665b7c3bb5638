"""The options for output on stdout, and the functions that write it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from orbitdb.cli.render import FOR_PEOPLE, Format, write
from orbitdb.errors import InputError

MarkWords = Annotated[
    bool,
    typer.Option(
        "--mark-words", help="In csv and tsv, write words as w01023, so that they are not read as numbers."
    ),
]


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


@dataclass(frozen=True)
class MarkedOutput(Output):
    """The options of `Output`, and the option to mark words."""

    mark_words: MarkWords = False

    def __post_init__(self) -> None:
        super().__post_init__()
        check_marks(self.mark_words, self.form)

    def write(self, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> int:
        """Write rows to stdout, with their words marked if requested, and return their number."""
        return super().write(columns, with_marks(columns, rows) if self.mark_words else rows)


def check_marks(mark_words: bool, form: str) -> None:
    """Refuse --mark-words for a format that needs no marks."""
    if mark_words and form not in (Format.CSV, Format.TSV):
        raise InputError(f"--mark-words is for csv and tsv; {form} keeps words as they are: leave it out")


_WORDS = ("code", "word", "representative", "sequence")


def with_marks(names: Sequence[str], rows: Iterable[Sequence[Any]]) -> Iterator[tuple[Any, ...]]:
    """Yield the rows with a mark before each word, as in w01023, so that no program reads it as a number."""
    from orbitdb.symbols.words import MARK

    words = [name in _WORDS for name in names]
    for row in rows:
        yield tuple(
            f"{MARK}{value}" if word and value is not None else value
            for value, word in zip(row, words, strict=True)
        )
