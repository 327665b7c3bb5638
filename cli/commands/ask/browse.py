"""``orbitdb browse``: the terminal UI, shown in a terminal or in a browser."""

import os
import sys
from dataclasses import replace
from typing import Annotated

import typer

from orbitdb.billiard import USUAL_A
from orbitdb.cli import options
from orbitdb.cli.choice import Choice
from orbitdb.cli.reading import meant
from orbitdb.cli.render import note
from orbitdb.errors import InputError
from orbitdb.extras import load

EXAMPLES = ("browse", "browse --code 1232131", 'browse --p 9 --where "lambda_c < 0.4"', "browse --web")
_PORT = 8000


def browse(
    *,
    context: typer.Context,
    code: Annotated[str | None, typer.Option(help="Start at this word, in any rotation.")] = None,
    a: options.StoredHalfLength = None,
    choice: Choice,
    web: Annotated[
        bool, typer.Option("--web", help="Show the screen in a browser on this machine; print its address.")
    ] = False,
    port: Annotated[
        int, options.count_option(least=0, most=65535, help="Port for --web; 0 takes any free port.")
    ] = _PORT,
    db: options.Database,
) -> None:
    """Browse the catalogue in the terminal: look at orbits, choose subsets, compute averages.

    Press ? to see the keys.
    """
    from orbitdb.store.asking.where import check
    from orbitdb.symbols.words import parse

    chosen = choice.at(USUAL_A if a is None else a)
    if code is not None:
        parse(code)
    if web:
        server = load("orbitdb.cli.tui.web", "browse --web", "web")
    else:
        options.refuse_idle(context, "without --web", "port")
        streams = (sys.stdin, sys.stdout, sys.stderr)  # Textual draws on stderr, except in a browser
        if "TEXTUAL_DRIVER" not in os.environ and not all(stream.isatty() for stream in streams):
            raise InputError("browse needs a terminal: use 'orbitdb query' without one")
    from orbitdb.cli.tui.app import BrowseApp
    from orbitdb.cli.tui.kept import state_path

    app = BrowseApp(db, replace(chosen, a=meant(db, a)[0]), code, state_path())
    if chosen.where is not None:
        check(chosen.where, dict(chosen.parameters))
    if web:
        arguments = ["browse", f"--db={db.absolute()}", *_typed_again(context)]
        server.serve(arguments, port, lambda address: note(f"open {address} to browse {db}; Ctrl-C stops it"))
        return
    app.run()
    app.close()


def _typed_again(context: typer.Context) -> list[str]:
    """Return the options of this command as arguments, except --web, --port and --db."""
    typed = []
    for parameter in context.command.params:
        value = context.params.get(parameter.name or "")
        if parameter.name in ("web", "port", "db") or value is None:
            continue
        flag = parameter.opts[0] + ("=" if parameter.opts[0].startswith("--") else "")
        typed += [f"{flag}{each}" for each in (value if isinstance(value, list | tuple) else [value])]
    return typed
