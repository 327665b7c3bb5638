"""The options that choose a subset of the catalogue, shared by several commands."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitdb.cli import options

if TYPE_CHECKING:
    from orbitdb.store.selection import Selection

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

    p: options.Periods = None
    status: Annotated[
        str | None,
        typer.Option(
            help="orbit, geometric, dynamical, boundary or unresolved, several separated by commas, or all.",
            autocompletion=options.offered_statuses,
        ),
    ] = None
    reversal: Reversal = None
    symmetry: Symmetry = None
    contains: Contains = None
    exists: Annotated[
        list[float] | None,
        options.number_option(
            help="Words that are orbits at this a, according to the stored births; repeatable."
        ),
    ] = None
    not_at: Annotated[
        list[float] | None,
        options.number_option(
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
            help="Rows for which this SQL expression holds; code('310') matches a word in any rotation.",
        ),
    ] = None
    parameters: options.Parameters = None

    def at(self, a: float) -> "Selection":
        """Return the subset at a given a; raise if an option cannot be parsed."""
        from orbitdb.store.codes import parse_parameters
        from orbitdb.store.selection import SelectionError, chosen_by, parse_bounds

        if self.parameters and self.where is None:
            raise SelectionError("-P gives a value to a name in --where: give --where, or leave out -P")
        parameters = parse_parameters(self.parameters or (), self.where or "")
        names = ("p", "status", "symmetry", "contains", "where")
        chosen = chosen_by(
            a,
            **{name: getattr(self, name) for name in names},
            time_reversal=self.reversal,
            exists=self.exists or (),
            not_at=self.not_at or (),
            parameters=parameters,
        )
        return replace(chosen, ranges=parse_bounds(self.bounds or ()))
