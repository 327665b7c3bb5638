"""``orbitdb browse``: the terminal UI."""

import os
import sys
from dataclasses import replace
from typing import Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.options import SelectionOptions
from orbitdb.cli.snapshots import given_a
from orbitdb.errors import InputError

EXAMPLES = ("browse", "browse --code 1232131", 'browse --p 9 --where "lambda_c < 0.4"')


def browse(
    *,
    code: Annotated[str | None, typer.Option(help="Start at this word, in any rotation.")] = None,
    a: options.HalfLength = None,
    choice: SelectionOptions,
    db: options.Database,
) -> None:
    """Browse the catalogue in the terminal: look at orbits, choose subsets, compute averages.

    It opens on the orbits; o and O choose other statuses. Press ? to see the keys.
    """
    from orbitdb.store.where import check
    from orbitdb.symbols.words import parse

    chosen = choice.at(USUAL_A if a is None else a)
    if code is not None:
        parse(code)
    streams = (sys.stdin, sys.stdout, sys.stderr)  # Textual draws on stderr, except in a browser
    if "TEXTUAL_DRIVER" not in os.environ and not all(stream.isatty() for stream in streams):
        if sys.stdin.isatty() and sys.stdout.isatty():
            raise InputError("stderr must be a terminal, too: browse draws on it")
        raise InputError("browse needs a terminal: use 'orbitdb query' without one")
    from orbitdb.cli.tui.app import BrowseApp
    from orbitdb.cli.tui.stored import state_path

    chosen = replace(chosen, a=given_a(db, a)[0])
    chosen.check_opening()
    app = BrowseApp(db, chosen, code, state_path())
    if chosen.where is not None:
        check(chosen.where, dict(chosen.parameters))
    app.run()
    app.end()
