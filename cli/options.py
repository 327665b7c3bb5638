"""Options that several commands share."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
        "--db",
        metavar="PATH",
        readable=False,  # the store says what is wrong with a file
        help="The catalogue [default: ORBITDB_DB, or the user's data folder].",
    ),
]
USUAL_A = 1.6
"""The paper's stadium."""

HalfLength = Annotated[float, typer.Option("--a", metavar="NUMBER", help="Half length of a straight wall.")]
StoredHalfLength = Annotated[
    float | None,
    typer.Option(
        "--a",
        metavar="NUMBER",
        help="Half length of a straight wall [default: the catalogue's only one, else 1.6].",
    ),
]
OutputFormat = Annotated[Format, typer.Option("--format", help="How to write the result.")]
Json = Annotated[bool, typer.Option("--json", help="The same as --format json.")]
Periods = Annotated[str | None, typer.Option("--p", metavar="PERIODS", help="Periods: 11, 2-8 or 2,3,5-7.")]


@dataclass(frozen=True)
class Choice:
    """The options that choose a subset of the catalogue, as they were typed; their help says what they take.

    A command takes all of them by one parameter, ``choice: Choice``, and the decorator `with_choice`.
    """

    p: Periods = None
    status: Annotated[
        str | None,
        typer.Option(
            "--status", help="orbit, geometric, dynamical, boundary or unresolved; several with commas; all."
        ),
    ] = None
    reversal: Annotated[
        str | None,
        typer.Option(
            "--reversal", metavar="self|pair", help="Orbits that retrace their path, or those that do not."
        ),
    ] = None
    symmetry: Annotated[
        str | None,
        typer.Option("--symmetry", metavar="LABEL", help="Exact symmetry, such as x,T,xT; 1 for none."),
    ] = None
    contains: Annotated[
        str | None,
        typer.Option(
            "--contains", metavar="SYMBOLS", help="Words with these symbols in a row, in any rotation."
        ),
    ] = None
    bounds: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            metavar="NAME=LOW:HIGH",
            help="Bounds on length, lyapunov, lambda_d, lambda_c or margin; repeatable.",
        ),
    ] = None
    where: Annotated[
        str | None,
        typer.Option("--where", metavar="SQL", help="An SQL expression over the columns of the catalogue."),
    ] = None
    parameters: Annotated[
        list[str] | None,
        typer.Option("-P", metavar="NAME=VALUE", help="What :name in --where stands for; repeatable."),
    ] = None

    def at(self, a: float) -> "Selection":
        """Return the subset at one a.

        Raises
        ------
        InputError
            If an option cannot be read.
        """
        from orbitdb import selection as sel
        from orbitdb.stadium import Stadium
        from orbitdb.words import parse

        return sel.Selection(
            a=Stadium(a).a,
            periods=() if self.p is None else sel.parse_periods(self.p),
            statuses=() if self.status is None else sel.parse_statuses(self.status),
            time_reversal=None if self.reversal is None else sel.parse_reversal(self.reversal),
            symmetry=None if self.symmetry is None else sel.parse_symmetry(self.symmetry),
            contains=None if self.contains is None else parse(self.contains),
            ranges=sel.parse_bounds(self.bounds or ()),
            where=self.where,
            parameters=dict(sel.parse_parameter(parameter) for parameter in self.parameters or ()),
        )


def with_choice(command: Callable[..., None]) -> Callable[..., None]:
    """Show Typer the options of `Choice` in the place of a command's parameter ``choice``."""

    @wraps(command)
    def run(**given: Any) -> None:
        command(choice=Choice(**{each.name: given.pop(each.name) for each in fields(Choice)}), **given)

    parameters = list(signature(command).parameters.values())
    place = [parameter.name for parameter in parameters].index("choice")
    parameters[place : place + 1] = [
        Parameter(each.name, Parameter.KEYWORD_ONLY, default=each.default, annotation=each.type)
        for each in fields(Choice)
    ]
    shown = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in parameters]
    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]  # what Typer reads
    return run


def chosen(format_: Format, json: bool) -> Format:
    """Return the output format, --json winning."""
    return Format.JSON if json else format_
