"""All commands of ``orbitdb``: one module a group of commands, loaded when one of them is called."""

import logging
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import Annotated, Any

import typer

from orbitdb import __version__
from orbitdb.cli.help import Command, Group

ParsingError = typer.TyperException

_ROOMS = (
    "fill", "sweep", "births", "query", "identify", "browse", "table", "entropy", "lyapunov", "bounds",
    "simulate", "levels", "spectrum", "plot", "export", "sql", "columns", "verify", "bench", "info",
)  # fmt: skip
"""The modules of `orbitdb.cli.commands`."""

_ROOM_OF = {room: room for room in _ROOMS} | {"tui": "browse", "migrate": "info"}
"""By command."""


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"orbitdb {__version__}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    pass


logging.getLogger("matplotlib").setLevel(logging.ERROR)  # where it keeps its fonts is nobody's concern here
logging.getLogger("sqlalchemy.pool").setLevel(logging.CRITICAL)  # a Ctrl-C as a file is closed it tells, too


def program(rooms: Sequence[str] = _ROOMS) -> typer.Typer:
    """Return the program with the commands of some modules, by default all."""
    app = typer.Typer(
        name="orbitdb",
        cls=Group,
        help="A certified catalogue of the unstable periodic orbits of the stadium billiard.",
        context_settings={"help_option_names": ["-h", "--help"]},
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    app.callback()(_options)
    for room in rooms:
        import_module(f"orbitdb.cli.commands.{room}").register(app)
    for command in app.registered_commands:
        command.cls = Command
    return app


@cache
def _command(rooms: tuple[str, ...]) -> Any:
    """Return what runs command lines; built once, however many of them one process runs."""
    return typer.main.get_command(program(rooms))


def call(arguments: Sequence[str]) -> Any:
    """Run the command that the arguments say; return its exit code, if it has one.

    Raises
    ------
    ParsingError
        If they cannot be read.
    KeyboardInterrupt
        On Ctrl-C, or the end of an input that is waited for.
    """
    room = _ROOM_OF.get(arguments[0])
    command = _command(_ROOMS if room is None else (room,))
    try:
        return command(arguments, prog_name="orbitdb", standalone_mode=False)
    except typer.Abort as end:
        raise KeyboardInterrupt from end
