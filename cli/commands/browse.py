"""``orbitdb browse``: the terminal UI."""

import sys
from dataclasses import replace
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.reading import meant
from orbitdb.errors import InputError

EXAMPLES = """
Examples:

  orbitdb browse

  orbitdb browse --code 1232131

  orbitdb browse --p 9 --where "lambda_c < 0.4"
"""


def register(app: typer.Typer) -> None:
    """Add the command and its other name."""
    app.command(epilog=EXAMPLES)(browse)
    app.command("tui", hidden=True, epilog=EXAMPLES)(browse)


@options.with_choice
def browse(
    *,
    code: Annotated[str | None, typer.Option("--code", help="Open at this word, in any rotation.")] = None,
    a: options.StoredHalfLength = None,
    choice: options.Choice,
    db: options.Database = None,
) -> None:
    """Browse the catalogue in the terminal: look at orbits, choose subsets, compute (? shows the keys)."""
    from orbitdb.store.file.database import default_path
    from orbitdb.symbols.words import parse

    path, chosen = db or default_path(), choice.at(options.USUAL_A if a is None else a)
    if code is not None:
        parse(code)
    if not all(stream.isatty() for stream in (sys.stdin, sys.stdout, sys.stderr)):  # it draws on stderr
        raise InputError("browse needs a terminal: use 'orbitdb query' where there is none")
    from orbitdb.cli.tui.app import BrowseApp
    from orbitdb.cli.tui.kept import state_path

    app = BrowseApp(path, replace(chosen, a=meant(path, a)), code, state_path())
    if chosen.where is not None:
        app.check_filter(chosen.where, dict(chosen.parameters))
    app.run()
    if app.failure is not None:
        raise app.failure
