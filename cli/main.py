"""The command ``orbitdb``: one module a group of commands, and what happens when one fails."""

import os
import sys
from typing import Annotated

import typer

from orbitdb import __version__
from orbitdb.cli import averages, bench, browse, export, fill, info, plot, query, simulate, table, verify
from orbitdb.cli.endings import Terminated, end_as_users_expect, end_undisturbed
from orbitdb.cli.render import note
from orbitdb.cli.streams import stand_in_for_closed
from orbitdb.errors import DISK_TROUBLE, InputError, StoreError, WorkError

DONE, FAILED, USAGE, NO_DATABASE, INTERRUPTED = 0, 1, 2, 3, 130
_SIGNALLED = 128
_GOES_ON = "nothing that was stored is lost, the same command goes on from there"

app = typer.Typer(
    name="orbitdb",
    help="A certified catalogue of the unstable periodic orbits of the stadium billiard.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for module in (fill, query, browse, table, averages, simulate, plot, export, verify, bench, info):
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


def run() -> None:
    """Run the command line; every failure becomes one line on stderr and an exit code."""
    end_as_users_expect()
    stand_in_for_closed()
    code = _run(sys.argv[1:] or ["--help"])
    end_undisturbed()
    try:
        sys.stdout.flush()
    except OSError as error:
        code = code or _unwritten(error)
        os.dup2(
            os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
        )  # for the flush at the end of the process
    sys.exit(code)


def _run(arguments: list[str]) -> int:
    if any("\0" in argument for argument in arguments):
        return _say("an argument has a NUL character in it", USAGE)
    try:
        result = app(arguments, prog_name="orbitdb", standalone_mode=False)
        if result == INTERRUPTED:
            raise KeyboardInterrupt
        return result if isinstance(result, int) else DONE
    except InputError as error:
        return _say(str(error), USAGE)
    except StoreError as error:
        return _say(str(error), NO_DATABASE)
    except WorkError as error:
        return _say(str(error), FAILED)
    except (KeyboardInterrupt, typer.Abort):
        return _say(f"interrupted; {_GOES_ON}", INTERRUPTED)
    except Terminated as end:
        return _say(f"terminated; {_GOES_ON}", _SIGNALLED + end.number)
    except typer.TyperException as error:
        return _say(" ".join(error.format_message().split()) + " (--help shows the options)", USAGE)
    except OSError as error:
        return _unwritten(error)
    except ModuleNotFoundError as error:
        return _say(f"{error}; it comes with an extra, see 'Install' in the README", FAILED)


def _unwritten(error: OSError) -> int:
    where = error.filename or "the output"
    if error.errno in DISK_TROUBLE:
        return _say(f"{where} cannot be written ({error.strerror})", NO_DATABASE)
    return _say(f"{where} cannot be read or written ({error.strerror})", FAILED)


def _say(message: str, code: int) -> int:
    note(f"orbitdb: {message}")
    return code
