"""Options shared by several commands, singly or in groups."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitdb.cli.completions import (
    offered_columns,
    offered_half_lengths,
    offered_several_half_lengths,
    offered_statuses,
)
from orbitdb.cli.grids import ALL, GivenValues, curvatures, half_length, half_lengths
from orbitdb.cli.notes import be_quiet, last_notes
from orbitdb.cli.output import ON_SCREEN
from orbitdb.errors import InputError
from orbitdb.store.paths import default_path, home_expanded
from orbitdb.text import parse_int, real

if TYPE_CHECKING:
    from orbitdb.selection import Selection


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Replace each parameter that is a dataclass by its fields, which Typer reads as options; add --quiet."""
    groups: dict[str, Any] = {}
    shown = []
    for parameter in signature(command).parameters.values():
        if is_dataclass(parameter.annotation):
            groups[parameter.name] = parameter.annotation
            shown += [
                Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
                for field in fields(parameter.annotation)
            ]
        else:
            shown.append(parameter.replace(kind=Parameter.KEYWORD_ONLY))
    shown.append(Parameter("quiet", Parameter.KEYWORD_ONLY, default=False, annotation=Quiet))

    @wraps(command)
    def run(*, quiet: bool = False, **given: Any) -> None:
        be_quiet(quiet)
        for name, kind in groups.items():
            given[name] = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
        with last_notes():
            command(**given)

    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]  # Typer reads it
    return run


def number_option(*flags: str, help: str, read: Callable[[str], Any] = real, **more: Any) -> Any:
    """Return an option that takes a number, such as a `half_length`."""
    return typer.Option(*flags, metavar="NUMBER", parser=_reader(read), help=help, **more)


def a_option(default: str = "") -> Any:
    """Return the option --a for one half length; the shell offers those that are stored."""
    text = f"Half length of the straight walls{default}."
    return number_option("--a", "-a", read=half_length, help=text, autocompletion=offered_half_lengths)


def count_option(*flags: str, help: str, least: float = -math.inf, most: float = math.inf) -> Any:
    """Return an option that takes a whole number within bounds; it may be written as 1e6."""
    return typer.Option(*flags, metavar="COUNT", parser=_reader(parse_int, least, most), help=help)


def _reader(reading: Callable[[str], Any], least: float = -math.inf, most: float = math.inf) -> Any:
    """Return a parser for Typer, whose errors say what is wrong with a value; defaults are not parsed."""

    def read(given: object) -> Any:
        try:
            value = reading(given) if isinstance(given, str) else given
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
        if isinstance(value, int) and not least <= value <= most:
            raise typer.BadParameter(
                f"{value} is less than {least}" if value < least else f"{value} is more than {most}"
            )
        return value

    return read


read_path = _reader(home_expanded)
"""Parser for every path that a user gives: ``~`` is the home folder, and an empty path is refused."""


def path_option(*flags: str, help: str) -> Any:
    """Return an option that takes the path of a file."""
    return typer.Option(*flags, metavar="FILE", parser=read_path, help=help)


Database = Annotated[
    Path,
    typer.Option(
        "--db",
        metavar="PATH",
        default_factory=default_path,
        parser=read_path,
        show_default=False,
        help="The catalogue [default: ORBITDB_DB, or the user's data folder].",
    ),
]
GivenHalfLength = Annotated[float, a_option()]
_USUAL = "[default: the only one stored, else 1.6]"
HalfLength = Annotated[float | None, a_option(f" {_USUAL}")]
read_half_lengths = _reader(half_lengths)
read_all_half_lengths = _reader(lambda text: GivenValues() if text == ALL else half_lengths(text))

HalfLengths = Annotated[
    list[GivenValues] | None,
    typer.Option(
        "--a",
        "-a",
        metavar="NUMBER|all",
        parser=read_all_half_lengths,
        help=f"Half length of the straight walls {_USUAL}; "
        "repeatable; also a grid FROM:TO:COUNT, or all for every stored value.",
        autocompletion=offered_several_half_lengths,
    ),
]
Kappa = Annotated[
    list[GivenValues] | None,
    typer.Option(
        "--kappa",
        metavar="NUMBER",
        parser=_reader(curvatures),
        help="Curvature of the path in a magnetic field, in 1/radius, positive if it turns left; "
        "repeatable; also a grid FROM:TO:COUNT.",
    ),
]
Parameters = Annotated[
    list[str] | None,
    typer.Option("--parameter", metavar="NAME=VALUE", help="The value of :name in the SQL; repeatable."),
]
Order = Annotated[
    str,
    typer.Option(
        "--order",
        help="Columns to sort by; desc after a column reverses its order.",
        autocompletion=offered_columns,
    ),
]
Columns = Annotated[
    str | None,
    typer.Option(
        "--columns",
        "-c",
        help="Columns to include, separated by commas; +NAME adds one to the usual ones.",
        autocompletion=offered_columns,
    ),
]
Words = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[WORD]...", help="Words in any rotation, stored or not; - reads them from stdin."
    ),
]
Codes = Annotated[list[str] | None, typer.Option("--code", help="Same as WORD; repeatable.")]
OnlyCodes = Annotated[
    list[str] | None,
    typer.Option("--code", help="Words in any rotation, repeatable; - reads them from stdin."),
]
"""`orbitdb.cli.snapshots.given_codes` reads these together with `Words`."""

Limit = Annotated[
    int | None,
    count_option(
        "--limit",
        "-n",
        least=0,
        help="Maximum number of rows, at each a if you ask for several "
        f"[default: {ON_SCREEN} in a table, else all].",
    ),
]

Periods = Annotated[
    str | None, typer.Option("--p", "-p", metavar="PERIODS", help="Periods, such as 11, 2-8 or 2,3,5-7.")
]
_TO_MAKE = typer.Option(
    "--p", "-p", metavar="PERIODS", help="The highest period: 11 is 2 to 11; or exactly these: 8-11 or 2,5."
)
PeriodsToMake = Annotated[str, _TO_MAKE]
SomePeriodsToMake = Annotated[str | None, _TO_MAKE]
MOST_JOBS = 1024

_JOBS = "Number of worker processes [default: one per core if there is enough work]."
Jobs = Annotated[int | None, count_option("--jobs", least=1, most=MOST_JOBS, help=_JOBS)]
Store = Annotated[
    bool | None,
    typer.Option(
        "--store/--no-store",
        help="Save the result in the catalogue [default: if there is one, or one can be made].",
    ),
]
Openings = Annotated[
    list[str] | None,
    typer.Option(
        "--opening",
        metavar="WALL:LOW:HIGH",
        help="An opening of the boundary: x on the top or bottom wall, or the angle on the left or right "
        "semicircle, such as top:-0.3:0.3; repeatable.",
    ),
]
Classes = Annotated[
    bool,
    typer.Option(
        "--classes",
        help="One row per symmetry class, for the least of its words that fulfil the conditions; the column "
        "words says how many do.",
    ),
]
ByBounce = Annotated[
    bool,
    typer.Option("--by-bounce", help="One row per bounce: x, y, arc length, sine, gamma, delta."),
]
Force = Annotated[bool, typer.Option("--force", "-f", help="Replace the file if it exists.")]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do it without asking.")]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Write no notes, except which a was chosen, and no progress.")
]

GONE = {
    "--reversal": "--time-reversal",
    "-P": "--parameter",
    "--coordinates": "-c +coordinates",
    "query --bounces": "--by-bounce",
    "export --bounces": "--by-bounce",
    "bench --plot": "--output",
    "--from": "--p LOW-HIGH",
    "--rigorous": "--prove",
    "bounds --window": "--edges",
    "bounds --time": "--seconds",
    "spectrum --range": "--lengths",
    "spectrum --points": "--resolution",
    "--k-max": "--k 0:HIGH",
}
"""What became of options that the program had before its first release, in one command or in all."""


def takes_only(context: typer.Context, asked: str, *names: str) -> None:
    """Refuse every given option that has no effect in a case such as ``with --code``.

    `names` are the parameters that do have an effect there; the catalogue and the output options always do.
    """
    useful = {*names, "format_", "digits", "uncertainty", "force", "json", "db", "quiet"}
    names_of = (parameter.name for parameter in context.command.params)
    refuse_idle(context, asked, *(name for name in names_of if name not in useful))


def refuse_idle(context: typer.Context, asked: str, *names: str | None) -> None:
    """Raise if the user gave any of the named options, which have no effect here (`takes_only`)."""
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


@dataclass(frozen=True)
class SelectionOptions:
    """The options that choose a subset of the catalogue, as the user typed them.

    A command gets all of them through one parameter, ``choice: SelectionOptions`` (`with_groups`).
    """

    p: Periods = None
    status: Annotated[
        str | None,
        typer.Option(
            help="orbit, geometric, dynamical, boundary or unresolved, several separated by commas, or all "
            "[default: orbit; all if words are named, if --exists or --not-at is given, or if --where names "
            "status, rules, born or dies].",
            autocompletion=offered_statuses,
        ),
    ] = None
    time_reversal: Annotated[
        Literal["self", "pair"] | None,
        typer.Option(help="Orbits that retrace their path (self) or do not (pair)."),
    ] = None
    symmetry: Annotated[
        str | None,
        typer.Option(metavar="LABEL", help="Orbits with exactly this symmetry, such as x,T,xT; 1 for none."),
    ] = None
    contains: Annotated[
        str | None,
        typer.Option(metavar="SYMBOLS", help="Words that contain this sequence of symbols, in any rotation."),
    ] = None
    without: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SYMBOLS",
            help="Words that do not contain this sequence of symbols, in any rotation; repeatable.",
        ),
    ] = None
    opening: Openings = None
    exists: Annotated[
        list[float] | None,
        number_option(
            read=half_length,
            help="Words that are orbits at this a, according to the stored births; repeatable.",
        ),
    ] = None
    not_at: Annotated[
        list[float] | None,
        number_option(
            read=half_length,
            help="Words that are not orbits at this a, according to the stored births; repeatable.",
        ),
    ] = None
    bounds: Annotated[
        list[str] | None,
        typer.Option(
            "--range",
            metavar="NAME=LOW:HIGH",
            help="Range of length, quarter_length, lyapunov, quarter_lyapunov, lambda_d, lambda_c, margin, "
            "born or dies, or number of walls, such as walls=0; repeatable.",
        ),
    ] = None
    where: Annotated[
        str | None,
        typer.Option(
            metavar="SQL",
            help="Rows for which this SQL expression holds; code = code('310') finds a word in any rotation, "
            "contains(code, '0202') the words that contain 0202 in any rotation.",
        ),
    ] = None
    parameters: Parameters = None

    def criteria(
        self, usual: Sequence[str] | None = None, code: Iterable[str] | None = None
    ) -> "dict[str, Any]":
        """Return the criteria of a `Selection`; raise if an option cannot be parsed.

        `usual` are the statuses to choose if neither --status nor --where names any, where they are not those
        of `Selection`, and `code` the words given with --code.
        """
        from orbitdb.criteria import OF_STATUS, parse_ranges
        from orbitdb.errors import SelectionError
        from orbitdb.sql_text import names_in, parse_parameters

        if self.parameters and self.where is None:
            raise SelectionError(
                "--parameter gives a value to a name in --where: give --where, or leave out --parameter"
            )
        names = ("p", "time_reversal", "symmetry", "contains", "where")
        many = ("without", "exists", "not_at", "opening")
        given = {name: value for name in (*names, *many) if (value := getattr(self, name)) is not None}
        by_status = OF_STATUS & names_in(self.where or "")
        status = usual if self.status is None and not by_status else self.status
        given |= {} if status is None else {"status": status}
        given |= {} if code is None else {"code": list(code)}
        given |= {"parameters": parse_parameters(self.parameters or (), self.where or "")}
        return given | parse_ranges(self.bounds or ())

    def at(
        self, a: float, usual: Sequence[str] | None = None, code: Iterable[str] | None = None
    ) -> "Selection":
        """Return the subset at a given a (`criteria`)."""
        from orbitdb.selection import Selection

        return Selection.from_criteria(a=a, **self.criteria(usual, code))
