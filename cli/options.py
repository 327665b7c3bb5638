"""Options that several commands share."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import StrEnum
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from orbitdb.cli import completion
from orbitdb.errors import InputError
from orbitdb.numerals import real, whole

if TYPE_CHECKING:
    from orbitdb.store.asking.selection import Selection


Number = TypeVar("Number", int, float)


class Format(StrEnum):
    """How data is written to stdout."""

    TABLE = "table"
    CSV = "csv"
    TSV = "tsv"
    JSON = "json"
    JSONL = "jsonl"
    MARKDOWN = "markdown"
    LATEX = "latex"


FOR_PEOPLE = (Format.TABLE, Format.MARKDOWN, Format.LATEX)
"""The formats with few columns and rounded numbers."""


def number_option(*flags: str, help: str, offers: Callable[..., list[str]] | None = None) -> Any:
    """Return an option that takes a number; a shell may offer some."""

    def read(given: str | float) -> float:
        return _read(real, str(given))

    return typer.Option(*flags, metavar="NUMBER", parser=read, help=help, autocompletion=offers)


def count_option(*flags: str, help: str, least: int | None = None, most: int | None = None) -> Any:
    """Return an option that takes a whole number, be it written 1e6, within bounds."""

    def read(given: str | int) -> int:
        count = _read(whole, str(given))
        if least is not None and count < least:
            raise typer.BadParameter(f"{count} is less than {least}")
        if most is not None and count > most:
            raise typer.BadParameter(f"{count} is more than {most}")
        return count

    return typer.Option(*flags, metavar="COUNT", parser=read, help=help)


def _read(reading: Callable[[str], Number], text: str) -> Number:
    try:
        return reading(text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None


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

HalfLength = Annotated[
    float, number_option("--a", help="Half length of a straight wall, whatever the catalogue holds.")
]
StoredHalfLength = Annotated[
    float | None,
    number_option(
        "--a",
        help="Half length of a straight wall [default: the catalogue's only one, else 1.6].",
        offers=completion.half_lengths,
    ),
]
StoredHalfLengths = Annotated[
    list[str] | None,
    typer.Option(
        "--a",
        metavar="NUMBER|all",
        help="Half length of a straight wall [default: the catalogue's only one, else 1.6]; "
        "repeatable, a grid FROM:TO:COUNT, or all that are stored.",
        autocompletion=completion.several_half_lengths,
    ),
]
OutputFormat = Annotated[Format, typer.Option("--format", help="How to write the result.")]
Json = Annotated[bool, typer.Option("--json", help="The same as --format json.")]
Parameters = Annotated[
    list[str] | None,
    typer.Option("-P", metavar="NAME=VALUE", help="What :name in SQL stands for; repeatable."),
]


def column_option(*flags: str, help: str) -> Any:
    """Return an option that takes names of columns, of which a shell offers those that are known."""
    return typer.Option(*flags, help=help, autocompletion=completion.columns)


Words = Annotated[
    list[str] | None,
    typer.Argument(metavar="[WORD]...", help="Words in any rotation, stored or not; - reads lines of stdin."),
]
Codes = Annotated[list[str] | None, typer.Option("--code", help="The same as WORD; repeatable.")]
"""With `Words`, what `orbitdb.cli.codes.given_codes` reads."""

MarkWords = Annotated[
    bool,
    typer.Option(
        "--mark-words", help="In csv and tsv, write words as w01023, which no program takes for a number."
    ),
]
Periods = Annotated[str | None, typer.Option("--p", metavar="PERIODS", help="Periods: 11, 2-8 or 2,3,5-7.")]


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


def _range_option(names: str) -> Any:
    return typer.Option("--range", metavar="NAME=LOW:HIGH", help=f"Bounds on {names}; repeatable.")


@dataclass(frozen=True)
class Choice:
    """The options that choose a subset of the catalogue, as they were typed; their help says what they take.

    A command takes all of them by one parameter, ``choice: Choice``, and the decorator `with_choice`.
    """

    p: Periods = None
    status: Annotated[
        str | None,
        typer.Option(
            "--status",
            help="orbit, geometric, dynamical, boundary or unresolved; several with commas; all.",
            autocompletion=completion.statuses,
        ),
    ] = None
    reversal: Reversal = None
    symmetry: Symmetry = None
    contains: Contains = None
    exists: Annotated[
        list[float] | None,
        number_option("--exists", help="Words that are orbits at this a, by their births; repeatable."),
    ] = None
    not_at: Annotated[
        list[float] | None,
        number_option("--not-at", help="Words that are no orbits at this a, by their births; repeatable."),
    ] = None
    bounds: Annotated[
        list[str] | None, _range_option("length, lyapunov, lambda_d, lambda_c, margin, born or dies")
    ] = None
    where: Annotated[
        str | None,
        typer.Option(
            "--where",
            metavar="SQL",
            help="An SQL expression over the columns; code('310') finds a word in any rotation.",
        ),
    ] = None
    parameters: Parameters = None

    def at(self, a: float) -> "Selection":
        """Return the subset at one a.

        Raises
        ------
        InputError
            If an option cannot be read.
        """
        from orbitdb.billiard.stadium import Stadium
        from orbitdb.store.asking import parsing
        from orbitdb.store.asking.selection import Selection, SelectionError
        from orbitdb.symbols.words import parse

        parameters = dict(parsing.parse_parameter(parameter) for parameter in self.parameters or ())
        if parameters and self.where is None:
            raise SelectionError("-P says what a name in --where stands for: give --where, or leave out -P")
        return Selection(
            a=Stadium(a).a,
            periods=() if self.p is None else parsing.parse_periods(self.p),
            statuses=() if self.status is None else parsing.parse_statuses(self.status),
            time_reversal=None if self.reversal is None else parsing.parse_reversal(self.reversal),
            symmetry=None if self.symmetry is None else parsing.parse_symmetry(self.symmetry),
            contains=None if self.contains is None else parse(self.contains),
            exists=parsing.parse_exists(self.exists or ()),
            not_at=parsing.parse_exists(self.not_at or ()),
            ranges=parsing.parse_bounds(self.bounds or ()),
            where=self.where,
            parameters=parameters,
        )


def _hidden(*flags: str) -> Any:
    return typer.Option(*flags, hidden=True)


@dataclass(frozen=True)
class SweptChoice:
    """The options of `Choice` that choose what is swept; the hidden ones are refused, and told why."""

    reversal: Reversal = None
    symmetry: Symmetry = None
    contains: Contains = None
    bounds: Annotated[list[str] | None, _range_option("length, lyapunov, lambda_d, lambda_c or margin")] = (
        None
    )
    status: Annotated[str | None, _hidden("--status")] = None
    exists: Annotated[list[float] | None, _hidden("--exists")] = None
    not_at: Annotated[list[float] | None, _hidden("--not-at")] = None
    where: Annotated[str | None, _hidden("--where")] = None

    def at(self, a: float) -> "Selection":
        """Return the subset at one a.

        Raises
        ------
        InputError
            If an option cannot be read, or cannot choose what is swept.
        """
        from orbitdb.store.asking.sweepable import swept_text

        chosen = Choice(**{each.name: getattr(self, each.name) for each in fields(self)}).at(a)
        swept_text(chosen)
        return chosen


def with_choice(command: Callable[..., None]) -> Callable[..., None]:
    """Show Typer the options of `Choice`, or of `SweptChoice`, in the place of a parameter ``choice``."""
    parameters = list(signature(command).parameters.values())
    place = [parameter.name for parameter in parameters].index("choice")
    kind = parameters[place].annotation

    @wraps(command)
    def run(**given: Any) -> None:
        command(choice=kind(**{each.name: given.pop(each.name) for each in fields(kind)}), **given)

    parameters[place : place + 1] = [
        Parameter(each.name, Parameter.KEYWORD_ONLY, default=each.default, annotation=each.type)
        for each in fields(kind)
    ]
    shown = [parameter.replace(kind=Parameter.KEYWORD_ONLY) for parameter in parameters]
    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]  # what Typer reads
    return run


def chosen(format_: Format, json: bool) -> Format:
    """Return the output format.

    Raises
    ------
    InputError
        If two are asked for.
    """
    if json and format_ not in (Format.TABLE, Format.JSON):
        raise InputError(f"--json and --format {format_} contradict one another: leave one of them out")
    return Format.JSON if json else format_


def check_marks(mark_words: bool, form: str) -> None:
    """Refuse marks before words in a format that keeps texts as they are.

    Raises
    ------
    InputError
        If they are asked for there.
    """
    if mark_words and form not in (Format.CSV, Format.TSV):
        raise InputError(f"--mark-words is for csv and tsv: {form} keeps words as they are, leave it out")


Force = Annotated[bool, typer.Option("--force", help="Replace the file if there is one.")]


def takes_only(context: typer.Context, asked: str, *names: str) -> None:
    """Refuse all options that do nothing in what is asked for.

    Parameters
    ----------
    context : typer.Context
        Of the command.
    asked : str
        What is asked for, as in ``with --code``.
    names : str
        The command's parameters that have a meaning then; where it reads and how it writes always have.

    Raises
    ------
    InputError
        If one of the others was given.
    """
    useful = {*names, "format_", "form", "force", "json", "db"}
    refuse_idle(context, asked, *(each.name for each in context.command.params if each.name not in useful))


def refuse_idle(context: typer.Context, asked: str, *names: str | None) -> None:
    """Refuse some options that do nothing in what is asked for (`takes_only`)."""
    given = [
        parameter.opts[0] if parameter.param_type_name == "option" else str(parameter.metavar).strip("[].")
        for parameter in context.command.params
        if parameter.name in names and _typed(context, parameter.name)
    ]
    if given:
        does, it = ("does", "it") if len(given) == 1 else ("do", "them")
        raise InputError(f"{', '.join(given)} {does} nothing {asked}: leave {it} out")


def _typed(context: typer.Context, name: str | None) -> bool:
    source = context.get_parameter_source(name or "")
    return source is not None and source.name == "COMMANDLINE"
