"""Options shared by several commands, singly or in groups, and their completion in the shell."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import wraps
from inspect import Parameter, Signature, signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.errors import InputError
from orbitdb.text import real, whole

if TYPE_CHECKING:
    from orbitdb.store.selection import Selection


def with_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Replace each parameter that is a dataclass by its fields, which Typer reads as options."""
    groups: dict[str, Any] = {}
    shown = []
    for each in signature(command).parameters.values():
        if is_dataclass(each.annotation):
            groups[each.name] = each.annotation
            shown += [
                Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
                for field in fields(each.annotation)
            ]
        else:
            shown.append(each.replace(kind=Parameter.KEYWORD_ONLY))

    @wraps(command)
    def run(**given: Any) -> None:
        for name, kind in groups.items():
            given[name] = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
        command(**given)

    run.__signature__ = Signature(shown)  # type: ignore[attr-defined]  # Typer reads it
    return run


def offered_columns(incomplete: str) -> Iterator[tuple[str, str]]:
    """Offer the columns of the catalogue that are not typed yet."""
    from orbitdb.columns import IN_CATALOGUE

    return _in_list(incomplete, ((each.name, each.brief) for each in IN_CATALOGUE))


def offered_statuses(incomplete: str) -> Iterator[tuple[str, str]]:
    """Offer the statuses that rows can have."""
    from orbitdb.orbits.status import STORED

    rows = ((status.value, status.sentence) for status in STORED)
    return _in_list(incomplete, [*rows, ("all", "every status")])


def offered_half_lengths(context: typer.Context) -> list[str]:
    """Offer the values of a in the catalogue of --db, or in the default one; none if it cannot be read."""
    from orbitdb.errors import StoreError
    from orbitdb.store.file import reading
    from orbitdb.store.lookup import a_values
    from orbitdb.text import exact

    try:
        with reading(context.params.get("db")) as moment:
            return [*map(exact, a_values(moment))]
    except (InputError, StoreError):
        return []


def offered_several_half_lengths(context: typer.Context) -> list[str]:
    """Offer the values of a in the catalogue, and ``all``."""
    return [*offered_half_lengths(context), "all"]


def _in_list(incomplete: str, known: Iterable[tuple[str, str]]) -> Iterator[tuple[str, str]]:
    """Yield the names that can continue a list separated by commas, with their meanings."""
    before, comma, _ = incomplete.rpartition(",")
    for name, meaning in known:
        if name not in before.split(","):
            yield f"{before}{comma}{name}", meaning


def number_option(*flags: str, help: str, offers: Callable[..., list[str]] | None = None) -> Any:
    """Return an option that takes a number, with optional completion."""
    return typer.Option(*flags, metavar="NUMBER", parser=_reader(real), help=help, autocompletion=offers)


def count_option(*flags: str, help: str, least: float = -math.inf, most: float = math.inf) -> Any:
    """Return an option that takes a whole number within bounds; it may be written as 1e6."""
    return typer.Option(*flags, metavar="COUNT", parser=_reader(whole, least, most), help=help)


def _reader(
    reading: Callable[[str], float], least: float = -math.inf, most: float = math.inf
) -> Callable[[object], float]:
    def read(given: object) -> float:
        try:
            number = reading(str(given))
        except ValueError as error:
            raise typer.BadParameter(str(error)) from None
        if number < least:
            raise typer.BadParameter(f"{number} is less than {least}")
        if number > most:
            raise typer.BadParameter(f"{number} is more than {most}")
        return number

    return read


def _default_path() -> Path:
    from orbitdb.store.paths import default_path

    return default_path()


def _home_expanded(path: Path) -> Path:
    from orbitdb.store.paths import home_expanded

    return home_expanded(path)


Database = Annotated[
    Path,
    typer.Option(
        "--db",
        metavar="PATH",
        default_factory=_default_path,
        callback=_home_expanded,
        show_default=False,
        readable=False,  # the store reports what is wrong with a file
        help="The catalogue [default: ORBITDB_DB, or the user's data folder].",
    ),
]
HalfLength = Annotated[float, number_option("--a", help="Half length of the straight walls.")]
StoredHalfLength = Annotated[
    float | None,
    number_option(
        "--a",
        help="Half length of the straight walls [default: the only one stored, else 1.6].",
        offers=offered_half_lengths,
    ),
]
StoredHalfLengths = Annotated[
    list[str] | None,
    typer.Option(
        "--a",
        metavar="NUMBER|all",
        help="Half length of the straight walls [default: the only one stored, else 1.6]; "
        "repeatable; also a grid FROM:TO:COUNT, or all for every stored value.",
        autocompletion=offered_several_half_lengths,
    ),
]
Parameters = Annotated[
    list[str] | None,
    typer.Option("-P", metavar="NAME=VALUE", help="The value of :name in the SQL; repeatable."),
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
        "-c", "--columns", help="Columns to include, separated by commas.", autocompletion=offered_columns
    ),
]
Words = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[WORD]...", help="Words in any rotation, stored or not; - reads them from stdin."
    ),
]
Codes = Annotated[list[str] | None, typer.Option("--code", help="Same as WORD; repeatable.")]
"""`orbitdb.cli.arguments.given_codes` reads these together with `Words`."""

Periods = Annotated[
    str | None, typer.Option("--p", metavar="PERIODS", help="Periods, such as 11, 2-8 or 2,3,5-7.")
]
Classes = Annotated[bool, typer.Option("--classes", help="One row per symmetry class: its representative.")]
Force = Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")]


def takes_only(context: typer.Context, asked: str, *names: str) -> None:
    """Refuse every given option that has no effect in a case such as ``with --code``.

    `names` are the parameters that do have an effect there; the catalogue and the output options always do.
    """
    useful = {*names, "format_", "form", "force", "json", "db"}
    refuse_idle(context, asked, *(each.name for each in context.command.params if each.name not in useful))


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


Reversal = Annotated[
    str | None,
    typer.Option(
        "--reversal",
        "--time-reversal",
        metavar="self|pair",
        help="Orbits that retrace their path (self) or do not (pair).",
    ),
]
Symmetry = Annotated[
    str | None,
    typer.Option(
        "--symmetry", metavar="LABEL", help="Orbits with exactly this symmetry, such as x,T,xT; 1 for none."
    ),
]
Contains = Annotated[
    str | None,
    typer.Option(
        "--contains", metavar="SYMBOLS", help="Words that contain this sequence of symbols, in any rotation."
    ),
]


def _range_option(names: str) -> Any:
    return typer.Option("--range", metavar="NAME=LOW:HIGH", help=f"Range of {names}; repeatable.")


@dataclass(frozen=True)
class Choice:
    """The options that choose a subset of the catalogue, as the user typed them.

    A command gets all of them through one parameter, ``choice: Choice`` (`orbitdb.cli.options.with_groups`).
    """

    p: Periods = None
    status: Annotated[
        str | None,
        typer.Option(
            help="orbit, geometric, dynamical, boundary or unresolved, several separated by commas, or all.",
            autocompletion=offered_statuses,
        ),
    ] = None
    reversal: Reversal = None
    symmetry: Symmetry = None
    contains: Contains = None
    exists: Annotated[
        list[float] | None,
        number_option(help="Words that are orbits at this a, according to the stored births; repeatable."),
    ] = None
    not_at: Annotated[
        list[float] | None,
        number_option(
            help="Words that are not orbits at this a, according to the stored births; repeatable."
        ),
    ] = None
    bounds: Annotated[
        list[str] | None, _range_option("length, lyapunov, lambda_d, lambda_c, margin, born or dies")
    ] = None
    where: Annotated[
        str | None,
        typer.Option(
            metavar="SQL",
            help="Rows for which this SQL expression holds; code = code('310') finds a word in any rotation.",
        ),
    ] = None
    parameters: Parameters = None

    def at(self, a: float) -> "Selection":
        """Return the subset at a given a; raise if an option cannot be parsed."""
        from orbitdb.store.selection import SelectionError, chosen_by, parse_bounds
        from orbitdb.store.where import parse_parameters

        if self.parameters and self.where is None:
            raise SelectionError("-P gives a value to a name in --where: give --where, or leave out -P")
        parameters = parse_parameters(self.parameters or (), self.where or "")
        names = ("p", "status", "symmetry", "contains", "where")
        chosen = chosen_by(
            a=a,
            **{name: getattr(self, name) for name in names},
            time_reversal=self.reversal,
            exists=self.exists or (),
            not_at=self.not_at or (),
            parameters=parameters,
        )
        return replace(chosen, ranges=parse_bounds(self.bounds or ()))
