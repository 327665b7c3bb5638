"""All commands of ``orbitdb``: one module a group of commands."""

import logging
from collections.abc import Sequence
from functools import cache
from typing import Annotated, Any

import typer

from orbitdb import __version__
from orbitdb.cli.commands import (
    bench,
    births,
    bounds,
    browse,
    columns,
    entropy,
    export,
    fill,
    identify,
    info,
    lyapunov,
    plot,
    query,
    simulate,
    sql,
    sweep,
    table,
    verify,
)

ParsingError = typer.TyperException

app = typer.Typer(
    name="orbitdb",
    help="A certified catalogue of the unstable periodic orbits of the stadium billiard.",
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for module in (
    fill, sweep, births, query, identify, browse, table, entropy, lyapunov, bounds, simulate, plot, export,
    sql, columns, verify, bench, info,
):  # fmt: skip
    module.register(app)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"orbitdb {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


logging.getLogger("matplotlib").setLevel(logging.ERROR)  # where it keeps its fonts is nobody's concern here

_command = cache(typer.main.get_command)  # built once, however many commands one process runs


def call(arguments: Sequence[str]) -> Any:
    """Run the command that the arguments say; return its exit code, if it has one.

    Raises
    ------
    ParsingError
        If they cannot be read.
    KeyboardInterrupt
        On Ctrl-C, or the end of an input that is waited for.
    """
    try:
        return _command(app)(arguments, prog_name="orbitdb", standalone_mode=False)
    except typer.Abort as end:
        raise KeyboardInterrupt from end
