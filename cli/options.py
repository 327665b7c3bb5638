"""Options that several commands share."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from orbitdb.selection import Selection


class Format(StrEnum):
    """How data is written to stdout."""

    TABLE = "table"
    CSV = "csv"
    TSV = "tsv"
    JSON = "json"
    JSONL = "jsonl"


Database = Annotated[
    Path | None,
    typer.Option(
        "--db", metavar="PATH", help="The catalogue [default: ORBITDB_DB, or the user's data folder]."
    ),
]
HalfLength = Annotated[float, typer.Option("--a", metavar="NUMBER", help="Half length of a straight wall.")]
OutputFormat = Annotated[Format, typer.Option("--format", help="How to write the result.")]
Json = Annotated[bool, typer.Option("--json", help="The same as --format json.")]
Periods = Annotated[str | None, typer.Option("--p", metavar="PERIODS", help="Periods: 11, 2-8 or 2,3,5-7.")]
Statuses = Annotated[
    str | None,
    typer.Option(
        "--status", help="orbit, geometric, dynamical, boundary or unresolved; several with commas; all."
    ),
]
Reversal = Annotated[
    str | None,
    typer.Option(
        "--reversal", metavar="self|pair", help="Orbits that retrace their path, or those that do not."
    ),
]
Symmetry = Annotated[
    str | None,
    typer.Option("--symmetry", metavar="LABEL", help="Exact symmetry, such as x,T,xT; 1 for none."),
]
Contains = Annotated[
    str | None,
    typer.Option("--contains", metavar="SYMBOLS", help="Words with these symbols in a row, in any rotation."),
]
Bounds = Annotated[
    list[str] | None,
    typer.Option(
        "--range",
        metavar="NAME=LOW:HIGH",
        help="Bounds on length, lyapunov, lambda_d, lambda_c or margin; repeatable.",
    ),
]
Where = Annotated[
    str | None,
    typer.Option("--where", metavar="SQL", help="An SQL expression over the columns of the catalogue."),
]
Parameters = Annotated[
    list[str] | None,
    typer.Option("-P", metavar="NAME=VALUE", help="What :name in --where stands for; repeatable."),
]


def chosen(format_: Format, json: bool) -> Format:
    """Return the output format, --json winning."""
    return Format.JSON if json else format_


def selection(
    a: float,
    periods: str | None,
    statuses: str | None,
    reversal: str | None,
    symmetry: str | None,
    contains: str | None,
    bounds: list[str] | None,
    where: str | None,
    parameters: list[str] | None,
) -> "Selection":
    """Return the chosen subset that the options name.

    Raises
    ------
    SelectionError
        If one of them cannot be read.
    """
    from orbitdb import selection as sel
    from orbitdb.stadium import Stadium
    from orbitdb.words import parse

    return sel.Selection(
        a=Stadium(a).a,
        periods=() if periods is None else sel.parse_periods(periods),
        statuses=() if statuses is None else sel.parse_statuses(statuses),
        time_reversal=None if reversal is None else sel.parse_reversal(reversal),
        symmetry=None if symmetry is None else sel.parse_symmetry(symmetry),
        contains=None if contains is None else parse(contains),
        ranges=sel.parse_bounds(bounds or ()),
        where=where,
        parameters=dict(sel.parse_parameter(parameter) for parameter in parameters or ()),
    )
